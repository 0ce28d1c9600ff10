// B16: tens of thousands of probes. On the surface of a lung, which moves from one breath to the next, they ask
// neighbours for more than tissue stretches, and share; in a block they sample a smooth field that all can reach.

#include "../Unit/Random.h"
#include "Scans.h"

#include "vtkChainMailSurfaceMotion.h"
#include "vtkContourFilter.h"
#include "vtkImageCast.h"
#include "vtkImageConstantPad.h"
#include "vtkImageGaussianSmooth.h"

namespace
{

/// Update of a filter from rest, with these probes.
void measure(bench::Session& session, const std::string& scene, const std::string& method,
  vtkChainMailDeformation* filter, vtkPolyData* probes)
{
  bench::Task task = bench::updateFromRest(filter, probes);
  std::map<std::string, double> figures;
  task.check = [&]
  {
    bench::requireSound(filter, 200.0); // the farthest that is asked for here [mm], of voxels from 1 mm on
    vtkImageData* output = filter->GetOutput();
    vtkDataArray* wanted = probes->GetPointData()->GetArray("Displacement");
    vtkDataArray* reached = output->GetFieldData()->GetArray("ProbeReached");
    double missed = 0.0;
    for (vtkIdType p = 0; p < probes->GetNumberOfPoints(); ++p)
    {
      const double* w = wanted->GetTuple3(p);
      const FilterTest::Vector asked{ w[0], w[1], w[2] };
      const double* r = reached->GetTuple3(p);
      const double away[3] = { r[0] - asked[0], r[1] - asked[1], r[2] - asked[2] };
      missed += bench::length(away);
    }
    figures = { { "probes", double(probes->GetNumberOfPoints()) },
      { "displaced elements", FilterTest::Field(output, "DisplacedElements") },
      { "probes miss their targets by, mean [mm]", missed / probes->GetNumberOfPoints() },
      { "propagate [ms]", FilterTest::Field(output, "Milliseconds", FilterTest::PROPAGATE) } };
  };
  const auto milliseconds = session.time(task);
  session.report({ scene, method, milliseconds, figures });
}

/// A mask as the lungs' tests take it: with air around it, which their surface needs.
vtkSmartPointer<vtkImageData> lung(const std::string& name)
{
  vtkSmartPointer<vtkImageData> mask = bench::readScan("lung/3DCT_lung_" + name + "_mask", ".mha");
  vtkNew<vtkImageConstantPad> pad;
  pad->SetInputData(mask);
  int extent[6];
  mask->GetExtent(extent);
  pad->SetOutputWholeExtent(extent[0] - 3, extent[1] + 3, extent[2] - 3, extent[3] + 3, extent[4] - 3, extent[5] + 3);
  pad->Update();
  return pad->GetOutput();
}

vtkSmartPointer<vtkPolyData> surfaceOf(vtkImageData* mask)
{
  vtkNew<vtkImageCast> cast;
  cast->SetInputData(mask);
  cast->SetOutputScalarTypeToFloat();
  vtkNew<vtkImageGaussianSmooth> smooth;
  smooth->SetInputConnection(cast->GetOutputPort());
  smooth->SetStandardDeviations(1.0, 1.0, 0.5);
  vtkNew<vtkContourFilter> contour;
  contour->SetInputConnection(smooth->GetOutputPort());
  contour->SetValue(0, 0.5);
  contour->ComputeNormalsOff();
  contour->Update();
  return contour->GetOutput();
}

void breathe(bench::Session& session)
{
  vtkSmartPointer<vtkImageData> mask = lung("baseline");
  vtkNew<vtkChainMailSurfaceMotion> motion;
  motion->SetInputData(surfaceOf(mask));
  motion->SetAfterData(surfaceOf(lung("followup")));
  motion->SetSpacing(session.small() ? 8.0 : 1.25);
  motion->SetIterations(session.small() ? 1 : 10);
  motion->Update();
  vtkNew<vtkPiecewiseFunction> soft;
  soft->AddPoint(0.0, 0.4);
  soft->AddPoint(1.0, 0.4);
  vtkNew<vtkChainMailDeformation> filter;
  filter->SetInputData(mask);
  filter->SetDevice(session.device().c_str());
  filter->SetMaterialPresetToFunction();
  filter->SetTissueThreshold(0.5);
  filter->SetMaterialFunction(soft);
  filter->SetAnchoredFaces(0, 0, 0, 0, 0, 0);
  filter->SetRelaxationPresetToFast();
  // One probe that goes so far that the whole lung follows: what a wave through the same tissue takes.
  vtkPolyData* probes = motion->GetOutput();
  FilterTest::Probe one;
  probes->GetPoint(0, one.Position.data());
  one.Displacement = { 0.0, 0.0, 200.0 };
  one.Radius = 5.0;
  measure(session, "a lung", "one probe", filter, FilterTest::MakeProbes({ one }));
  filter->SetConflictPolicyToShare();
  measure(session, "a lung", "probes on its surface, Share", filter, probes);
}

/// Probes on elements of their own that sample a smooth field, which no link is too short for.
void sample(bench::Session& session, int side, int count, bool rotations)
{
  Random random(session.seed());
  auto block = FilterTest::MakeImage({ 0, side - 1, 0, side - 1, 0, side - 1 }, VTK_UNSIGNED_CHAR);
  FilterTest::Fill(
    block->GetPointData()->GetScalars(), block, [&](int, int, int) { return std::floor(random(10.0, 41.0)); });
  std::vector<char> taken(static_cast<std::size_t>(block->GetNumberOfPoints()), 0);
  std::vector<FilterTest::Probe> probes;
  const double pi = std::acos(-1.0);
  while (probes.size() < static_cast<std::size_t>(count))
  {
    FilterTest::Probe probe;
    double bump = side / 68.0; // at most a slope of 0.046
    for (double& p : probe.Position)
    {
      p = 1 + random.below(side - 2);
      bump *= std::sin(pi * p / (side - 1));
    }
    int at[3] = { int(probe.Position[0]), int(probe.Position[1]), int(probe.Position[2]) };
    char& here = taken[static_cast<std::size_t>(block->ComputePointId(at))];
    if (!here)
    {
      here = 1;
      probe.Displacement = { bump, -0.8 * bump, 0.6 * bump };
      probes.push_back(probe);
    }
  }
  vtkNew<vtkPiecewiseFunction> material; // constraints of 0.1 to 0.4
  material->AddPoint(0.0, 0.0);
  material->AddPoint(50.0, 0.5);
  vtkNew<vtkChainMailDeformation> filter;
  filter->SetInputData(block);
  filter->SetDevice(session.device().c_str());
  filter->SetMaterialPresetToFunction();
  filter->SetTissueThreshold(5.0);
  filter->SetMaterialFunction(material);
  filter->SetRotations(rotations);
  filter->SetRelaxationPresetToFast();
  const std::string text = std::to_string(side);
  measure(session, text + " x " + text + " x " + text + ", a smooth field",
    rotations ? "probes that fit, with rotations" : "probes that fit", filter, FilterTest::MakeProbes(probes));
}

}

int main(int argc, char** argv)
{
  return bench::run(argc, argv, "B16", "many probes",
    [](bench::Session& session)
    {
      vtkChainMailDeformation::SetGlobalProbeWarnings(false); // that some share is what is measured
      sample(session, session.small() ? 32 : 128, session.small() ? 500 : 20000, false);
      sample(session, session.small() ? 32 : 128, session.small() ? 200 : 5000, true);
      breathe(session);
    });
}
