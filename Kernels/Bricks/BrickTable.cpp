#include "BrickTable.h"

#include "Error.h"
#include "Format.h"

#include <algorithm>
#include <limits>
#include <string>

namespace chainmail
{

namespace
{

bool isPowerOfTwo(int n)
{
  return n > 0 && (n & (n - 1)) == 0;
}

void checkBrickSize(const Index3& size)
{
  const bool x = isPowerOfTwo(size[0]) && size[0] >= 4 && size[0] <= 64;
  const bool y = isPowerOfTwo(size[1]) && size[1] >= 2 && size[1] <= 32;
  const bool z = isPowerOfTwo(size[2]) && size[2] >= 2 && size[2] <= 32;
  if (!x || !y || !z)
  {
    throw InputError(
      "The brick size " + toString(size) +
      " cannot be used: every number must be a power of two, the first from 4 to 64, the others from 2 to 32; or all 0 "
      "for the best one.");
  }
}

}

BrickTable::BrickTable(const Grid& grid, const Index3& brickSize)
  : grid_(grid)
  , size_(brickSize)
{
  checkBrickSize(this->size_);
  this->elements_ = this->size_[0] * this->size_[1] * this->size_[2];
  for (int a = 0; a < 3; ++a)
  {
    this->counts_[a] = (this->grid_.size[a] + this->size_[a] - 1) / this->size_[a];
  }
  const double numbers =
    (this->counts_[0] + 2.0) * (this->counts_[1] + 2.0) * (this->counts_[2] + 2.0); // exact up to 2^53
  if (numbers > std::numeric_limits<int>::max())
  {
    throw InputError("The brick size " + toString(this->size_) +
                     " divides the image into more than 2147483647 bricks. "
                     "Take larger ones, or all 0 for the best size.");
  }
  this->strideY_ = this->counts_[0] + 2;
  this->strideZ_ = this->strideY_ * (this->counts_[1] + 2);
  this->table_.assign(static_cast<std::size_t>(this->strideZ_) * (this->counts_[2] + 2), 0);
  this->place_.assign(1, 0);
}

Index3 BrickTable::origin(int brick) const
{
  return { (brick % this->strideY_ - 1) * this->size_[0],
    (brick % this->strideZ_ / this->strideY_ - 1) * this->size_[1], (brick / this->strideZ_ - 1) * this->size_[2] };
}

std::uint32_t BrickTable::local(int i, int j, int k) const
{
  const int x = i & (this->size_[0] - 1);
  const int y = j & (this->size_[1] - 1);
  const int z = k & (this->size_[2] - 1);
  const int colour = (x + y + z) & 1;
  return static_cast<std::uint32_t>(
    colour * (this->elements_ / 2) + (z * this->size_[1] + y) * (this->size_[0] / 2) + (x >> 1));
}

std::uint32_t BrickTable::address(int i, int j, int k) const
{
  return static_cast<std::uint32_t>(this->slot(this->brickAt(i, j, k))) * this->elements_ + this->local(i, j, k);
}

std::vector<BrickTable::Row> BrickTable::rows(int brick) const
{
  const Index3 first = this->origin(brick);
  Index3 end;
  for (int a = 0; a < 3; ++a)
  {
    end[a] = std::min(first[a] + this->size_[a], this->grid_.size[a]);
  }
  std::vector<Row> rows;
  for (int k = first[2]; k < end[2]; ++k)
  {
    for (int j = first[1]; j < end[1]; ++j)
    {
      rows.push_back({ this->grid_.at(first[0], j, k), end[0] - first[0],
        { this->local(first[0], j, k), this->local(first[0] + 1, j, k) } });
    }
  }
  return rows;
}

std::vector<int> BrickTable::slotsOf(const std::vector<int>& bricks) const
{
  std::vector<int> slots;
  for (const int brick : bricks)
  {
    if (this->slot(brick) > 0)
    {
      slots.push_back(this->slot(brick));
    }
  }
  return slots;
}

std::vector<int> BrickTable::slotsIn(const VoxelBox& box, const std::vector<int>& slots) const
{
  std::vector<int> found;
  for (const int slot : slots)
  {
    const Index3 origin = this->origin(this->brick(slot));
    bool meets = true;
    for (int a = 0; a < 3; ++a)
    {
      meets = meets && origin[a] < box.first[a] + box.size[a] && box.first[a] < origin[a] + this->size_[a];
    }
    if (meets)
    {
      found.push_back(slot);
    }
  }
  return found;
}

std::vector<int> BrickTable::bricksOf(const std::vector<int>& slots) const
{
  std::vector<int> bricks;
  for (const int slot : slots)
  {
    bricks.push_back(this->brick(slot));
  }
  return bricks;
}

std::vector<int> BrickTable::bricksWhere(const std::vector<int>& slots, const std::vector<int>& found) const
{
  std::vector<int> bricks;
  for (std::size_t n = 0; n < slots.size(); ++n)
  {
    if (found[n] != 0)
    {
      bricks.push_back(this->brick(slots[n]));
    }
  }
  return bricks;
}

std::vector<int> BrickTable::slotsAround(const std::vector<int>& slots) const
{
  std::vector<char> isAround(this->slots(), 0);
  for (const int slot : slots)
  {
    isAround[slot] = 1;
    for (int direction = 0; direction < 6; ++direction)
    {
      isAround[this->slot(this->neighbour(this->brick(slot), direction))] = 1;
    }
  }
  std::vector<int> around;
  for (int slot = 1; slot < this->slots(); ++slot)
  {
    if (isAround[slot] != 0)
    {
      around.push_back(slot);
    }
  }
  return around;
}

}
