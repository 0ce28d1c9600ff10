#include "Bricks.h"

#include "Error.h"

#include <algorithm>
#include <cmath>

namespace chainmail
{

Index3 defaultBrickSize(const DeviceInfo& device)
{
  // CPUs: a vector of 16 or two of 8 for each row and colour, and bricks that fit the second-level cache. GPUs: two
  // elements of a colour for each of 256 work-items.
  return device.takesManyItems() ? Index3{ 16, 8, 8 } : Index3{ 32, 8, 8 };
}

namespace
{

Index3 sizeOr(const Index3& wanted, const DeviceInfo& device)
{
  return wanted == Index3{ 0, 0, 0 } ? defaultBrickSize(device) : wanted;
}

}

Bricks::Bricks(
  std::shared_ptr<Context> context, std::shared_ptr<const Model> model, Index3 brickSize, const Turning& turning)
  : BrickTable(model->grid(), sizeOr(brickSize, context->info()))
  , context_(std::move(context))
  , model_(std::move(model))
  , links_(*this)
  , cutDistances_(*this)
  , turning_(turning)
{
  this->status_.assign(this->table_.size(), Status::Air);
  for (int k = 0; k < this->counts_[2]; ++k)
  {
    for (int j = 0; j < this->counts_[1]; ++j)
    {
      for (int i = 0; i < this->counts_[0]; ++i)
      {
        this->status_[(i + 1) + this->strideY_ * (j + 1) + this->strideZ_ * (k + 1)] = Status::Unknown;
      }
    }
  }
  this->tableBuffer_ = this->context_->upload(this->table_, "the brick table");

  // Slot 0 is a brick of air at rest.
  this->touched_.assign(1, 0);
  this->growTissue(1);
  this->growStates(1);
  const std::vector<float> air(this->elements_, -std::numeric_limits<float>::infinity());
  for (int a = 0; a < this->model_->axes(); ++a)
  {
    this->context_->write(this->constraint, sizeof(float) * a * this->tissuePitch(), air);
  }
  if (turning.on)
  {
    this->spins_ = std::make_unique<Spins>();
    this->spins_->proportions = proportionsOf(this->model_->grid());
    this->spins_->proportions.s[3] =
      static_cast<float>(2.0 * turning.poissonRatio / (1.0 - 2.0 * turning.poissonRatio));
    this->spins_->spin.runs = this->spins_->hasPressure() ? 10 : 3;
    this->keep(this->spins_->spin);
  }
  this->separateJoints();
}

int Bricks::width(bool vectors) const
{
  return vectors && !this->context_->info().takesManyItems() ? std::min(8, this->size_[0] / 2) : 1;
}

std::size_t Bricks::workItems(bool vectors) const
{
  if (vectors && !this->context_->info().takesManyItems())
  {
    return 1; // vectors are wide enough; a single work-item has all registers and needs neither atomics nor barriers
  }
  // 256 fits the local memory that measure.cl needs and the limits of all usual devices.
  return std::min(256, this->elements_ / 2 / this->width(vectors));
}

std::string Bricks::defines(bool vectors, const Spins* spins) const
{
  return this->definesFor(this->width(vectors), spins);
}

std::string Bricks::definesOfRows(const Spins* spins) const
{
  const DeviceInfo& device = this->context_->info();
  const int longest = device.floatsAtOnce < 16 ? this->width(true) : 16;
  return this->definesFor(device.takesManyItems() ? 1 : std::min(longest, this->size_[0] / 2), spins);
}

std::string Bricks::definesFor(int width, const Spins* spins) const
{
  return "-DBX=" + std::to_string(this->size_[0]) + " -DBY=" + std::to_string(this->size_[1]) +
         " -DBZ=" + std::to_string(this->size_[2]) + " -DWIDTH=" + std::to_string(width) +
         " -DAXES=" + std::to_string(this->model_->axes()) + " -DSKEW=" + std::to_string(skew) +
         (this->anyCut() ? " -DCUTS" : "") + (spins ? " -DTURNING" : "");
}

bool Bricks::fill(int brick, std::vector<float>& out) const
{
  const Grid& grid = this->model_->grid();
  const int axes = this->model_->axes();
  std::fill(out.begin(), out.end(), -std::numeric_limits<float>::infinity());
  std::vector<float> constraints(static_cast<std::size_t>(this->size_[0]) * axes);
  // A brick from which everything was carved keeps its memory, because mend() may fill it again.
  bool tissue = this->links_.carvedBricks().count(brick) > 0;
  for (const Row& row : this->rows(brick))
  {
    const Index3 first = grid.indexOf(row.voxel);
    this->row(first[0], first[1], first[2], row.count, constraints.data());
    for (int i = 0; i < row.count; ++i)
    {
      for (int a = 0; a < axes; ++a)
      {
        out[static_cast<std::size_t>(a) * this->elements_ + row.local(i)] = constraints[i * axes + a];
      }
      tissue = tissue || !std::isinf(constraints[i * axes]);
    }
  }
  return tissue;
}

namespace
{

/// A sentence on how large an image this device can hold, however much of it moves.
std::string whatFits(const DeviceInfo& device)
{
  constexpr std::size_t largestField = 3 * sizeof(float);
  // Displacement, displacement before a wave and constraint, plus a second copy of one of the displacements while it is
  // enlarged.
  constexpr std::size_t all = 3 * largestField + sizeof(float);
  const std::size_t voxels = std::min(device.maxAllocation / largestField, device.globalMemory / all);
  return "However much of it moves, an image of " + std::to_string(voxels / 1000000) +
         " million voxels fits: crop it to a volume of interest of that size.";
}

}

/// Allocates memory for a field.
cl::Buffer Bricks::allocate(std::size_t bytes, const char* purpose, Field::Start start)
{
  cl::Buffer buffer = this->context_->allocate(bytes, purpose, start == Field::Start::Zeros ? bytes : 1);
  if (start == Field::Start::Infinity)
  {
    this->context_->queue().enqueueFillBuffer(buffer, std::numeric_limits<cl_float>::infinity(), 0, bytes);
  }
  return buffer;
}

/// Enlarges each run of a field.
void Bricks::enlarge(cl::Buffer& buffer, std::size_t runs, std::size_t bytes, std::size_t oldPitch, std::size_t pitch,
  const char* purpose, Field::Start start)
{
  if (pitch * runs > std::numeric_limits<std::uint32_t>::max())
  {
    throw MemoryError("The deformation reaches more tissue than one device can address (1.4 billion elements). Crop "
                      "the scan or resample it to fewer voxels.");
  }
  const std::size_t values = buffer() ? oldPitch - skew : 0;
  cl::Buffer larger;
  try
  {
    larger = this->allocate(runs * pitch * bytes, purpose, start);
  }
  catch (const MemoryError& error)
  {
    throw MemoryError(std::string(error.what()) + ' ' + whatFits(this->context_->info()));
  }
  cl::CommandQueue& queue = this->context_->queue();
  for (std::size_t run = 0; values > 0 && run < runs; ++run)
  {
    queue.enqueueCopyBuffer(buffer, larger, run * oldPitch * bytes, run * pitch * bytes, values * bytes);
  }
  queue.finish();
  buffer = larger; // frees the old one before the next field grows, so at most one field exists twice
}

namespace
{

/// The new capacity in slots. Small capacities double, so copies are rare; large ones grow by a sixteenth, so little
/// memory stays empty.
int roomFor(int slots, int before, int most)
{
  constexpr int few = 1024;
  return std::min(std::max({ slots, before + (before < few ? before : before / 16), 64 }), std::max(most, slots));
}

}

void Bricks::growTissue(int slots)
{
  if (slots <= this->tissueCapacity_)
  {
    return;
  }
  const std::size_t oldPitch = this->tissuePitch();
  const int bricks = this->counts_[0] * this->counts_[1] * this->counts_[2] + 1;
  this->tissueCapacity_ = roomFor(slots, this->tissueCapacity_, bricks);
  this->enlarge(this->constraint, static_cast<std::size_t>(this->model_->axes()), sizeof(float), oldPitch,
    this->tissuePitch(), "the constraints of the tissue reached");
  if (this->anyCut())
  {
    this->enlarge(this->cut, 1, 1, oldPitch, this->tissuePitch(), "the cuts");
  }
  if (this->links_.anyAtJoint())
  {
    this->enlarge(this->shownCut_, 1, 1, oldPitch, this->tissuePitch(), "the cuts");
  }
  std::vector<int> place = this->place_;
  place.resize(this->tissueCapacity_, 0);
  this->placeBuffer_ = this->context_->upload(place, "the brick list");
}

void Bricks::growStates(int slots)
{
  if (slots <= this->capacity_)
  {
    return;
  }
  const std::size_t oldPitch = this->pitch();
  this->capacity_ = roomFor(slots, this->capacity_, this->tissueCapacity_);
  this->enlarge(
    this->displacement, 3, sizeof(float), oldPitch, this->pitch(), "the displacement of the tissue reached");
  for (Field* field : this->fields_)
  {
    this->enlarge(field->buffer, field->runs, field->bytes, oldPitch, this->pitch(), field->purpose, field->start);
  }
}

/// Loads the tissue of bricks with Status::Unknown.
void Bricks::readTissue(const std::vector<int>& bricks)
{
  // New slots are consecutive, so many bricks are uploaded in one transfer.
  constexpr std::size_t batch = 256;
  const std::size_t axes = this->model_->axes();
  const std::size_t count = this->elements_;
  std::vector<int> found;
  std::vector<float> constraints(axes * count);
  std::vector<std::vector<float>> staging(axes);
  const auto flush = [&]
  {
    const std::size_t first = this->slots();
    this->growTissue(static_cast<int>(first + found.size()));
    for (std::size_t a = 0; a < axes; ++a)
    {
      this->context_->write(this->constraint, sizeof(float) * (a * this->tissuePitch() + first * count), staging[a]);
      staging[a].clear();
    }
    for (const int brick : found)
    {
      this->table_[brick] = this->slots();
      this->place_.push_back(brick);
      this->known_.push_back(brick);
      this->status_[brick] = Status::Known;
      const auto bits = this->links_.all().find(brick);
      if (bits != this->links_.all().end() && this->cut())
      {
        this->writeCuts(brick, bits->second);
      }
    }
    found.clear();
  };
  for (const int brick : bricks)
  {
    if (!this->fill(brick, constraints))
    {
      this->status_[brick] = Status::Air;
      continue;
    }
    found.push_back(brick);
    for (std::size_t a = 0; a < axes; ++a)
    {
      staging[a].insert(staging[a].end(), constraints.begin() + a * count, constraints.begin() + (a + 1) * count);
    }
    if (found.size() == batch)
    {
      flush();
    }
  }
  flush();
}

void Bricks::loadTissue(const std::vector<int>& bricks)
{
  std::vector<int> wanted;
  for (const int brick : bricks)
  {
    if (this->isUpdatable(brick))
    {
      continue;
    }
    for (int z = -1; z <= 1; ++z)
    {
      for (int y = -1; y <= 1; ++y)
      {
        for (int x = -1; x <= 1; ++x)
        {
          const int near = this->beside(brick, x, y, z);
          if (this->status_[near] == Status::Unknown)
          {
            wanted.push_back(near);
          }
        }
      }
    }
  }
  const int before = this->slots();
  std::sort(wanted.begin(), wanted.end());
  wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
  this->readTissue(wanted);
  if (this->slots() > before)
  {
    this->uploadTables();
  }
}

void Bricks::uploadTables()
{
  this->context_->write(this->tableBuffer_, 0, this->table_);
  this->context_->write(this->placeBuffer_, 0, this->place_);
}

void Bricks::makeUpdatable(const std::vector<int>& bricks)
{
  this->loadTissue(bricks);
  this->allocateStates(bricks);
  for (const int brick : bricks)
  {
    this->status_[brick] = this->status_[brick] == Status::Known ? Status::Ready : this->status_[brick];
  }
}

/// The bricks get the slots behind those with a state, in exchange with bricks without one.
void Bricks::allocateStates(const std::vector<int>& bricks)
{
  std::vector<char> wanted(this->slots(), 0);
  int count = 0;
  for (const int brick : bricks)
  {
    const int slot = this->slot(brick);
    if (slot >= this->states_ && !wanted[slot])
    {
      wanted[slot] = 1;
      ++count;
    }
  }
  if (count == 0)
  {
    return;
  }
  int next = this->states_;
  this->states_ += count;
  this->growStates(this->states_);
  this->touched_.resize(this->states_, 0);
  std::vector<cl_uint> pairs;
  for (int from = this->states_; from < this->slots(); ++from)
  {
    if (!wanted[from])
    {
      continue;
    }
    while (wanted[next])
    {
      ++next;
    }
    pairs.push_back(static_cast<cl_uint>(next));
    pairs.push_back(static_cast<cl_uint>(from));
    this->exchanged_.emplace_back(next, from);
    std::swap(this->place_[next], this->place_[from]);
    this->table_[this->place_[next]] = next;
    this->table_[this->place_[from]] = from;
    ++next;
  }
  if (pairs.empty())
  {
    return;
  }
  const cl::Buffer& list = this->addresses_.holding(*this->context_, pairs);
  const std::size_t perBrick = static_cast<std::size_t>(this->elements_);
  this->exchange(this->constraint, static_cast<std::size_t>(this->model_->axes()), perBrick, list, pairs.size() / 2);
  if (this->cut())
  {
    this->exchange(this->cut, 1, perBrick / sizeof(cl_uint), list, pairs.size() / 2);
  }
  if (this->shownCut_())
  {
    this->exchange(this->shownCut_, 1, perBrick / sizeof(cl_uint), list, pairs.size() / 2);
  }
  this->uploadTables();
}

/// Exchanges the values of `count` pairs of slots, `perBrick` 4-byte values per slot and run.
void Bricks::exchange(
  const cl::Buffer& field, std::size_t runs, std::size_t perBrick, const cl::Buffer& pairs, std::size_t count)
{
  this->context_->launch(this->context_->kernel("scatter.cl", "", "exchange"), count, 64, field, this->tissuePitch(),
    static_cast<cl_int>(runs), static_cast<cl_uint>(perBrick), pairs);
}

void Bricks::follow(SharedTable& rows, std::size_t& followed) const
{
  for (; followed < this->exchanged_.size(); ++followed)
  {
    rows.exchange(this->exchanged_[followed].first, this->exchanged_[followed].second);
  }
}

void Bricks::keep(Field& field, Field::Start start)
{
  if (!field.buffer())
  {
    field.buffer = this->allocate(field.runs * this->pitch() * field.bytes, field.purpose, start);
    field.start = start;
    this->fields_.push_back(&field);
  }
}

void Bricks::drop(Field& field)
{
  field.buffer = cl::Buffer();
  this->fields_.erase(std::remove(this->fields_.begin(), this->fields_.end(), &field), this->fields_.end());
}

void Bricks::clearDisplacements()
{
  this->context_->queue().enqueueFillBuffer(this->displacement, cl_float(0), 0, sizeof(float) * 3 * this->pitch());
  if (this->spins_)
  {
    this->context_->queue().enqueueFillBuffer(
      this->spins_->spin.buffer, cl_float(0), 0, sizeof(float) * this->spins_->spin.runs * this->pitch());
    this->spins_->any = false;
  }
  std::fill(this->touched_.begin(), this->touched_.end(), 0);
}

void Bricks::setSoftLinks(std::vector<SoftLink> links)
{
  this->soft_.reset(); // frees the old ones first, so both never exist at once
  if (links.empty())
  {
    return;
  }
  this->soft_ = std::make_unique<SoftLinks>(*this->context_, *this, this->model_->grid(), std::move(links));
  for (const SoftLink& link : this->soft_->all())
  {
    const Index3 at = this->model_->grid().indexOf(link.voxel);
    this->touch(this->slot(this->brickAt(at[0], at[1], at[2])));
  }
}

std::vector<int> Bricks::touchedSlots() const
{
  std::vector<int> slots;
  for (int slot = 1; slot < this->states_; ++slot)
  {
    if (this->touched_[slot] != 0)
    {
      slots.push_back(slot);
    }
  }
  return slots;
}

std::vector<int> Bricks::bricksWhere(const std::vector<int>& slots, const std::vector<cl_int>& found) const
{
  std::vector<int> bricks;
  for (std::size_t n = 0; n < slots.size(); ++n)
  {
    if (found[n] != 0)
    {
      bricks.push_back(this->brick(slots[n]));
    }
  }
  return bricks;
}

std::vector<int> Bricks::slotsAround(const std::vector<int>& slots) const
{
  std::vector<char> isAround(this->slots(), 0);
  for (const int slot : slots)
  {
    isAround[slot] = 1;
    for (int direction = 0; direction < 6; ++direction)
    {
      isAround[this->slot(this->neighbour(this->brick(slot), direction))] = 1;
    }
  }
  std::vector<int> around;
  for (int slot = 1; slot < this->slots(); ++slot)
  {
    if (isAround[slot] != 0)
    {
      around.push_back(slot);
    }
  }
  return around;
}

void Bricks::saveIn(Field& field)
{
  constexpr cl_uint perGroup = 1 << 14;
  this->keep(field, Field::Start::Anything);
  field.start = Field::Start::Zeros; // bricks that get a state later are at rest in the saved field
  const cl_uint count = 3 * this->pitch();
  this->context_->launch(this->context_->kernel("scatter.cl", "", "copy"), (count + perGroup - 1) / perGroup,
    this->workItems(true), this->displacement, field.buffer, count, perGroup);
}

void Bricks::saveIn(Field& field, const std::vector<int>& slots)
{
  this->keep(field, Field::Start::Anything);
  this->copyBricks(slots, this->displacement, field.buffer);
}

void Bricks::restoreBefore(const std::vector<int>& slots)
{
  this->copyBricks(slots, this->before(), this->displacement);
}

void Bricks::copyBricks(const std::vector<int>& slots, const cl::Buffer& from, const cl::Buffer& to)
{
  this->context_->launch(this->context_->kernel("scatter.cl", "", "copyBricks"), slots.size(), this->workItems(true),
    from, to, this->pitch(), static_cast<cl_uint>(this->elements_), this->addresses_.holding(*this->context_, slots));
}

void Bricks::removeElements(const std::vector<std::size_t>& voxels)
{
  std::vector<std::uint32_t> known;
  std::vector<std::uint32_t> movable;
  for (const std::size_t voxel : voxels)
  {
    const Index3 at = this->model_->grid().indexOf(voxel);
    this->links_.removeElement(at[0], at[1], at[2]);
    const int brick = this->brickAt(at[0], at[1], at[2]);
    if (this->slot(brick) > 0)
    {
      known.push_back(this->address(at[0], at[1], at[2]));
    }
    if (this->hasState(brick))
    {
      movable.push_back(this->address(at[0], at[1], at[2]));
    }
  }
  this->uploadCuts();
  const std::size_t axes = this->model_->axes();
  this->setConstraints(known, std::vector<float>(axes * known.size(), -std::numeric_limits<float>::infinity()));
  const std::vector<float> atRest(3 * movable.size(), 0.0f);
  this->setDisplacements(movable, atRest);
  if (this->spins_)
  {
    this->setSpins(movable, atRest);
  }
}

void Bricks::row(int i, int j, int k, int count, float* out) const
{
  this->model_->row(i, j, k, count, out);
  this->links_.takeOut(i, j, k, count, this->model_->axes(), out);
}

bool Bricks::isElement(const Index3& at) const
{
  float c[3];
  this->row(at[0], at[1], at[2], 1, c);
  return !std::isinf(c[0]);
}

void Bricks::restoreTopology()
{
  this->cut = cl::Buffer();
  this->shownCut_ = cl::Buffer();
  const std::set<int> carved = this->links_.carvedBricks();
  this->links_.clear();
  this->cutDistances_.clear();
  const std::size_t axes = this->model_->axes();
  const std::size_t count = this->elements_;
  std::vector<float> constraints(axes * count);
  for (const int brick : carved)
  {
    if (this->slot(brick) > 0)
    {
      this->fill(brick, constraints);
      for (std::size_t a = 0; a < axes; ++a)
      {
        const std::vector<float> run(constraints.begin() + a * count, constraints.begin() + (a + 1) * count);
        this->context_->write(
          this->constraint, sizeof(float) * (a * this->tissuePitch() + this->slot(brick) * count), run);
      }
    }
  }
  this->separateJoints();
}

void Bricks::uploadCuts()
{
  if (!this->anyCut())
  {
    return;
  }
  if (!this->cut())
  {
    this->cut = this->context_->allocate(this->tissuePitch(), "the cuts");
  }
  if (this->links_.anyAtJoint() && !this->shownCut_())
  {
    this->shownCut_ = this->context_->allocate(this->tissuePitch(), "the cuts");
  }
  for (const auto& [brick, bits] : this->links_.all())
  {
    if (this->slot(brick) > 0)
    {
      this->writeCuts(brick, bits);
    }
  }
}

/// Copies the removed links of a brick with a slot to the device.
void Bricks::writeCuts(int brick, const std::vector<std::uint8_t>& bits)
{
  const std::size_t first = static_cast<std::size_t>(this->slot(brick)) * this->elements_;
  this->context_->write(this->cut, first, bits);
  if (this->shownCut_())
  {
    this->context_->write(this->shownCut_, first, this->links_.shown(brick));
  }
}

/// Removes the links across free joints.
void Bricks::separateJoints()
{
  for (const auto& [voxel, axis] : this->model_->linksOfJoints())
  {
    const Index3 at = this->model_->grid().indexOf(voxel);
    this->links_.removeAtJoint(at[0], at[1], at[2], 2 * axis + 1);
  }
  this->uploadCuts();
}

std::size_t Bricks::deviceBytes() const
{
  std::size_t state = 3 * sizeof(float);
  for (const Field* field : this->fields_)
  {
    state += field->runs * field->bytes;
  }
  const std::size_t tissue = sizeof(float) * static_cast<std::size_t>(this->model_->axes()) + (this->cut() ? 1 : 0) +
                             (this->shownCut_() ? 1 : 0);
  return state * this->pitch() + tissue * this->tissuePitch() +
         sizeof(int) * (this->table_.size() + this->tissueCapacity_) + this->addresses_.bytes() +
         this->values_.bytes() + (this->soft_ ? this->soft_->bytes() : 0);
}

}
