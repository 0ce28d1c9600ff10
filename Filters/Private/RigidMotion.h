// SPDX-License-Identifier: BSD-3-Clause
// Rigid motions of bodies, given as matrices, as probes that rotate.

#ifndef RigidMotion_h
#define RigidMotion_h

#include <array>
#include <string>
#include <vector>

class vtkPolyData;

namespace vtkChainMail
{

/// One body and its motion x -> M x, in world axes.
struct BodyMotion
{
  std::string Name;                ///< for messages: "row 3 of the table"
  long long Body = -1;             ///< its label; -1: the body at Position
  std::array<double, 16> Matrix{}; ///< row by row
  /// The point about which the body rotates; it does not change the final pose. Without it MakeProbes() chooses one.
  bool HasCentre = false;
  std::array<double, 3> Centre{ { 0.0, 0.0, 0.0 } };
  bool HasPosition = false; ///< whether the probe is at Position instead of Centre
  std::array<double, 3> Position{ { 0.0, 0.0, 0.0 } };
};

/// Throws chainmail::InputError where the matrix is not finite or not rigid; the message gives the deviation.
void CheckRigid(const BodyMotion& motion);

/// The inverse.
std::array<double, 16> Inverted(const std::array<double, 16>& matrix);

/// Makes probes from motions: a point for each, with `Displacement`, `Rotation`, `Centre`, `Body` and `Matrix`. Throws
/// chainmail::InputError where a matrix is not rigid, or two are for one body.
void MakeProbes(std::vector<BodyMotion> motions, vtkPolyData* probes);

/// A sentence about the largest rotation and displacement of such probes.
std::string SummaryOf(vtkPolyData* probes);

}

#endif
