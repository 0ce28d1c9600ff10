#include "PublishedChainMail.h"

#include "Programs.h"

#include <algorithm>
#include <limits>

namespace baseline
{

namespace
{

/// Items of a work-group, at most.
constexpr int groupItems = 256;

}

class PublishedChainMail::Impl
{
public:
  Impl(const std::string& device, const std::array<int, 3>& size, const std::vector<float>& constraint,
    const Method& method)
    : context_(chainmail::Context::of(device))
    , size_(size)
    , method_(method)
    , count_(constraint.size())
  {
    std::string defines = method.timestamps ? " -DTIMESTAMPS" : "";
    defines += method.launch == Launch::Listed ? " -DLISTED" : "";
    // Without blocks the whole grid is one.
    const char* const names[3] = { "BX", "BY", "BZ" };
    for (int a = 0; a < 3; ++a)
    {
      this->block_[a] = method.block[a];
      while (method.launch == Launch::Whole && this->block_[a] < size[a])
      {
        this->block_[a] *= 2;
      }
      this->blocks_[a] = (size[a] + this->block_[a] - 1) / this->block_[a];
      defines += std::string(" -D") + names[a] + "=" + std::to_string(this->block_[a]);
    }
    const cl::Program program = buildProgram(*this->context_, "published.cl", defines);
    this->propagateKernel_ = cl::Kernel(program, "propagate");
    this->relaxKernel_ = cl::Kernel(program, "relax");

    this->constraint_ = this->context_->upload(constraint, "constraints");
    this->held_ = this->allocate(1);
    for (Copy& copy : this->copies_)
    {
      for (cl::Buffer& axis : copy.u)
      {
        axis = this->allocate(sizeof(cl_float));
      }
      copy.stamp = this->allocate(sizeof(cl_int));
      if (method.timestamps)
      {
        copy.time = this->allocate(sizeof(cl_float));
        copy.front = this->allocate(sizeof(cl_int));
      }
    }
    this->flags_.assign(this->blocks_[0] * this->blocks_[1] * this->blocks_[2], 0);
    this->changed_ = this->context_->upload(this->flags_, "activity flags");
    this->list_ = this->context_->allocate(sizeof(cl_int4) * this->flags_.size(), "active blocks");
    this->reset();
  }

  void reset()
  {
    cl::CommandQueue& queue = this->context_->queue();
    for (const Copy& copy : this->copies_)
    {
      for (const cl::Buffer& axis : copy.u)
      {
        queue.enqueueFillBuffer(axis, cl_float(0), 0, sizeof(cl_float) * this->count_);
      }
      queue.enqueueFillBuffer(copy.stamp, cl_int(-1), 0, sizeof(cl_int) * this->count_);
      if (this->method_.timestamps)
      {
        queue.enqueueFillBuffer(
          copy.time, std::numeric_limits<cl_float>::infinity(), 0, sizeof(cl_float) * this->count_);
        queue.enqueueFillBuffer(copy.front, cl_int(0), 0, sizeof(cl_int) * this->count_);
      }
    }
    queue.enqueueFillBuffer(this->held_, cl_uchar(0), 0, this->count_);
    queue.finish();
    this->iteration_ = 0;
    this->waves_ = 0;
    std::fill(this->flags_.begin(), this->flags_.end(), 0);
    this->dirty_ = this->flags_;
  }

  void hold(std::size_t element) { this->set(this->held_, element, cl_uchar(1)); }

  void pull(std::size_t element, const std::array<double, 3>& displacement)
  {
    const Copy& now = this->copies_[this->iteration_ % 2];
    for (int a = 0; a < 3; ++a)
    {
      this->set(now.u[a], element, static_cast<cl_float>(displacement[a]));
    }
    this->set(now.stamp, element, cl_int(this->iteration_));
    if (this->method_.timestamps)
    {
      this->set(now.time, element, cl_float(0));
      this->set(now.front, element, cl_int(++this->waves_));
    }
    this->hold(element);
    const std::array<int, 3> p{ static_cast<int>(element % this->size_[0]),
      static_cast<int>(element / this->size_[0] % this->size_[1]),
      static_cast<int>(element / this->size_[0] / this->size_[1]) };
    for (int n = 0; n < 7; ++n) // the element's block and those of its neighbours
    {
      std::array<int, 3> q = p;
      q[n / 2 % 3] += n == 6 ? 0 : n % 2 == 0 ? -1 : 1;
      if (q[n / 2 % 3] >= 0 && q[n / 2 % 3] < this->size_[n / 2 % 3])
      {
        this->flags_[this->blockOf(q)] = 1;
      }
    }
  }

  int propagate()
  {
    int iterations = 0;
    for (; this->anyFlag(); ++iterations)
    {
      this->iterate(this->propagateKernel_, nullptr);
    }
    return iterations;
  }

  int relax(int iterations, double tolerance)
  {
    this->flags_ = this->dirty_;
    const cl_float still = static_cast<cl_float>(tolerance);
    int done = 0;
    for (; done < iterations && this->anyFlag(); ++done)
    {
      this->iterate(this->relaxKernel_, &still);
    }
    return done;
  }

  State state()
  {
    State state;
    for (int a = 0; a < 3; ++a)
    {
      state[a].resize(this->count_);
      this->context_->read(this->copies_[this->iteration_ % 2].u[a], state[a]);
    }
    return state;
  }

  std::size_t deviceBytes() const { return this->bytes_ + sizeof(cl_float) * this->count_; }

private:
  /// One copy of the state.
  struct Copy
  {
    cl::Buffer u[3];
    cl::Buffer stamp;
    cl::Buffer time;
    cl::Buffer front;
  };

  cl::Buffer allocate(std::size_t bytesPerElement)
  {
    this->bytes_ += bytesPerElement * this->count_;
    return this->context_->allocate(bytesPerElement * this->count_, "the state");
  }

  template <typename T> void set(const cl::Buffer& buffer, std::size_t element, T value)
  {
    this->context_->write(buffer, element * sizeof(T), std::vector<T>{ value });
  }

  std::size_t blockOf(const std::array<int, 3>& p) const
  {
    return static_cast<std::size_t>(
      p[0] / this->block_[0] +
      this->blocks_[0] * (p[1] / this->block_[1] + this->blocks_[1] * (p[2] / this->block_[2])));
  }

  bool anyFlag() const
  {
    return std::any_of(this->flags_.begin(), this->flags_.end(), [](cl_uchar flag) { return flag != 0; });
  }

  /// One iteration over the active blocks; finds those of the next one. `tolerance`: where the kernel takes one.
  void iterate(cl::Kernel& kernel, const cl_float* tolerance)
  {
    std::vector<cl_int4> active;
    for (std::size_t b = 0; b < this->flags_.size(); ++b)
    {
      if (this->flags_[b])
      {
        this->dirty_[b] = 1;
        const int x = static_cast<int>(b) % this->blocks_[0];
        const int y = static_cast<int>(b) / this->blocks_[0] % this->blocks_[1];
        const int z = static_cast<int>(b) / this->blocks_[0] / this->blocks_[1];
        active.push_back({ { x * this->block_[0], y * this->block_[1], z * this->block_[2], 0 } });
      }
    }
    const Copy& before = this->copies_[this->iteration_ % 2];
    const Copy& after = this->copies_[(this->iteration_ + 1) % 2];
    ++this->iteration_;
    int argument = 1; // the first says where
    if (tolerance)
    {
      kernel.setArg(argument++, *tolerance);
    }
    kernel.setArg(argument++, cl_int4{ { this->size_[0], this->size_[1], this->size_[2], 0 } });
    kernel.setArg(argument++, cl_int(this->iteration_));
    kernel.setArg(argument++, this->constraint_);
    kernel.setArg(argument++, this->held_);
    for (const cl::Buffer& axis : before.u)
    {
      kernel.setArg(argument++, axis);
    }
    kernel.setArg(argument++, before.stamp);
    for (const cl::Buffer& axis : after.u)
    {
      kernel.setArg(argument++, axis);
    }
    kernel.setArg(argument++, after.stamp);
    kernel.setArg(argument++, this->changed_);
    if (this->method_.timestamps && !tolerance)
    {
      kernel.setArg(argument++, before.time);
      kernel.setArg(argument++, before.front);
      kernel.setArg(argument++, after.time);
      kernel.setArg(argument++, after.front);
    }

    cl::CommandQueue& queue = this->context_->queue();
    queue.enqueueFillBuffer(this->changed_, cl_uchar(0), 0, this->flags_.size());
    if (this->method_.launch == Launch::Listed)
    {
      this->context_->write(this->list_, 0, active);
      kernel.setArg(0, this->list_);
      const int items = std::min(groupItems, this->block_[0] * this->block_[1] * this->block_[2]);
      this->context_->launch(kernel, active.size(), items);
    }
    else
    {
      // Work-groups: the block where it is small enough, else a part of it that is long in x.
      int room = groupItems;
      std::array<std::size_t, 3> group{};
      std::array<std::size_t, 3> range{};
      for (int a = 0; a < 3; ++a)
      {
        group[a] = std::min(room, this->method_.block[a]);
        room /= static_cast<int>(group[a]);
        const std::size_t length = this->method_.launch == Launch::Whole ? this->size_[a] : this->block_[a];
        range[a] = (length + group[a] - 1) / group[a] * group[a];
      }
      for (const cl_int4& first : active)
      {
        kernel.setArg(0, first);
        queue.enqueueNDRangeKernel(
          kernel, cl::NullRange, cl::NDRange(range[0], range[1], range[2]), cl::NDRange(group[0], group[1], group[2]));
      }
    }
    this->context_->read(this->changed_, this->flags_);
  }

  std::shared_ptr<chainmail::Context> context_;
  std::array<int, 3> size_;
  Method method_;
  std::size_t count_;
  std::size_t bytes_ = 0;
  std::array<int, 3> block_{};
  std::array<int, 3> blocks_{};
  cl::Kernel propagateKernel_;
  cl::Kernel relaxKernel_;
  cl::Buffer constraint_;
  cl::Buffer held_;
  Copy copies_[2];
  cl::Buffer changed_;
  cl::Buffer list_;
  std::vector<cl_uchar> flags_; ///< blocks of the next iteration
  std::vector<cl_uchar> dirty_; ///< blocks that any wave has reached
  int iteration_ = 0;           ///< copies_[iteration_ % 2] is the state
  int waves_ = 0;
};

PublishedChainMail::PublishedChainMail(
  const std::string& device, const std::array<int, 3>& size, const std::vector<float>& constraint, const Method& method)
  : impl_(chainmail::translated([&] { return std::make_unique<Impl>(device, size, constraint, method); }))
{
}

PublishedChainMail::~PublishedChainMail() = default;

void PublishedChainMail::reset()
{
  chainmail::translated([&] { this->impl_->reset(); });
}

void PublishedChainMail::hold(std::size_t element)
{
  chainmail::translated([&] { this->impl_->hold(element); });
}

void PublishedChainMail::pull(std::size_t element, const std::array<double, 3>& displacement)
{
  chainmail::translated([&] { this->impl_->pull(element, displacement); });
}

int PublishedChainMail::propagate()
{
  return chainmail::translated([&] { return this->impl_->propagate(); });
}

int PublishedChainMail::relax(int iterations, double tolerance)
{
  return chainmail::translated([&] { return this->impl_->relax(iterations, tolerance); });
}

State PublishedChainMail::state() const
{
  return chainmail::translated([&] { return this->impl_->state(); });
}

std::size_t PublishedChainMail::deviceBytes() const
{
  return this->impl_->deviceBytes();
}

}
