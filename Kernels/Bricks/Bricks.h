#pragma once

#include "BrickTable.h"
#include "Context.h"
#include "CutDistances.h"
#include "Links.h"
#include "Model.h"
#include "SharedTable.h"
#include "SoftLinks.h"
#include "Threads.h"

#include <cstdint>
#include <tuple>
#include <utility>
#include <vector>

namespace chainmail
{

/// A field of the state: values for every element that may move, laid out as [run][address], where a run is one
/// component. Bricks::keep() allocates optional fields.
struct Field
{
  std::size_t runs;
  std::size_t bytes; ///< of one value
  const char* purpose;
  cl::Buffer buffer{};
  /// The initial content of new memory, chosen in Bricks::keep().
  enum class Start
  {
    Zeros,
    Infinity, ///< as a float
    Anything
  };
  Start start = Start::Zeros;
};

/// Whether elements rotate and, if so, how strongly they resist changes of volume.
struct Turning
{
  bool on = false;
  double poissonRatio = 0.0; ///< [0, 0.5)
};

/// The rotations of elements and bones (`spin`, see spin.clh) and, where Poisson's ratio is not 0, the pressure of
/// elements (volumetricstrain.clh). They exist only where elements rotate.
struct Spins
{
  Field spin{ 3, sizeof(float), "the rotations of the tissue reached" };
  bool any = false;      ///< whether an element may have rotated since all were at rest
  cl_float4 proportions; ///< the spacing of each axis, divided by the geometric mean of all three; then 2 kappa

  bool hasPressure() const { return this->proportions.s[3] > 0.0f; }

  /// The rest offset of a link on an axis, as a fraction of the spacing: u(j) - u(i) of the unstrained link from
  /// element i to its neighbour j in this direction. It is the mean over the rotations of both ends (spinI and spinJ, 3
  /// values each).
  float restOffset(const float* spinI, const float* spinJ, int direction, int axis) const;
  /// The factor 1 / h^2 in the weight of links along an axis, h their length in mean spacings.
  double weight(int along) const
  {
    return 1.0 / (static_cast<double>(this->proportions.s[along]) * this->proportions.s[along]);
  }

  /// SPIN_ARGUMENTS of turning.clh.
  auto arguments() const { return std::tuple<const cl::Buffer&, cl_float4>(this->spin.buffer, this->proportions); }
};

/// The state of all elements on the device, stored in bricks that get memory when they are first needed. All other
/// parts of the engine access it through the fields below and their addresses. brick.clh describes the layout and the
/// addresses.
///
/// Displacements take most of the memory, so only bricks whose elements may move have a state: those in the first
/// slots. Of the bricks around them only the tissue is loaded, and kernels read rest where there is no state.
class Bricks : public BrickTable
{
public:
  /// With `turning.on` elements have rotations (spins()).
  Bricks(std::shared_ptr<Context> context, std::shared_ptr<const Model> model, Index3 brickSize,
    const Turning& turning = {});
  Bricks(const Bricks&) = delete;
  Bricks& operator=(const Bricks&) = delete;

  const Model& model() const { return *this->model_; }
  Context& context() const { return *this->context_; }
  const std::shared_ptr<Context>& sharedContext() const { return this->context_; }
  /// The -D options that every kernel with brick.clh needs. With `vectors` a kernel processes as many elements at once
  /// as suits the device, else one.
  std::string defines(bool vectors) const { return this->defines(vectors, this->spins()); }
  /// The same for a kernel that reads these rotations; null: none.
  std::string defines(bool vectors, const Spins* spins) const;
  /// The same for a kernel that benefits from the longest vectors of the device, up to a row.
  std::string definesOfRows() const { return this->definesOfRows(this->spins()); }
  std::string definesOfRows(const Spins* spins) const;
  /// Work-items for one colour of a brick.
  std::size_t workItems(bool vectors) const;

  /// The elements of a row that a kernel handles at once: its WIDTH.
  int width(bool vectors) const;

  // --- Memory

  /// Loads the tissue of these bricks and of the 26 around each of them, so kernels may read it.
  void loadTissue(const std::vector<int>& bricks);
  /// Allocates a state for those of these bricks whose tissue is loaded and that have none. The addresses of their
  /// elements change, for the last time. Other bricks without a state may change places with them.
  void allocateStates(const std::vector<int>& bricks);
  /// Calls know() and allocateStates(). Afterwards kernels may update these bricks.
  void makeUpdatable(const std::vector<int>& bricks);
  bool isUpdatable(int brick) const
  {
    return this->status_[brick] == Status::Ready || this->status_[brick] == Status::Air;
  }

  /// The slots with a state are 1 .. states() - 1.
  int states() const { return this->states_; }
  bool hasState(int brick) const { return this->slot(brick) > 0 && this->slot(brick) < this->states_; }
  /// Applies to a table with a row for each slot the exchanges of slots since `followed`, and updates `followed`. The
  /// table must have all its rows.
  void follow(SharedTable& rows, std::size_t& followed) const;
  bool isFollowed(const SharedTable& rows, std::size_t followed) const
  {
    return rows.rows() == this->slots() && followed == this->exchanged_.size();
  }
  /// The bricks of those slots whose entry in `found` is not 0.
  std::vector<int> bricksWhere(const std::vector<int>& slots, const std::vector<cl_int>& found) const;
  /// Calls f(slot) for all slots, in the order in which the tissue of their bricks was loaded.
  template <typename F> void forKnown(const F& f) const
  {
    for (const int brick : this->known_)
    {
      f(this->slot(brick));
    }
  }

  /// keep() allocates a field for all states and enlarges it whenever there are more; drop() frees it. A kept field
  /// must outlive the bricks or be dropped.
  void keep(Field& field, Field::Start start = Field::Start::Zeros);
  void drop(Field& field);
  /// Copies the displacements to a field, which is kept from then on. Without `slots` it copies all, and states that
  /// are allocated later start at 0. With `slots` it copies those; the values in other slots are undefined.
  void saveIn(Field& field);
  void saveIn(Field& field, const std::vector<int>& slots);

  /// Puts all elements at rest: sets displacements and rotations to zero.
  void clearDisplacements();

  /// Slots in which an element may be displaced, ascending. They have a state.
  std::vector<int> touchedSlots() const;
  /// These slots and all that share a face with one of them, ascending.
  std::vector<int> slotsAround(const std::vector<int>& slots) const;
  void touch(int slot) { this->touched_[slot] = 1; }

  /// The rotations of all elements; null where elements do not rotate.
  const Spins* spins() const { return this->spins_.get(); }
  /// The same, but null while no element can have rotated: then waves need no rotations.
  const Spins* turned() const { return this->spins_ && this->spins_->any ? this->spins_.get() : nullptr; }
  /// To be called with true where elements may rotate, and with false where all are back at rest.
  void setTurned(bool any)
  {
    if (this->spins_)
    {
      this->spins_->any = any;
    }
  }
  const Turning& turning() const { return this->turning_; }
  /// The -D options of kernels that include volumetricstrain.clh.
  std::string ofVolumetricStrain() const
  {
    return this->spins_ && this->spins_->hasPressure() ? " -DVOLUMETRIC_STRAIN" : "";
  }
  /// Writes or reads the rotations of single elements, 3 interleaved values each. Elements must rotate (spins()).
  void setSpins(const std::vector<std::uint32_t>& addresses, const std::vector<float>& values);
  std::vector<float> spinsAt(const std::vector<std::uint32_t>& addresses);
  /// The pressure of single elements; only where Poisson's ratio is not 0.
  std::vector<float> pressuresAt(const std::vector<std::uint32_t>& addresses);

  /// Replaces all soft links by these: in ascending order of voxels, at most one per voxel, in bricks with a state.
  /// These bricks count as touched, because the tissue that the links pull has to settle again.
  void setSoftLinks(std::vector<SoftLink> links);
  /// Null where there are none.
  const SoftLinks* softLinks() const { return this->soft_.get(); }
  /// The -D options of kernels that include softlinks.clh.
  std::string ofSoftLinks() const { return this->soft_ ? " -DSOFT" : ""; }

  /// Saves the displacements of some slots as the state before a wave. Its values in other slots are undefined.
  void saveBefore(const std::vector<int>& slots) { this->saveIn(this->before_, slots); }
  /// Restores that state in these slots.
  void restoreBefore(const std::vector<int>& slots);
  /// Allocates memory for that state, or frees it when no wave needs it any more.
  void keepBefore() { this->keep(this->before_); }
  void forgetBefore() { this->drop(this->before_); }

  /// Sets single elements: displacements (3 values each), of bricks with a state, or signed constraints (`axes()`
  /// values each), interleaved.
  void setDisplacements(const std::vector<std::uint32_t>& addresses, const std::vector<float>& values);
  void setConstraints(const std::vector<std::uint32_t>& addresses, const std::vector<float>& values);
  /// Displacements of single elements, 3 interleaved values each.
  std::vector<float> displacements(const std::vector<std::uint32_t>& addresses);
  /// Signed constraints of single elements, `axes()` interleaved values each.
  std::vector<float> constraints(const std::vector<std::uint32_t>& addresses);
  /// All displacements of one slot: 3 runs of elementsPerBrick() values, in the order of addresses.
  void readSlot(int slot, std::vector<float>& out);
  /// The same for the rotations.
  void readSpins(int slot, std::vector<float>& out);
  /// Where an element is now [voxels]. `u` is what readSlot() gave for its slot.
  Vector3 place(int i, int j, int k, const std::vector<float>& u) const
  {
    const std::size_t at = this->local(i, j, k);
    const std::size_t count = static_cast<std::size_t>(this->elements_);
    return { static_cast<double>(i) + u[at], static_cast<double>(j) + u[count + at],
      static_cast<double>(k) + u[2 * count + at] };
  }

  /// Sets values of a field at single elements, `runs` interleaved values each.
  template <typename T>
  void set(const Field& field, const std::vector<std::uint32_t>& addresses, const std::vector<T>& values)
  {
    this->set(field.buffer, this->pitch(), field.runs, addresses, values);
  }

  /// Reads values of a float field of the state at single elements, `runs` interleaved values each.
  std::vector<float> valuesAt(const Field& field, const std::vector<std::uint32_t>& addresses)
  {
    return this->get(field.buffer, this->pitch(), field.runs, addresses);
  }

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
    T operator()(std::size_t run, std::uint32_t local) const { return this->runs_[run].get()[this->first_ + local]; }

  private:
    const std::vector<Context::View<T>>& runs_;
    std::size_t first_;
  };
  struct Runs
  {
    const cl::Buffer& buffer;
    std::size_t count;
  };
  /// Reads these fields, of 4-byte values, in these slots (ascending). It reads many slots in each transfer, because
  /// every transfer has a fixed cost. Calls visit(slot, SlotValues<T>) for each slot, from several threads.
  template <typename T, typename Visit>
  void readSlots(const std::vector<Runs>& fields, const std::vector<int>& slots, const Visit& visit) const;

  // --- Cuts and carves

  const Links& links() const { return this->links_; }
  bool anyCut() const { return this->links_.anyCut(); }
  CutDistances& cutDistances() { return this->cutDistances_; }
  const CutDistances& cutDistances() const { return this->cutDistances_; }
  std::uint8_t cutBits(int i, int j, int k) const { return this->links_.cutBits(i, j, k); }
  /// See Links::remove().
  bool removeLink(int i, int j, int k, int direction) { return this->links_.remove(i, j, k, direction); }
  /// Replaces these elements (Grid::at) by air, for row() and on the device, and puts them at rest.
  void removeElements(const std::vector<std::size_t>& voxels);
  /// Like Model::row(), for the tissue as it is now: removed elements are air.
  void row(int i, int j, int k, int count, float* out) const;
  bool isElement(const Index3& at) const;
  /// Calls f(direction, neighbour) for every face neighbour of a voxel that lies in the grid and behind no cut.
  template <typename F> void forNeighbours(const Index3& at, const F& f) const
  {
    const std::uint8_t cut = this->cutBits(at[0], at[1], at[2]);
    for (int d = 0; d < 6; ++d)
    {
      Index3 next = at;
      next[d / 2] += d % 2 == 0 ? -1 : 1;
      if ((cut & (1 << d)) == 0 && this->model_->grid().contains(next[0], next[1], next[2]))
      {
        f(d, next);
      }
    }
  }
  /// Restores all links and elements. No element may be held at that time.
  void restoreTopology();
  /// Copies the removed links to the device.
  void uploadCuts();

  std::size_t deviceBytes() const;

  // --- Fields that kernels read

  cl::Buffer displacement; ///< float [axis][address]
  cl::Buffer constraint;   ///< float [axis][address], signed, with the pitch of tissue
  cl::Buffer cut;          ///< uchar [address], bits as in Links; only where anyCut()
  /// float [axis][address], the state before a wave. saveBefore() saves it, or kernels do so brick by brick
  /// (fixedpoint.clh).
  const cl::Buffer& before() const { return this->before_.buffer; }
  /// `cut` or, where there are no cuts, any buffer: kernels built without cuts do not read it.
  const cl::Buffer& cutsOrNothing() const { return this->anyCut() ? this->cut : this->constraint; }
  /// The distance between the runs of a state field, and of a tissue field [elements].
  cl_uint pitch() const { return static_cast<cl_uint>(this->capacity_) * this->elements_ + skew; }
  cl_uint tissuePitch() const { return static_cast<cl_uint>(this->tissueCapacity_) * this->elements_ + skew; }

  // --- Groups of kernel arguments, in this order

  /// LAYOUT_ARGUMENTS of brick.clh.
  auto layout() const
  {
    return std::tuple<cl_uint, cl_uint, const cl::Buffer&, const cl::Buffer&, cl_int, cl_int>(
      this->pitch(), this->tissuePitch(), this->tableBuffer_, this->placeBuffer_, this->strideY_, this->strideZ_);
  }
  /// `table, strideY, strideZ`.
  auto table() const
  {
    return std::tuple<const cl::Buffer&, cl_int, cl_int>(this->tableBuffer_, this->strideY_, this->strideZ_);
  }
  /// `constraint, cut`.
  auto tissue() const
  {
    return std::tuple<const cl::Buffer&, const cl::Buffer&>(this->constraint, this->cutsOrNothing());
  }
  /// `displacement, constraint, cut`, with the cuts that pictures show (Links).
  auto shown() const
  {
    return std::tuple<const cl::Buffer&, const cl::Buffer&, const cl::Buffer&>(
      this->displacement, this->constraint, this->shownCut_() ? this->shownCut_ : this->cutsOrNothing());
  }
  /// `displacement, constraint, cut`.
  auto state() const { return std::tuple_cat(std::tuple<const cl::Buffer&>(this->displacement), this->tissue()); }

private:
  std::string definesFor(int width, const Spins* spins) const;

  enum class Status : std::uint8_t
  {
    Unknown,
    Air,   ///< holds no element
    Known, ///< its tissue is loaded
    Ready  ///< has a state, and the tissue of all 26 bricks around it is loaded
  };

  void readTissue(const std::vector<int>& bricks);
  void readSlot(const cl::Buffer& field, int slot, std::vector<float>& out);
  cl::Buffer allocate(std::size_t bytes, const char* purpose, Field::Start start);
  void growTissue(int slots);
  void growStates(int slots);
  void enlarge(cl::Buffer& buffer, std::size_t runs, std::size_t bytes, std::size_t oldPitch, std::size_t pitch,
    const char* purpose, Field::Start start = Field::Start::Zeros);
  void exchange(
    const cl::Buffer& field, std::size_t runs, std::size_t perBrick, const cl::Buffer& pairs, std::size_t count);
  void copyBricks(const std::vector<int>& slots, const cl::Buffer& from, const cl::Buffer& to);
  void uploadTables();
  bool fill(int brick, std::vector<float>& out) const;
  void writeCuts(int brick, const std::vector<std::uint8_t>& bits);
  void separateJoints();
  /// Addresses and values of single elements.
  template <typename T>
  void set(const cl::Buffer& field, cl_uint pitch, std::size_t components, const std::vector<std::uint32_t>& addresses,
    const std::vector<T>& values)
  {
    static_assert(sizeof(T) == sizeof(cl_uint), "scatter.cl moves 4 bytes");
    if (!addresses.empty())
    {
      this->scatter(field, pitch, components, addresses, this->values_.holding(*this->context_, values));
    }
  }
  void scatter(const cl::Buffer& field, cl_uint pitch, std::size_t components,
    const std::vector<std::uint32_t>& addresses, const cl::Buffer& values);
  std::vector<float> get(
    const cl::Buffer& field, cl_uint pitch, std::size_t components, const std::vector<std::uint32_t>& addresses);

  std::shared_ptr<Context> context_;
  std::shared_ptr<const Model> model_;
  /// Extra elements after each run of a field. In state fields they are at rest and stand for all slots without a state
  /// (brick.clh). Without this padding the components of an element would be a power of two apart. They would compete
  /// for the same lines of a CPU's cache.
  static constexpr int skew = 272;

  int capacity_ = 0;       ///< slots with memory for the state
  int tissueCapacity_ = 0; ///< slots with memory for tissue
  int states_ = 1;
  std::vector<Status> status_;
  std::vector<int> known_;                     ///< bricks with loaded tissue, in the order of loading
  std::vector<std::pair<int, int>> exchanged_; ///< pairs of slots whose bricks were exchanged, in order
  std::vector<char> touched_;                  ///< for each slot with a state
  Links links_;
  CutDistances cutDistances_;
  cl::Buffer shownCut_; ///< `cut` without the links missing because of joints alone; null without such links
  Field before_{ 3, sizeof(float), "the displacement before a wave" };
  Turning turning_;
  std::unique_ptr<Spins> spins_;
  std::unique_ptr<SoftLinks> soft_;
  std::vector<Field*> fields_; ///< the fields that keep() was called for
  cl::Buffer tableBuffer_;
  cl::Buffer placeBuffer_;
  mutable Scratch addresses_{ "a list of elements" };
  mutable Scratch values_{ "a list of elements" };
};

template <typename T, typename Visit>
void Bricks::readSlots(const std::vector<Runs>& fields, const std::vector<int>& slots, const Visit& visit) const
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

/// The best brick size for a device.
Index3 defaultBrickSize(const DeviceInfo& device);

}
