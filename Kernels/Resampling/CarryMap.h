#pragma once

#include "CarryAir.h"
#include "CarryCells.h"
#include "CarryTree.h"

#include <array>
#include <memory>
#include <mutex>

namespace chainmail
{

/// Maps positions from rest to the deformed state and back. In tissue and the voxels beside it this is the map that
/// resamples images (resample.clh), so it keeps the two sides of a cut apart. Air moves with the tissue nearby; further
/// away the displacements continue smoothly (CarryAir). Units as in RestModel. May be used by several threads at once.
class CarryMap
{
public:
  explicit CarryMap(const RestModel& model);

  /// The current position of the material at a position at rest. `derivatives`: [3 b + a] of coordinate b along axis a.
  Vector3 forward(const Vector3& rest, std::array<double, 9>* derivatives = nullptr) const;

  /// The position at rest of the material that is now at a position. A position that no material covers, for example in
  /// an opened cut, moves with the tissue that is nearest to it now.
  Vector3 backward(const Vector3& now) const;

  /// What an image shows at a position.
  struct Shown
  {
    enum class What
    {
      Same,     ///< what it showed before
      Material, ///< what it showed at `from`
      Nothing   ///< tissue went away and none came
    };
    What what = What::Same;
    Vector3 from{};
  };

  /// What an image that deforms with the tissue shows at a position now.
  Shown shownNow(const Vector3& now) const;

  /// What an image of the deformed tissue, warped back to rest, shows at a position.
  Shown shownAtRest(const Vector3& rest) const;

private:
  struct Hit
  {
    // Of several cells that cover a position the one with the lowest rank wins. The rank is the sum of these values,
    // and 1 more where the position lies just outside the cell or the component's share of it.
    static constexpr int tissue = 0;
    static constexpr int border = 4;
    static constexpr int atRest = 2;
    static constexpr int none = 8;

    int rank = none;
    std::size_t key = 0; ///< the cell and component
    Vector3 rest{};

    bool rests() const { return (this->rank & atRest) != 0; }
    bool isMovedTissue() const { return this->rank < atRest; }
  };

  Vector3 displacementAt(const Vector3& rest, std::array<double, 9>* derivatives) const;
  CarryCells::Corners cornersInAir(const Index3& base, const Vector3& place) const;
  void cover(const CarryCells::Cell& cell, unsigned component, const CarryCells::Corners& corners, const Vector3& now,
    bool carvedIsGone, Hit& hit) const;
  void coverCell(const Index3& base, const Vector3& now, bool carvedIsGone, Hit& hit) const;
  void coverWholeLeaf(const Index3& first, const Vector3& now, bool carvedIsGone, Hit& hit) const;
  Hit find(const Vector3& now, bool carvedIsGone) const;
  bool solve(const Vector3& now, Vector3& rest) const;
  Shown materialOf(const Vector3& place, Vector3 from) const;
  Index3 nearestVoxel(const Vector3& place) const;
  Index3 cellOf(const Vector3& inside) const;
  Vector3 inside(const Vector3& place) const;
  bool isOutside(const Vector3& place) const;
  const CarryAir& air() const;
  const CarryTree& tree() const;

  RestModel model_;
  CarryCells cells_;
  // Made on first use.
  mutable std::once_flag airMade_, treeMade_;
  mutable std::unique_ptr<CarryAir> air_;
  mutable std::unique_ptr<CarryTree> tree_;
};

}
