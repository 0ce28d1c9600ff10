// SPDX-License-Identifier: BSD-3-Clause
// Every bad input gives exactly one error that says what is wrong and what to do, goes on showing the last good result
// (before there is one, the image as it is), and leaves a filter whose next update with good input works and finds its
// earlier work done.

#include "FilterTest.h"

#include "vtkCellData.h"
#include "vtkDoubleArray.h"
#include "vtkErrorCode.h"
#include "vtkFloatArray.h"
#include "vtkMatrix3x3.h"

#include <limits>

using namespace FilterTest;

namespace
{

const double notANumber = std::nan("");
const double infinity = std::numeric_limits<double>::infinity();

struct Scene
{
  vtkSmartPointer<vtkImageData> Image = MakeImage({ { 3, 12, 0, 7, 0, 7 } }, VTK_FLOAT);
  vtkSmartPointer<vtkPolyData> Probes = MakeProbes(
    { { { { 8.0, 4.0, 4.0 } }, { { 0.8, 0.0, 0.0 } } }, { { { 10.0, 4.0, 4.0 } }, { { 0.0, 0.2, 0.0 } }, 1.0 } });
  vtkSmartPointer<vtkPolyData> Cuts =
    MakeBlade({ { { { 6.5, -1.0, -1.0 } }, { { 6.5, 4.4, -1.0 } }, { { 6.5, 4.4, 9.0 } }, { { 6.5, -1.0, 9.0 } } } });
  vtkSmartPointer<vtkPiecewiseFunction> Material = ConstantMaterial(0.3);

  Scene()
  {
    // A slab of air at the low end of x.
    Fill(this->Image->GetPointData()->GetScalars(), this->Image, [](int i, int j, int) { return i < 2 ? 0 : 50 + j; });
    vtkNew<vtkFloatArray> fractions;
    fractions->SetName("Fractions");
    fractions->SetNumberOfTuples(this->Image->GetNumberOfPoints());
    fractions->Fill(0.2);
    this->Image->GetPointData()->AddArray(fractions);
    vtkNew<vtkStringArray> words;
    words->SetName("Words");
    words->SetNumberOfTuples(this->Image->GetNumberOfPoints());
    this->Image->GetPointData()->AddArray(words);
  }
};

void Apply(Scene& scene, vtkChainMailDeformation* filter)
{
  filter->SetInputData(scene.Image);
  filter->SetInputDataObject(1, scene.Probes);
  filter->SetInputDataObject(2, scene.Cuts);
  filter->SetMaterialFunction(scene.Material);
  filter->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS, vtkDataSetAttributes::SCALARS);
  filter->SetConstraintArray("");
  filter->SetTissueThreshold(10.0);
  filter->SetDevice("");
  filter->SetBrickSize(0, 0, 0);
  filter->SetModelReduction(1);
  filter->SetRotations(false);
  filter->SetPoissonRatio(0.0);
  filter->SetElasticRecovery(1.0);
  filter->SetBodyArray("");
  filter->SetJointSize(0);
  filter->ClearLabelArrays();
  filter->SetMaterialPresetToFunction();
  filter->SetModeToFromRest();
  filter->SetPropagationMethodToEnvelope();
  filter->SetConflictPolicyToLimit();
  filter->SetRelaxationMethodToProjected();
  filter->SetRelaxationPresetToCustom();
  filter->SetInterpolationToLinear();
}

/// A way to spoil the scene or the filter, and what the message has to say.
struct Case
{
  const char* Name;
  std::vector<std::string> Says;
  std::function<void(Scene&, vtkChainMailDeformation*)> Spoil;
  bool OfTheEngine = false; // found by the engine: it has to start from rest again
};

vtkDataArray* Array(vtkDataSet* data, const char* name)
{
  return data->GetPointData()->GetArray(name);
}

}

int TestChainMailErrors(int, char*[])
{
  Checks check;
  const std::vector<Case> cases = {
    { "empty image", { "image is empty", "at least one voxel" },
      [](Scene& s, vtkChainMailDeformation* f)
      {
        s.Image = vtkSmartPointer<vtkImageData>::New();
        f->SetInputData(s.Image);
      } },
    { "no arrays", { "no active point scalars", "It has none", "Give an image" },
      [](Scene& s, vtkChainMailDeformation*) { s.Image->GetPointData()->Initialize(); } },
    { "no active scalars", { "no active point scalars", "Scan, Fractions, Words", "Choose" },
      [](Scene& s, vtkChainMailDeformation*) { s.Image->GetPointData()->SetActiveScalars(nullptr); } },
    { "unknown scalars", { "no point array called \"Scans\"", "Scan, Fractions, Words", "Choose" },
      [](Scene&, vtkChainMailDeformation* f)
      { f->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS, "Scans"); } },
    { "scalars that are words", { "\"Words\"", "does not hold numbers", "Choose" },
      [](Scene&, vtkChainMailDeformation* f)
      { f->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS, "Words"); } },
    { "cell scalars", { "cell array", "Cell Data to Point Data" },
      [](Scene& s, vtkChainMailDeformation* f)
      {
        vtkNew<vtkFloatArray> cells;
        cells->SetName("Cells");
        cells->SetNumberOfTuples(s.Image->GetNumberOfCells());
        s.Image->GetCellData()->AddArray(cells);
        f->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, "Cells");
      } },
    { "cell data alone", { "cell data alone", "It has: Cells.", "Cell Data to Point Data", "TIFF Series Reader" },
      [](Scene& s, vtkChainMailDeformation* f)
      {
        vtkNew<vtkFloatArray> cells;
        cells->SetName("Cells");
        cells->SetNumberOfTuples(s.Image->GetNumberOfCells());
        s.Image->GetPointData()->Initialize();
        s.Image->GetCellData()->AddArray(cells);
        f->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS, "0"); // as ParaView's proxy does
      } },
    { "unknown constraints", { "no point array called \"Fraction\"", "ConstraintArray", "Scan, Fractions, Words" },
      [](Scene&, vtkChainMailDeformation* f) { f->SetConstraintArray("Fraction"); } },
    { "constraints that are words", { "ConstraintArray", "\"Words\"", "does not hold numbers" },
      [](Scene&, vtkChainMailDeformation* f) { f->SetConstraintArray("Words"); } },
    { "constraints with two components", { "2 components", "1", "3" },
      [](Scene& s, vtkChainMailDeformation* f)
      {
        vtkNew<vtkFloatArray> two;
        two->SetName("Two");
        two->SetNumberOfComponents(2);
        two->SetNumberOfTuples(s.Image->GetNumberOfPoints());
        two->Fill(0.1);
        s.Image->GetPointData()->AddArray(two);
        f->SetConstraintArray("Two");
      },
      true },
    { "constraint of 1 in the array", { "constraint", "is 1.", "less than 1" },
      [](Scene& s, vtkChainMailDeformation* f)
      {
        Array(s.Image, "Fractions")->SetTuple1(305, 1.0);
        f->SetConstraintArray("Fractions");
      },
      true },
    { "negative constraint in the array", { "constraint", "-0.1", "from 0" },
      [](Scene& s, vtkChainMailDeformation* f)
      {
        Array(s.Image, "Fractions")->SetTuple1(305, -0.1);
        f->SetConstraintArray("Fractions");
      },
      true },
    { "constraint that is not a number", { "constraint", "nan" },
      [](Scene& s, vtkChainMailDeformation* f)
      {
        Array(s.Image, "Fractions")->SetTuple1(305, notANumber);
        f->SetConstraintArray("Fractions");
      },
      true },
    { "unknown bodies", { "no point array called \"Bones\"", "BodyArray", "Scan, Fractions, Words" },
      [](Scene&, vtkChainMailDeformation* f) { f->SetBodyArray("Bones"); } },
    { "bodies that are words", { "BodyArray", "\"Words\"", "does not hold numbers" },
      [](Scene&, vtkChainMailDeformation* f) { f->SetBodyArray("Words"); } },
    { "labels that are no whole numbers", { "label of the body at voxel", "whole numbers" },
      [](Scene&, vtkChainMailDeformation* f)
      {
        f->SetMaterialFunction(ConstantMaterial(0.0));
        f->SetBodyArray("Fractions");
      },
      true },
    { "joints in a reduced model", { "closes the joints", "ModelReduction" },
      [](Scene&, vtkChainMailDeformation* f)
      {
        f->SetJointSize(3);
        f->SetModelReduction(2);
      },
      true },
    { "array of another length", { "\"Short\"", "7 tuples", "640 voxels" },
      [](Scene& s, vtkChainMailDeformation*)
      {
        vtkNew<vtkFloatArray> few;
        few->SetName("Short");
        few->SetNumberOfTuples(7);
        s.Image->GetPointData()->AddArray(few);
      } },
    { "unknown label array", { "LabelArrays", "\"Organs\"", "Scan, Fractions, Words" },
      [](Scene&, vtkChainMailDeformation* f) { f->AddLabelArray("Organs"); } },
    { "material of 1", { "MaterialFunction is 1 for a scalar of 70", "less than 1", "move that node" },
      [](Scene& s, vtkChainMailDeformation*) { s.Material->AddPoint(70.0, 1.0); } },
    { "negative material", { "MaterialFunction is -0.2 for a scalar of 70" },
      [](Scene& s, vtkChainMailDeformation*) { s.Material->AddPoint(70.0, -0.2); } },
    { "material without nodes", { "MaterialFunction has no nodes" },
      [](Scene& s, vtkChainMailDeformation*) { s.Material->RemoveAllPoints(); } },
    { "all air", { "all air", "threshold", "1000" },
      [](Scene&, vtkChainMailDeformation* f) { f->SetTissueThreshold(1000.0); }, true },
    { "nothing finite", { "all air", "finite" },
      [](Scene& s, vtkChainMailDeformation*) { s.Image->GetPointData()->GetScalars()->Fill(notANumber); }, true },
    { "no thickness", { "spacing", "positive" },
      [](Scene& s, vtkChainMailDeformation*) { s.Image->SetSpacing(1.0, 0.0, 1.0); }, true },
    { "skewed direction", { "direction matrix", "not orthonormal" },
      [](Scene& s, vtkChainMailDeformation*)
      { s.Image->SetDirectionMatrix(1.0, 0.3, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0); } },
    { "unknown device", { "no such device as this", "" },
      [](Scene&, vtkChainMailDeformation* f) { f->SetDevice("no such device as this"); }, true },
    { "odd brick size", { "brick size", "power" }, [](Scene&, vtkChainMailDeformation* f) { f->SetBrickSize(5, 4, 4); },
      true },
    { "model reduction by 3", { "model reduction", "1, 2, 4 or 8" },
      [](Scene&, vtkChainMailDeformation* f) { f->SetModelReduction(3); }, true },
    { "rotations of plastic tissue", { "Rotations need", "switch Rotations off" },
      [](Scene&, vtkChainMailDeformation* f)
      {
        f->SetRotations(true);
        f->SetElasticRecovery(0.5);
      } },
    { "Poisson's ratio of tissue that does not turn", { "PoissonRatio", "needs Rotations" },
      [](Scene&, vtkChainMailDeformation* f) { f->SetPoissonRatio(0.3); } },
    { "material preset of no name", { "MaterialPreset is 99", "Choose 0 (Function)" },
      [](Scene&, vtkChainMailDeformation* f) { f->SetMaterialPreset(99); } },
    { "mode of no name", { "Mode is 99", "Choose 0 (FromRest)" },
      [](Scene&, vtkChainMailDeformation* f) { f->SetMode(99); } },
    { "mode below all", { "Mode is -1", "Choose 0 (FromRest)" },
      [](Scene&, vtkChainMailDeformation* f) { f->SetMode(-1); } },
    { "propagation of no name", { "PropagationMethod is 99", "Choose 0 (Envelope)" },
      [](Scene&, vtkChainMailDeformation* f) { f->SetPropagationMethod(99); } },
    { "conflict policy of no name", { "ConflictPolicy is 99", "Choose 0 (Limit)" },
      [](Scene&, vtkChainMailDeformation* f) { f->SetConflictPolicy(99); } },
    { "sharing without envelopes", { "ConflictPolicy Share", "PropagationMethod Envelope" },
      [](Scene&, vtkChainMailDeformation* f)
      {
        f->SetConflictPolicyToShare();
        f->SetPropagationMethodToTimestamp();
      } },
    { "relaxation of no name", { "RelaxationMethod is 99", "Choose 0 (Projected)" },
      [](Scene&, vtkChainMailDeformation* f) { f->SetRelaxationMethod(99); } },
    { "relaxation preset of no name", { "RelaxationPreset is 99", "Choose 0 (Custom)" },
      [](Scene&, vtkChainMailDeformation* f) { f->SetRelaxationPreset(99); } },
    { "interpolation of no name", { "Interpolation is 99", "Choose 0 (Linear)" },
      [](Scene&, vtkChainMailDeformation* f) { f->SetInterpolation(99); } },
    { "probe in air", { "Probes input 0, point 0 at (3.25, 4, 4)", "holds no tissue", "radius" },
      [](Scene& s, vtkChainMailDeformation*) { s.Probes->GetPoints()->SetPoint(0, 3.25, 4.0, 4.0); }, true },
    { "probe outside", { "Probes input 0, point 1 at (100, 4, 4)", "holds no tissue" },
      [](Scene& s, vtkChainMailDeformation*) { s.Probes->GetPoints()->SetPoint(1, 100.0, 4.0, 4.0); }, true },
    { "probe of the second input in air", { "Probes input 1, point 0 at (4, 4, 4)" },
      [](Scene&, vtkChainMailDeformation* f) {
        f->AddInputDataObject(1, MakeProbes({ { { { 4.0, 4.0, 4.0 } }, { { 1.0, 0.0, 0.0 } } } }));
      },
      true },
    { "probe nowhere", { "Probes input 0, point 1", "position", "finite" },
      [](Scene& s, vtkChainMailDeformation*) { s.Probes->GetPoints()->SetPoint(1, notANumber, 4.0, 4.0); } },
    { "no displacement",
      { "Probes input 0, point 0 at (8, 4, 4)", "no point array \"Displacement\"", "Radius, Anchor", "3" },
      [](Scene& s, vtkChainMailDeformation*) { s.Probes->GetPointData()->RemoveArray("Displacement"); } },
    { "displacement of two components", { "Probes input 0", "\"Displacement\"", "3 numbers", "2" },
      [](Scene& s, vtkChainMailDeformation*)
      {
        vtkNew<vtkDoubleArray> flat;
        flat->SetName("Displacement");
        flat->SetNumberOfComponents(2);
        flat->SetNumberOfTuples(2);
        flat->Fill(1.0);
        s.Probes->GetPointData()->AddArray(flat);
      } },
    { "displacement without end", { "Probes input 0, point 1 at (10, 4, 4)", "displacement", "inf", "finite" },
      [](Scene& s, vtkChainMailDeformation*) { Array(s.Probes, "Displacement")->SetTuple3(1, 0.0, infinity, 0.0); } },
    { "negative radius", { "Probes input 0, point 1 at (10, 4, 4)", "radius", "-2" },
      [](Scene& s, vtkChainMailDeformation*) { Array(s.Probes, "Radius")->SetTuple1(1, -2.0); } },
    { "radius that is not a number", { "Probes input 0, point 0", "radius", "nan" },
      [](Scene& s, vtkChainMailDeformation*) { Array(s.Probes, "Radius")->SetTuple1(0, notANumber); } },
    { "radius of two components", { "\"Radius\"", "1 number for every point" },
      [](Scene& s, vtkChainMailDeformation*)
      {
        vtkNew<vtkDoubleArray> two;
        two->SetName("Radius");
        two->SetNumberOfComponents(2);
        two->SetNumberOfTuples(2);
        two->Fill(1.0);
        s.Probes->GetPointData()->AddArray(two);
      } },
    { "anchors that are words", { "\"Anchor\"", "no numbers" },
      [](Scene& s, vtkChainMailDeformation*)
      {
        vtkNew<vtkStringArray> words;
        words->SetName("Anchor");
        words->SetNumberOfTuples(2);
        s.Probes->GetPointData()->AddArray(words);
      } },
    { "blade without end", { "Cuts input 0, point 2", "inf", "finite" },
      [](Scene& s, vtkChainMailDeformation*) { s.Cuts->GetPoints()->SetPoint(2, 6.5, infinity, 9.0); } },
  };

  // What a filter without a past gives.
  Scene good;
  vtkNew<vtkChainMailDeformation> reference;
  Apply(good, reference);
  reference->Update();
  check.That(Field(reference->GetOutput(), "DisplacedElements") > 10.0, "the good scene is deformed");

  // One filter goes through all cases, each after a good update.
  vtkNew<vtkChainMailDeformation> filter;
  EventLog log(filter);
  Apply(good, filter);
  filter->Update();
  check.Equal(log.TakeErrors(), std::string(), "the good scene");
  for (const Case& one : cases)
  {
    // As the first thing that a filter meets, and after good work.
    vtkNew<vtkChainMailDeformation> fresh;
    EventLog freshLog(fresh);
    for (vtkChainMailDeformation* tried : { fresh.Get(), filter.Get() })
    {
      const std::string where = one.Name + std::string(tried == fresh ? ", at once" : ", later");
      EventLog& events = tried == fresh ? freshLog : log;
      Scene scene;
      // The same arrays as before, so that the tissue is as it was.
      Apply(scene, tried);
      scene.Image->GetPointData()->ShallowCopy(good.Image->GetPointData());
      const std::vector<std::string> edited = { "Fractions", "Scan" };
      for (const std::string& name : edited)
      {
        // Cases write into these.
        if (one.OfTheEngine)
        {
          vtkDataArray* shared = Array(scene.Image, name.c_str());
          auto copy = vtkSmartPointer<vtkDataArray>::Take(shared->NewInstance());
          copy->DeepCopy(shared);
          scene.Image->GetPointData()->AddArray(copy);
        }
      }
      scene.Image->GetPointData()->SetActiveScalars("Scan");
      one.Spoil(scene, tried);
      vtkNew<vtkImageData> shown;
      vtkNew<vtkImageData> shownModel;
      shown->ShallowCopy(tried->GetOutput());
      shownModel->ShallowCopy(tried->GetModelOutput());
      tried->Update();
      const std::string errors = events.TakeErrors();
      for (const std::string& part : one.Says)
      {
        check.Contains(errors, part, where + ": message");
      }
      std::size_t count = 0;
      for (std::size_t at = errors.find("ERROR:"); at != std::string::npos; at = errors.find("ERROR:", at + 1))
      {
        ++count;
      }
      check.Equal(count, std::size_t(1), where + ": one message");
      check.Equal(tried->GetErrorCode(), vtkErrorCode::UserError, where + ": the error code");
      if (scene.Image->GetNumberOfPoints() == 0)
      {
        check.Equal(tried->GetOutput()->GetNumberOfPoints(), 0, where + ": nothing to show");
      }
      else if (tried == fresh)
      {
        check.That(SameImage(tried->GetOutput(), scene.Image), where + ": the image as it is");
      }
      else
      {
        check.That(SameImage(tried->GetOutput(), shown), where + ": the last good volume");
        check.That(SameImage(tried->GetModelOutput(), shownModel), where + ": the last good model");
      }
      for (const std::string& part : one.Says)
      {
        check.Contains(ErrorOf(tried->GetOutput()), part, where + ": the volume says what is wrong");
        check.Contains(ErrorOf(tried->GetModelOutput()), part, where + ": the model says what is wrong");
      }
      tried->Update();
      check.Equal(events.TakeErrors(), std::string(), where + ": nothing is reported twice");

      Apply(good, tried);
      tried->Modified();
      tried->Update();
      check.Equal(events.TakeErrors(), std::string(), where + ": no error after recovery");
      check.Equal(ErrorOf(tried->GetOutput()), std::string(), where + ": none in the volume");
      check.Equal(tried->GetErrorCode(), vtkErrorCode::NoError, where + ": no error code after recovery");
      check.That(SameBits(tried->GetOutput()->GetPointData()->GetScalars(),
                   reference->GetOutput()->GetPointData()->GetScalars()),
        where + ": the volume after recovery");
      check.That(
        SameBits(Array(tried->GetModelOutput(), "Displacement"), Array(reference->GetModelOutput(), "Displacement")),
        where + ": the displacements after recovery");
      if (tried == filter && !one.OfTheEngine)
      {
        check.Equal(Field(filter->GetOutput(), "Milliseconds", UPLOAD), 0.0, where + ": nothing was built again");
        check.Equal(Field(filter->GetOutput(), "Milliseconds", RELAX), 0.0, where + ": nothing was deformed again");
      }
    }
  }

  // What a failed update of another image asked for is not asked of the next one.
  {
    vtkNew<vtkChainMailDeformation> moved;
    EventLog movedLog(moved);
    std::string complaints;
    vtkNew<vtkCallbackCommand> listen;
    listen->SetClientData(&complaints);
    listen->SetCallback([](vtkObject*, unsigned long, void* all, void* text)
      { *static_cast<std::string*>(all) += static_cast<const char*>(text); });
    Apply(good, moved);
    vtkNew<vtkImageData> elsewhere;
    elsewhere->SetExtent(-30, -20, 40, 50, 7, 19);
    moved->SetInputData(elsewhere);
    moved->Update();
    check.Contains(movedLog.TakeErrors(), "no active point scalars", "an image without scalars");
    moved->GetExecutive()->AddObserver(vtkCommand::ErrorEvent, listen);
    Apply(good, moved);
    for (const char* where : { "first update", "second update", "update of the model at rest" })
    {
      moved->Update(std::strcmp(where, "update of the model at rest") == 0 ? 1 : 0);
      check.Equal(complaints, std::string(), std::string("after it, ") + where);
      check.That(SameBits(moved->GetOutput()->GetPointData()->GetScalars(),
                   reference->GetOutput()->GetPointData()->GetScalars()),
        std::string("after it, ") + where + ": as if it had not been");
    }
  }

  // Not errors: data that has nothing to say.
  {
    vtkNew<vtkPolyData> nothing;
    vtkNew<vtkPolyData> points;
    vtkNew<vtkPoints> unused;
    unused->InsertNextPoint(notANumber, notANumber, notANumber);
    points->SetPoints(unused);
    vtkNew<vtkCellArray> vertices;
    vertices->InsertNextCell({ 0 });
    points->SetVerts(vertices);
    Apply(good, filter);
    filter->AddInputDataObject(1, nothing);
    filter->AddInputDataObject(2, nothing);
    filter->AddInputDataObject(2, points);
    // Cells with too few corners for a triangle.
    for (const bool strips : { false, true })
    {
      for (int corners = 0; corners < 3; ++corners)
      {
        vtkNew<vtkCellArray> cells;
        cells->InsertNextCell(corners);
        for (int c = 0; c < corners; ++c)
        {
          cells->InsertCellPoint(c);
        }
        vtkNew<vtkPolyData> degenerate;
        degenerate->SetPoints(good.Cuts->GetPoints());
        strips ? degenerate->SetStrips(cells) : degenerate->SetPolys(cells);
        filter->AddInputDataObject(2, degenerate);
        filter->AddInputDataObject(3, degenerate);
      }
    }
    filter->Update();
    check.Equal(log.TakeErrors(), std::string(), "empty probes and cuts, and cuts without polygons or corners");
    check.That(
      SameBits(filter->GetOutput()->GetPointData()->GetScalars(), reference->GetOutput()->GetPointData()->GetScalars()),
      "they change nothing");
    check.Equal(filter->GetOutput()->GetFieldData()->GetArray("ProbeReached")->GetNumberOfTuples(), 2, "two probes");
    filter->RemoveAllCarves();

    auto anchors = MakeProbes({ { { { 8.0, 2.0, 2.0 } }, {}, 1.0, true } });
    anchors->GetPointData()->RemoveArray("Displacement");
    Apply(good, filter);
    filter->AddInputDataObject(1, anchors);
    filter->Update();
    check.Equal(log.TakeErrors(), std::string(), "anchors need no displacement");

    auto bare = MakeProbes({ { { { 8.0, 2.0, 2.0 } }, { { 0.1, 0.0, 0.0 } } } });
    bare->GetPointData()->RemoveArray("Radius");
    bare->GetPointData()->RemoveArray("Anchor");
    filter->SetInputDataObject(1, bare);
    filter->Update();
    check.Equal(log.TakeErrors(), std::string(), "radius and anchor are optional");
    check.Near(Field(filter->GetOutput(), "ProbeReached"), 0.1, 1e-6, "a bare probe pulls");
  }

  // Scalars that are not finite: air, counted, warned about once.
  {
    Scene scene;
    Apply(scene, filter);
    vtkDataArray* scalars = scene.Image->GetPointData()->GetScalars();
    const vtkIdType some = scene.Image->vtkDataSet::FindPoint(11.0, 1.0, 6.0);
    scalars->SetTuple1(some, notANumber);
    scalars->SetTuple1(some + 10, infinity);
    scalars->SetTuple1(some + 20, -infinity);
    filter->SetTissueThreshold(notANumber); // fitted to the finite ones
    filter->SetMaterialFunction(nullptr);
    filter->Update();
    check.Equal(log.TakeErrors(), std::string(), "non-finite scalars are no error");
    check.Contains(log.TakeWarnings(), "3 voxels", "they are counted");
    for (int n = 0; n < 3; ++n)
    {
      check.Equal(Array(filter->GetModelOutput(), "Element")->GetTuple1(some + 10 * n), 0.0, "they are air");
    }
    check.Equal(Array(filter->GetModelOutput(), "Element")->GetTuple1(some + 1), 1.0, "their neighbours are not");
    Array(scene.Probes, "Displacement")->SetTuple3(0, 0.5, 0.0, 0.1);
    scene.Probes->Modified();
    filter->Update();
    check.Equal(log.TakeWarnings(), std::string(), "the warning comes once");
  }
  return check.Finish();
}
