// SPDX-License-Identifier: BSD-3-Clause
#include "RigidMotion.h"

#include "Error.h"
#include "ProbeSet.h"
#include "Text.h"

#include "vtkLongLongArray.h"
#include "vtkMath.h"
#include "vtkMatrix4x4.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace vtkChainMail
{

namespace
{

using chainmail::InputError;

/// Files have about six digits. Larger deviations are not rounding.
constexpr double rigidTolerance = 1e-4;

std::string NameOf(const BodyMotion& motion)
{
  return motion.Name + (motion.Body >= 0 ? " (body " + std::to_string(motion.Body) + ")" : "");
}

void RotationPart(const std::array<double, 16>& m, double rotation[3][3])
{
  for (int i = 0; i < 3; ++i)
  {
    for (int j = 0; j < 3; ++j)
    {
      rotation[i][j] = m[4 * i + j];
    }
  }
}

/// The nearest rotation to the matrix (least squares), as axis times angle [rad], at most pi.
std::array<double, 3> RotationVector(const std::array<double, 16>& matrix)
{
  double rotation[3][3];
  RotationPart(matrix, rotation);
  double q[4]; // w, x, y, z of the nearest rotation
  vtkMath::Matrix3x3ToQuaternion(rotation, q);
  const double sign = q[0] < 0.0 ? -1.0 : 1.0;
  std::array<double, 3> vector = { { sign * q[1], sign * q[2], sign * q[3] } };
  const double sine = vtkMath::Norm(vector.data());
  // 2 asin(s) / s near 0, where the quotient below is 0 / 0
  const double factor = sine > 1e-9 ? 2.0 * std::atan2(sine, sign * q[0]) / sine : 2.0;
  vtkMath::MultiplyScalar(vector.data(), factor);
  return vector;
}

/// The centre about which the body rotates: the point on the screw axis of the matrix that is nearest to the origin.
/// Below 3 degrees this point is far away, and any point will do; the origin is returned.
std::array<double, 3> CentreOf(const std::array<double, 16>& matrix, const std::array<double, 3>& rotation)
{
  std::array<double, 3> centre = { { 0.0, 0.0, 0.0 } };
  const double angle = vtkMath::Norm(rotation.data());
  if (angle < vtkMath::RadiansFromDegrees(3.0))
  {
    return centre;
  }
  double axis[3] = { rotation[0] / angle, rotation[1] / angle, rotation[2] / angle };
  const double shift[3] = { matrix[3], matrix[7], matrix[11] };
  const double along = vtkMath::Dot(shift, axis);
  double across[3];
  double beside[3];
  for (int a = 0; a < 3; ++a)
  {
    across[a] = shift[a] - along * axis[a];
  }
  vtkMath::Cross(axis, across, beside);
  for (int a = 0; a < 3; ++a)
  {
    centre[a] = 0.5 * (across[a] + beside[a] / std::tan(0.5 * angle));
  }
  return centre;
}

}

//------------------------------------------------------------------------------
void CheckRigid(const BodyMotion& motion)
{
  const auto& m = motion.Matrix;
  const std::string name = "The matrix of " + NameOf(motion);
  for (const double value : m)
  {
    if (!std::isfinite(value))
    {
      throw InputError(name + " has a number that is not finite. Correct the matrix.");
    }
  }
  if (m[12] != 0.0 || m[13] != 0.0 || m[14] != 0.0 || std::fabs(m[15] - 1.0) > 1e-9)
  {
    const bool isTransposed = m[3] == 0.0 && m[7] == 0.0 && m[11] == 0.0 && m[15] == 1.0;
    throw InputError(name + " does not end with the row 0 0 0 1" +
                     (isTransposed ? ", because it is written column by column. Write the matrix row by row." : "."));
  }
  double rotation[3][3];
  RotationPart(m, rotation);
  double off = 0.0;
  std::string lengths;
  for (int i = 0; i < 3; ++i)
  {
    for (int j = 0; j < 3; ++j)
    {
      double product = 0.0;
      for (int k = 0; k < 3; ++k)
      {
        product += rotation[k][i] * rotation[k][j];
      }
      off = std::max(off, std::fabs(product - (i == j ? 1.0 : 0.0)));
      lengths += i == j ? (i ? ", " : "") + chainmail::toString(std::sqrt(product), 5) : "";
    }
  }
  const double determinant = vtkMath::Determinant3x3(rotation);
  if (off > rigidTolerance || determinant < 0.0)
  {
    throw InputError(name + " is not a rigid motion (a rotation and a translation): " +
                     (determinant < 0.0       ? "it mirrors (determinant " + chainmail::toString(determinant, 5) + ")"
                       : off > rigidTolerance ? "it scales or shears"
                                              : "") +
                     ". The axes become " + lengths +
                     " times as long, and the transpose times the matrix differs from the identity by " +
                     chainmail::toString(off, 3) + "; at most " + chainmail::toString(rigidTolerance) +
                     " is corrected.");
  }
}

//------------------------------------------------------------------------------
std::array<double, 16> Inverted(const std::array<double, 16>& matrix)
{
  std::array<double, 16> inverse{};
  vtkMatrix4x4::Invert(matrix.data(), inverse.data());
  return inverse;
}

//------------------------------------------------------------------------------
void MakeProbes(std::vector<BodyMotion> motions, vtkPolyData* probes)
{
  std::map<long long, std::string> names;
  for (const BodyMotion& motion : motions)
  {
    CheckRigid(motion);
    if (motion.Body >= 0 && !names.emplace(motion.Body, motion.Name).second)
    {
      throw InputError("Two matrices are for body " + std::to_string(motion.Body) + ": " + names[motion.Body] +
                       " and " + motion.Name + ". Multiply them, or remove one.");
    }
  }
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(static_cast<vtkIdType>(motions.size()));
  std::vector<std::array<double, 3>> rotations;
  for (std::size_t n = 0; n < motions.size(); ++n)
  {
    BodyMotion& motion = motions[n];
    rotations.push_back(RotationVector(motion.Matrix));
    if (!motion.HasCentre)
    {
      motion.Centre = CentreOf(motion.Matrix, rotations.back());
    }
    points->SetPoint(static_cast<vtkIdType>(n), (motion.HasPosition ? motion.Position : motion.Centre).data());
  }
  SetProbePoints(probes, points);
  const auto displacement = AddProbeArray(probes, "Displacement", 3);
  const auto rotation = AddProbeArray(probes, "Rotation", 3);
  const auto centre = AddProbeArray(probes, "Centre", 3);
  const auto matrix = AddProbeArray(probes, "Matrix", 16);
  vtkNew<vtkLongLongArray> body;
  body->SetName("Body");
  body->SetNumberOfTuples(probes->GetNumberOfPoints());
  probes->GetPointData()->AddArray(body);
  for (std::size_t n = 0; n < motions.size(); ++n)
  {
    const auto row = static_cast<vtkIdType>(n);
    const std::array<double, 16>& m = motions[n].Matrix;
    const std::array<double, 3>& c = motions[n].Centre;
    // From the given matrix, not from the nearest rotation: so near the centre the body is placed to the last digit.
    for (int a = 0; a < 3; ++a)
    {
      displacement->SetComponent(
        row, a, m[4 * a] * c[0] + m[4 * a + 1] * c[1] + m[4 * a + 2] * c[2] + m[4 * a + 3] - c[a]);
      rotation->SetComponent(row, a, vtkMath::DegreesFromRadians(rotations[n][a]));
    }
    centre->SetTuple(row, c.data());
    matrix->SetTuple(row, m.data());
    body->SetValue(row, motions[n].Body);
  }
  probes->GetPointData()->SetActiveVectors("Displacement");
}

//------------------------------------------------------------------------------
std::string SummaryOf(vtkPolyData* probes)
{
  const auto largest = [&](const char* name)
  {
    double range[2];
    probes->GetPointData()->GetArray(name)->GetRange(range, -1);
    return chainmail::toString(range[1], 4);
  };
  return "Rotations up to " + largest("Rotation") + " degrees, displacements of the centres up to " +
         largest("Displacement") + " mm.";
}

}
