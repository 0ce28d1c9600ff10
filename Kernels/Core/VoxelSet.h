#pragma once

#include "Model.h"

#include <algorithm>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace chainmail
{

/// A set of voxels of a grid: one bit for each voxel of the grid, and half a bit more to number the members.
class VoxelSet
{
public:
  static constexpr std::size_t none = ~std::size_t(0);

  explicit VoxelSet(const Grid& grid)
    : words_((grid.voxels() + 63) / 64, 0)
  {
  }

  void insert(std::size_t voxel) { this->words_[voxel / 64] |= std::uint64_t(1) << voxel % 64; }
  void insert(const VoxelSet& other)
  {
    std::transform(this->words_.begin(), this->words_.end(), other.words_.begin(), this->words_.begin(),
      [](std::uint64_t one, std::uint64_t two) { return one | two; });
  }
  bool contains(std::size_t voxel) const { return (this->words_[voxel / 64] >> voxel % 64 & 1) != 0; }
  std::size_t count() const
  {
    std::size_t sum = 0;
    for (const std::uint64_t word : this->words_)
    {
      sum += bitsOf(word);
    }
    return sum;
  }

  /// Adds members of `others` that faces connect with a member, within `steps` steps through such voxels. It may add
  /// some of `others` that are farther away: the last voxel of a row counts as the neighbour of the first one of the
  /// next row.
  void growInto(const VoxelSet& others, const Grid& grid, int steps)
  {
    const std::size_t row = static_cast<std::size_t>(grid.size[0]);
    const std::size_t layer = row * static_cast<std::size_t>(grid.size[1]);
    bool hasGrown = true;
    for (int step = 0; step < steps && hasGrown; ++step)
    {
      hasGrown = false;
      const VoxelSet before = *this;
      for (std::size_t w = 0; w < this->words_.size(); ++w)
      {
        std::uint64_t& word = this->words_[w];
        const std::uint64_t free = others.words_[w] & ~word;
        if (free == 0)
        {
          continue;
        }
        std::uint64_t beside = 0;
        for (const std::size_t way : { std::size_t(1), row, layer })
        {
          beside |= before.bitsFrom(64 * w + way) | before.bitsFrom(64 * w - way);
        }
        hasGrown = hasGrown || (free & beside) != 0;
        word |= free & beside;
      }
    }
  }

  /// Numbers the members in ascending order, from 0. To be called after the last insert().
  void number()
  {
    this->counts_.resize(this->words_.size());
    this->sums_.clear();
    std::size_t sum = 0;
    for (std::size_t w = 0; w < this->words_.size(); ++w)
    {
      if (w % block == 0)
      {
        this->sums_.push_back(sum);
      }
      this->counts_[w] = static_cast<std::uint32_t>(sum - this->sums_.back());
      sum += bitsOf(this->words_[w]);
    }
  }
  /// The number of a member; `none` of other voxels.
  std::size_t numberOf(std::size_t voxel) const
  {
    const std::size_t w = voxel / 64;
    const std::uint64_t bit = std::uint64_t(1) << voxel % 64;
    return (this->words_[w] & bit) == 0
             ? none
             : this->sums_[w / block] + this->counts_[w] + bitsOf(this->words_[w] & (bit - 1));
  }

  /// Calls visit(voxel) for each member, in ascending order.
  template <typename Visit> void forEach(const Visit& visit) const
  {
    for (std::size_t w = 0; w < this->words_.size(); ++w)
    {
      for (std::uint64_t left = this->words_[w]; left != 0; left &= left - 1)
      {
        visit(64 * w + bitsOf((left & (~left + 1)) - 1));
      }
    }
  }

private:
  static constexpr std::size_t block = 1024; ///< words whose members are counted together

  static std::size_t bitsOf(std::uint64_t word) { return std::bitset<64>(word).count(); }

  /// The bits of 64 voxels from number `first` on, which wraps around where it is negative. Zero beyond all voxels.
  std::uint64_t bitsFrom(std::size_t first) const
  {
    const std::size_t w = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(first) >> 6);
    const std::size_t shift = first % 64;
    const auto word = [this](std::size_t n) { return n < this->words_.size() ? this->words_[n] : 0; };
    return shift == 0 ? word(w) : word(w) >> shift | word(w + 1) << (64 - shift);
  }

  std::vector<std::uint64_t> words_;
  std::vector<std::uint32_t> counts_; ///< members before each word in its block
  std::vector<std::size_t> sums_;     ///< members before each block
};

/// A value for each voxel of a set.
template <typename T> class VoxelMap
{
public:
  /// All values are `value`.
  explicit VoxelMap(VoxelSet where, T value = T())
    : where_(std::move(where))
  {
    this->where_.number();
    this->values_.assign(this->where_.count(), value);
  }

  const VoxelSet& where() const { return this->where_; }
  std::vector<T>& values() { return this->values_; } ///< by the numbers of the voxels
  const std::vector<T>& values() const { return this->values_; }

  /// The value of a member, and T() of other voxels.
  T at(std::size_t voxel) const
  {
    const std::size_t number = this->where_.numberOf(voxel);
    return number == VoxelSet::none ? T() : this->values_[number];
  }
  void set(std::size_t voxel, T value) { this->values_[this->where_.numberOf(voxel)] = value; }

  /// Calls visit(voxel, value) for each member, in ascending order. The value may be written to.
  template <typename Visit> void forEach(const Visit& visit)
  {
    std::size_t number = 0;
    this->where_.forEach([&](std::size_t voxel) { visit(voxel, this->values_[number++]); });
  }
  template <typename Visit> void forEach(const Visit& visit) const
  {
    std::size_t number = 0;
    this->where_.forEach([&](std::size_t voxel) { visit(voxel, this->values_[number++]); });
  }

private:
  VoxelSet where_;
  std::vector<T> values_;
};

}
