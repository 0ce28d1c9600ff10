#pragma once

#include "Model.h"

#include <array>
#include <vector>

namespace chainmail
{

/// A unit quaternion, its scalar part first.
using Quaternion = std::array<double, 4>;

/// A rotation by its rotation vector: along the axis, as long as the angle [rad].
Quaternion rotationBy(const Vector3& vector);
/// The rotation vector of a rotation, of at most half a turn.
Vector3 rotationVectorOf(const Quaternion& rotation);
/// The rotation by `first`, then by `second`.
Quaternion product(const Quaternion& second, const Quaternion& first);
Vector3 rotated(const Quaternion& rotation, const Vector3& vector);

/// The rotation of 3 numbers that an element keeps, and the reverse (spin.clh).
Quaternion rotationOfSpin(const Vector3& spin);
Vector3 spinOf(const Quaternion& rotation);

/// The rotation about the origin that takes points nearest to others, in the sense of least squares: by steps of Gauss
/// and Newton from a first guess. Both hold 3 values a point. Points in a line leave the rotation about it as guessed.
Quaternion nearestRotation(
  const std::vector<double>& rest, const std::vector<double>& now, const Quaternion& guess = { 1.0, 0.0, 0.0, 0.0 });

/// A rigid motion about a centre c: x goes to c + shift + R (x - c).
struct Pose
{
  Vector3 shift{};    ///< [mm]
  Vector3 rotation{}; ///< the rotation vector of R; more than half a turn where it went further round

  /// Where it takes a place [mm].
  Vector3 of(const Vector3& place, const Vector3& centre) const;
};

/// The pose at a share of the way from one to another. The centre goes straight. Rotations about one axis go on about
/// it, also beyond half a turn; others go the shortest way. A share of 1 is exactly `to`.
Pose between(const Pose& from, const Pose& to, double share);

/// The angle from one pose to another on that way [rad].
double angleBetween(const Pose& from, const Pose& to);

}
