// B10: resampling alone, on whole scans: the share of an update in which displacements become a deformed image. Against
// it stands what VTK has for the same field: an inverted vtkGridTransform in vtkImageReslice, with linear interpolation
// in both, in one thread, whose time is halved for two. VTK works on a box within the displaced tissue, also on those
// voxels of the box that did not move; the filter's time is counted per displaced voxel, so the comparison favours VTK.

#include "Scans.h"

#include "vtkGridTransform.h"
#include "vtkImageReslice.h"

#include <chrono>
#include <cmath>

namespace
{

/// The box around the displaced voxels, as an extent, no thicker than `most` slices around its middle.
std::array<int, 6> displacedExtent(vtkImageData* field, int most)
{
  std::array<int, 6> box{ { VTK_INT_MAX, VTK_INT_MIN, VTK_INT_MAX, VTK_INT_MIN, VTK_INT_MAX, VTK_INT_MIN } };
  vtkDataArray* displacement = field->GetPointData()->GetArray("Displacement");
  for (vtkIdType v = 0; v < field->GetNumberOfPoints(); ++v)
  {
    const double* u = displacement->GetTuple3(v);
    if (u[0] != 0.0 || u[1] != 0.0 || u[2] != 0.0)
    {
      int dimensions[3];
      field->GetDimensions(dimensions);
      const vtkIdType at[3] = { v % dimensions[0], v / dimensions[0] % dimensions[1],
        v / dimensions[0] / dimensions[1] };
      for (int a = 0; a < 3; ++a)
      {
        const int i = static_cast<int>(at[a]) + field->GetExtent()[2 * a];
        box[2 * a] = std::min(box[2 * a], i);
        box[2 * a + 1] = std::max(box[2 * a + 1], i);
      }
    }
  }
  const int middle = (box[4] + box[5]) / 2;
  box[4] = std::max(box[4], middle - most / 2);
  box[5] = std::min(box[5], box[4] + most - 1);
  return box;
}

/// Seconds that VTK takes for the box.
double sliceByVtk(vtkImageData* scan, vtkImageData* field, std::array<int, 6> box)
{
  vtkNew<vtkImageData> grid;
  grid->CopyStructure(field);
  grid->GetPointData()->SetScalars(field->GetPointData()->GetArray("Displacement"));
  vtkNew<vtkGridTransform> transform;
  transform->SetDisplacementGridData(grid);
  transform->SetInterpolationModeToLinear();
  vtkNew<vtkImageReslice> reslice;
  reslice->SetInputData(scan);
  reslice->SetResliceTransform(transform->GetInverse());
  reslice->SetInterpolationModeToLinear();
  reslice->SetOutputSpacing(scan->GetSpacing());
  reslice->SetOutputOrigin(scan->GetOrigin());
  reslice->SetOutputExtent(box.data());
  reslice->SetEnableSMP(false);
  reslice->SetNumberOfThreads(1);
  // Where the field is steep, at borders of tissue, VTK's inverse does not converge and says so for each voxel.
  vtkObject::GlobalWarningDisplayOff();
  const auto begin = std::chrono::steady_clock::now();
  reslice->Update();
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  vtkObject::GlobalWarningDisplayOn();
  return seconds;
}

void resampling(bench::Session& session, const std::string& name, double threshold, double top,
  const FilterTest::Vector& share, double radius, double far)
{
  const auto scan = bench::readScan(name);
  bench::Drag drag(session, scan, threshold, top);
  drag.grabAt(share, radius);
  drag.filter()->SetAnchoredFaces(0, 0, 0, 0, 0, 0); // all tissue may follow
  std::vector<double> ours;
  std::vector<double> theirs;
  std::size_t sliced = 0;
  bench::Task both;
  both.prepare = [&] { drag.rest(); };
  both.run = [&] { drag.to(far); };
  both.check = [&]
  {
    drag.requireSound(false);
    ours.push_back(1e6 * drag.field("Milliseconds", FilterTest::RESAMPLE) / drag.field("DisplacedElements"));
    vtkImageData* field = drag.filter()->GetOutput(1);
    const std::array<int, 6> box = displacedExtent(field, session.small() ? 2 : 8);
    sliced = static_cast<std::size_t>(box[1] - box[0] + 1) * (box[3] - box[2] + 1) * (box[5] - box[4] + 1);
    theirs.push_back(1e9 * sliceByVtk(scan, field, box) / static_cast<double>(sliced));
  };
  const std::vector<double> whole = session.time(both);
  const double ratio = 0.5 * bench::median(theirs) / bench::median(ours);
  session.report({ name, "resampling", whole,
    { { "elements displaced", drag.field("DisplacedElements") }, { "ns per displaced voxel", bench::median(ours) },
      { "ns per voxel, VTK in one thread", bench::median(theirs) }, { "voxels by VTK", static_cast<double>(sliced) },
      { "times as fast as VTK in two", ratio } } });
}

}

int main(int argc, char** argv)
{
  return bench::run(argc, argv, "B10", "resampling",
    [](bench::Session& session)
    {
      resampling(session, bench::scanName(session, "chest_lidc_ct"), -300.0, 600.0, { 0.1, 0.0, 0.0 }, 8.0, 25.0);
      if (!session.small())
      {
        resampling(session, "head_vhf_ct", 35.0, 110.0, { 0.3, -0.1, -0.1 }, 6.0, 12.0);
        resampling(session, "heart_cta", -100.0, 600.0, { 0.0, 0.1, 0.1 }, 8.0, 15.0);
      }
    });
}
