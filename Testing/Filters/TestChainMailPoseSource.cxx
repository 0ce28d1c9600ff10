// SPDX-License-Identifier: BSD-3-Clause
// The pose source: defaults as documented, and a rotation vector that is the angles' matrix, by vtkTransform.

#include "FilterTest.h"
#include "vtkChainMailPoseSource.h"

#include "vtkTransform.h"

#include <cmath>

int TestChainMailPoseSource(int, char*[])
{
  FilterTest::Checks check;
  vtkNew<vtkChainMailPoseSource> source;
  for (int a = 0; a < 3; ++a)
  {
    check.Equal(source->GetPosition()[a], 0.0, "default Position");
    check.Equal(source->GetTarget()[a], 0.0, "default Target");
    check.Equal(source->GetRotation()[a], 0.0, "default Rotation");
  }
  check.Equal(source->GetBody(), vtkIdType(-1), "default Body");

  const double all[][3] = { { 0, 0, 0 }, { 0, 0, 5 }, { 0, -720, 0 }, { 10, 20, 30 }, { 90, 45, -30 }, { -90, 10, 10 },
    { 1e-9, 1e-9, 0 }, { 170, -5, 175 }, { 0, 180, 90 } };
  for (const auto& angles : all)
  {
    source->SetRotation(angles);
    double vector[3];
    source->GetProbeRotation(vector);
    vtkNew<vtkTransform> expected;
    expected->RotateZ(angles[2]);
    expected->RotateX(angles[0]);
    expected->RotateY(angles[1]);
    vtkNew<vtkTransform> found;
    const double degrees = vtkMath::Norm(vector);
    found->RotateWXYZ(degrees, vector);
    double off = 0.0;
    for (int i = 0; i < 3; ++i)
    {
      for (int j = 0; j < 3; ++j)
      {
        off = std::fmax(off, std::fabs(found->GetMatrix()->GetElement(i, j) - expected->GetMatrix()->GetElement(i, j)));
      }
    }
    check.That(off < 1e-14 * (1.0 + degrees), "the vector is the angles' matrix"); // of sines of such angles
  }

  source->SetPosition(1.0, 2.0, 3.0);
  source->SetTarget(1.5, 1.0, 7.0);
  source->SetRotation(0.0, 400.0, 0.0);
  source->SetBody(27);
  source->Update();
  vtkPointData* arrays = source->GetOutput()->GetPointData();
  check.Equal(source->GetOutput()->GetNumberOfPoints(), vtkIdType(1), "one point");
  check.Equal(arrays->GetArray("Displacement")->GetComponent(0, 2), 4.0, "Displacement");
  check.Equal(arrays->GetArray("Rotation")->GetComponent(0, 1), 400.0, "more than a turn");
  check.Equal(arrays->GetArray("Body")->GetTuple1(0), 27.0, "Body");
  source->SetBody(-1);
  source->Update();
  check.That(!source->GetOutput()->GetPointData()->HasArray("Body"), "no label");

  std::ostringstream text;
  source->Print(text);
  for (const char* name : { "Position: 1 2 3", "Target: 1.5 1 7", "Rotation: 0 400 0", "Body: -1" })
  {
    check.Contains(text.str(), name, "PrintSelf");
  }
  return check.Finish();
}
