#include "ArrivalTimes.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <numeric>

namespace chainmail
{

ArrivalTimes::ArrivalTimes(Bricks& bricks)
  : bricks_(bricks)
  , fixedPoint_(bricks, "arrivals.cl", "arrive")
  , time_{ static_cast<std::size_t>(bricks.model().axes()), sizeof(cl_float), "propagation times" }
  , front_{ static_cast<std::size_t>(bricks.model().axes()), sizeof(cl_int), "wave ids" }
  , arrival_{ static_cast<std::size_t>(bricks.model().axes()), sizeof(cl_float), "propagation times" }
{
}

ArrivalTimes::~ArrivalTimes()
{
  this->bricks_.removeField(this->time_);
  this->bricks_.removeField(this->front_);
  this->bricks_.removeField(this->arrival_);
}

void ArrivalTimes::allocate()
{
  this->bricks_.addField(this->time_);
  this->bricks_.addField(this->front_);
}

void ArrivalTimes::start(const Handle& source, int front)
{
  const std::size_t axes = static_cast<std::size_t>(this->bricks_.model().axes());
  source.elements.set(this->time_, std::vector<cl_float>(axes * source.elements.size(), 0.0f));
  source.elements.set(this->front_, std::vector<cl_int>(axes * source.elements.size(), front));
}

void ArrivalTimes::computeTimes(const std::vector<const Handle*>& sources, int front, const Checkpoint& checkpoint)
{
  const cl_int states = this->bricks_.states();
  this->allocate();
  this->bricks_.addField(this->arrival_, Field::Start::Infinity);
  Context& context = this->bricks_.context();
  const std::size_t axes = this->arrival_.runs;
  context.queue().enqueueFillBuffer(this->arrival_.buffer, std::numeric_limits<cl_float>::infinity(), 0,
    sizeof(cl_float) * axes * this->bricks_.pitch());
  std::vector<int> bricks;
  Elements elements(this->bricks_);
  for (const Handle* source : sources)
  {
    elements.add(source->elements);
    bricks.insert(bricks.end(), source->bricks.begin(), source->bricks.end());
  }
  elements.set(this->arrival_, std::vector<cl_float>(axes * elements.size(), 0.0f));

  this->fixedPoint_.start(bricks);
  this->fixedPoint_.run(0, std::numeric_limits<float>::infinity(), checkpoint,
    [this, states](ArgumentList& own) { own.add(this->bricks_.before().buffer(), states, this->arrival_.buffer); });

  const std::vector<int> slots = this->fixedPoint_.seen();
  Scratch list("the list of active bricks");
  context.launch(context.kernel("arrivals.cl", this->bricks_.definesOfRows(this->bricks_.activeRotations()), "record"),
    slots.size(), this->bricks_.workItems(true), list.holding(context, slots), this->bricks_.pitch(),
    this->arrival_.buffer, front, this->time_.buffer, this->front_.buffer);
  context.queue().finish();
}

void ArrivalTimes::clear()
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

// Reads a field of 4-byte integers or floats into `out`, only where a wave came.
template <typename T> void ArrivalTimes::read(const Field& field, const VoxelBox& box, T* out) const
{
  static_assert(sizeof(T) == sizeof(cl_int), "fields are read as integers");
  if (!field.buffer())
  {
    return;
  }
  const std::size_t axes = field.runs;
  std::vector<int> slots(this->bricks_.states() - 1);
  std::iota(slots.begin(), slots.end(), 1);
  this->bricks_.readSlots<cl_int>({ { this->front_.buffer, axes }, { field.buffer, axes } },
    this->bricks_.slotsIn(box, slots),
    [&](int slot, const Bricks::SlotValues<cl_int>& values)
    {
      const int brick = this->bricks_.brick(slot);
      const auto cut = this->bricks_.links().all().find(brick);
      const std::uint8_t* cutBits = cut == this->bricks_.links().all().end() ? nullptr : cut->second.data();
      this->bricks_.forRows(brick, box,
        [&](const Bricks::Row& row, int first, int last, std::size_t at)
        {
          for (int i = first; i < last; ++i, ++at)
          {
            const std::uint32_t local = row.local(i);
            for (std::size_t a = 0; a < axes; ++a)
            {
              if (values(a, local) != 0 && !(cutBits && (cutBits[local] & CARVED_BIT) != 0))
              {
                const cl_int bits = values(axes + a, local);
                std::memcpy(out + axes * at + a, &bits, sizeof(bits));
              }
            }
          }
        });
    });
}

void ArrivalTimes::readTimes(const VoxelBox& box, float* out) const
{
  std::fill(out, out + this->time_.runs * box.voxels(), -1.0f);
  this->read(this->time_, box, out);
}

void ArrivalTimes::readFronts(const VoxelBox& box, int* out, bool zeroed) const
{
  if (!zeroed)
  {
    std::fill(out, out + this->front_.runs * box.voxels(), 0);
  }
  this->read(this->front_, box, out);
}

}
