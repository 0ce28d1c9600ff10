// SPDX-License-Identifier: BSD-3-Clause
// Cell arrays are not deformed. Those that are lost are named, once for as long as they are the same.

#include "FilterTest.h"

#include "vtkCellData.h"
#include "vtkDataSetAttributes.h"
#include "vtkIntArray.h"

using namespace FilterTest;

int TestChainMailCellData(int, char*[])
{
  Checks check;
  auto image = MakeImage({ { 0, 7, 0, 7, 0, 7 } });
  image->GetPointData()->GetScalars()->Fill(50.0);
  const auto add = [&](const char* name)
  {
    vtkNew<vtkIntArray> cells;
    cells->SetName(name);
    cells->SetNumberOfTuples(image->GetNumberOfCells());
    cells->Fill(0.0);
    image->GetCellData()->AddArray(cells);
    image->Modified();
  };
  for (const int mode : { vtkChainMailDeformation::MODE_FROM_REST, vtkChainMailDeformation::MODE_INTERACTIVE })
  {
    image->GetCellData()->Initialize();
    vtkNew<vtkChainMailDeformation> filter;
    EventLog log(filter);
    filter->SetMode(mode);
    filter->SetInputData(image);
    filter->SetTissueThreshold(0.0);
    filter->SetMaterialFunction(ConstantMaterial(0.3));
    double pull = 0.0;
    const auto update = [&]
    {
      filter->SetInputDataObject(1, MakeProbes({ { { { 4.0, 4.0, 4.0 } }, { { pull += 0.125, 0.0, 0.0 } } } }));
      filter->Update();
      check.Equal(log.TakeErrors(), std::string(), "no error");
      return log.TakeWarnings();
    };

    check.Equal(update(), std::string(), "no cell data, no warning");
    add(vtkDataSetAttributes::GhostArrayName());
    check.Equal(update(), std::string(), "ghosts are passed on");
    add("Density");
    add("Material");
    const std::string warning = update();
    check.Contains(warning, "Density, Material", "both are named");
    check.Contains(warning, "Cell Data to Point Data", "what to do");
    check.That(warning.find(vtkDataSetAttributes::GhostArrayName()) == std::string::npos, "ghosts are not lost");
    check.That(!filter->GetOutput()->GetCellData()->HasArray("Density"), "they are not passed on");
    check.Equal(update(), std::string(), "once");
    image->Modified();
    check.Equal(update(), std::string(), "once, also for an image that was touched");
    add("Label");
    check.Contains(update(), "Label", "another one is named");
    check.Equal(update(), std::string(), "once");
    image->GetCellData()->Initialize();
    image->Modified();
    check.Equal(update(), std::string(), "none any more");
  }
  return check.Finish();
}
