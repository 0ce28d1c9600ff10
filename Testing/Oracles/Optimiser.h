#pragma once

#include "Propagation.h"

#include <cmath>
#include <stdexcept>

namespace oracle
{

/// The minimum of the energy under the link limits, with proof. The problem is convex. Its optimum lies between
/// `bound`, the value of a feasible point of the dual problem, and `energy`, the value of a feasible point of the
/// primal problem.
struct Optimum
{
  std::vector<Vector3> state; ///< feasible
  double energy = 0.0;
  double bound = 0.0;
  int iterations = 0;

  /// Relative duality gap: 0 is a perfect proof.
  double gap() const { return this->energy > 0.0 ? (this->energy - this->bound) / this->energy : 0.0; }
};

/// Cholesky factor of a sparse symmetric positive definite matrix, stored by rows from their first non-zero on.
class Skyline
{
public:
  explicit Skyline(std::size_t n)
    : first_(n)
    , row_(n)
  {
    for (std::size_t i = 0; i < n; ++i)
    {
      this->first_[i] = i;
    }
  }

  /// Call for every non-zero (i, j), j <= i, before the first add().
  void reserve(std::size_t i, std::size_t j) { this->first_[i] = std::min(this->first_[i], j); }

  void add(std::size_t i, std::size_t j, double value)
  {
    std::vector<double>& row = this->row_[i];
    row.resize(i - this->first_[i] + 1, 0.0);
    row[j - this->first_[i]] += value;
  }

  void factorise()
  {
    for (std::size_t i = 0; i < this->row_.size(); ++i)
    {
      for (std::size_t j = this->first_[i]; j <= i; ++j)
      {
        const std::size_t from = std::max(this->first_[i], this->first_[j]);
        double sum = this->row_[i][j - this->first_[i]];
        const double* a = this->row_[i].data() - this->first_[i];
        const double* b = this->row_[j].data() - this->first_[j];
        for (std::size_t k = from; k < j; ++k)
        {
          sum -= a[k] * b[k];
        }
        if (j < i)
        {
          this->row_[i][j - this->first_[i]] = sum / b[j];
        }
        else
        {
          if (!(sum > 0.0))
          {
            throw std::logic_error("oracle: matrix is not positive definite");
          }
          this->row_[i][j - this->first_[i]] = std::sqrt(sum);
        }
      }
    }
  }

  void solve(std::vector<double>& x) const
  {
    for (std::size_t i = 0; i < this->row_.size(); ++i)
    {
      const double* a = this->row_[i].data() - this->first_[i];
      double sum = x[i];
      for (std::size_t k = this->first_[i]; k < i; ++k)
      {
        sum -= a[k] * x[k];
      }
      x[i] = sum / a[i];
    }
    for (std::size_t i = this->row_.size(); i-- > 0;)
    {
      const double* a = this->row_[i].data() - this->first_[i];
      x[i] /= a[i];
      for (std::size_t k = this->first_[i]; k < i; ++k)
      {
        x[k] -= a[k] * x[i];
      }
    }
  }

private:
  std::vector<std::size_t> first_;
  std::vector<std::vector<double>> row_;
};

namespace detail
{

/// One axis of the problem, with u given at held elements:
///
///     minimise  sum over links l of w(l) max(0, |y(l)| - s(l))^2  +  sum over soft links of v (u - t)^2
///     subject to  y = A u (y(l) = u(to) - u(from)),  |y(l)| <= D(l),  where s = slack D.
///
/// It is convex, so the value of the minimum is unique. With s > 0 several states may have it.
///
/// The method is ADMM (alternating direction method of multipliers) on the splitting y = A u, with penalties
/// rho(l) = c w(l). The step in u is a linear system with a constant matrix. The step in y has a closed form for each
/// link.
///
/// Lower bound: after the step in u the multiplier z satisfies A^T z = 0 at free elements without soft links. So z is
/// feasible in the dual problem
///
///     maximise  -sum over links of phi*(z)  +  sum over held elements of (flow out of the element) * (its u),
///     phi*(z) = max over |y| <= D of  z y - w max(0, |y| - s)^2.
///
/// An element with soft links of total weight v and mean target t may have any flow g = A^T z. It adds
/// min over u of g u + v (u - t)^2 = g t - g^2 / (4 v). The value of z is a lower bound after every iteration,
/// converged or not.
///
/// Upper bound: the energy of u after projection to a feasible state. u is clamped between the cones of the held
/// elements, then replaced by the mean of its two Lipschitz envelopes.
inline void minimiseAxis(const Block& block, int axis, const std::vector<char>& held, const std::vector<Vector3>& start,
  double gap, double epsilon, Optimum& result)
{
  // Unknowns: one for a free element, one for a rigid cluster. Clusters are last, because their rows are long.
  const std::vector<int> group = parts(block, [&](const Link& link) { return limit(block, link, axis) == 0.0; });
  const int groups = 1 + *std::max_element(group.begin(), group.end());
  std::vector<int> members(groups, 0);
  std::vector<char> fixed(groups, 0);
  std::vector<double> value(groups, 0.0);
  for (std::size_t v = 0; v < block.count(); ++v)
  {
    if (!block.tissue[v])
    {
      continue;
    }
    const int g = group[v];
    ++members[g];
    if (held[v])
    {
      if (fixed[g] && std::abs(value[g] - start[v][axis]) > 1e-9)
      {
        throw std::logic_error("oracle: a rigid cluster is held at two places");
      }
      fixed[g] = 1;
      value[g] = start[v][axis];
    }
  }

  struct Edge
  {
    int from, to;
    double weight, limit, slack;
  };
  std::vector<Edge> edges;
  for (const Link& link : links(block))
  {
    if (group[link.from] != group[link.to])
    {
      const double d = limit(block, link, axis);
      edges.push_back({ group[link.from], group[link.to], 1.0 / (d + epsilon), d, block.slack * d });
    }
  }

  std::vector<double> softWeight(groups, 0.0), softPlace(groups, 0.0);
  for (const Soft& soft : block.soft)
  {
    const double weight = block.spacing[axis] / soft.tolerance;
    softWeight[group[soft.voxel]] += weight;
    softPlace[group[soft.voxel]] += weight * soft.target[axis];
  }
  for (int g = 0; g < groups; ++g)
  {
    softPlace[g] /= softWeight[g] > 0.0 ? softWeight[g] : 1.0;
  }

  // A component that nothing holds is free to move as a whole. One of its unknowns is held to make the matrix regular.
  int number = 0;
  const std::vector<int> part = parts(block, &number);
  std::vector<char> grounded(number, 0);
  for (std::size_t v = 0; v < block.count(); ++v)
  {
    if (block.tissue[v] && (fixed[group[v]] || softWeight[group[v]] > 0.0))
    {
      grounded[part[v]] = 1;
    }
  }
  for (std::size_t v = 0; v < block.count(); ++v)
  {
    if (block.tissue[v] && !grounded[part[v]])
    {
      grounded[part[v]] = 1;
      fixed[group[v]] = 1;
      value[group[v]] = start[v][axis];
    }
  }

  std::vector<long> unknown(groups, -1);
  std::size_t unknowns = 0;
  for (const bool single : { true, false })
  {
    for (int g = 0; g < groups; ++g)
    {
      if (!fixed[g] && (members[g] == 1) == single)
      {
        unknown[g] = static_cast<long>(unknowns++);
      }
    }
  }

  const double c = 4.0; // penalty over weight; only speed depends on it
  Skyline matrix(unknowns);
  for (int pass = 0; pass < 2; ++pass)
  {
    for (const Edge& e : edges)
    {
      const long i = unknown[e.from], j = unknown[e.to];
      const auto put = [&](long a, long b, double w) { pass == 0 ? matrix.reserve(a, b) : matrix.add(a, b, w); };
      const double rho = c * e.weight;
      if (i >= 0)
      {
        put(i, i, rho);
      }
      if (j >= 0)
      {
        put(j, j, rho);
      }
      if (i >= 0 && j >= 0)
      {
        put(std::max(i, j), std::min(i, j), -rho);
      }
    }
  }
  for (int g = 0; g < groups; ++g)
  {
    if (unknown[g] >= 0 && softWeight[g] > 0.0)
    {
      matrix.add(unknown[g], unknown[g], 2.0 * softWeight[g]);
    }
  }
  matrix.factorise();

  std::vector<double> u = value;
  std::vector<double> y(edges.size(), 0.0), dual(edges.size(), 0.0); // dual: z / rho
  std::vector<std::pair<std::size_t, double>> heldUp, heldDown;
  for (std::size_t v = 0; v < block.count(); ++v)
  {
    if (block.tissue[v] && fixed[group[v]])
    {
      heldUp.push_back({ v, value[group[v]] });
      heldDown.push_back({ v, -value[group[v]] });
    }
  }
  const std::vector<double> coneUp = shortest(block, axis, heldUp);
  const std::vector<double> coneDown = shortest(block, axis, heldDown);

  const auto energyOf = [&](const std::vector<double>& x)
  {
    double sum = 0.0;
    for (const Soft& soft : block.soft)
    {
      const double distance = x[group[soft.voxel]] - soft.target[axis];
      sum += block.spacing[axis] / soft.tolerance * distance * distance;
    }
    for (const Edge& e : edges)
    {
      const double d = std::max(0.0, std::abs(x[e.to] - x[e.from]) - e.slack);
      sum += e.weight * d * d;
    }
    return sum;
  };

  double best = std::numeric_limits<double>::infinity();
  double bound = -best;
  std::vector<double> bestState;
  int iteration = 0;
  for (; iteration < 20000; ++iteration)
  {
    // u: minimise sum of rho (A u - y + dual)^2.
    std::vector<double> right(unknowns, 0.0);
    for (int g = 0; g < groups; ++g)
    {
      if (unknown[g] >= 0)
      {
        right[unknown[g]] = 2.0 * softWeight[g] * softPlace[g];
      }
    }
    for (std::size_t l = 0; l < edges.size(); ++l)
    {
      const Edge& e = edges[l];
      const double rho = c * e.weight;
      const double target = y[l] - dual[l];
      const long i = unknown[e.from], j = unknown[e.to];
      if (j >= 0)
      {
        right[j] += rho * (target + (i < 0 ? value[e.from] : 0.0));
      }
      if (i >= 0)
      {
        right[i] -= rho * (target - (j < 0 ? value[e.to] : 0.0));
      }
    }
    matrix.solve(right);
    for (int g = 0; g < groups; ++g)
    {
      if (unknown[g] >= 0)
      {
        u[g] = right[unknown[g]];
      }
    }
    for (std::size_t l = 0; l < edges.size(); ++l)
    {
      dual[l] += u[edges[l].to] - u[edges[l].from] - y[l];
    }

    // The proof, every few iterations.
    if (iteration % 20 == 19)
    {
      double lower = 0.0;
      std::vector<double> flow(groups, 0.0);
      for (std::size_t l = 0; l < edges.size(); ++l)
      {
        const Edge& e = edges[l];
        const double z = c * e.weight * dual[l];
        const double size = std::abs(z);
        const double widest = e.limit - e.slack;
        lower -= size <= 2.0 * e.weight * widest ? size * e.slack + z * z / (4.0 * e.weight)
                                                 : size * e.limit - e.weight * widest * widest;
        lower += z * ((unknown[e.to] < 0 ? value[e.to] : 0.0) - (unknown[e.from] < 0 ? value[e.from] : 0.0));
        flow[e.to] += z;
        flow[e.from] -= z;
      }
      for (int g = 0; g < groups; ++g)
      {
        if (softWeight[g] > 0.0 && unknown[g] >= 0)
        {
          lower += flow[g] * softPlace[g] - flow[g] * flow[g] / (4.0 * softWeight[g]);
        }
      }
      // The part of the soft links' energy that does not depend on the free unknowns.
      for (const Soft& soft : block.soft)
      {
        const int g = group[soft.voxel];
        const double distance = (unknown[g] < 0 ? value[g] : softPlace[g]) - soft.target[axis];
        lower += block.spacing[axis] / soft.tolerance * distance * distance;
      }
      bound = std::max(bound, lower);

      std::vector<std::pair<std::size_t, double>> up, down;
      for (std::size_t v = 0; v < block.count(); ++v)
      {
        if (block.tissue[v])
        {
          const double x = std::min(std::max(u[group[v]], -coneDown[v]), coneUp[v]);
          up.push_back({ v, x });
          down.push_back({ v, -x });
        }
      }
      const std::vector<double> high = shortest(block, axis, up);
      const std::vector<double> low = shortest(block, axis, down);
      std::vector<double> feasible = u;
      for (std::size_t v = 0; v < block.count(); ++v)
      {
        if (block.tissue[v])
        {
          feasible[group[v]] = 0.5 * (high[v] - low[v]);
        }
      }
      const double upper = energyOf(feasible);
      if (upper < best)
      {
        best = upper;
        bestState = feasible;
      }
      if (best - bound <= gap * best || best < 1e-20)
      {
        break;
      }
    }

    // y: minimise w max(0, |y| - s)^2 + rho/2 (A u - y + dual)^2 over |y| <= D.
    for (std::size_t l = 0; l < edges.size(); ++l)
    {
      const Edge& e = edges[l];
      const double unclamped = u[e.to] - u[e.from] + dual[l];
      const double beyond = std::max(0.0, std::abs(unclamped) - e.slack);
      const double size = std::min(std::abs(unclamped) - beyond + beyond * c / (2.0 + c), e.limit);
      y[l] = std::copysign(size, unclamped);
    }
  }

  result.iterations = std::max(result.iterations, iteration + 1);
  result.energy += block.spacing[axis] * best;
  result.bound += block.spacing[axis] * bound;
  for (std::size_t v = 0; v < block.count(); ++v)
  {
    if (block.tissue[v])
    {
      result.state[v][axis] = bestState[group[v]];
    }
  }
}

}

/// Minimises the energy of a block whose `held` elements keep their displacements in `start`. For up to 16^3 elements.
/// The caller must check gap().
inline Optimum minimise(const Block& block, const std::vector<char>& held, const std::vector<Vector3>& start,
  double gap = 1e-6, double epsilon = 1e-6)
{
  Optimum result;
  result.state = start;
  for (int axis = 0; axis < 3; ++axis)
  {
    detail::minimiseAxis(block, axis, held, start, gap, epsilon, result);
  }
  return result;
}

}
