#include "Spread.h"

namespace chainmail
{

namespace
{

// As spread.clh has them.
constexpr int everyFace = 63;
constexpr int anything = 64;

}

int Spread::parityOf(int brick) const
{
  const Index3 size = this->bricks_.size();
  const Index3 origin = this->bricks_.origin(brick);
  return (origin[0] / size[0] + origin[1] / size[1] + origin[2] / size[2]) & 1;
}

void Spread::start(const std::vector<int>& bricks)
{
  this->pending_[0].clear();
  this->pending_[1].clear();
  for (const int brick : bricks)
  {
    this->pending_[this->parityOf(brick)][brick] = anything;
  }
  // What changed may lie beside a face.
  for (const int brick : bricks)
  {
    this->notify(brick, this->parityOf(brick), everyFace);
  }
}

/// Something changed at these faces of a brick.
void Spread::notify(int brick, int parity, int faces)
{
  for (int d = 0; d < 6; ++d)
  {
    if (faces & (1 << d))
    {
      this->pending_[1 - parity][this->bricks_.neighbour(brick, d)] |= 1 << Bricks::opposite(d);
    }
  }
}

void Spread::turn(int parity, const std::function<void(cl::Kernel&, int&)>& bind)
{
  std::vector<int> wanted;
  for (const auto& [brick, before] : this->pending_[parity])
  {
    wanted.push_back(brick);
  }
  this->bricks_.require(wanted);
  this->slots_.clear();
  this->list_.clear();
  for (const auto& [brick, before] : this->pending_[parity])
  {
    if (this->bricks_.slot(brick) > 0)
    {
      this->slots_.push_back(this->bricks_.slot(brick));
      this->list_.push_back({ { this->slots_.back(), before } });
    }
  }
  this->pending_[parity].clear();
  if (this->slots_.empty())
  {
    return;
  }

  const Index3 size = this->bricks_.size();
  Context& context = this->bricks_.context();
  this->values_.resize(this->results_ * this->slots_.size());
  const cl::Buffer& result = this->result_.sized(context, sizeof(cl_int) * this->values_.size());
  cl::Kernel kernel = context.kernel(this->file_, this->bricks_.defines(true), this->name_);
  int argument = 0;
  kernel.setArg(argument++, this->listBuffer_.holding(context, this->list_));
  kernel.setArg(argument++, static_cast<cl_int>(size[0] + size[1] + size[2]));
  kernel.setArg(argument++, this->bricks_.pitch());
  this->bricks_.bindTable(kernel, argument);
  bind(kernel, argument);
  kernel.setArg(argument++, result);
  context.runGroups(kernel, this->slots_.size(), this->bricks_.workItems(true));
  context.read(result, this->values_);

  for (std::size_t n = 0; n < this->slots_.size(); ++n)
  {
    const int brick = this->bricks_.brick(this->slots_[n]);
    const int faces = *this->resultOf(n);
    this->notify(brick, parity, faces);
    if (faces & 128)
    {
      this->pending_[parity][brick] = anything;
    }
  }
}

}
