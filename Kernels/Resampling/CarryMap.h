#pragma once

#include "CarryAir.h"
#include "CarryCells.h"
#include "CarryTree.h"

#include <array>
#include <memory>
#include <mutex>

namespace chainmail
{

/// Carries places along with tissue, from rest to where it is now and back. Within tissue and the voxels beside it this
/// is the map by which images are resampled (resample.clh), so it keeps the two sides of a cut apart. Air goes along
/// with the tissue nearby, and smoothly on from there. Units as in RestModel. May be used by several threads at once.
class CarryMap
{
public:
  explicit CarryMap(const RestModel& model);

  /// Where the material at a place at rest is now. `derivatives`: [3 b + a] of coordinate b along axis a.
  Vector3 forward(const Vector3& rest, std::array<double, 9>* derivatives = nullptr) const;

  /// Where the material that is now at a place was at rest. A place that nothing came to, as in a cut that opened, goes
  /// along with the tissue that is nearest now.
  Vector3 backward(const Vector3& now) const;

  /// What an image shows at a place.
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

  /// What an image that goes along with the tissue shows at a place now.
  Shown shownNow(const Vector3& now) const;

  /// What an image of the tissue as it is now shows at a place when it goes back to rest.
  Shown shownAtRest(const Vector3& rest) const;

private:
  struct Hit
  {
    // Which of several that cover a place counts: the lowest sum of these, and of 1 where it lies just outside of the
    // cell's share.
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
  // Made when they are first needed.
  mutable std::once_flag airMade_, treeMade_;
  mutable std::unique_ptr<CarryAir> air_;
  mutable std::unique_ptr<CarryTree> tree_;
};

}
