// SPDX-License-Identifier: BSD-3-Clause
// The blade: defaults as documented, and one rectangle that goes as deep and stands out as far as it is told.

#include "FilterTest.h"
#include "vtkChainMailBladeSource.h"

using namespace FilterTest;

int TestChainMailBladeSource(int, char*[])
{
  Checks check;
  vtkNew<vtkChainMailBladeSource> source;
  const double start[3] = { -0.5, 0.0, 0.0 };
  const double end[3] = { 0.5, 0.0, 0.0 };
  const double direction[3] = { 0.0, 0.0, -1.0 };
  for (int a = 0; a < 3; ++a)
  {
    check.Equal(source->GetStart()[a], start[a], "default Start");
    check.Equal(source->GetEnd()[a], end[a], "default End");
    check.Equal(source->GetDirection()[a], direction[a], "default Direction");
  }
  check.Equal(source->GetDepth(), 0.5, "default Depth");
  check.Equal(source->GetHeight(), 0.5, "default Height");
  source->SetDepth(-1.0);
  source->SetHeight(-1.0);
  check.Equal(source->GetDepth(), 0.0, "a negative depth is brought to 0");
  check.Equal(source->GetHeight(), 0.0, "a negative height is brought to 0");

  source->SetStart(1, 2, 3);
  source->SetEnd(5, 2, 3);
  source->SetDirection(0, 3, 4);
  source->SetDepth(10);
  source->SetHeight(5);
  source->Update();
  vtkPolyData* output = source->GetOutput();
  const Vector corners[4] = { { { 1, -1, -1 } }, { { 5, -1, -1 } }, { { 5, 8, 11 } }, { { 1, 8, 11 } } };
  check.Equal(output->GetNumberOfPoints(), 4, "four corners");
  check.Equal(output->GetNumberOfPolys(), 1, "one polygon");
  for (int n = 0; n < 4 && output->GetNumberOfPoints() == 4; ++n)
  {
    for (int a = 0; a < 3; ++a)
    {
      check.Near(output->GetPoint(n)[a], corners[n][a], 1e-12, "corner");
    }
  }

  EventLog log{ source };
  source->SetDirection(0, 0, 0);
  source->Update();
  check.Contains(log.TakeErrors(), "Direction is (0, 0, 0)", "no direction");
  std::ostringstream text;
  source->PrintSelf(text, vtkIndent());
  for (const char* name : { "Start: 1 2 3", "End: 5 2 3", "Direction: 0 0 0", "Depth: 10", "Height: 5" })
  {
    check.Contains(text.str(), name, "PrintSelf");
  }
  return check.Finish();
}
