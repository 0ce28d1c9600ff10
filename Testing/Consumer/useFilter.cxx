// Pulls the middle of a soft block by one voxel through the VTK filter and checks where the marked voxel went.

#include <vtkChainMailDeformation.h>
#include <vtkChainMailProbeSource.h>

#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPiecewiseFunction.h>

#include <iostream>

int main()
{
  vtkNew<vtkImageData> scan;
  scan->SetDimensions(13, 13, 13);
  scan->AllocateScalars(VTK_SHORT, 1);
  auto* voxels = static_cast<short*>(scan->GetScalarPointer());
  for (vtkIdType i = 0; i < scan->GetNumberOfPoints(); ++i)
  {
    voxels[i] = 100;
  }
  *static_cast<short*>(scan->GetScalarPointer(6, 6, 6)) = 1000;

  vtkNew<vtkPiecewiseFunction> soft;
  soft->AddPoint(0.0, 0.4);
  soft->AddPoint(1000.0, 0.4);

  vtkNew<vtkChainMailProbeSource> probe;
  probe->SetPosition(6.0, 6.0, 6.0);
  probe->SetTarget(7.0, 6.0, 6.0);

  vtkNew<vtkChainMailDeformation> deformation;
  deformation->SetInputData(scan);
  deformation->SetProbesConnection(probe->GetOutputPort());
  deformation->SetMaterialFunction(soft);
  deformation->SetTissueThreshold(0.0);
  deformation->SetRelaxationIterations(0);
  deformation->Update();

  // The held voxel moved by a whole voxel, so the mark is at its target, unblended.
  vtkImageData* deformed = vtkImageData::SafeDownCast(deformation->GetOutputDataObject(0));
  const double mark = deformed->GetScalarComponentAsDouble(7, 6, 6, 0);
  std::cout << "the marked voxel's target shows " << mark << '\n';
  return mark == 1000.0 ? 0 : 1;
}
