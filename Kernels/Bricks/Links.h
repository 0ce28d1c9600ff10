#pragma once

#include "BrickTable.h"
#include "cutbits.clh"

#include <cstdint>
#include <set>
#include <unordered_map>
#include <vector>

namespace chainmail
{

/// The links and elements that cuts and carves removed, and the missing links across free joints (Joints).
class Links
{
public:
  /// `table` must outlive this object and must not move.
  explicit Links(const BrickTable& table)
    : table_(table)
  {
  }

  /// What was removed, by brick: one byte for each element, in the order of `local`. For the bits
  /// see cutbits.clh.
  using CutBits = std::unordered_map<int, std::vector<std::uint8_t>>;

  const CutBits& all() const { return this->cuts_; }
  bool anyCut() const { return !this->cuts_.empty(); }
  std::uint8_t cutBits(int i, int j, int k) const;
  bool carved(int i, int j, int k) const { return (this->cutBits(i, j, k) & CARVED_BIT) != 0; }
  /// Bricks from which elements were removed.
  const std::set<int>& carvedBricks() const { return this->carvedBricks_; }

  /// Removes the link from (i, j, k) in one direction, at both of its ends. Both must lie in the grid. Returns whether
  /// the link existed, or was missing because of a joint alone.
  bool remove(int i, int j, int k, int direction);
  /// The same for a link across a free joint (Joints), which pictures treat as existing.
  void removeAtJoint(int i, int j, int k, int direction);
  bool anyAtJoint() const { return !this->joints_.empty(); }
  /// cutBits(), and the bits of a brick in all(), for pictures: links missing because of joints alone count as
  /// existing.
  std::uint8_t shownBits(int i, int j, int k) const;
  std::vector<std::uint8_t> shown(int brick) const;
  void removeElement(int i, int j, int k);
  /// Restores all links and elements.
  void clear();
  /// Removes what these bits say and nothing else.
  void replace(CutBits bits);

  /// Replaces the carved elements by air among `count` constraints from (i, j, k) on, laid out as in Model::row().
  void takeOut(int i, int j, int k, int count, int axes, float* constraints) const;

private:
  bool set(CutBits& to, const Index3& at, int direction);

  const BrickTable& table_;
  CutBits cuts_;
  CutBits joints_; ///< the bits of cuts_ for links that are missing because of joints alone
  std::set<int> carvedBricks_;
};

}
