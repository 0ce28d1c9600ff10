// B17: a vertebra of a CT that rotates about its own centre, against a pull of the same vertebra as far as the pose
// moves any of its voxels.

#include "Scans.h"

#include "vtkIntArray.h"
#include "vtkMath.h"

namespace
{

/// A vertebra in the middle of the scan, in the labels of TotalSegmentator.
constexpr int vertebra = 29;

/// The voxels of the vertebra.
struct Bone
{
  FilterTest::Vector centre{};
  double radius = 0.0; ///< of the farthest voxel from the axis along x through the centre
};

Bone boneOf(vtkImageData* scan, vtkDataArray* labels)
{
  std::vector<FilterTest::Vector> places;
  for (vtkIdType v = 0; v < scan->GetNumberOfPoints(); ++v)
  {
    if (labels->GetTuple1(v) == vertebra)
    {
      places.emplace_back();
      scan->GetPoint(v, places.back().data());
    }
  }
  Bone bone;
  for (const FilterTest::Vector& place : places)
  {
    for (int a = 0; a < 3; ++a)
    {
      bone.centre[a] += place[a] / places.size();
    }
  }
  for (const FilterTest::Vector& place : places)
  {
    bone.radius = std::max(bone.radius, std::hypot(place[1] - bone.centre[1], place[2] - bone.centre[2]));
  }
  return bone;
}

vtkSmartPointer<vtkPolyData> probeOn(const Bone& bone, const FilterTest::Vector& displacement, double degrees)
{
  FilterTest::Probe probe;
  probe.Position = bone.centre;
  probe.Displacement = displacement;
  vtkSmartPointer<vtkPolyData> probes = FilterTest::MakeProbes({ probe });
  vtkNew<vtkDoubleArray> rotation;
  rotation->SetName("Rotation");
  rotation->SetNumberOfComponents(3);
  rotation->InsertNextTuple3(degrees, 0.0, 0.0);
  vtkNew<vtkIntArray> body;
  body->SetName("Body");
  body->InsertNextValue(vertebra);
  probes->GetPointData()->AddArray(rotation);
  probes->GetPointData()->AddArray(body);
  return probes;
}

void pose(bench::Session& session, vtkChainMailDeformation* filter, const Bone& bone, double degrees)
{
  const double far = 2.0 * bone.radius * std::sin(vtkMath::RadiansFromDegrees(0.5 * degrees));
  const vtkSmartPointer<vtkPolyData> rotated = probeOn(bone, { 0.0, 0.0, 0.0 }, degrees);
  const vtkSmartPointer<vtkPolyData> pulled = probeOn(bone, { 0.0, -0.6 * far, 0.8 * far }, 0.0);
  std::map<std::string, double> figures[2];
  std::vector<bench::Task> tasks;
  for (const auto& probes : { rotated, pulled })
  {
    bench::Task task = bench::updateFromRest(filter, probes);
    task.check = [&figures = figures[tasks.size()], filter, far]
    {
      bench::requireSound(filter, far); // voxels are larger than a millimetre
      vtkImageData* output = filter->GetOutput();
      double reached[3];
      output->GetFieldData()->GetArray("ProbeReached")->GetTuple(0, reached);
      figures["asked for [mm]"] = far;
      figures["moved by [mm]"] = bench::length(reached);
      figures["displaced elements"] = FilterTest::Field(output, "DisplacedElements");
      figures["turned by [degrees]"] = FilterTest::Field(output, "ProbeTurned");
      figures["propagate [ms]"] = FilterTest::Field(output, "Milliseconds", FilterTest::PROPAGATE);
      figures["relax [ms]"] = FilterTest::Field(output, "Milliseconds", FilterTest::RELAX);
    };
    tasks.push_back(task);
  }
  const auto milliseconds = session.time(tasks);
  figures[0]["times a pull"] = bench::median(milliseconds[0]) / bench::median(milliseconds[1]);
  const std::string scene = "abdomen_ct, a vertebra by " + std::to_string(int(degrees)) + " degrees";
  session.report({ scene, "pose", milliseconds[0], figures[0] });
  session.report({ scene, "pull as far", milliseconds[1], figures[1] });
}

}

int main(int argc, char** argv)
{
  return bench::run(argc, argv, "B17", "poses",
    [](bench::Session& session)
    {
      vtkChainMailDeformation::SetGlobalProbeWarnings(false); // 30 degrees may be more than the tissue around allows
      vtkSmartPointer<vtkImageData> scan = bench::readScan("abdomen_ct");
      vtkSmartPointer<vtkDataArray> labels = bench::readScan("abdomen_labels")->GetPointData()->GetScalars();
      labels->SetName("Labels");
      scan->GetPointData()->AddArray(labels);
      // Spongy bone is bone, since voxels of 3 mm leave little of the compact one.
      vtkNew<vtkPiecewiseFunction> material;
      material->AddPoint(-300.0, 0.35);
      material->AddPoint(249.0, 0.1);
      material->AddPoint(250.0, 0.0);
      vtkNew<vtkChainMailDeformation> filter;
      filter->SetInputData(scan);
      filter->SetDevice(session.device().c_str());
      filter->SetMaterialPresetToFunction();
      filter->SetTissueThreshold(-300.0);
      filter->SetMaterialFunction(material);
      filter->SetBodyArray("Labels");
      filter->SetJointConstraint(1.0);
      filter->SetRotations(true);
      const Bone bone = boneOf(scan, labels);
      pose(session, filter, bone, 10.0);
      if (!session.small())
      {
        pose(session, filter, bone, 30.0);
      }
    });
}
