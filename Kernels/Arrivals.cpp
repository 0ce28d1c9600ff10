#include "Arrivals.h"

#include <algorithm>
#include <limits>

namespace chainmail
{

Arrivals::Arrivals(Bricks& bricks)
  : bricks_(bricks)
  , spread_(bricks, "arrive.cl", "arrive", 1)
  , time_{ static_cast<std::size_t>(bricks.model().axes()), sizeof(cl_float), "propagation times" }
  , front_{ static_cast<std::size_t>(bricks.model().axes()), sizeof(cl_int), "wavefront numbers" }
  , arrival_{ static_cast<std::size_t>(bricks.model().axes()), sizeof(cl_float), "propagation times" }
{
}

Arrivals::~Arrivals()
{
  this->bricks_.drop(this->time_);
  this->bricks_.drop(this->front_);
  this->bricks_.drop(this->arrival_);
}

void Arrivals::keep()
{
  this->bricks_.keep(this->time_);
  this->bricks_.keep(this->front_);
}

void Arrivals::start(const Hold& source, int front)
{
  const std::size_t axes = static_cast<std::size_t>(this->bricks_.model().axes());
  this->bricks_.set(this->time_, source.addresses, std::vector<cl_float>(axes * source.addresses.size(), 0.0f));
  this->bricks_.set(this->front_, source.addresses, std::vector<cl_int>(axes * source.addresses.size(), front));
}

void Arrivals::follow(const std::vector<const Hold*>& sources, int front, const Checkpoint& checkpoint)
{
  this->keep();
  this->bricks_.keep(this->arrival_);
  Context& context = this->bricks_.context();
  const std::size_t axes = this->arrival_.runs;
  context.queue().enqueueFillBuffer(this->arrival_.buffer, std::numeric_limits<cl_float>::infinity(), 0,
    sizeof(cl_float) * axes * this->bricks_.pitch());
  std::vector<int> bricks;
  for (const Hold* source : sources)
  {
    this->bricks_.set(this->arrival_, source->addresses, std::vector<cl_float>(axes * source->addresses.size(), 0.0f));
    bricks.insert(bricks.end(), source->bricks.begin(), source->bricks.end());
  }

  std::set<int> visited;
  this->spread_.start(bricks);
  for (int turn = 0; !this->spread_.finished(); turn = 1 - turn)
  {
    checkpoint();
    this->spread_.turn(turn,
      [this](cl::Kernel& kernel, int& argument)
      {
        kernel.setArg(argument++, this->bricks_.displacement);
        kernel.setArg(argument++, this->bricks_.before);
        kernel.setArg(argument++, this->bricks_.constraint);
        kernel.setArg(argument++, this->bricks_.cutsOrNothing());
        kernel.setArg(argument++, this->arrival_.buffer);
      });
    visited.insert(this->spread_.slots().begin(), this->spread_.slots().end());
  }

  const std::vector<int> slots(visited.begin(), visited.end());
  Scratch list("the list of active bricks");
  cl::Kernel kernel = context.kernel("arrive.cl", this->bricks_.defines(true), "record");
  kernel.setArg(0, list.holding(context, slots));
  kernel.setArg(1, this->bricks_.pitch());
  kernel.setArg(2, this->arrival_.buffer);
  kernel.setArg(3, front);
  kernel.setArg(4, this->time_.buffer);
  kernel.setArg(5, this->front_.buffer);
  context.runGroups(kernel, slots.size(), this->bricks_.workItems(true));
  context.queue().finish();
}

void Arrivals::clear()
{
  for (const Field* field : { &this->time_, &this->front_ })
  {
    if (field->buffer())
    {
      this->bricks_.context().queue().enqueueFillBuffer(
        field->buffer, cl_int(0), 0, field->runs * field->bytes * this->bricks_.pitch());
    }
  }
  this->bricks_.context().queue().finish();
}

template <typename T> void Arrivals::read(const Field& field, T nothing, T* out) const
{
  const Grid& grid = this->bricks_.model().grid();
  const Index3 size = this->bricks_.size();
  const std::size_t count = static_cast<std::size_t>(this->bricks_.elementsPerBrick());
  const std::size_t axes = field.runs;
  std::fill(out, out + axes * grid.voxels(), nothing);
  if (!field.buffer())
  {
    return;
  }
  std::vector<cl_int> fronts;
  std::vector<T> values;
  for (int slot = 1; slot < this->bricks_.slots(); ++slot)
  {
    this->bricks_.readSlot(this->front_, slot, fronts);
    if (std::all_of(fronts.begin(), fronts.end(), [](cl_int front) { return front == 0; }))
    {
      continue;
    }
    this->bricks_.readSlot(field, slot, values);
    const Index3 first = this->bricks_.origin(this->bricks_.brick(slot));
    const bool carved = this->bricks_.carvedBricks().count(this->bricks_.brick(slot)) > 0;
    for (int k = first[2]; k < std::min(first[2] + size[2], grid.size[2]); ++k)
    {
      for (int j = first[1]; j < std::min(first[1] + size[1], grid.size[1]); ++j)
      {
        for (int i = first[0]; i < std::min(first[0] + size[0], grid.size[0]); ++i)
        {
          const std::uint32_t local = this->bricks_.local(i, j, k);
          for (std::size_t a = 0; a < axes; ++a)
          {
            if (fronts[a * count + local] != 0 && !(carved && this->bricks_.carved(i, j, k)))
            {
              out[axes * grid.at(i, j, k) + a] = values[a * count + local];
            }
          }
        }
      }
    }
  }
}

void Arrivals::readTimes(float* out) const
{
  this->read<float>(this->time_, -1.0f, out);
}

void Arrivals::readFronts(int* out) const
{
  this->read<int>(this->front_, 0, out);
}

}
