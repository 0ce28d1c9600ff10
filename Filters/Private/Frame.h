// SPDX-License-Identifier: BSD-3-Clause
// Converts between world space and the engine's space.

#ifndef Frame_h
#define Frame_h

#include "Error.h"
#include "Model.h"

#include "vtkImageData.h"
#include "vtkMatrix3x3.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace vtkChainMail
{

using chainmail::Vector3;

/// World space and the engine's space: lengths [mm] along the image's axes from the centre of its first voxel.
class Frame
{
public:
  explicit Frame(vtkImageData* image)
  {
    image->GetOrigin(this->Origin.data());
    image->GetSpacing(this->Spacing.data());
    std::copy_n(image->GetDirectionMatrix()->GetData(), 9, this->Direction.data());
    int extent[6];
    image->GetExtent(extent);
    for (int a = 0; a < 3; ++a)
    {
      this->First[a] = extent[2 * a] * this->Spacing[a];
    }
    for (int a = 0; a < 3; ++a)
    {
      for (int b = 0; b < 3; ++b)
      {
        double product = 0.0;
        for (int row = 0; row < 3; ++row)
        {
          product += this->Direction[3 * row + a] * this->Direction[3 * row + b];
        }
        // Direction cosines in image files often have only six digits.
        if (!(std::fabs(product - (a == b ? 1.0 : 0.0)) < 1e-4))
        {
          throw chainmail::InputError(
            "The direction matrix of the input image is not orthonormal: its columns have to be unit "
            "vectors at right angles. Resample the image onto such a grid.");
        }
      }
    }
  }

  Vector3 PointToEngine(const double world[3]) const
  {
    const double fromOrigin[3] = { world[0] - this->Origin[0], world[1] - this->Origin[1], world[2] - this->Origin[2] };
    Vector3 engine = this->VectorToEngine(fromOrigin);
    for (int a = 0; a < 3; ++a)
    {
      engine[a] -= this->First[a];
    }
    return engine;
  }

  /// The position of a voxel, whose indices count from the image's first voxel.
  Vector3 VoxelToWorld(const chainmail::Index3& at) const
  {
    double engine[3];
    double world[3];
    for (int a = 0; a < 3; ++a)
    {
      engine[a] = this->First[a] + at[a] * this->Spacing[a];
    }
    this->VectorToWorld(engine, world);
    return { this->Origin[0] + world[0], this->Origin[1] + world[1], this->Origin[2] + world[2] };
  }

  Vector3 VectorToEngine(const double world[3]) const
  {
    const double* d = this->Direction.data();
    return { d[0] * world[0] + d[3] * world[1] + d[6] * world[2], d[1] * world[0] + d[4] * world[1] + d[7] * world[2],
      d[2] * world[0] + d[5] * world[1] + d[8] * world[2] };
  }

  /// For axial vectors (rotation vectors, moments): where the image's axes are left-handed they change sign.
  Vector3 AxialToEngine(const double world[3]) const
  {
    Vector3 engine = this->VectorToEngine(world);
    for (double& part : engine)
    {
      part *= this->GetHandedness();
    }
    return engine;
  }

  void AxialToWorld(const double engine[3], double world[3]) const
  {
    const double handed[3] = { this->GetHandedness() * engine[0], this->GetHandedness() * engine[1],
      this->GetHandedness() * engine[2] };
    this->VectorToWorld(handed, world);
  }

  template <typename T> void VectorToWorld(const T engine[3], T world[3]) const
  {
    const double v[3] = { engine[0], engine[1], engine[2] };
    const double* d = this->Direction.data();
    for (int a = 0; a < 3; ++a)
    {
      world[a] = static_cast<T>(d[3 * a] * v[0] + d[3 * a + 1] * v[1] + d[3 * a + 2] * v[2]);
    }
  }

  bool operator==(const Frame& other) const
  {
    return this->Origin == other.Origin && this->Spacing == other.Spacing && this->First == other.First &&
           this->Direction == other.Direction;
  }

  bool IsRotated() const { return this->Direction != std::array<double, 9>{ { 1, 0, 0, 0, 1, 0, 0, 0, 1 } }; }

  const Vector3& GetSpacing() const { return this->Spacing; }

private:
  /// 1 or, where the image's axes are left-handed, -1.
  double GetHandedness() const
  {
    const double* d = this->Direction.data();
    const double determinant =
      d[0] * (d[4] * d[8] - d[5] * d[7]) - d[1] * (d[3] * d[8] - d[5] * d[6]) + d[2] * (d[3] * d[7] - d[4] * d[6]);
    return determinant < 0.0 ? -1.0 : 1.0;
  }

  Vector3 Origin;
  Vector3 Spacing;
  Vector3 First;
  std::array<double, 9> Direction; // row by row; its columns are the image's axes
};

}

#endif
