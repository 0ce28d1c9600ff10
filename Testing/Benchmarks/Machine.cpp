#include "Machine.h"

#include "Context.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <thread>
#include <vector>

namespace bench
{

namespace
{

constexpr int passes = 5;

/// Four floats an item: what a processor's vectors and a GPU's memory both like.
const char* const source = R"(
kernel void triad(global float4* a, global const float4* b, global const float4* c, float s)
{
  const size_t i = get_global_id(0);
  a[i] = b[i] + s * c[i];
}
kernel void copy(global float4* a, global const float4* b)
{
  const size_t i = get_global_id(0);
  a[i] = b[i];
}
)";

double bestSeconds(const std::function<void()>& pass)
{
  double best = 1e9;
  pass();
  for (int n = 0; n < passes; ++n)
  {
    const auto begin = std::chrono::steady_clock::now();
    pass();
    best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }
  return best;
}

/// Runs `part(begin, end)` on every core.
void onAllCores(std::size_t count, const std::function<void(std::size_t, std::size_t)>& part)
{
  const std::size_t cores = std::max(1u, std::thread::hardware_concurrency());
  std::vector<std::thread> threads;
  for (std::size_t n = 0; n < cores; ++n)
  {
    threads.emplace_back(part, count * n / cores, count * (n + 1) / cores);
  }
  for (std::thread& thread : threads)
  {
    thread.join();
  }
}

}

class Machine::Impl
{
public:
  Impl(const std::string& deviceName, bool small)
    : context_(chainmail::Context::of(deviceName))
  {
    // A GPU's caches and bandwidth are larger than a processor's.
    const std::size_t bytes = small ? std::size_t(4) << 20 : std::size_t(this->context_->info().gpu ? 512 : 96) << 20;
    this->floats_ = bytes / sizeof(float);
    const cl::Context context = this->context_->queue().getInfo<CL_QUEUE_CONTEXT>();
    this->program_ = cl::Program(context, source);
    this->program_.build({ this->context_->device() });
  }

  const chainmail::DeviceInfo& info() const { return this->context_->info(); }

  Bandwidth measure()
  {
    Bandwidth result;
    this->measureDevice(result);
    this->measureHost(result);
    return result;
  }

private:
  double gigabytes() const { return static_cast<double>(this->floats_) * sizeof(float) * 1e-9; }

  // The memory is there only meanwhile, so that no benchmark takes it for that of what it measures.

  void measureDevice(Bandwidth& result)
  {
    cl::Buffer buffers[3];
    for (int n = 0; n < 3; ++n)
    {
      buffers[n] = this->context_->allocate(this->floats_ * sizeof(float), "the measurement of bandwidth");
    }
    const auto launch = [&](const char* name, int arrays)
    {
      cl::Kernel kernel(this->program_, name);
      for (int n = 0; n < arrays; ++n)
      {
        kernel.setArg(n, buffers[n]);
      }
      if (arrays == 3)
      {
        kernel.setArg(3, 1.5f);
      }
      return this->gigabytes() * arrays /
             bestSeconds(
               [&]
               {
                 this->context_->queue().enqueueNDRangeKernel(
                   kernel, cl::NullRange, cl::NDRange(this->floats_ / 4), cl::NDRange(256));
                 this->context_->queue().finish();
               });
    };
    result.deviceTriad = launch("triad", 3);
    result.deviceCopy = launch("copy", 2);
  }

  void measureHost(Bandwidth& result)
  {
    std::vector<float> arrays[3];
    for (std::vector<float>& array : arrays)
    {
      array.resize(this->floats_, 1.0f);
    }
    float* const a = arrays[0].data();
    const float* const b = arrays[1].data();
    const float* const c = arrays[2].data();
    const auto triad = [&](std::size_t begin, std::size_t end)
    {
      for (std::size_t i = begin; i < end; ++i)
      {
        a[i] = b[i] + 1.5f * c[i];
      }
    };
    const auto copy = [&](std::size_t begin, std::size_t end) { std::copy(b + begin, b + end, a + begin); };
    result.hostTriad = 3.0 * this->gigabytes() / bestSeconds([&] { onAllCores(this->floats_, triad); });
    result.hostCopy = 2.0 * this->gigabytes() / bestSeconds([&] { onAllCores(this->floats_, copy); });
  }

  std::shared_ptr<chainmail::Context> context_;
  std::size_t floats_ = 0;
  cl::Program program_;
};

Machine::Machine(const std::string& deviceName, bool small)
  : impl_(chainmail::translated([&] { return std::make_unique<Impl>(deviceName, small); }))
{
}

Machine::~Machine() = default;

const std::string& Machine::device() const
{
  return this->impl_->info().name;
}

const std::string& Machine::platform() const
{
  return this->impl_->info().platform;
}

unsigned Machine::computeUnits() const
{
  return this->impl_->info().computeUnits;
}

bool Machine::gpu() const
{
  return this->impl_->info().gpu;
}

Bandwidth Machine::measure()
{
  return chainmail::translated([&] { return this->impl_->measure(); });
}

std::string processor()
{
  std::string name = "an unknown processor";
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
  {
    if (line.compare(0, 10, "model name") == 0)
    {
      name = line.substr(line.find(':') + 2);
      break;
    }
  }
  return std::to_string(std::thread::hardware_concurrency()) + " cores of " + name;
}

double load()
{
  double average = -1.0;
  return getloadavg(&average, 1) == 1 ? average : -1.0;
}

}
