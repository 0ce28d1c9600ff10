#pragma once

#include "BrickTable.h"
#include "Context.h"
#include "KernelOptions.h"
#include "SharedTable.h"
#include "Threads.h"

#include <cstdint>
#include <memory>
#include <tuple>
#include <utility>
#include <vector>

namespace chainmail
{

/// A field: values for every element of all bricks that have memory for it, laid out as [run][address], where a run is
/// one component.
struct Field
{
  std::size_t runs;
  std::size_t bytes; ///< of one value
  const char* purpose;
  cl::Buffer buffer{};
  /// The initial content of new memory. BrickStorage::addField() sets it for a state field.
  enum class Start
  {
    Zeros,
    Infinity, ///< as a float
    Anything
  };
  Start start = Start::Zeros;
};

/// The memory of bricks on the device: slots of a pool, which bricks get one by one, and the fields that are stored in
/// them. brick.clh describes the layout and the addresses.
///
/// State fields take most of the memory, so they exist in the first slots only, those of bricks whose elements may
/// move. Tissue fields exist in all slots. Tissue fields grow with the slots, state fields with
/// the slots that have a state.
class BrickStorage : public BrickTable
{
public:
  BrickStorage(std::shared_ptr<Context> context, const Grid& grid, const Index3& brickSize, int axes);
  BrickStorage(const BrickStorage&) = delete;
  BrickStorage& operator=(const BrickStorage&) = delete;

  Context& context() const { return *this->context_; }
  const std::shared_ptr<Context>& sharedContext() const { return this->context_; }
  const KernelOptions& options() const { return this->options_; }

  // --- Slots

  /// Allocates memory for the tissue and the state of this many bricks at once.
  void reserve(std::size_t tissue, std::size_t states);
  /// The slots with a state are 1 .. states() - 1.
  int states() const { return this->states_; }
  bool hasState(int brick) const { return this->slot(brick) > 0 && this->slot(brick) < this->states_; }
  /// addStates() exchanges slots. This repeats, in a table with a row for each slot, all exchanges since number
  /// `applied`, and updates `applied`. The table must already have slots() rows.
  void applyExchanges(SharedTable& rows, std::size_t& applied) const;
  bool isUpToDate(const SharedTable& rows, std::size_t applied) const
  {
    return rows.rows() == this->slots() && applied == this->exchanged_.size();
  }

  // --- Fields

  /// Allocates a state field, which has memory for all states from then on; removeField() frees it. The field must
  /// outlive the storage or be removed.
  void addField(Field& field, Field::Start start = Field::Start::Zeros);
  /// The same for a field that is needed for a short time and starts at 0. It gets memory that is kept for such fields,
  /// because a system takes long to provide new memory (Pages).
  void addTemporary(Field& field);
  void removeField(Field& field);
  /// The distance between the runs of a state field, and of a tissue field [elements].
  cl_uint pitch() const { return static_cast<cl_uint>(this->capacity_) * this->elements_ + skew; }
  cl_uint tissuePitch() const { return static_cast<cl_uint>(this->tissueCapacity_) * this->elements_ + skew; }

  /// LAYOUT_ARGUMENTS of brick.clh, for a kernel that declares no STATE_ARGUMENTS.
  using LayoutArguments = std::tuple<cl_uint, cl_uint, const cl::Buffer&, const cl::Buffer&, cl_int, cl_int>;
  LayoutArguments layout() const
  {
    return { this->pitch(), this->tissuePitch(), this->tableBuffer_, this->placeBuffer_, this->strideY_,
      this->strideZ_ };
  }

  // --- Values of fields

  /// The first three runs of a float field of the state in one slot, elementsPerBrick() values each, in the order of
  /// addresses.
  void readSlot(const Field& field, int slot, std::vector<float>& out) const;

  /// The values of one slot that readSlots() has read: the value at the offset `local` in a run. Runs are numbered
  /// consecutively over all fields.
  template <typename T> class SlotValues
  {
  public:
    SlotValues(const std::vector<Context::View<T>>& runs, std::size_t first)
      : runs_(runs)
      , first_(first)
    {
    }
    T operator()(std::size_t run, std::uint32_t local) const { return this->of(run)[local]; }
    /// All values of a run, in the order of addresses.
    const T* of(std::size_t run) const { return this->runs_[run].get() + this->first_; }

  private:
    const std::vector<Context::View<T>>& runs_;
    std::size_t first_;
  };
  struct Runs
  {
    const cl::Buffer& buffer;
    std::size_t count;
  };
  /// Reads these state fields, of 4-byte values, in these slots (ascending). It reads many slots in each transfer,
  /// because every transfer has a fixed cost. Calls visit(slot, SlotValues<T>) for each slot, from several threads.
  template <typename T, typename Visit>
  void readSlots(const std::vector<Runs>& fields, const std::vector<int>& slots, const Visit& visit) const;

  /// Sets all values of a state field to 0; does nothing where it has no memory.
  void clear(const Field& field) const;
  /// Copies the first three runs of one float field of the state to another: those of all slots, or of some.
  void copy(const Field& from, const Field& to) const;
  void copy(const Field& from, const Field& to, const std::vector<int>& slots) const;

protected:
  /// Sets values of a state field at single elements, `runs` interleaved values each.
  template <typename T>
  void set(const Field& field, const std::vector<std::uint32_t>& addresses, const std::vector<T>& values)
  {
    this->set(field, this->pitch(), addresses, values);
  }
  /// Reads values of a float field of the state at single elements: of its first `runs` (0: of all), interleaved.
  std::vector<float> valuesAt(
    const Field& field, const std::vector<std::uint32_t>& addresses, std::size_t runs = 0) const
  {
    return this->get(field.buffer, runs == 0 ? field.runs : runs, this->pitch(), addresses);
  }

  /// Allocates a tissue field, which has memory for all slots from then on.
  void addTissueField(Field& field);
  void removeTissueField(Field& field);
  template <typename T>
  void setTissue(const Field& field, const std::vector<std::uint32_t>& addresses, const std::vector<T>& values)
  {
    this->set(field, this->tissuePitch(), addresses, values);
  }
  std::vector<float> tissueValuesAt(const Field& field, const std::vector<std::uint32_t>& addresses) const
  {
    return this->get(field.buffer, field.runs, this->tissuePitch(), addresses);
  }
  /// Writes one run of a tissue field, from the first element of a slot on.
  template <typename T> void writeTissue(const Field& field, std::size_t run, int slot, const std::vector<T>& values)
  {
    const std::size_t first = run * this->tissuePitch() + static_cast<std::size_t>(slot) * this->elements_;
    this->context_->write(field.buffer, field.bytes * first, values);
  }

  /// Gives the next slots to these bricks, without a state. uploadTables() has to be called after the last one.
  void addSlots(const std::vector<int>& bricks);
  void uploadTables();
  /// Takes the slots away from all bricks, for other bricks. Fields start again as new memory does. No table may follow
  /// applyExchanges().
  void takeSlots();
  /// Gives a state to each of these bricks that has a slot but no state. Their elements get new addresses; other bricks
  /// without a state may change places with them.
  void addStates(const std::vector<int>& bricks);

  /// The bytes of all fields and tables on the device.
  std::size_t bytes() const;

private:
  cl::Buffer allocate(std::size_t bytes, const char* purpose, Field::Start start);
  void startAgain(const Field& field, std::size_t pitch) const;
  void enlarge(Field& field, std::size_t oldPitch, std::size_t pitch);
  void growTissue(int slots);
  void growStates(int slots);
  template <typename T>
  void set(const Field& field, cl_uint pitch, const std::vector<std::uint32_t>& addresses, const std::vector<T>& values)
  {
    static_assert(sizeof(T) == sizeof(cl_uint), "scatter.cl moves 4 bytes");
    if (!addresses.empty())
    {
      this->scatter(field, pitch, addresses, this->values_.holding(*this->context_, values));
    }
  }
  void scatter(
    const Field& field, cl_uint pitch, const std::vector<std::uint32_t>& addresses, const cl::Buffer& values);
  std::vector<float> get(
    const cl::Buffer& field, std::size_t runs, cl_uint pitch, const std::vector<std::uint32_t>& addresses) const;

  std::shared_ptr<Context> context_;
  KernelOptions options_;
  /// Extra elements after each run of a field. In state fields they are at rest and stand for all slots without a state
  /// (brick.clh). Without this padding the components of an element would be a power of two apart. They would compete
  /// for the same lines of a CPU's cache.
  static constexpr int skew = KernelOptions::skew;

  int capacity_ = 0;       ///< slots with memory for the state
  int tissueCapacity_ = 0; ///< slots with memory for tissue
  int states_ = 1;
  std::vector<std::pair<int, int>> exchanged_; ///< pairs of slots whose bricks were exchanged, in order
  std::vector<Field*> fields_;                 ///< the fields that addField() was called for
  std::vector<Field*> tissueFields_;           ///< likewise, addTissueField()
  cl::Buffer tableBuffer_;
  cl::Buffer placeBuffer_;
  mutable Scratch addresses_{ "a list of elements" };
  mutable Scratch values_{ "values of elements" };
};

template <typename T, typename Visit>
void BrickStorage::readSlots(const std::vector<Runs>& fields, const std::vector<int>& slots, const Visit& visit) const
{
  // Slots in between are read as well where that takes less time than another transfer.
  constexpr std::size_t valuesPerTransfer = std::size_t(1) << 20;
  constexpr std::size_t valuesBetween = std::size_t(1) << 16;
  const std::size_t elements = static_cast<std::size_t>(this->elements_);
  for (std::size_t begin = 0, end = 0; begin < slots.size(); begin = end)
  {
    end = begin + 1;
    while (end < slots.size() && elements * (slots[end] - slots[begin]) < valuesPerTransfer &&
           elements * (slots[end] - slots[end - 1]) <= valuesBetween)
    {
      ++end;
    }
    const std::size_t first = elements * slots[begin];
    const std::size_t count = elements * (slots[end - 1] - slots[begin] + 1);
    std::vector<Context::View<T>> runs;
    for (const Runs& field : fields)
    {
      for (std::size_t run = 0; run < field.count; ++run)
      {
        runs.emplace_back(*this->context_, field.buffer, run * this->pitch() + first, count);
      }
    }
    inParallel(end - begin,
      [&](std::size_t n)
      {
        const int slot = slots[begin + n];
        visit(slot, SlotValues<T>(runs, elements * (slot - slots[begin])));
      });
  }
}

}
