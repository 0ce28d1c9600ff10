// SPDX-License-Identifier: BSD-3-Clause
// What can be told from the size of an image and its spacing is told before its scalars are looked at: they lie in
// memory whose reading would end the test.

#include "FilterTest.h"

#include <sys/mman.h>

using namespace FilterTest;

int TestChainMailLimits(int, char*[])
{
  Checks check;
  struct Case
  {
    std::array<int, 3> Size;
    double Thickness;
    std::vector<std::string> Says;
  };
  for (const Case& one :
    { Case{ { { 8192, 8192, 4097 } }, 1.0, { "8192 x 8192 x 4097 voxels", "at most 274877906944", "Crop" } },
      Case{ { { 1024, 1024, 256 } }, 0.0, { "spacing", "positive" } } })
  {
    vtkNew<vtkImageData> image;
    image->SetDimensions(one.Size.data());
    image->SetSpacing(1.0, 1.0, one.Thickness);
    const vtkIdType voxels = image->GetNumberOfPoints();
    void* unreadable = mmap(nullptr, voxels, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    check.That(unreadable != MAP_FAILED, "memory that cannot be read");
    vtkNew<vtkUnsignedCharArray> scan;
    scan->SetName("Scan");
    scan->SetVoidArray(unreadable, voxels, 1);
    image->GetPointData()->SetScalars(scan);

    vtkNew<vtkChainMailDeformation> filter;
    EventLog log(filter);
    filter->SetInputData(image);
    filter->Update();
    const std::string error = log.TakeErrors();
    for (const std::string& part : one.Says)
    {
      check.Contains(error, part, "message");
    }
    check.Equal(filter->GetOutput()->GetNumberOfPoints(), voxels, "the image as it is");
    munmap(unreadable, voxels);
  }
  return check.Finish();
}
