#include "SerialChainMail.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <queue>

namespace baseline
{

SerialChainMail::SerialChainMail(const std::array<int, 3>& size, std::vector<float> constraint)
  : size_(size)
  , constraint_(std::move(constraint))
  , moved_(this->constraint_.size(), 0)
{
  for (std::vector<float>& axis : this->state_)
  {
    axis.assign(this->constraint_.size(), 0.0f);
  }
}

void SerialChainMail::reset()
{
  for (std::vector<float>& axis : this->state_)
  {
    std::fill(axis.begin(), axis.end(), 0.0f);
  }
  std::fill(this->moved_.begin(), this->moved_.end(), 0);
}

bool SerialChainMail::place(std::size_t element, const std::array<double, 3>& displacement)
{
  for (int a = 0; a < 3; ++a)
  {
    this->state_[a][element] = static_cast<float>(displacement[a]);
  }
  this->moved_[element] = 1;
  return displacement != std::array<double, 3>{};
}

template <typename Visit> void SerialChainMail::eachNeighbour(std::size_t element, Visit&& visit) const
{
  const std::size_t nx = this->size_[0];
  const std::size_t ny = this->size_[1];
  const std::size_t nz = this->size_[2];
  const std::size_t x = element % nx;
  const std::size_t y = element / nx % ny;
  const std::size_t z = element / (nx * ny);
  if (x > 0)
  {
    visit(element - 1);
  }
  if (x + 1 < nx)
  {
    visit(element + 1);
  }
  if (y > 0)
  {
    visit(element - nx);
  }
  if (y + 1 < ny)
  {
    visit(element + nx);
  }
  if (z > 0)
  {
    visit(element - nx * ny);
  }
  if (z + 1 < nz)
  {
    visit(element + nx * ny);
  }
}

std::size_t SerialChainMail::pullFirstMovedFirst(std::size_t element, const std::array<double, 3>& displacement)
{
  if (!this->place(element, displacement))
  {
    return 0;
  }
  std::vector<std::uint32_t> queue{ static_cast<std::uint32_t>(element) };
  for (std::size_t next = 0; next < queue.size(); ++next)
  {
    const std::size_t i = queue[next];
    this->eachNeighbour(i,
      [&](std::size_t j)
      {
        // An element is moved once: whoever came first is nearest, and its box is the right one.
        if (this->moved_[j])
        {
          return;
        }
        const float limit = 0.5f * (this->constraint_[i] + this->constraint_[j]);
        bool violated = false;
        for (std::vector<float>& axis : this->state_)
        {
          const float inside = std::min(std::max(axis[j], axis[i] - limit), axis[i] + limit);
          violated = violated || inside != axis[j];
          axis[j] = inside;
        }
        if (violated)
        {
          this->moved_[j] = 1;
          queue.push_back(static_cast<std::uint32_t>(j));
        }
      });
  }
  return queue.size();
}

std::size_t SerialChainMail::pullLargestViolationFirst(std::size_t element, const std::array<double, 3>& displacement)
{
  struct Violation
  {
    float size; ///< by how much the link is too long, on its worst axis
    std::uint32_t from;
    std::uint32_t to;
    bool operator<(const Violation& other) const { return this->size < other.size; }
  };
  if (!this->place(element, displacement))
  {
    return 0;
  }
  std::priority_queue<Violation> queue;
  const auto look = [&](std::size_t i)
  {
    this->eachNeighbour(i,
      [&](std::size_t j)
      {
        if (this->moved_[j])
        {
          return;
        }
        const float limit = 0.5f * (this->constraint_[i] + this->constraint_[j]);
        float worst = 0.0f;
        for (const std::vector<float>& axis : this->state_)
        {
          worst = std::max(worst, std::fabs(axis[i] - axis[j]) - limit);
        }
        if (worst > 0.0f)
        {
          queue.push({ worst, static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j) });
        }
      });
  };
  look(element);
  std::size_t count = 1;
  while (!queue.empty())
  {
    const Violation v = queue.top();
    queue.pop();
    if (this->moved_[v.to])
    {
      continue;
    }
    const float limit = 0.5f * (this->constraint_[v.from] + this->constraint_[v.to]);
    for (std::vector<float>& axis : this->state_)
    {
      axis[v.to] = std::min(std::max(axis[v.to], axis[v.from] - limit), axis[v.from] + limit);
    }
    this->moved_[v.to] = 1;
    ++count;
    look(v.to);
  }
  return count;
}

}
