// SPDX-License-Identifier: BSD-3-Clause
// The probe source: defaults as documented, and one point with the arrays that the deformation reads.

#include "FilterTest.h"
#include "vtkChainMailProbeSource.h"

int TestChainMailProbeSource(int, char*[])
{
  FilterTest::Checks check;
  vtkNew<vtkChainMailProbeSource> source;

  for (int a = 0; a < 3; ++a)
  {
    check.Equal(source->GetPosition()[a], 0.0, "default Position");
    check.Equal(source->GetTarget()[a], 0.0, "default Target");
  }
  check.Equal(source->GetRadius(), 0.0, "default Radius");
  check.Equal(source->GetAnchor(), false, "default Anchor");
  check.Equal(source->GetTolerance(), 0.0, "default Tolerance");
  source->SetTolerance(-1.0);
  check.Equal(source->GetTolerance(), 0.0, "a negative tolerance is brought to 0");
  source->SetRadius(-1.0);
  check.Equal(source->GetRadius(), 0.0, "a negative radius is brought to 0");

  source->SetPosition(1.0, 2.0, 3.0);
  source->SetTarget(1.5, 1.0, 7.0);
  source->SetRadius(2.5);
  source->SetTolerance(0.75);
  source->AnchorOn();
  source->Update();
  vtkPolyData* output = source->GetOutput();
  check.Equal(output->GetNumberOfPoints(), 1, "one point");
  check.Equal(output->GetNumberOfVerts(), 1, "one vertex, to be seen");
  double position[3];
  output->GetPoint(0, position);
  const double displacement[3] = { 0.5, -1.0, 4.0 };
  vtkDataArray* displacements = output->GetPointData()->GetArray("Displacement");
  check.That(displacements && displacements->GetNumberOfComponents() == 3, "Displacement has 3 components");
  for (int a = 0; a < 3; ++a)
  {
    check.Equal(position[a], source->GetPosition()[a], "the point is at Position");
    check.Equal(displacements->GetComponent(0, a), displacement[a], "Displacement is Target - Position");
  }
  check.Equal(output->GetPointData()->GetArray("Radius")->GetTuple1(0), 2.5, "Radius");
  check.Equal(output->GetPointData()->GetArray("Anchor")->GetTuple1(0), 1.0, "Anchor");

  check.Equal(output->GetPointData()->GetArray("Tolerance")->GetTuple1(0), 0.75, "Tolerance");

  source->AnchorOff();
  source->Update();
  check.Equal(output->GetPointData()->GetArray("Anchor")->GetTuple1(0), 0.0, "Anchor off");

  std::ostringstream text;
  source->PrintSelf(text, vtkIndent());
  check.That(!output->GetPointData()->HasArray("Rotation") && !output->GetPointData()->HasArray("Body"), "no pose");
  source->TurnsOn();
  source->SetRotation(10.0, -20.0, 5.0);
  source->SetBody(27);
  source->Update();
  check.Equal(output->GetPointData()->GetArray("Rotation")->GetComponent(0, 1), -20.0, "Rotation");
  check.Equal(output->GetPointData()->GetArray("Body")->GetTuple1(0), 27.0, "Body");
  for (const char* name : { "Position: 1 2 3", "Target: 1.5 1 7", "Radius: 2.5", "Anchor: Off", "Tolerance: 0.75" })
  {
    check.Contains(text.str(), name, "PrintSelf");
  }
  std::ostringstream turning;
  source->Print(turning);
  for (const char* name : { "Turns: On", "Rotation: 10 -20 5", "Body: 27" })
  {
    check.Contains(turning.str(), name, "PrintSelf");
  }
  return check.Finish();
}
