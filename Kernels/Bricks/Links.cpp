#include "Links.h"

#include <algorithm>
#include <limits>

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

bool Links::remove(int i, int j, int k, int direction)
{
  const auto mark = [this](int x, int y, int z, int d)
  {
    std::vector<std::uint8_t>& bits = this->cuts_[this->table_.brickAt(x, y, z)];
    bits.resize(this->table_.elementsPerBrick(), 0);
    std::uint8_t& byte = bits[this->table_.local(x, y, z)];
    const bool added = (byte & (1 << d)) == 0;
    byte = static_cast<std::uint8_t>(byte | (1 << d));
    return added;
  };
  Index3 other{ i, j, k };
  other[direction / 2] += direction % 2 == 0 ? -1 : 1;
  mark(other[0], other[1], other[2], BrickTable::opposite(direction));
  return mark(i, j, k, direction);
}

void Links::removeElement(int i, int j, int k)
{
  const int brick = this->table_.brickAt(i, j, k);
  std::vector<std::uint8_t>& bits = this->cuts_[brick];
  bits.resize(this->table_.elementsPerBrick(), 0);
  bits[this->table_.local(i, j, k)] |= carvedBit;
  this->carvedBricks_.insert(brick);
}

void Links::clear()
{
  this->cuts_.clear();
  this->carvedBricks_.clear();
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
        if ((bits[this->table_.local(n, j, k)] & carvedBit) != 0)
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
