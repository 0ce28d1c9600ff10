#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace chainmail
{

/// Visits a connected component: visit(node, add) is called for `first` and for every node that a visit adds, once for
/// each time it is added, in any order. The caller has to remember which nodes it has added and add none twice. `front`
/// is memory to work in, empty before and after.
template <typename Visit> void visitComponent(std::size_t first, std::vector<std::size_t>& front, const Visit& visit)
{
  front.push_back(first);
  while (!front.empty())
  {
    const std::size_t node = front.back();
    front.pop_back();
    visit(node, [&front](std::size_t next) { front.push_back(next); });
  }
}

/// Disjoint sets of numbers that can be joined. A set's root is its lowest member, so the order of joining changes
/// nothing.
class DisjointSets
{
public:
  explicit DisjointSets(std::size_t count)
    : parent_(count)
  {
    std::iota(this->parent_.begin(), this->parent_.end(), 0u);
  }

  std::uint32_t root(std::size_t n)
  {
    std::uint32_t at = static_cast<std::uint32_t>(n);
    while (this->parent_[at] != at)
    {
      this->parent_[at] = this->parent_[this->parent_[at]];
      at = this->parent_[at];
    }
    return at;
  }
  void join(std::size_t n, std::size_t m)
  {
    const std::uint32_t a = this->root(n);
    const std::uint32_t b = this->root(m);
    this->parent_[std::max(a, b)] = std::min(a, b);
  }

private:
  std::vector<std::uint32_t> parent_;
};

}
