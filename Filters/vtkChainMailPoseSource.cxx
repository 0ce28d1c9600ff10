// SPDX-License-Identifier: BSD-3-Clause
#include "vtkChainMailPoseSource.h"

#include "vtkChainMailProbeSource.h"
#include "vtkMath.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPolyData.h"

#include <algorithm>
#include <array>
#include <cmath>

vtkStandardNewMacro(vtkChainMailPoseSource);

//------------------------------------------------------------------------------
vtkChainMailPoseSource::vtkChainMailPoseSource()
{
  this->SetNumberOfInputPorts(0);
}

//------------------------------------------------------------------------------
void vtkChainMailPoseSource::GetProbeRotation(double vector[3]) const
{
  const double* angles = this->Rotation;
  if (std::count(angles, angles + 3, 0.0) >= 2)
  {
    std::copy_n(angles, 3, vector); // about one axis or none: angles beyond 360 and all bits are kept
    return;
  }
  // Quaternions (w, x, y, z) of the three rotations, multiplied as R = RotateZ RotateX RotateY.
  const auto about = [angles](int axis)
  {
    const double half = 0.5 * vtkMath::RadiansFromDegrees(angles[axis]);
    std::array<double, 4> one{ { std::cos(half), 0.0, 0.0, 0.0 } };
    one[axis + 1] = std::sin(half);
    return one;
  };
  double zx[4];
  double q[4];
  vtkMath::MultiplyQuaternion(about(2).data(), about(0).data(), zx);
  vtkMath::MultiplyQuaternion(zx, about(1).data(), q);
  const double sine = vtkMath::Norm(q + 1); // sine of half the angle
  const double factor = sine > 0.0 ? 2.0 * std::atan2(sine, std::fabs(q[0])) / sine : 0.0;
  for (int a = 0; a < 3; ++a)
  {
    vector[a] = vtkMath::DegreesFromRadians((q[0] < 0.0 ? -factor : factor) * q[a + 1]);
  }
}

//------------------------------------------------------------------------------
int vtkChainMailPoseSource::RequestData(vtkInformation* vtkNotUsed(request),
  vtkInformationVector** vtkNotUsed(inputVector), vtkInformationVector* outputVector)
{
  double vector[3];
  this->GetProbeRotation(vector);
  vtkNew<vtkChainMailProbeSource> probe;
  probe->SetPosition(this->Position);
  probe->SetTarget(this->Target);
  probe->TurnsOn();
  probe->SetRotation(vector);
  probe->SetBody(this->Body);
  probe->Update();
  vtkPolyData::GetData(outputVector, 0)->ShallowCopy(probe->GetOutput());
  return 1;
}

//------------------------------------------------------------------------------
void vtkChainMailPoseSource::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Position: " << this->Position[0] << " " << this->Position[1] << " " << this->Position[2] << "\n";
  os << indent << "Target: " << this->Target[0] << " " << this->Target[1] << " " << this->Target[2] << "\n";
  os << indent << "Rotation: " << this->Rotation[0] << " " << this->Rotation[1] << " " << this->Rotation[2] << "\n";
  os << indent << "Body: " << this->Body << "\n";
}
