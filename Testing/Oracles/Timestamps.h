#pragma once

#include "Block.h"

#include <algorithm>

namespace oracle
{

/// The published propagation, algorithms 1 and 2: Jacobi iterations over all elements of the block, with one time for
/// all axes. As in the engine, only an element that the wave displaces passes the wave on.
class TimestampWaves
{
public:
  struct Element
  {
    Vector3 u{};
    double time = -1.0;
    int front = 0;
    bool active = false;
  };

  explicit TimestampWaves(const Block& block)
    : state(block.count())
    , held(block.anchored)
    , graph_(graph(block, 0))
  {
  }

  /// Starts wave `front` by moving one element.
  void start(std::size_t voxel, const Vector3& to, int front) { this->state[voxel] = { to, 0.0, front, true }; }

  bool finished() const
  {
    return std::none_of(this->state.begin(), this->state.end(), [](const Element& e) { return e.active; });
  }

  void iterate()
  {
    const std::vector<Element> old = this->state;
    for (std::size_t i = 0; i < old.size(); ++i)
    {
      Element& e = this->state[i];
      e.active = false;
      for (const Neighbour& neighbour : this->graph_[i])
      {
        const Element& n = old[neighbour.voxel];
        if (!n.active || this->held[i])
        {
          continue;
        }
        const double arrival = n.time + neighbour.limit;
        if (n.front > e.front || (n.front == e.front && arrival < e.time))
        {
          e.front = n.front;
          e.time = arrival;
          for (int a = 0; a < 3; ++a)
          {
            // From the displacement before this iteration: an earlier arrival in the same iteration does not count.
            e.u[a] = std::min(std::max(old[i].u[a], n.u[a] - neighbour.limit), n.u[a] + neighbour.limit);
          }
          e.active = e.u != old[i].u;
        }
      }
    }
  }

  std::vector<Element> state;
  std::vector<char> held;

private:
  std::vector<std::vector<Neighbour>> graph_;
};

}
