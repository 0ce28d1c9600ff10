#include "BrickStorage.h"

#include "Error.h"

#include <algorithm>
#include <limits>
#include <string>

namespace chainmail
{

namespace
{

Index3 sizeOr(const Index3& wanted, const DeviceInfo& device)
{
  return wanted == Index3{ 0, 0, 0 } ? defaultBrickSize(device) : wanted;
}

/// A sentence on how large an image this device can hold, however much of it moves.
std::string whatFits(const DeviceInfo& device)
{
  constexpr std::size_t largestField = 3 * sizeof(float);
  // Displacement, displacement before a wave and constraint, plus a second copy of one of the displacements while it is
  // enlarged.
  constexpr std::size_t all = 3 * largestField + sizeof(float);
  const std::size_t voxels = std::min(device.maxAllocation / largestField, device.globalMemory / all);
  return "The device can hold an image of " + std::to_string(voxels / 1000000) +
         " million voxels, however much of it moves: crop the scan to that size.";
}

/// The values that each work-group clears or copies.
constexpr cl_uint valuesPerGroup = 1 << 14;

/// The new capacity in slots. Small capacities double, so copies are rare; large ones grow by a sixteenth, so little
/// memory stays empty.
int roomFor(int slots, int before, int most)
{
  constexpr int few = 1024;
  return std::min(std::max({ slots, before + (before < few ? before : before / 16), 64 }), std::max(most, slots));
}

}

BrickStorage::BrickStorage(std::shared_ptr<Context> context, const Grid& grid, const Index3& brickSize, int axes)
  : BrickTable(grid, sizeOr(brickSize, context->info()))
  , context_(std::move(context))
  , options_(this->context_->info(), this->size(), axes)
{
  this->tableBuffer_ = this->context_->upload(this->table_, "the brick table");
  this->growTissue(1); // slot 0, a brick of air at rest
  this->growStates(1);
}

// --- Slots

void BrickStorage::reserve(std::size_t tissue, std::size_t states)
{
  this->growTissue(static_cast<int>(tissue) + 1);
  this->growStates(static_cast<int>(states) + 1);
}

void BrickStorage::addSlots(const std::vector<int>& bricks)
{
  this->growTissue(this->slots() + static_cast<int>(bricks.size()));
  for (const int brick : bricks)
  {
    this->table_[brick] = this->slots();
    this->place_.push_back(brick);
  }
}

void BrickStorage::takeSlots()
{
  for (std::size_t slot = 1; slot < this->place_.size(); ++slot)
  {
    this->table_[this->place_[slot]] = 0;
  }
  this->place_.resize(1);
  this->states_ = 1;
  this->exchanged_.clear();
  for (const Field* field : this->fields_)
  {
    this->startAgain(*field, this->pitch());
  }
  for (const Field* field : this->tissueFields_)
  {
    this->startAgain(*field, this->tissuePitch());
  }
  this->uploadTables();
}

void BrickStorage::uploadTables()
{
  this->context_->write(this->tableBuffer_, 0, this->table_);
  this->context_->write(this->placeBuffer_, 0, this->place_);
}

/// The bricks get the slots behind those with a state, in exchange with bricks without one.
void BrickStorage::addStates(const std::vector<int>& bricks)
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
  for (const Field* field : this->tissueFields_)
  {
    // The kernel exchanges 4-byte values.
    const std::size_t perBrick = field->bytes * this->elements_ / sizeof(cl_uint);
    this->context_->launch(this->context_->kernel("scatter.cl", "", "exchange"), pairs.size() / 2, 64, field->buffer,
      this->tissuePitch(), static_cast<cl_int>(field->runs), static_cast<cl_uint>(perBrick), list);
  }
  this->uploadTables();
}

void BrickStorage::applyExchanges(SharedTable& rows, std::size_t& applied) const
{
  for (; applied < this->exchanged_.size(); ++applied)
  {
    rows.exchange(this->exchanged_[applied].first, this->exchanged_[applied].second);
  }
}

// --- Fields

void BrickStorage::addField(Field& field, Field::Start start)
{
  if (!field.buffer())
  {
    field.buffer = this->allocate(field.runs * this->pitch() * field.bytes, field.purpose, start);
    field.start = start;
    this->fields_.push_back(&field);
  }
}

void BrickStorage::addTemporary(Field& field)
{
  if (!field.buffer())
  {
    this->addField(field, Field::Start::Anything);
    field.start = Field::Start::Zeros; // of bricks that get a state later
    this->clear(field);
  }
}

void BrickStorage::removeField(Field& field)
{
  field.buffer = cl::Buffer();
  this->fields_.erase(std::remove(this->fields_.begin(), this->fields_.end(), &field), this->fields_.end());
}

void BrickStorage::addTissueField(Field& field)
{
  if (!field.buffer())
  {
    field.buffer = this->allocate(field.runs * this->tissuePitch() * field.bytes, field.purpose, field.start);
    this->tissueFields_.push_back(&field);
  }
}

void BrickStorage::removeTissueField(Field& field)
{
  field.buffer = cl::Buffer();
  this->tissueFields_.erase(
    std::remove(this->tissueFields_.begin(), this->tissueFields_.end(), &field), this->tissueFields_.end());
}

cl::Buffer BrickStorage::allocate(std::size_t bytes, const char* purpose, Field::Start start)
{
  cl::Buffer buffer = this->context_->allocate(bytes, purpose, start == Field::Start::Zeros ? bytes : 1);
  if (start == Field::Start::Infinity)
  {
    this->context_->queue().enqueueFillBuffer(buffer, std::numeric_limits<cl_float>::infinity(), 0, bytes);
  }
  return buffer;
}

/// Gives all elements of a field the content of new memory.
void BrickStorage::startAgain(const Field& field, std::size_t pitch) const
{
  const std::size_t bytes = field.runs * pitch * field.bytes;
  switch (field.start)
  {
  case Field::Start::Zeros:
    this->context_->queue().enqueueFillBuffer(field.buffer, cl_uchar(0), 0, bytes);
    break;
  case Field::Start::Infinity:
    this->context_->queue().enqueueFillBuffer(field.buffer, std::numeric_limits<cl_float>::infinity(), 0, bytes);
    break;
  case Field::Start::Anything:
    break;
  }
}

/// Enlarges each run of a field.
void BrickStorage::enlarge(Field& field, std::size_t oldPitch, std::size_t pitch)
{
  if (pitch * field.runs > std::numeric_limits<std::uint32_t>::max())
  {
    throw MemoryError("The deformation reaches more tissue than one device can address (1.4 billion elements). Crop "
                      "the scan or resample it to fewer voxels.");
  }
  cl::Buffer larger;
  try
  {
    larger = this->allocate(field.runs * pitch * field.bytes, field.purpose, field.start);
  }
  catch (const MemoryError& error)
  {
    throw MemoryError(std::string(error.what()) + ' ' + whatFits(this->context_->info()));
  }
  cl::CommandQueue& queue = this->context_->queue();
  for (std::size_t run = 0; oldPitch > skew && run < field.runs; ++run)
  {
    queue.enqueueCopyBuffer(
      field.buffer, larger, run * oldPitch * field.bytes, run * pitch * field.bytes, (oldPitch - skew) * field.bytes);
  }
  queue.finish();
  field.buffer = larger; // frees the old one before the next field grows, so at most one field exists twice
}

void BrickStorage::growTissue(int slots)
{
  if (slots <= this->tissueCapacity_)
  {
    return;
  }
  const std::size_t oldPitch = this->tissuePitch();
  const int bricks = this->counts_[0] * this->counts_[1] * this->counts_[2] + 1;
  this->tissueCapacity_ = roomFor(slots, this->tissueCapacity_, bricks);
  for (Field* field : this->tissueFields_)
  {
    this->enlarge(*field, oldPitch, this->tissuePitch());
  }
  std::vector<int> place = this->place_;
  place.resize(this->tissueCapacity_, 0);
  this->placeBuffer_ = this->context_->upload(place, "the brick list");
}

void BrickStorage::growStates(int slots)
{
  if (slots <= this->capacity_)
  {
    return;
  }
  const std::size_t oldPitch = this->pitch();
  this->capacity_ = roomFor(slots, this->capacity_, this->tissueCapacity_);
  for (Field* field : this->fields_)
  {
    this->enlarge(*field, oldPitch, this->pitch());
  }
}

std::size_t BrickStorage::bytes() const
{
  std::size_t state = 0;
  for (const Field* field : this->fields_)
  {
    state += field->runs * field->bytes;
  }
  std::size_t tissue = 0;
  for (const Field* field : this->tissueFields_)
  {
    tissue += field->runs * field->bytes;
  }
  return state * this->pitch() + tissue * this->tissuePitch() +
         sizeof(int) * (this->table_.size() + this->tissueCapacity_) + this->addresses_.bytes() + this->values_.bytes();
}

// --- Values of fields

void BrickStorage::scatter(
  const Field& field, cl_uint pitch, const std::vector<std::uint32_t>& addresses, const cl::Buffer& values)
{
  Context& context = *this->context_;
  context.launchOver(context.kernel("scatter.cl", "", "scatter"), addresses.size(), field.buffer, pitch,
    static_cast<cl_int>(field.runs), this->addresses_.holding(context, addresses), values);
}

std::vector<float> BrickStorage::get(
  const cl::Buffer& field, std::size_t runs, cl_uint pitch, const std::vector<std::uint32_t>& addresses) const
{
  Context& context = *this->context_;
  std::vector<float> values(runs * addresses.size());
  if (!addresses.empty())
  {
    const cl::Buffer& out = this->values_.sized(context, sizeof(float) * values.size());
    // From the address pitch - skew on there are zeros: elements without a state are at rest.
    context.launchOver(context.kernel("scatter.cl", "", "gather"), addresses.size(), field, pitch,
      static_cast<cl_uint>(pitch - skew), static_cast<cl_int>(runs), this->addresses_.holding(context, addresses), out);
    context.read(out, values);
  }
  return values;
}

void BrickStorage::readSlot(const Field& field, int slot, std::vector<float>& out) const
{
  const std::size_t count = static_cast<std::size_t>(this->elements_);
  out.resize(3 * count);
  for (std::size_t a = 0; a < 3; ++a)
  {
    this->context_->queue().enqueueReadBuffer(field.buffer, CL_TRUE, sizeof(float) * (a * this->pitch() + slot * count),
      sizeof(float) * count, out.data() + a * count);
  }
}

void BrickStorage::clear(const Field& field) const
{
  if (field.buffer())
  {
    const auto count = static_cast<cl_uint>(field.runs * this->pitch() * field.bytes / sizeof(cl_uint));
    this->context_->launch(this->context_->kernel("scatter.cl", "", "clear"),
      (count + valuesPerGroup - 1) / valuesPerGroup, this->options_.workItems(true), field.buffer, count,
      valuesPerGroup);
  }
}

void BrickStorage::copy(const Field& from, const Field& to) const
{
  const cl_uint count = 3 * this->pitch();
  this->context_->launch(this->context_->kernel("scatter.cl", "", "copy"),
    (count + valuesPerGroup - 1) / valuesPerGroup, this->options_.workItems(true), from.buffer, to.buffer, count,
    valuesPerGroup);
}

void BrickStorage::copy(const Field& from, const Field& to, const std::vector<int>& slots) const
{
  this->context_->launch(this->context_->kernel("scatter.cl", "", "copyBricks"), slots.size(),
    this->options_.workItems(true), from.buffer, to.buffer, this->pitch(), static_cast<cl_uint>(this->elements_),
    this->addresses_.holding(*this->context_, slots));
}

}
