#pragma once

#include "ElementRuns.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace chainmail
{

/// The connected components of tissue: elements that links join, directly or along a path. They do not depend on the
/// deformation, so they are found once for a tissue.
class TissueComponents
{
public:
  explicit TissueComponents(const Tissue& tissue);

  /// Components are numbered from 0 to count() - 1.
  int count() const { return static_cast<int>(this->isAnchored_.size()); }
  /// The component with the most elements, the first of several.
  int largest() const { return this->largest_; }
  /// Whether an element of it is anchored from the start.
  bool isAnchored(int component) const { return this->isAnchored_[component] != 0; }
  /// The component of an element (Grid::at).
  int of(std::size_t voxel) const;

  /// The components that have elements in a brick, ascending.
  std::vector<int> inBrick(int brick) const;
  /// The elements of a component in a brick, ascending.
  std::vector<std::size_t> elementsIn(int brick, int component) const;

  /// Whether f(run) is true for a run of a component. The others after that one, in the order of voxels, are not
  /// visited.
  template <typename F> bool anyRun(int component, const F& f) const
  {
    return std::any_of(this->byComponent_.begin() + this->firstOf_[component],
      this->byComponent_.begin() + this->firstOf_[component + 1], [&](std::uint32_t n) { return f(this->runs_[n]); });
  }

private:
  template <typename F> void forRunsIn(int brick, const F& f) const;

  const Tissue& tissue_;
  std::vector<ElementRun> runs_;           ///< in the order of voxels
  std::vector<std::uint32_t> byComponent_; ///< numbers of runs, component by component
  std::vector<std::size_t> firstOf_{ 0 };  ///< of each component, its first place in byComponent_; then the end
  std::vector<char> isAnchored_;
  int largest_ = 0;
};

}
