// SPDX-License-Identifier: BSD-3-Clause
// Matrices of bodies as probes that turn.

#ifndef RigidMotion_h
#define RigidMotion_h

#include <array>
#include <string>
#include <vector>

class vtkPolyData;

namespace vtkChainMail
{

/// One body and where its matrix moves it: x -> M x, in world axes.
struct BodyMotion
{
  std::string Name;                ///< for messages: "row 3 of the table"
  long long Body = -1;             ///< its label; -1: the body at Position
  std::array<double, 16> Matrix{}; ///< row by row
  /// The point about which it turns on its way, by which the matrix stays what it is; without one it is chosen.
  bool HasCentre = false;
  std::array<double, 3> Centre{ { 0.0, 0.0, 0.0 } };
  bool HasPosition = false; ///< whether the probe is to be elsewhere than at the centre
  std::array<double, 3> Position{ { 0.0, 0.0, 0.0 } };
};

/// Throws chainmail::InputError where the matrix is no rotation and shift, or not finite, and says how far off it is.
void CheckRigid(const BodyMotion& motion);

/// The way back.
std::array<double, 16> Inverted(const std::array<double, 16>& matrix);

/// Makes probes of motions: a point for each, with `Displacement`, `Rotation`, `Centre`, `Body` and `Matrix`. Throws
/// chainmail::InputError where a matrix is not rigid, or two are for one body.
void MakeProbes(std::vector<BodyMotion> motions, vtkPolyData* probes);

/// What such probes do, in a sentence.
std::string SummaryOf(vtkPolyData* probes);

}

#endif
