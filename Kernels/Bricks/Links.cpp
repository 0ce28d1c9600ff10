#include "Links.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace chainmail
{

std::uint8_t Links::cutBits(int i, int j, int k) const
{
  if (this->cuts_.empty())
  {
    return 0;
  }
  const auto bits = this->cuts_.find(this->table_.brickAt(i, j, k));
  return bits == this->cuts_.end() ? 0 : bits->second[this->table_.local(i, j, k)];
}

std::uint8_t Links::shownBits(int i, int j, int k) const
{
  const std::uint8_t bits = this->cutBits(i, j, k);
  const auto joints = this->joints_.find(this->table_.brickAt(i, j, k));
  return joints == this->joints_.end() ? bits
                                       : static_cast<std::uint8_t>(bits & ~joints->second[this->table_.local(i, j, k)]);
}

/// Sets the bit of a link at one of its ends. Returns whether it was not set.
bool Links::set(CutBits& to, const Index3& at, int direction)
{
  std::vector<std::uint8_t>& bits = to[this->table_.brickAt(at[0], at[1], at[2])];
  bits.resize(this->table_.elementsPerBrick(), 0);
  std::uint8_t& byte = bits[this->table_.local(at[0], at[1], at[2])];
  const bool added = (byte & CUT_BIT(direction)) == 0;
  byte = static_cast<std::uint8_t>(byte | CUT_BIT(direction));
  return added;
}

bool Links::remove(int i, int j, int k, int direction)
{
  Index3 other{ i, j, k };
  other[direction / 2] += direction % 2 == 0 ? -1 : 1;
  const bool added = this->set(this->cuts_, { i, j, k }, direction);
  this->set(this->cuts_, other, BrickTable::opposite(direction));
  bool wasOfJoint = false;
  const auto cut = [&](const Index3& at, int d)
  {
    const auto bits = this->joints_.find(this->table_.brickAt(at[0], at[1], at[2]));
    if (bits != this->joints_.end())
    {
      std::uint8_t& byte = bits->second[this->table_.local(at[0], at[1], at[2])];
      wasOfJoint = wasOfJoint || (byte & CUT_BIT(d)) != 0;
      byte = static_cast<std::uint8_t>(byte & ~CUT_BIT(d));
    }
  };
  cut({ i, j, k }, direction);
  cut(other, BrickTable::opposite(direction));
  return added || wasOfJoint;
}

void Links::removeAtJoint(int i, int j, int k, int direction)
{
  Index3 other{ i, j, k };
  other[direction / 2] += direction % 2 == 0 ? -1 : 1;
  for (CutBits* bits : { &this->cuts_, &this->joints_ })
  {
    this->set(*bits, { i, j, k }, direction);
    this->set(*bits, other, BrickTable::opposite(direction));
  }
}

std::vector<std::uint8_t> Links::shown(int brick) const
{
  std::vector<std::uint8_t> bits = this->cuts_.at(brick);
  const auto joints = this->joints_.find(brick);
  for (std::size_t n = 0; joints != this->joints_.end() && n < bits.size(); ++n)
  {
    bits[n] = static_cast<std::uint8_t>(bits[n] & ~joints->second[n]);
  }
  return bits;
}

void Links::removeElement(int i, int j, int k)
{
  const int brick = this->table_.brickAt(i, j, k);
  std::vector<std::uint8_t>& bits = this->cuts_[brick];
  bits.resize(this->table_.elementsPerBrick(), 0);
  bits[this->table_.local(i, j, k)] |= CARVED_BIT;
  this->carvedBricks_.insert(brick);
}

void Links::clear()
{
  this->cuts_.clear();
  this->joints_.clear();
  this->carvedBricks_.clear();
}

void Links::replace(CutBits bits)
{
  this->clear();
  this->cuts_ = std::move(bits);
  for (const auto& [brick, cuts] : this->cuts_)
  {
    if (std::any_of(cuts.begin(), cuts.end(), [](std::uint8_t byte) { return (byte & CARVED_BIT) != 0; }))
    {
      this->carvedBricks_.insert(brick);
    }
  }
}

void Links::takeOut(int i, int j, int k, int count, int axes, float* constraints) const
{
  if (this->carvedBricks_.empty())
  {
    return;
  }
  const int width = this->table_.size()[0];
  for (int x = i; x < i + count;)
  {
    const int end = std::min(i + count, (x / width + 1) * width);
    const int brick = this->table_.brickAt(x, j, k);
    if (this->carvedBricks_.count(brick) > 0)
    {
      const std::vector<std::uint8_t>& bits = this->cuts_.at(brick);
      for (int n = x; n < end; ++n)
      {
        if ((bits[this->table_.local(n, j, k)] & CARVED_BIT) != 0)
        {
          float* c = constraints + static_cast<std::size_t>(n - i) * axes;
          std::fill(c, c + axes, -std::numeric_limits<float>::infinity());
        }
      }
    }
    x = end;
  }
}

}
