// SPDX-License-Identifier: BSD-3-Clause
// Ids are names, not quantities: they are never blended. Global ids are unique, which they are no more after tissue has
// moved, so they stay as an array but are not global ids any more; pedigree ids tell where a voxel came from and do.

#include "FilterTest.h"

#include "vtkIdTypeArray.h"
#include "vtkIntArray.h"

using namespace FilterTest;

int TestChainMailIds(int, char*[])
{
  Checks check;
  const int size = 8;
  for (const bool words : { false, true })
  {
    auto image = MakeImage({ { 0, size - 1, 0, size - 1, 0, size - 1 } });
    image->GetPointData()->GetScalars()->Fill(50.0);
    vtkNew<vtkIdTypeArray> global;
    global->SetName("Ids of points");
    vtkNew<vtkIntArray> numbers;
    vtkNew<vtkStringArray> names;
    vtkAbstractArray* pedigree = words ? static_cast<vtkAbstractArray*>(names) : numbers;
    pedigree->SetName("Pedigree");
    for (vtkIdType p = 0; p < image->GetNumberOfPoints(); ++p)
    {
      global->InsertNextValue(1000 + 3 * p * p);
      numbers->InsertNextValue(static_cast<int>(5000 - 7 * p));
      names->InsertNextValue("voxel " + std::to_string(p));
    }
    image->GetPointData()->SetGlobalIds(global);
    image->GetPointData()->SetPedigreeIds(pedigree);

    vtkNew<vtkChainMailDeformation> filter;
    filter->SetInputData(image);
    filter->SetTissueThreshold(0.0);
    filter->SetMaterialFunction(ConstantMaterial(0.0));
    filter->SetAnchoredFaces(0, 0, 0, 0, 0, 0);
    for (const double pull : { 0.0, 0.375, 0.75, 2.25 })
    {
      filter->SetInputDataObject(1, MakeProbes({ { { { 4.0, 4.0, 4.0 } }, { { pull, 0.0, 0.0 } } } }));
      filter->Update();
      const std::string where = "pulled by " + std::to_string(pull) + (words ? ", words: " : ", numbers: ");
      vtkPointData* out = filter->GetOutput()->GetPointData();
      check.That(!out->GetGlobalIds(), where + "no global ids");
      check.That(out->GetAbstractArray("Pedigree") && out->GetPedigreeIds() == out->GetAbstractArray("Pedigree"),
        where + "pedigree ids");
      for (vtkAbstractArray* from : { static_cast<vtkAbstractArray*>(global), pedigree })
      {
        vtkAbstractArray* to = out->GetAbstractArray(from->GetName());
        check.That(to && to->GetDataType() == from->GetDataType(), where + from->GetName() + " is there");
        for (vtkIdType p = 0; to && p < image->GetNumberOfPoints(); ++p)
        {
          // Tissue ends at the first voxel's centre. Where it left, arrays show their least value.
          const vtkIdType x = p % size;
          const bool left = static_cast<double>(x) < pull;
          const vtkIdType least = from == numbers ? image->GetNumberOfPoints() - 1 : 0;
          const vtkIdType source =
            left ? least : p - x + static_cast<vtkIdType>(std::floor(static_cast<double>(x) - pull + 0.5));
          check.Equal(ValueText(to, p), left && from == names ? std::string() : ValueText(from, source),
            where + from->GetName() + " of voxel " + std::to_string(p));
        }
      }
    }
  }
  return check.Finish();
}
