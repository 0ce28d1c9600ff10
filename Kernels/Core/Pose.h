#pragma once

#include "Model.h"

#include <array>
#include <vector>

namespace chainmail
{

/// A unit quaternion, its scalar part first.
using Quaternion = std::array<double, 4>;

/// The rotation of a rotation vector, which is along the axis and as long as the angle [rad].
Quaternion rotationBy(const Vector3& vector);
/// The rotation vector of a rotation, no longer than half a turn.
Vector3 rotationVectorOf(const Quaternion& rotation);
/// The rotation by `first`, then by `second`.
Quaternion product(const Quaternion& second, const Quaternion& first);
Vector3 rotated(const Quaternion& rotation, const Vector3& vector);

/// Converts the 3 numbers that an element stores for its rotation (`spin`, see spin.clh) to a quaternion, and back.
Quaternion rotationOfSpin(const Vector3& spin);
Vector3 spinOf(const Quaternion& rotation);

/// The rotation about the origin that brings the points `rest` nearest to the points `now`, in the sense of least
/// squares. It is found by Newton steps from `guess`. Both lists hold 3 values per point. For points on a line, the
/// rotation about that line stays as guessed.
Quaternion nearestRotation(
  const std::vector<double>& rest, const std::vector<double>& now, const Quaternion& guess = { 1.0, 0.0, 0.0, 0.0 });

/// A rigid motion about a centre c: x goes to c + shift + R (x - c).
struct Pose
{
  Vector3 shift{};    ///< [mm]
  Vector3 rotation{}; ///< the rotation vector of R; longer than half a turn where it has rotated further

  /// The image of a place under the motion [mm].
  Vector3 of(const Vector3& place, const Vector3& centre) const;
};

/// Interpolates between two poses; a share of 1 is exactly `to`. The centre moves along a straight line. Rotations
/// about a common axis are interpolated about it, also beyond half a turn; others take the shortest path.
Pose between(const Pose& from, const Pose& to, double share);

/// The angle between two poses along the path of between() [rad].
double angleBetween(const Pose& from, const Pose& to);

}
