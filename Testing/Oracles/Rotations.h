#pragma once

// The optimum of rotating tissue for small pulls: displacements u and rotation vectors s that minimise the linear
// energy
//
//   E = 1/2 sum over links of W ( |u(j) - u(i) - s(i) x h e|^2 + |u(j) - u(i) - s(j) x h e|^2 ),  W = v / (h^2 D),
//
// where e and h are a link's direction and length and v is the cube root of an element's volume [mm]. With a Poisson's
// ratio n an element of volumetric strain t adds n / (1 - 2 n) v / D t^2. Its volumetric strain is the sum of its
// shares of the axial strains of its links; links of rigid elements do not count. A rigid body has one displacement and
// one rotation. Soft links add softEnergy(). Limits are ignored. The method is conjugate gradients on the normal
// equations, in double.

#include "Block.h"

namespace oracle
{

struct RotationOptimum
{
  std::vector<Vector3> u;        ///< [mm]
  std::vector<Vector3> rotation; ///< [rad]
  double energy = 0.0;
};

inline Vector3 crossProduct(const Vector3& a, const Vector3& b)
{
  return { a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0] };
}

class RotationProblem
{
public:
  /// `held`: 1 where an element's displacement is given. No element of a rigid body may be held.
  RotationProblem(const Block& block, std::vector<char> held, double poissonRatio = 0.0)
    : block_(block)
    , links_(links(block))
    , held_(std::move(held))
    , body_(block.count(), -1)
    , bulk_(block.count(), 0.0)
  {
    const Vector3& h = block.spacing;
    for (std::size_t v = 0; v < block.count(); ++v)
    {
      this->bulk_[v] =
        2.0 * poissonRatio / (1.0 - 2.0 * poissonRatio) * std::cbrt(h[0] * h[1] * h[2]) / (block.give[v][0] + 1e-6);
    }
    std::vector<int> part = parts(block, [&](const Link& link) { return limit(block, link, 0) == 0.0; });
    std::vector<Vector3> sum;
    std::vector<double> count;
    std::vector<int> number(block.count(), -1);
    for (std::size_t v = 0; v < block.count(); ++v)
    {
      if (!block.tissue[v] || block.give[v][0] > 0.0)
      {
        continue;
      }
      int& id = number[part[v]];
      if (id < 0)
      {
        id = static_cast<int>(sum.size());
        sum.push_back({});
        count.push_back(0.0);
      }
      this->body_[v] = id;
      for (int a = 0; a < 3; ++a)
      {
        sum[id][a] += block.index(v)[a] * block.spacing[a];
      }
      count[id] += 1.0;
    }
    for (std::size_t b = 0; b < sum.size(); ++b)
    {
      this->centre_.push_back({ sum[b][0] / count[b], sum[b][1] / count[b], sum[b][2] / count[b] });
    }
  }

  /// Minimises from `given`, which holds the displacements of held elements [mm].
  RotationOptimum minimise(const std::vector<Vector3>& given) const
  {
    const std::size_t n = 6 * (this->block_.count() + this->centre_.size());
    State fixed = this->zero();
    for (std::size_t v = 0; v < this->block_.count(); ++v)
    {
      fixed.u[v] = this->held_[v] ? given[v] : Vector3{};
    }
    // Residuals are linear: r(x) = J x + r(fixed). Solve J'WJ x = -J'W r(fixed).
    std::vector<double> x(n, 0.0), r = this->gradient(fixed, 1.0), p(n), q;
    for (double& value : r)
    {
      value = -value;
    }
    p = r;
    double square = dot(r, r);
    const double first = square;
    for (int round = 0; round < 20000 && square > 1e-24 * first; ++round)
    {
      q = this->gradient(this->place(p), 0.0);
      const double step = square / dot(p, q);
      for (std::size_t m = 0; m < n; ++m)
      {
        x[m] += step * p[m];
        r[m] -= step * q[m];
      }
      const double next = dot(r, r);
      for (std::size_t m = 0; m < n; ++m)
      {
        p[m] = r[m] + next / square * p[m];
      }
      square = next;
    }
    State state = this->place(x);
    for (std::size_t v = 0; v < this->block_.count(); ++v)
    {
      state.u[v] = this->held_[v] ? given[v] : state.u[v];
    }
    return { state.u, state.rotation, this->energy(state.u, state.rotation) };
  }

  double energy(const std::vector<Vector3>& u, const std::vector<Vector3>& rotation) const
  {
    double sum = 0.0;
    this->each(u, rotation,
      [&](const Link&, double weight, const Vector3&, const Vector3& byFrom, const Vector3& byTo)
      {
        for (int a = 0; a < 3; ++a)
        {
          sum += 0.5 * weight * (byFrom[a] * byFrom[a] + byTo[a] * byTo[a]);
        }
      });
    const std::vector<double> volumetricStrain = this->volumetricStrain(u);
    for (std::size_t v = 0; v < volumetricStrain.size(); ++v)
    {
      sum += 0.5 * this->bulk_[v] * volumetricStrain[v] * volumetricStrain[v];
    }
    for (const Soft& soft : this->block_.soft)
    {
      for (int a = 0; a < 3; ++a)
      {
        const double distance = u[soft.voxel][a] - soft.target[a] * this->block_.spacing[a];
        sum += distance * distance / soft.tolerance;
      }
    }
    return sum;
  }

private:
  struct State
  {
    std::vector<Vector3> u;
    std::vector<Vector3> rotation;
  };

  static double dot(const std::vector<double>& a, const std::vector<double>& b)
  {
    double sum = 0.0;
    for (std::size_t m = 0; m < a.size(); ++m)
    {
      sum += a[m] * b[m];
    }
    return sum;
  }

  State zero() const
  {
    return { std::vector<Vector3>(this->block_.count(), Vector3{}),
      std::vector<Vector3>(this->block_.count(), Vector3{}) };
  }

  Vector3 leverArm(std::size_t v) const
  {
    Vector3 r;
    for (int a = 0; a < 3; ++a)
    {
      r[a] = this->block_.index(v)[a] * this->block_.spacing[a] - this->centre_[this->body_[v]][a];
    }
    return r;
  }

  /// The state of a vector of unknowns: 6 for each voxel, then 6 for each body. Those of rigid and held voxels are
  /// unused.
  State place(const std::vector<double>& x) const
  {
    State state = this->zero();
    for (std::size_t v = 0; v < this->block_.count(); ++v)
    {
      const int b = this->body_[v];
      const double* at = x.data() + 6 * (b < 0 ? v : this->block_.count() + b);
      const Vector3 rotation{ at[3], at[4], at[5] };
      const Vector3 byRotation = b < 0 ? Vector3{} : crossProduct(rotation, this->leverArm(v));
      for (int a = 0; a < 3; ++a)
      {
        state.u[v][a] = this->held_[v] ? 0.0 : at[a] + byRotation[a];
        state.rotation[v][a] = rotation[a];
      }
    }
    return state;
  }

  template <typename F> void each(const std::vector<Vector3>& u, const std::vector<Vector3>& rotation, F&& f) const
  {
    const Vector3& h = this->block_.spacing;
    const double size = std::cbrt(h[0] * h[1] * h[2]);
    for (const Link& link : this->links_)
    {
      const double d = limit(this->block_, link, 0);
      if (d == 0.0)
      {
        continue;
      }
      Vector3 rest{};
      rest[link.direction] = h[link.direction];
      const Vector3 from = crossProduct(rotation[link.from], rest), to = crossProduct(rotation[link.to], rest);
      Vector3 byFrom, byTo;
      for (int a = 0; a < 3; ++a)
      {
        const double difference = u[link.to][a] - u[link.from][a];
        byFrom[a] = difference - from[a];
        byTo[a] = difference - to[a];
      }
      f(link, size / (rest[link.direction] * rest[link.direction] * (d + 1e-6)), rest, byFrom, byTo);
    }
  }

  /// Calls f(link, length, share of link.from, share of link.to) for each link between soft elements. A share is the
  /// part of the link's strain in the element's half.
  template <typename F> void eachSoft(F&& f) const
  {
    for (const Link& link : this->links_)
    {
      const double from = this->block_.give[link.from][0], to = this->block_.give[link.to][0];
      if (from > 0.0 && to > 0.0)
      {
        f(link, this->block_.spacing[link.direction], from / (from + to), to / (from + to));
      }
    }
  }

  std::vector<double> volumetricStrain(const std::vector<Vector3>& u) const
  {
    std::vector<double> sum(this->block_.count(), 0.0);
    this->eachSoft(
      [&](const Link& link, double length, double ofFrom, double ofTo)
      {
        const double strain = (u[link.to][link.direction] - u[link.from][link.direction]) / length;
        sum[link.from] += ofFrom * strain;
        sum[link.to] += ofTo * strain;
      });
    return sum;
  }

  /// `constant`: factor of the constant part of the gradient, which comes from the targets of soft links; 0 or 1.
  std::vector<double> gradient(const State& state, double constant) const
  {
    std::vector<Vector3> force(this->block_.count(), Vector3{}), torque(this->block_.count(), Vector3{});
    this->each(state.u, state.rotation,
      [&](const Link& link, double weight, const Vector3& rest, const Vector3& byFrom, const Vector3& byTo)
      {
        // d/ds (|b|^2 / 2) = -rest x b for b = ... - s x rest.
        const Vector3 from = crossProduct(rest, byFrom), to = crossProduct(rest, byTo);
        for (int a = 0; a < 3; ++a)
        {
          force[link.to][a] += weight * (byFrom[a] + byTo[a]);
          force[link.from][a] -= weight * (byFrom[a] + byTo[a]);
          torque[link.from][a] -= weight * from[a];
          torque[link.to][a] -= weight * to[a];
        }
      });
    const std::vector<double> volumetricStrain = this->volumetricStrain(state.u);
    this->eachSoft(
      [&](const Link& link, double length, double ofFrom, double ofTo)
      {
        const double pull = (this->bulk_[link.from] * volumetricStrain[link.from] * ofFrom +
                              this->bulk_[link.to] * volumetricStrain[link.to] * ofTo) /
                            length;
        force[link.to][link.direction] += pull;
        force[link.from][link.direction] -= pull;
      });
    for (const Soft& soft : this->block_.soft)
    {
      for (int a = 0; a < 3; ++a)
      {
        const double distance = state.u[soft.voxel][a] - constant * soft.target[a] * this->block_.spacing[a];
        force[soft.voxel][a] += 2.0 / soft.tolerance * distance;
      }
    }
    std::vector<double> result(6 * (this->block_.count() + this->centre_.size()), 0.0);
    for (std::size_t v = 0; v < this->block_.count(); ++v)
    {
      if (!this->block_.tissue[v])
      {
        continue;
      }
      const int b = this->body_[v];
      double* at = result.data() + 6 * (b < 0 ? v : this->block_.count() + b);
      const Vector3 ofForce = b < 0 ? Vector3{} : crossProduct(this->leverArm(v), force[v]);
      for (int a = 0; a < 3; ++a)
      {
        at[a] += this->held_[v] ? 0.0 : force[v][a];
        at[3 + a] += torque[v][a] + ofForce[a];
      }
    }
    return result;
  }

  const Block& block_;
  std::vector<Link> links_;
  std::vector<char> held_;
  std::vector<int> body_;
  std::vector<double> bulk_; ///< second derivative of each element's energy with respect to its volumetric strain
  std::vector<Vector3> centre_;
};

}
