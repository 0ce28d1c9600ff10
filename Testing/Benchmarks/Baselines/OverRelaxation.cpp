#include "OverRelaxation.h"

#include <algorithm>
#include <limits>
#include <thread>

namespace baseline
{

namespace
{

constexpr double epsilon = 1e-6;

}

OverRelaxation::OverRelaxation(const std::array<int, 3>& size, const std::vector<float>& constraint)
  : size_(size)
  , constraint_(constraint.begin(), constraint.end())
{
  // Bodies: what links without give connect.
  std::vector<char> seen(constraint.size(), 0);
  for (std::size_t v = 0; v < constraint.size(); ++v)
  {
    if (constraint[v] != 0.0f || seen[v])
    {
      continue;
    }
    std::vector<std::size_t> body{ v };
    seen[v] = 1;
    for (std::size_t n = 0; n < body.size(); ++n)
    {
      this->eachNeighbour(body[n],
        [&](std::size_t j)
        {
          if (constraint[j] == 0.0f && !seen[j])
          {
            seen[j] = 1;
            body.push_back(j);
          }
        });
    }
    this->bodies_.push_back(std::move(body));
  }
}

template <typename Visit> void OverRelaxation::eachNeighbour(std::size_t i, Visit&& visit) const
{
  const std::size_t stride[3] = { 1, static_cast<std::size_t>(this->size_[0]),
    static_cast<std::size_t>(this->size_[0]) * this->size_[1] };
  for (int a = 0; a < 3; ++a)
  {
    const std::size_t p = i / stride[a] % this->size_[a];
    if (p > 0)
    {
      visit(i - stride[a]);
    }
    if (p + 1 < static_cast<std::size_t>(this->size_[a]))
    {
      visit(i + stride[a]);
    }
  }
}

void OverRelaxation::start(const State& state, const std::vector<char>& held)
{
  this->held_ = held;
  for (int a = 0; a < 3; ++a)
  {
    this->u_[a].assign(state[a].begin(), state[a].end());
  }
}

State OverRelaxation::state() const
{
  State state;
  for (int a = 0; a < 3; ++a)
  {
    state[a].assign(this->u_[a].begin(), this->u_[a].end());
  }
  return state;
}

void OverRelaxation::add(Box& box, int axis, std::size_t i, std::size_t j) const
{
  const double limit = 0.5 * (this->constraint_[i] + this->constraint_[j]);
  const double u = this->u_[axis][j];
  box.weight += 1.0 / (limit + epsilon);
  box.sum += u / (limit + epsilon);
  box.low = std::max(box.low, u - limit);
  box.high = std::min(box.high, u + limit);
}

double OverRelaxation::relaxed(const Box& box, double u, double omega) const
{
  // Rounding may leave no room.
  if (box.weight == 0.0 || box.low > box.high)
  {
    return u;
  }
  return std::min(std::max(u + omega * (box.sum / box.weight - u), box.low), box.high);
}

void OverRelaxation::sweep(double omega)
{
  // Axes know nothing of each other.
  std::vector<std::thread> threads;
  for (int axis = 0; axis < 3; ++axis)
  {
    threads.emplace_back([this, axis, omega] { this->sweepAxis(axis, omega); });
  }
  for (std::thread& thread : threads)
  {
    thread.join();
  }
}

void OverRelaxation::sweepAxis(int axis, double omega)
{
  constexpr double infinity = std::numeric_limits<double>::infinity();
  std::vector<double>& u = this->u_[axis];
  for (int colour = 0; colour < 2; ++colour)
  {
    for (int k = 0; k < this->size_[2]; ++k)
    {
      for (int j = 0; j < this->size_[1]; ++j)
      {
        const std::size_t row =
          static_cast<std::size_t>(this->size_[0]) * (j + static_cast<std::size_t>(this->size_[1]) * k);
        for (int i = (colour + j + k) % 2; i < this->size_[0]; i += 2)
        {
          const std::size_t v = row + i;
          if (this->held_[v] || this->constraint_[v] == 0.0)
          {
            continue;
          }
          Box box{ 0.0, 0.0, -infinity, infinity };
          this->eachNeighbour(v, [&](std::size_t n) { this->add(box, axis, v, n); });
          u[v] = this->relaxed(box, u[v], omega);
        }
      }
    }
  }
  for (const std::vector<std::size_t>& body : this->bodies_)
  {
    Box box{ 0.0, 0.0, -infinity, infinity };
    bool held = false;
    for (const std::size_t v : body)
    {
      held = held || this->held_[v];
      this->eachNeighbour(v,
        [&](std::size_t n)
        {
          if (this->constraint_[n] != 0.0)
          {
            this->add(box, axis, v, n);
          }
        });
    }
    const double to = held ? u[body[0]] : this->relaxed(box, u[body[0]], omega);
    for (const std::size_t v : body)
    {
      u[v] = to;
    }
  }
}

double OverRelaxation::energy() const
{
  double energy = 0.0;
  for (std::size_t i = 0; i < this->constraint_.size(); ++i)
  {
    this->eachNeighbour(i,
      [&](std::size_t j)
      {
        for (int axis = 0; j > i && axis < 3; ++axis)
        {
          const double strain = this->u_[axis][i] - this->u_[axis][j];
          energy += strain * strain / (0.5 * (this->constraint_[i] + this->constraint_[j]) + epsilon);
        }
      });
  }
  return energy;
}

}
