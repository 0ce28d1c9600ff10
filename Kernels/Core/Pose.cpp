#include "Pose.h"

#include "ElementRule.h"

#include <algorithm>
#include <cmath>

namespace chainmail
{

namespace
{

double length(const Vector3& v)
{
  return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

Vector3 cross(const Vector3& a, const Vector3& b)
{
  return { a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0] };
}

Quaternion inverse(const Quaternion& q)
{
  return { q[0], -q[1], -q[2], -q[3] };
}

/// Whether two rotations have a common axis.
bool areParallel(const Vector3& a, const Vector3& b)
{
  return length(cross(a, b)) <= 1e-12 * length(a) * length(b);
}

}

Quaternion rotationBy(const Vector3& vector)
{
  const double angle = length(vector);
  const double scale = angle > 0.0 ? std::sin(0.5 * angle) / angle : 0.5;
  return { std::cos(0.5 * angle), scale * vector[0], scale * vector[1], scale * vector[2] };
}

Vector3 rotationVectorOf(const Quaternion& rotation)
{
  const double sign = rotation[0] < 0.0 ? -1.0 : 1.0;
  const Vector3 axis{ sign * rotation[1], sign * rotation[2], sign * rotation[3] };
  const double sine = length(axis);
  const double scale = sine > 0.0 ? 2.0 * std::atan2(sine, sign * rotation[0]) / sine : 2.0;
  return { scale * axis[0], scale * axis[1], scale * axis[2] };
}

Quaternion product(const Quaternion& second, const Quaternion& first)
{
  const Vector3 a{ second[1], second[2], second[3] };
  const Vector3 b{ first[1], first[2], first[3] };
  const Vector3 c = cross(a, b);
  Quaternion result{ second[0] * first[0] - (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]), 0.0, 0.0, 0.0 };
  for (std::size_t n = 0; n < 3; ++n)
  {
    result[n + 1] = second[0] * b[n] + first[0] * a[n] + c[n];
  }
  return result;
}

Vector3 rotated(const Quaternion& rotation, const Vector3& vector)
{
  const Vector3 axis{ rotation[1], rotation[2], rotation[3] };
  const Vector3 once = cross(axis, vector);
  const Vector3 twice = cross(axis, once);
  Vector3 result;
  for (std::size_t n = 0; n < 3; ++n)
  {
    result[n] = vector[n] + 2.0 * (rotation[0] * once[n] + twice[n]);
  }
  return result;
}

Quaternion rotationOfSpin(const Vector3& spin)
{
  double vector[3];
  const double scalar = rule::wide::quaternionOf(spin.data(), vector);
  return { scalar, vector[0], vector[1], vector[2] };
}

Vector3 spinOf(const Quaternion& rotation)
{
  const double sign = rotation[0] < 0.0 ? -1.0 : 1.0;
  const double scale = 4.0 * sign / (1.0 + std::fabs(rotation[0]));
  return { scale * rotation[1], scale * rotation[2], scale * rotation[3] };
}

Quaternion nearestRotation(const std::vector<double>& rest, const std::vector<double>& now, const Quaternion& guess)
{
  Quaternion rotation = guess;
  for (int round = 0; round < 20; ++round)
  {
    double inertia = 0.0;
    double second[3][3] = {};
    double torque[3] = {};
    for (std::size_t n = 0; n < rest.size(); n += 3)
    {
      const Vector3 arm = rotated(rotation, { rest[n], rest[n + 1], rest[n + 2] });
      for (int a = 0; a < 3; ++a)
      {
        const int b = (a + 1) % 3;
        const int c = (a + 2) % 3;
        torque[a] += arm[b] * now[n + c] - arm[c] * now[n + b];
        inertia += arm[a] * now[n + a];
        for (int e = 0; e < 3; ++e)
        {
          second[a][e] += 0.5 * (arm[a] * now[n + e] + arm[e] * now[n + a]);
        }
      }
    }
    // (inertia - second) step = torque, by Cramer's rule.
    double m[3][3];
    for (int a = 0; a < 3; ++a)
    {
      for (int e = 0; e < 3; ++e)
      {
        m[a][e] = (a == e ? inertia * (1.0 + 1e-9) : 0.0) - second[a][e];
      }
    }
    double cofactor[3][3];
    for (int a = 0; a < 3; ++a)
    {
      for (int e = 0; e < 3; ++e)
      {
        cofactor[a][e] = m[(a + 1) % 3][(e + 1) % 3] * m[(a + 2) % 3][(e + 2) % 3] -
                         m[(a + 1) % 3][(e + 2) % 3] * m[(a + 2) % 3][(e + 1) % 3];
      }
    }
    const double determinant = m[0][0] * cofactor[0][0] + m[0][1] * cofactor[0][1] + m[0][2] * cofactor[0][2];
    if (!(determinant > 0.0))
    {
      return rotation;
    }
    Vector3 step;
    double largest = 0.0;
    for (int a = 0; a < 3; ++a)
    {
      step[a] = (cofactor[0][a] * torque[0] + cofactor[1][a] * torque[1] + cofactor[2][a] * torque[2]) / determinant;
      largest = std::max(largest, std::fabs(step[a]));
    }
    for (double& part : step)
    {
      part *= std::min(1.0, 1.0 / std::max(largest, 1e-300)); // at most about a radian per step
    }
    rotation = product(rotationBy(step), rotation);
    if (largest < 1e-12)
    {
      return rotation;
    }
  }
  return rotation;
}

Vector3 Pose::of(const Vector3& place, const Vector3& centre) const
{
  Vector3 arm;
  for (std::size_t n = 0; n < 3; ++n)
  {
    arm[n] = place[n] - centre[n];
  }
  Vector3 result = rotated(rotationBy(this->rotation), arm);
  for (std::size_t n = 0; n < 3; ++n)
  {
    result[n] += centre[n] + this->shift[n];
  }
  return result;
}

Pose between(const Pose& from, const Pose& to, double share)
{
  if (share == 1.0)
  {
    return to;
  }
  Pose pose;
  for (std::size_t n = 0; n < 3; ++n)
  {
    pose.shift[n] = from.shift[n] + share * (to.shift[n] - from.shift[n]);
    pose.rotation[n] = from.rotation[n] + share * (to.rotation[n] - from.rotation[n]);
  }
  if (!areParallel(from.rotation, to.rotation))
  {
    const Quaternion start = rotationBy(from.rotation);
    Vector3 way = rotationVectorOf(product(rotationBy(to.rotation), inverse(start)));
    for (double& part : way)
    {
      part *= share;
    }
    pose.rotation = rotationVectorOf(product(rotationBy(way), start));
  }
  return pose;
}

double angleBetween(const Pose& from, const Pose& to)
{
  if (areParallel(from.rotation, to.rotation))
  {
    return length(
      { to.rotation[0] - from.rotation[0], to.rotation[1] - from.rotation[1], to.rotation[2] - from.rotation[2] });
  }
  return length(rotationVectorOf(product(rotationBy(to.rotation), inverse(rotationBy(from.rotation)))));
}

}
