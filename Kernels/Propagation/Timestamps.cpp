#include "Timestamps.h"

#include "Error.h"
#include "Pass.h"

namespace chainmail
{

Timestamps::Timestamps(Bricks& bricks, ArrivalTimes& arrivals)
  : bricks_(bricks)
  , arrivals_(arrivals)
  , stamp_{ static_cast<std::size_t>(bricks.model().axes()), sizeof(cl_int), "activity flags" }
  , nextTime_{ static_cast<std::size_t>(bricks.model().axes()), sizeof(cl_float), "propagation times" }
  , nextFront_{ static_cast<std::size_t>(bricks.model().axes()), sizeof(cl_int), "wave ids" }
{
}

Timestamps::~Timestamps()
{
  this->clear();
}

void Timestamps::clear()
{
  this->active_.clear();
  this->iteration_ = 1;
  for (Field* field : { &this->stamp_, &this->nextTime_, &this->nextFront_ })
  {
    this->bricks_.removeField(*field);
  }
}

void Timestamps::allocate()
{
  this->arrivals_.allocate();
  this->bricks_.before().allocate();
  for (Field* field : { &this->stamp_, &this->nextTime_, &this->nextFront_ })
  {
    this->bricks_.addField(*field);
  }
}

void Timestamps::start(const Handle& source, int front)
{
  this->allocate();
  this->arrivals_.start(source, front);
  source.elements.set(this->stamp_, std::vector<cl_int>(this->stamp_.runs * source.elements.size(), this->iteration_));
  for (const int brick : source.bricks)
  {
    this->active_.insert(brick);
    for (int d = 0; d < 6; ++d)
    {
      this->active_.insert(this->bricks_.neighbour(brick, d));
    }
  }
}

int Timestamps::run(int iterations, const Checkpoint& checkpoint)
{
  int done = 0;
  while (!this->finished() && (iterations == 0 || done < iterations))
  {
    checkpoint();
    this->advance();
    ++done;
    // Iteration n completes paths of n links, and the path of the earliest time visits no element twice.
    if (static_cast<std::size_t>(done) > this->bricks_.model().grid().voxels() && !this->finished())
    {
      throw Error("An error of the engine: waves do not end. Reset the tissue, and please report this error.");
    }
  }
  return done;
}

const WavesUnderWay& Timestamps::underWay()
{
  this->allocate();
  this->underWay_.front = &this->arrivals_.front().buffer;
  this->underWay_.stamp = &this->stamp_.buffer;
  this->underWay_.iteration = this->iteration_;
  return this->underWay_;
}

void Timestamps::advance()
{
  ++this->iteration_;
  const std::vector<int> wanted(this->active_.begin(), this->active_.end());
  this->active_.clear();
  this->bricks_.makeUpdatable(wanted);
  const std::vector<int> list = this->bricks_.slotsOf(wanted);
  if (list.empty())
  {
    return;
  }

  Context& context = this->bricks_.context();
  const cl::Buffer& slots = this->list_.holding(context, list);
  std::vector<cl_int> faces(list.size());
  const cl::Buffer& result = this->result_.sized(context, sizeof(cl_int) * faces.size());
  const std::string defines = this->bricks_.defines(false);
  const std::size_t items = this->bricks_.workItems(false);

  const auto arguments = std::tuple_cat(
    std::make_tuple(this->bricks_.state(this->bricks_.rotations()), static_cast<cl_int>(this->iteration_)),
    std::tie(this->arrivals_.time().buffer, this->arrivals_.front().buffer, this->stamp_.buffer,
      this->bricks_.before().buffer(), this->nextTime_.buffer, this->nextFront_.buffer));

  context.launch(context.kernel("timestamp.cl", defines, "arriveNext"), list.size(), items, slots, arguments);
  launchPass(
    this->bricks_, context.kernel("timestamp.cl", defines, "shift"), list.size(), items, slots, arguments, result);
  context.read(result, faces);

  for (std::size_t n = 0; n < list.size(); ++n)
  {
    if (faces[n] == 0)
    {
      continue;
    }
    this->bricks_.markDirty(list[n]);
    const int brick = this->bricks_.brick(list[n]);
    this->active_.insert(brick);
    for (int d = 0; d < 6; ++d)
    {
      if (faces[n] & (1 << d))
      {
        this->active_.insert(this->bricks_.neighbour(brick, d));
      }
    }
  }
}

}
