#include "TissueComponents.h"

#include <algorithm>

namespace chainmail
{

TissueComponents::TissueComponents(const Tissue& tissue)
  : tissue_(tissue)
  , runs_(connectedRuns(tissue, 0, false))
{
  // A counting sort leaves the runs of each component in the order of voxels.
  std::vector<std::size_t> elements;
  for (const ElementRun& run : this->runs_)
  {
    const std::size_t component = static_cast<std::size_t>(run.component);
    elements.resize(std::max(elements.size(), component + 1), 0);
    this->firstOf_.resize(elements.size() + 1, 0);
    this->isAnchored_.resize(elements.size(), 0);
    elements[component] += run.count;
    ++this->firstOf_[component + 1];
    this->isAnchored_[component] = this->isAnchored_[component] || run.anchored ? 1 : 0;
  }
  this->largest_ = static_cast<int>(std::max_element(elements.begin(), elements.end()) - elements.begin());
  for (std::size_t n = 1; n < this->firstOf_.size(); ++n)
  {
    this->firstOf_[n] += this->firstOf_[n - 1];
  }
  std::vector<std::size_t> next(this->firstOf_.begin(), this->firstOf_.end() - 1);
  this->byComponent_.resize(this->runs_.size());
  for (std::size_t n = 0; n < this->runs_.size(); ++n)
  {
    this->byComponent_[next[this->runs_[n].component]++] = static_cast<std::uint32_t>(n);
  }
}

int TissueComponents::of(std::size_t voxel) const
{
  const auto after = std::upper_bound(
    this->runs_.begin(), this->runs_.end(), voxel, [](std::size_t v, const ElementRun& run) { return v < run.first; });
  return (after - 1)->component;
}

/// Calls f(run, first, end) for every run with elements in a brick: those from voxel `first` to before `end`.
template <typename F> void TissueComponents::forRunsIn(int brick, const F& f) const
{
  for (const Tissue::Row& row : this->tissue_.rows(brick))
  {
    const std::size_t end = row.voxel + static_cast<std::size_t>(row.count);
    auto run = std::upper_bound(this->runs_.begin(), this->runs_.end(), row.voxel,
      [](std::size_t v, const ElementRun& one) { return v < one.first; });
    run -= run != this->runs_.begin() && (run - 1)->first + (run - 1)->count > row.voxel ? 1 : 0;
    for (; run != this->runs_.end() && run->first < end; ++run)
    {
      f(*run, std::max(run->first, row.voxel), std::min(run->first + run->count, end));
    }
  }
}

std::vector<int> TissueComponents::inBrick(int brick) const
{
  std::vector<int> components;
  this->forRunsIn(brick,
    [&](const ElementRun& run, std::size_t, std::size_t)
    {
      if (components.empty() || components.back() != run.component)
      {
        components.push_back(run.component);
      }
    });
  std::sort(components.begin(), components.end());
  components.erase(std::unique(components.begin(), components.end()), components.end());
  return components;
}

std::vector<std::size_t> TissueComponents::elementsIn(int brick, int component) const
{
  std::vector<std::size_t> elements;
  this->forRunsIn(brick,
    [&](const ElementRun& run, std::size_t first, std::size_t end)
    {
      for (std::size_t voxel = first; run.component == component && voxel < end; ++voxel)
      {
        elements.push_back(voxel);
      }
    });
  return elements;
}

}
