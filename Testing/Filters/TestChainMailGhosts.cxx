// SPDX-License-Identifier: BSD-3-Clause
// Ghosts and blanks belong to the grid, not to the tissue: what of the image counts stays where it is, whatever moves
// under it; padding counts.

#include "FilterTest.h"

#include "vtkCellData.h"
#include "vtkDataSetAttributes.h"

using namespace FilterTest;

namespace
{

vtkSmartPointer<vtkUnsignedCharArray> MakeGhosts(vtkIdType tuples, unsigned char hidden, unsigned char duplicate)
{
  auto ghosts = vtkSmartPointer<vtkUnsignedCharArray>::New();
  ghosts->SetName(vtkDataSetAttributes::GhostArrayName());
  for (vtkIdType n = 0; n < tuples; ++n)
  {
    ghosts->InsertNextValue(n % 7 == 3 ? hidden : n % 5 == 1 ? duplicate : 0);
  }
  return ghosts;
}

/// The array of a grid of `size`, in the middle of one that is padded, with 0 around it.
void CheckPadded(Checks& check, vtkDataArray* from, vtkDataArray* to, const std::array<int, 3>& size,
  const std::array<int, 3>& padding, const std::string& where)
{
  check.That(from && to, where + ": is there");
  if (!from || !to)
  {
    return;
  }
  std::array<int, 3> padded;
  for (int a = 0; a < 3; ++a)
  {
    padded[a] = size[a] + 2 * padding[a];
  }
  check.Equal(to->GetDataType(), from->GetDataType(), where + ": type");
  check.Equal(to->GetNumberOfTuples(), static_cast<vtkIdType>(padded[0]) * padded[1] * padded[2], where + ": tuples");
  vtkIdType id = 0;
  for (int k = -padding[2]; k < size[2] + padding[2]; ++k)
  {
    for (int j = -padding[1]; j < size[1] + padding[1]; ++j)
    {
      for (int i = -padding[0]; i < size[0] + padding[0]; ++i, ++id)
      {
        const bool inside = i >= 0 && j >= 0 && k >= 0 && i < size[0] && j < size[1] && k < size[2];
        check.Equal(to->GetTuple1(id),
          inside ? from->GetTuple1(i + size[0] * (j + static_cast<vtkIdType>(size[1]) * k)) : 0.0,
          where + ": value " + std::to_string(id));
      }
    }
  }
}

}

int TestChainMailGhosts(int, char*[])
{
  Checks check;
  const std::string name = vtkDataSetAttributes::GhostArrayName();
  for (const auto& size : { std::array<int, 3>{ { 9, 8, 7 } }, { { 9, 8, 1 } }, { { 9, 1, 1 } } })
  {
    auto image = MakeImage({ { 3, 2 + size[0], 0, size[1] - 1, -2, size[2] - 3 } });
    image->GetPointData()->GetScalars()->Fill(50.0);
    image->GetPointData()->AddArray(
      MakeGhosts(image->GetNumberOfPoints(), vtkDataSetAttributes::HIDDENPOINT, vtkDataSetAttributes::DUPLICATEPOINT));
    image->GetCellData()->AddArray(
      MakeGhosts(image->GetNumberOfCells(), vtkDataSetAttributes::HIDDENCELL, vtkDataSetAttributes::DUPLICATECELL));

    vtkNew<vtkChainMailDeformation> filter;
    EventLog log(filter);
    filter->SetInputData(image);
    filter->SetTissueThreshold(0.0);
    filter->SetMaterialFunction(ConstantMaterial(0.0));
    filter->SetAnchoredFaces(0, 0, 0, 0, 0, 0);
    for (const double pull : { 0.0, 2.0, 0.5 })
    {
      for (const int padding : { 0, 3 })
      {
        filter->SetInputDataObject(1, MakeProbes({ { { { 5.0, 0.0, -2.0 } }, { { pull, 0.0, 0.0 } } } }));
        filter->SetOutputPadding(padding);
        filter->Update();
        vtkImageData* output = filter->GetOutput();
        const std::string where = std::to_string(size[1]) + " x " + std::to_string(size[2]) + " rows, pulled by " +
                                  std::to_string(pull) + ", padding " + std::to_string(padding);
        check.Equal(log.TakeErrors() + log.TakeWarnings(), std::string(), where + ": nothing to say");
        std::array<int, 3> cells;
        std::array<int, 3> around;
        for (int a = 0; a < 3; ++a)
        {
          cells[a] = std::max(1, size[a] - 1);
          around[a] = size[a] > 1 ? padding : 0;
        }
        CheckPadded(check, image->GetPointData()->GetArray(name.c_str()),
          output->GetPointData()->GetArray(name.c_str()), size, around, where + ", points");
        CheckPadded(check, image->GetCellData()->GetArray(name.c_str()), output->GetCellData()->GetArray(name.c_str()),
          cells, around, where + ", cells");

        // As VTK sees it.
        int extent[6];
        image->GetExtent(extent);
        for (int k = extent[4]; k <= extent[5]; ++k)
        {
          for (int j = extent[2]; j <= extent[3]; ++j)
          {
            for (int i = extent[0]; i <= extent[1]; ++i)
            {
              int at[3] = { i, j, k };
              check.Equal(static_cast<int>(output->IsPointVisible(output->ComputePointId(at))),
                static_cast<int>(image->IsPointVisible(image->ComputePointId(at))), where + ": visible points");
              // A cell has the number of its first corner.
              const bool isCell =
                (i < extent[1] || size[0] == 1) && (j < extent[3] || size[1] == 1) && (k < extent[5] || size[2] == 1);
              check.That(!isCell || output->IsCellVisible(output->ComputeCellId(at)) ==
                                      image->IsCellVisible(image->ComputeCellId(at)),
                where + ": visible cells");
            }
          }
        }
      }
    }

    // They go when the input's go.
    image->GetPointData()->RemoveArray(name.c_str());
    image->GetCellData()->RemoveArray(name.c_str());
    image->Modified();
    filter->Update();
    check.That(!filter->GetOutput()->GetPointData()->HasArray(name.c_str()) &&
                 !filter->GetOutput()->GetCellData()->HasArray(name.c_str()),
      "no ghosts without ghosts");

    // Of another length.
    image->GetCellData()->AddArray(MakeGhosts(3, 0, 0));
    image->Modified();
    filter->Update();
    const std::string error = log.TakeErrors();
    check.Contains(error, "\"vtkGhostType\" has 3 tuples", "too few");
    check.Contains(error, std::to_string(image->GetNumberOfCells()) + " cells", "too few");
  }
  return check.Finish();
}
