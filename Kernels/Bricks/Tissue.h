#pragma once

#include "BrickStorage.h"
#include "CutDistances.h"
#include "ElementRule.h"
#include "Links.h"
#include "Model.h"

#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

namespace chainmail
{

/// The tissue of a model in bricks: the constraints of its elements, and what cuts and carves have removed. A brick's
/// tissue is loaded from the model when a deformation comes near.
class Tissue : public BrickStorage
{
public:
  Tissue(std::shared_ptr<Context> context, std::shared_ptr<const Model> model, const Index3& brickSize);

  const Model& model() const { return *this->model_; }

  // --- Loading

  /// Loads the tissue of these bricks and of the 26 around each of them, so kernels may read it.
  void loadTissue(const std::vector<int>& bricks);
  /// Allocates a state for those of these bricks whose tissue is loaded and that have none. The addresses of their
  /// elements change, for the last time. Other bricks without a state may change places with them.
  void allocateStates(const std::vector<int>& bricks) { this->addStates(bricks); }
  /// Calls loadTissue() and allocateStates(). Afterwards kernels may update these bricks.
  void makeUpdatable(const std::vector<int>& bricks);
  bool isUpdatable(int brick) const
  {
    return this->status_[brick] == Status::Ready || this->status_[brick] == Status::Air;
  }
  /// Forgets which tissue is loaded, to make room for other tissue. Cuts and carves stay.
  void unloadTissue();
  /// Calls f(slot) for all slots, in the order in which the tissue of their bricks was loaded.
  template <typename F> void forKnown(const F& f) const
  {
    for (const int brick : this->known_)
    {
      f(this->slot(brick));
    }
  }

  // --- Elements and links

  /// Like Model::row(), for the tissue as it is now: removed elements are air.
  void row(int i, int j, int k, int count, float* out) const;
  bool isElement(const Index3& at) const;

  /// The link between two elements with these signed constraints, to the bit as on the device (element.clh).
  rule::Link link(float ci, float cj, int direction, int axis) const { return rule::linkOf(ci, cj, direction, axis); }
  const Links& links() const { return this->links_; }
  bool anyCut() const { return this->links_.anyCut(); }
  std::uint8_t cutBits(int i, int j, int k) const { return this->links_.cutBits(i, j, k); }
  /// Calls f(direction, neighbour) for every face neighbour of a voxel that lies in the grid and behind no cut.
  template <typename F> void forNeighbours(const Index3& at, const F& f) const
  {
    const std::uint8_t cut = this->cutBits(at[0], at[1], at[2]);
    for (int d = 0; d < 6; ++d)
    {
      Index3 next = at;
      next[d / 2] += d % 2 == 0 ? -1 : 1;
      if ((cut & CUT_BIT(d)) == 0 && this->model_->grid().contains(next[0], next[1], next[2]))
      {
        f(d, next);
      }
    }
  }
  CutDistances& cutDistances() { return this->cutDistances_; }
  const CutDistances& cutDistances() const { return this->cutDistances_; }

  // --- Cuts and carves

  /// See Links::remove(). uploadCuts() has to be called after the last one.
  bool removeLink(int i, int j, int k, int direction) { return this->links_.remove(i, j, k, direction); }
  /// Copies the removed links to the device.
  void uploadCuts();
  /// Restores all links and elements. No element may be held at that time.
  void restoreTopology();
  /// What cuts and carves have changed of this tissue, by brick, for pictures.
  struct Topology
  {
    Links::CutBits bits;
    std::unordered_map<int, std::vector<std::uint16_t>> distances; ///< CutDistances::Brick::values()

    bool operator==(const Topology& other) const
    {
      return this->bits == other.bits && this->distances == other.distances;
    }
  };
  /// Restores everything, then removes and sets what `topology` says.
  void replaceTopology(Topology topology);

  // --- Fields that kernels read

  /// float [axis][address], signed (element.clh).
  const cl::Buffer& constraint() const { return this->constraint_.buffer; }
  /// uchar [address], bits as in Links. Where there are no cuts, any buffer: kernels built without cuts do not read it.
  const cl::Buffer& cut() const { return this->anyCut() ? this->cut_.buffer : this->constraint_.buffer; }
  /// The same for pictures: without the links that are missing because of joints alone.
  const cl::Buffer& shownCut() const { return this->shownCut_.buffer() ? this->shownCut_.buffer : this->cut(); }

protected:
  /// Signed constraints of single elements, `axes()` interleaved values each.
  std::vector<float> constraints(const std::vector<std::uint32_t>& addresses) const
  {
    return this->tissueValuesAt(this->constraint_, addresses);
  }
  void setConstraints(const std::vector<std::uint32_t>& addresses, const std::vector<float>& values)
  {
    this->setTissue(this->constraint_, addresses, values);
  }
  /// Replaces these elements (Grid::at) by air, for row() and on the device.
  void replaceByAir(const std::vector<std::size_t>& voxels);

private:
  enum class Status : std::uint8_t
  {
    Unknown,
    Air,   ///< holds no element
    Known, ///< its tissue is loaded
    Ready  ///< has a state, and the tissue of all 26 bricks around it is loaded
  };

  void fillFirstSlot();
  void readTissue(const std::vector<int>& bricks);
  bool fill(int brick, std::vector<float>& out) const;
  void fillAgain(const std::set<int>& bricks);
  void writeCuts(int brick, const std::vector<std::uint8_t>& bits);
  void separateJoints();

  std::shared_ptr<const Model> model_;
  std::vector<Status> status_;
  std::vector<int> known_; ///< bricks with loaded tissue, in the order of loading
  Links links_;
  CutDistances cutDistances_;
  Field constraint_;
  Field cut_{ 1, 1, "the cuts" };      ///< only where there are cuts
  Field shownCut_{ 1, 1, "the cuts" }; ///< only where links are missing because of joints alone
};

}
