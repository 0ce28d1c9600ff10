// SPDX-License-Identifier: BSD-3-Clause
// An update does again what its inputs changed, and no more: the rows of Milliseconds of the other stages are 0.
// However a state is reached, the output is that of a new filter.

#include "DeformationProperties.h"

#include "vtkFloatArray.h"
#include "vtkIntArray.h"

using namespace FilterTest;

namespace
{

const int none = 0;
const int resampled = 1 << RESAMPLE | 1 << DOWNLOAD; // displacements are read anew: readers may have written to them
const int relaxed = resampled | 1 << PROPAGATE | 1 << RELAX;
const int rebuilt = relaxed | 1 << UPLOAD;

/// The stages that the last update ran.
int Stages(vtkChainMailDeformation* filter)
{
  int stages = 0;
  for (int t = UPLOAD; t <= DOWNLOAD; ++t)
  {
    stages |= (Field(filter->GetOutput(), "Milliseconds", t) > 0.0) << t;
  }
  return stages;
}

/// A scene whose every part can be changed and given to any filter.
struct Scene
{
  vtkSmartPointer<vtkImageData> Image = MakeImage({ { 0, 15, 0, 11, 0, 9 } }, VTK_FLOAT);
  vtkSmartPointer<vtkPolyData> Probes = MakeProbes({ { { { 7.0, 5.0, 4.0 } }, { { 1.3, 0.4, 0.0 } } } });
  vtkSmartPointer<vtkPolyData> Cuts =
    MakeBlade({ { { { 9.5, -1.0, -1.0 } }, { { 9.5, 8.3, -1.0 } }, { { 9.5, 8.3, 20.0 } }, { { 9.5, -1.0, 20.0 } } } });
  vtkSmartPointer<vtkPiecewiseFunction> Material = vtkSmartPointer<vtkPiecewiseFunction>::New();

  Scene()
  {
    Noise noise(5);
    Fill(
      this->Image->GetPointData()->GetScalars(), this->Image, [&](int, int, int) { return 100.0 * noise.Uniform(); });
    vtkNew<vtkFloatArray> other;
    other->SetName("Other");
    vtkNew<vtkFloatArray> fractions;
    fractions->SetName("Fractions");
    for (vtkIdType p = 0; p < this->Image->GetNumberOfPoints(); ++p)
    {
      other->InsertNextValue(static_cast<float>(noise.Uniform()));
      fractions->InsertNextValue(static_cast<float>(0.5 * noise.Uniform()));
    }
    this->Image->GetPointData()->AddArray(other);
    this->Image->GetPointData()->AddArray(fractions);
    this->Material->AddPoint(0.0, 0.4);
    this->Material->AddPoint(100.0, 0.1);
  }

  void Connect(vtkChainMailDeformation* filter)
  {
    filter->SetInputData(this->Image);
    filter->SetInputDataObject(1, this->Probes);
    filter->SetInputDataObject(2, this->Cuts);
    filter->SetMaterialFunction(this->Material);
  }
};

}

int TestChainMailUpdates(int, char*[])
{
  Checks check;
  Scene scene;
  vtkNew<vtkChainMailDeformation> filter;
  scene.Connect(filter);
  filter->SetTissueThreshold(15.0);
  filter->SetRelaxationIterations(20);

  const std::vector<DeformationProperty> properties = DeformationProperties();

  // Both outputs are those of a filter that has no past.
  const auto compare = [&](const std::string& where)
  {
    vtkNew<vtkChainMailDeformation> fresh;
    scene.Connect(fresh);
    for (const DeformationProperty& property : properties)
    {
      property.Copy(filter, fresh);
    }
    fresh->Update();
    for (int port : { 0, 1 })
    {
      auto* actual = vtkImageData::SafeDownCast(filter->GetOutputDataObject(port))->GetPointData();
      auto* expected = vtkImageData::SafeDownCast(fresh->GetOutputDataObject(port))->GetPointData();
      check.Equal(actual->GetNumberOfArrays(), expected->GetNumberOfArrays(), where + ": number of arrays");
      for (int a = 0; a < expected->GetNumberOfArrays(); ++a)
      {
        check.That(SameBits(actual->GetAbstractArray(expected->GetArrayName(a)), expected->GetAbstractArray(a)),
          where + ": " + expected->GetArrayName(a) + " is that of a new filter");
      }
    }
    for (const char* field :
      { "Energy", "MaxLinkExcess", "PropagationIterationsUsed", "RelaxationIterationsUsed", "DisplacedElements" })
    {
      check.Equal(Field(filter->GetOutput(), field), Field(fresh->GetOutput(), field), where + ": " + field);
    }
  };
  const auto update = [&](const std::string& where, int expected)
  {
    filter->Update();
    check.Equal(Stages(filter), expected, where + ": stages run");
    compare(where);
  };

  update("first", rebuilt);
  check.That(Field(filter->GetOutput(), "DisplacedElements") > 100.0, "the scene is deformed");

  // Nothing changed: the filter is not even called.
  const vtkMTimeType before = filter->GetOutput()->GetPointData()->GetScalars()->GetMTime();
  filter->Update();
  check.Equal(filter->GetOutput()->GetPointData()->GetScalars()->GetMTime(), before, "no change, no call");

  // Something says it was modified, but is as before: of the inputs their contents count, of the filter its word.
  const auto untouched = [&](const std::string& where)
  {
    filter->Update();
    check.Equal(filter->GetOutput()->GetPointData()->GetScalars()->GetMTime(), before, where + ": nothing is done");
    compare(where);
  };
  scene.Probes->Modified();
  untouched("probes touched, not changed");

  // Arrays of the model at rest come and go without another deformation.
  vtkDataArraySelection* const chosen = filter->GetModelArraySelection();
  chosen->DisableAllArrays();
  untouched("no array of the model");
  chosen->EnableArray("Constraint");
  chosen->EnableArray("Cluster");
  untouched("two arrays of the model");
  chosen->EnableAllArrays();
  untouched("all arrays of the model");
  chosen->DisableArray("Displacement");
  untouched("all arrays of the model but one");
  chosen->EnableAllArrays();
  scene.Cuts->GetPoints()->Modified();
  scene.Cuts->Modified();
  untouched("cuts touched, not changed");
  scene.Image->Modified();
  untouched("image touched, not changed");
  scene.Material->Modified();
  update("material touched, not changed", resampled);
  filter->Modified();
  update("filter touched", resampled);

  // Options of the output.
  filter->SetInterpolationToNearest();
  update("Interpolation", resampled);
  filter->AddLabelArray("Other");
  update("LabelArrays", resampled);
  filter->SetInterpolationToLinear();
  update("Interpolation back", resampled);
  filter->SetBackgroundValue(-5.0);
  update("BackgroundValue", resampled);
  filter->SetOutputPadding(2);
  update("OutputPadding", resampled);
  filter->PullBackOn();
  update("PullBack", resampled);
  filter->SetScalarSmoothing(0.75);
  update("ScalarSmoothing", resampled);
  filter->SetOutputMagnification(2);
  update("OutputMagnification", resampled);
  filter->SetOutputBounds(3.0, 11.0, 2.0, 9.5, 1.0, 8.0);
  filter->UseOutputBoundsOn();
  update("OutputBounds", resampled);
  filter->SetOutputMagnification(1);
  update("OutputMagnification back", resampled);
  filter->UseOutputBoundsOff();
  update("OutputBounds back", resampled);
  filter->SetOutputPadding(0);
  update("OutputPadding back", resampled);
  vtkNew<vtkFloatArray> more;
  more->SetName("More");
  more->SetNumberOfTuples(scene.Image->GetNumberOfPoints());
  more->Fill(3.0);
  scene.Image->GetPointData()->AddArray(more);
  update("another point array", resampled);
  scene.Image->SetOrigin(0.0, 0.0, 0.0);
  scene.Image->Modified();
  update("image touched, arrays not", resampled);
  more->SetValue(7, 4.0f);
  scene.Image->Modified();
  update("an array written to in place, the image told", resampled);

  filter->PropagationTimesOn();
  update("PropagationTimes on", relaxed);
  filter->PropagationTimesOff();
  update("PropagationTimes off", resampled);
  filter->PropagationTimesOn();
  update("PropagationTimes on again", resampled);

  // How tissue is deformed.
  filter->SetPropagationMethodToTimestamp();
  update("PropagationMethod", relaxed);
  filter->SetPropagationIterations(2);
  update("PropagationIterations", relaxed);
  filter->SetPropagationMethodToEnvelope();
  update("PropagationMethod back, with a wave under way", relaxed);
  filter->SetPropagationIterations(0);
  update("PropagationIterations back", relaxed);
  filter->SetConflictPolicyToLatest();
  update("ConflictPolicy", relaxed);
  filter->SetConflictPolicyToShare();
  update("ConflictPolicy Share", relaxed);
  filter->SetConflictPolicyToLimit();
  update("ConflictPolicy back", relaxed);
  filter->SetElasticRecovery(0.6);
  update("ElasticRecovery", relaxed);
  filter->SetRelaxationMethodToPaper();
  update("RelaxationMethod", relaxed);
  filter->SetRelaxationMethodToProjected();
  update("RelaxationMethod back", relaxed);
  filter->SetElasticRecovery(1.0);
  update("ElasticRecovery back", relaxed);
  filter->SetRotations(true);
  update("Rotations", rebuilt);
  filter->SetPoissonRatio(0.4);
  update("PoissonRatio", rebuilt);
  filter->SetPoissonRatio(0.0);
  update("PoissonRatio back", rebuilt);
  filter->SetRotations(false);
  update("Rotations off", rebuilt);
  filter->CoarseToFineOn();
  update("CoarseToFine", relaxed);
  filter->CoarseToFineOff();
  update("CoarseToFine back", relaxed);
  filter->SetRelaxationPresetToFast();
  update("RelaxationPreset", relaxed);
  check.That(Field(filter->GetOutput(), "RelaxationIterationsUsed") <= 10.0, "few iterations when interactive");
  filter->SetRelaxationPresetToAccurate();
  update("RelaxationPreset to Accurate", relaxed);
  check.That(Field(filter->GetOutput(), "RelaxationIterationsUsed") > 40.0, "many iterations when accurate");
  filter->SetRelaxationPresetToCustom();
  update("RelaxationPreset back", relaxed);
  filter->PropagationTimesOff();
  filter->SetPropagationMethodToTimestamp();
  update("times are not kept", relaxed);
  filter->PropagationTimesOn();
  filter->SetPropagationMethodToEnvelope();
  update("times are kept again", relaxed);

  // Relaxation, probes, cuts.
  filter->SetRelaxationIterations(30);
  update("RelaxationIterations", relaxed);
  filter->SetRelaxationTolerance(0.02);
  update("RelaxationTolerance", relaxed);
  filter->SetRelaxationIterations(0);
  filter->Update();
  check.Equal(Field(filter->GetOutput(), "RelaxationIterationsUsed"), 0.0, "no relaxation");
  compare("no relaxation");
  filter->SetRelaxationIterations(25);
  update("relaxation again", relaxed);
  scene.Probes->GetPointData()->GetArray("Displacement")->SetTuple3(0, 0.5, -0.8, 0.3);
  scene.Probes->GetPointData()->GetArray("Displacement")->Modified();
  scene.Probes->Modified();
  update("probe pulled elsewhere", relaxed);
  scene.Probes->GetPoints()->SetPoint(0, 5.0, 6.0, 5.0);
  scene.Probes->GetPoints()->Modified();
  update("probe moved", relaxed);
  vtkNew<vtkDoubleArray> ofProbes[2];
  for (int n = 0; n < 2; ++n)
  {
    ofProbes[n]->SetName(n == 0 ? "Tolerance" : "Radius");
    ofProbes[n]->SetNumberOfTuples(scene.Probes->GetNumberOfPoints());
    ofProbes[n]->Fill(n == 0 ? 0.4 : 0.0);
    scene.Probes->GetPointData()->AddArray(ofProbes[n]);
    update(std::string(ofProbes[n]->GetName()) + " of probes", relaxed);
    ofProbes[n]->SetValue(0, n == 0 ? 2.5 : 1.5);
    ofProbes[n]->Modified();
    scene.Probes->Modified();
    update(std::string(ofProbes[n]->GetName()) + " of a probe changed", relaxed);
  }
  scene.Probes->GetPointData()->RemoveArray("Tolerance");
  scene.Probes->GetPointData()->RemoveArray("Radius");
  update("probes without them again", relaxed);
  scene.Cuts->GetPoints()->SetPoint(1, 9.5, 6.3, -1.0);
  scene.Cuts->GetPoints()->Modified();
  update("cut changed", relaxed);
  auto cuts = scene.Cuts;
  scene.Cuts = nullptr;
  filter->RemoveAllCuts();
  update("cuts removed", relaxed);
  scene.Cuts = cuts;
  filter->SetInputDataObject(2, cuts);
  update("cuts back", relaxed);
  auto probes = scene.Probes;
  scene.Probes = nullptr;
  filter->RemoveAllProbes();
  filter->Update();
  check.Equal(Field(filter->GetOutput(), "DisplacedElements"), 0.0, "without probes tissue is at rest again");
  compare("probes removed");
  scene.Probes = probes;
  filter->SetInputDataObject(1, probes);
  update("probes back", relaxed);
  scene.Image->SetOrigin(0.5, 0.25, 0.0);
  update("image moved under its probes", relaxed);

  // The tissue.
  filter->SetTissueThreshold(20.0);
  update("TissueThreshold", rebuilt);
  scene.Material->AddPoint(35.0, 0.0);
  scene.Material->AddPoint(65.0, 0.0);
  update("MaterialFunction edited", rebuilt);
  const auto divided = [&]()
  {
    double range[2];
    filter->GetModelOutput()->GetPointData()->GetArray("Cluster")->GetRange(range);
    return range[1];
  };
  const double clusters = divided();
  scene.Cuts->GetPoints()->SetPoint(0, 9.5, -1.0, -1.0);
  scene.Cuts->GetPoints()->SetPoint(1, 9.5, 20.0, -1.0);
  scene.Cuts->GetPoints()->SetPoint(2, 9.5, 20.0, 20.0);
  scene.Cuts->GetPoints()->Modified();
  update("rigid tissue cut", relaxed);
  check.That(divided() > clusters, "a cut divides rigid clusters");
  filter->SetAnchoredFaces(1, 0, 1, 1, 0, 1);
  update("AnchoredFaces", rebuilt);
  filter->AnchorRigidOn();
  update("AnchorRigid", rebuilt);
  filter->SetMaterialPresetToMR();
  update("MaterialPreset", rebuilt);
  filter->SetMaterialPresetToFunction();
  update("MaterialPreset back", rebuilt);
  filter->SetConstraintArray("Fractions");
  update("ConstraintArray", rebuilt);
  scene.Image->GetPointData()->GetArray("Fractions")->SetTuple1(800, 0.6);
  scene.Image->GetPointData()->GetArray("Fractions")->Modified();
  update("constraints edited", rebuilt);
  filter->SetConstraintArray("");
  update("ConstraintArray back", rebuilt);
  vtkNew<vtkIntArray> labels;
  labels->SetName("Labels");
  for (vtkIdType p = 0; p < scene.Image->GetNumberOfPoints(); ++p)
  {
    labels->InsertNextValue(p % 16 < 8 ? 1 : 2);
  }
  scene.Image->GetPointData()->AddArray(labels);
  const double undivided = divided();
  filter->SetBodyArray("Labels");
  update("BodyArray", rebuilt);
  check.That(divided() > undivided, "labels divide rigid clusters");
  labels->SetValue(4 + 16 * (5 + 12 * 4), 3);
  labels->Modified();
  update("labels edited", rebuilt);
  filter->SetJointConstraint(0.3);
  update("JointConstraint", rebuilt);
  filter->SetJointSize(2);
  update("JointSize", rebuilt);
  filter->SetBodyArray("");
  filter->SetJointSize(0);
  update("no bodies", rebuilt);
  filter->SetJointConstraint(0.4);
  update("a joint constraint without joints", resampled);
  scene.Image->GetPointData()->GetScalars()->SetTuple1(801, 99.0);
  scene.Image->GetPointData()->GetScalars()->Modified();
  update("scalars edited", rebuilt);
  scene.Image->SetSpacing(1.1, 1.0, 1.0);
  update("spacing", rebuilt);
  filter->SetBrickSize(8, 8, 8);
  update("BrickSize", rebuilt);
  filter->SetModelReduction(2);
  update("ModelReduction", rebuilt);

  // Another material function object with the same nodes, and scalars that are the same array in another image.
  vtkNew<vtkPiecewiseFunction> copy;
  copy->DeepCopy(scene.Material);
  scene.Material = copy.Get();
  filter->SetMaterialFunction(copy);
  update("the same nodes in another function", resampled);
  vtkNew<vtkImageData> shallow;
  shallow->ShallowCopy(scene.Image);
  scene.Image = shallow.Get();
  filter->SetInputData(shallow);
  update("the same arrays in another image", resampled);

  // A property that makes no difference.
  filter->SetMaterialFunction(scene.Material);
  filter->SetTissueThreshold(20.0);
  const vtkMTimeType unchanged = filter->GetOutput()->GetMTime();
  filter->Update();
  check.Equal(filter->GetOutput()->GetMTime(), unchanged, "values set again");
  return check.Finish();
}
