// SPDX-License-Identifier: BSD-3-Clause
// Random inputs and settings for vtkChainMailDeformation, most of them bad:
//
//     FuzzDeformation SECONDS [SEED [SCENES]]
//
// plays scenes SEED, SEED + 1, ... for that long, or so many of them. A scene is a sequence of updates of one filter,
// each of which has to give either outputs that make sense or an error and no outputs; whatever it was, the filter then
// has to take a good scene and give the bits that a fresh filter gives. The number of a scene is printed before it is
// played, so that the last one printed is the one that crashed, or that the alarm ended because it hung.

#include "../Filters/FilterTest.h"
#include "../Unit/Random.h"

#include "vtkCellArray.h"
#include "vtkCellData.h"
#include "vtkLogger.h"
#include "vtkMatrix3x3.h"
#include "vtkOutputWindow.h"
#include "vtkSphereSource.h"
#include "vtkStringArray.h"
#include "vtkTrivialProducer.h"
#include "vtkUnstructuredGrid.h"
#include "vtkVariantArray.h"

#include <chrono>
#include <cstdint>
#include <limits>
#include <sys/time.h>

namespace
{

using namespace FilterTest;

constexpr time_t patience = 120; // [s] of processor time a scene may take, also where a sanitizer looks on

/// Ends the program, by SIGPROF, when it has used so much more processor time; 0: does not.
void SetAlarm(time_t seconds)
{
  const itimerval timer{ { 0, 0 }, { seconds, 0 } };
  setitimer(ITIMER_PROF, &timer, nullptr);
}

//------------------------------------------------------------------------------
/// Decisions, all from one number, some of them odd.
class Chance : public Random
{
public:
  using Random::Random;

  /// A number that nobody expects.
  double oddNumber()
  {
    using Limits = std::numeric_limits<double>;
    return this->of({ 0.0, -0.0, 1.0, -1.0, Limits::quiet_NaN(), Limits::infinity(), -Limits::infinity(), Limits::max(),
      Limits::lowest(), Limits::min(), Limits::denorm_min(), Limits::epsilon(), 1e-30, 1e30, -1e30, 0x1p31, -0x1p31,
      0x1p63, 1e-6, 255.0, 65536.0 });
  }

  /// From `low` to `high`, and rarely an odd one.
  double number(double low, double high) { return this->oneIn(40) ? this->oddNumber() : (*this)(low, high); }
};

/// Takes what other classes of VTK say about bad data.
class Silence : public vtkOutputWindow
{
public:
  static Silence* New() { return new Silence; }
  void DisplayText(const char*) override {}
};

//------------------------------------------------------------------------------
const std::initializer_list<const char*> arrayNames{ "Scan", "Fractions", "Labels", "vtkGhostType", "", "Words" };

vtkSmartPointer<vtkAbstractArray> RandomArray(Chance& chance, const char* name, vtkIdType tuples)
{
  const int type = chance.of({ VTK_FLOAT, VTK_FLOAT, VTK_SHORT, VTK_DOUBLE, VTK_UNSIGNED_CHAR, VTK_BIT, VTK_CHAR,
    VTK_SIGNED_CHAR, VTK_UNSIGNED_SHORT, VTK_INT, VTK_UNSIGNED_INT, VTK_LONG, VTK_UNSIGNED_LONG, VTK_LONG_LONG,
    VTK_UNSIGNED_LONG_LONG, VTK_ID_TYPE, VTK_STRING, VTK_VARIANT });
  auto array = vtkSmartPointer<vtkAbstractArray>::Take(vtkAbstractArray::CreateArray(type));
  array->SetName(chance.oneIn(30) ? nullptr : name);
  array->SetNumberOfComponents(chance.oneIn(4) ? chance.of({ 2, 3, 3, 4, 9 }) : 1);
  array->SetNumberOfTuples(chance.oneIn(20) ? chance.of({ vtkIdType(0), tuples / 2, tuples + 1 }) : tuples);
  const bool fractions = std::strcmp(name, "Fractions") == 0;
  const double low = fractions ? 0.0 : chance.number(-50.0, 50.0);
  const double high = fractions ? chance.of({ 0.3, 0.6, 0.99, 1.1 }) : chance.number(0.0, 500.0);
  const bool odd = chance.oneIn(5);
  const double limit = type == VTK_FLOAT || type == VTK_DOUBLE ? std::numeric_limits<double>::infinity() : 100.0;
  for (vtkIdType v = 0; v < array->GetNumberOfValues(); ++v)
  {
    const double value = odd && chance.oneIn(20) ? chance.oddNumber() : low + chance(0.0, 1.0) * (high - low);
    if (auto* numbers = vtkDataArray::SafeDownCast(array))
    {
      // Whole types take what fits into all of them: the conversion is the test's own.
      const bool fits = std::fabs(value) <= limit;
      numbers->SetComponent(v / array->GetNumberOfComponents(), static_cast<int>(v % array->GetNumberOfComponents()),
        limit < 1e9 ? (fits ? std::fabs(value) : limit) : value);
    }
    else
    {
      array->SetVariantValue(v, vtkVariant(vtkStdString(std::to_string(value))));
    }
  }
  return array;
}

vtkSmartPointer<vtkImageData> RandomImage(Chance& chance)
{
  auto image = vtkSmartPointer<vtkImageData>::New();
  int extent[6];
  for (int a = 0; a < 3; ++a)
  {
    const int size = chance.oneIn(8) ? chance.of({ 0, 1, 1, 40 }) : chance.between(2, 9);
    const int first = chance.oneIn(4) ? chance.of({ -7, 3, -2000000000, 2000000000 }) : 0;
    extent[2 * a] = first;
    extent[2 * a + 1] = first + size - 1;
  }
  image->SetExtent(extent);
  if (chance.oneIn(2))
  {
    image->SetSpacing(chance.number(0.1, 3.0), chance.number(0.1, 3.0), chance.number(0.1, 3.0));
    image->SetOrigin(chance.number(-50.0, 50.0), chance.number(-50.0, 50.0), chance.number(-50.0, 50.0));
  }
  if (chance.oneIn(4))
  {
    const double angle = chance(0.0, 6.3);
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    const double flip = chance.oneIn(2) ? -1.0 : 1.0;
    double matrix[9] = { c, -s, 0, s, c, 0, 0, 0, flip };
    if (chance.oneIn(4))
    {
      matrix[chance.below(9)] = chance.oddNumber();
    }
    image->SetDirectionMatrix(matrix);
  }
  const vtkIdType voxels = image->GetNumberOfPoints();
  for (const char* name : arrayNames)
  {
    if (std::strcmp(name, "Scan") == 0 ? !chance.oneIn(30) : chance.oneIn(3))
    {
      image->GetPointData()->AddArray(RandomArray(chance, name, voxels));
    }
  }
  if (!chance.oneIn(30))
  {
    image->GetPointData()->SetActiveScalars("Scan");
  }
  if (chance.oneIn(10))
  {
    image->GetCellData()->SetScalars(
      vtkDataArray::SafeDownCast(RandomArray(chance, "OfCells", image->GetNumberOfCells())));
  }
  if (chance.oneIn(10))
  {
    image->GetFieldData()->AddArray(RandomArray(chance, chance.of({ "Energy", "ProbeForce", "Note" }), 3));
  }
  return image;
}

/// Somewhere in or about the image.
void RandomPlace(Chance& chance, vtkImageData* image, double place[3])
{
  const double* bounds = image->GetBounds();
  for (int a = 0; a < 3; ++a)
  {
    const double margin = 0.1 * (bounds[2 * a + 1] - bounds[2 * a]);
    place[a] = chance.number(bounds[2 * a] - margin, bounds[2 * a + 1] + margin);
  }
}

vtkSmartPointer<vtkPoints> RandomPoints(Chance& chance, vtkImageData* image, int count)
{
  auto points = vtkSmartPointer<vtkPoints>::New();
  points->SetDataType(chance.of({ VTK_FLOAT, VTK_DOUBLE }));
  for (int n = 0; n < count; ++n)
  {
    double place[3];
    RandomPlace(chance, image, place);
    points->InsertNextPoint(place);
  }
  return points;
}

vtkSmartPointer<vtkPointSet> RandomProbes(Chance& chance, vtkImageData* image)
{
  vtkSmartPointer<vtkPointSet> probes;
  if (chance.oneIn(5))
  {
    probes = vtkSmartPointer<vtkUnstructuredGrid>::New();
  }
  else
  {
    probes = vtkSmartPointer<vtkPolyData>::New();
  }
  const int count = chance.below(5);
  if (!chance.oneIn(20))
  {
    probes->SetPoints(RandomPoints(chance, image, count));
  }
  const double reach = chance.of({ 0.5, 3.0, 30.0, 1e6 });
  const auto add = [&](const char* name, int components, double low, double high)
  {
    vtkSmartPointer<vtkAbstractArray> array;
    if (chance.oneIn(15))
    {
      array = RandomArray(chance, name, count);
    }
    else
    {
      auto numbers = vtkSmartPointer<vtkDoubleArray>::New();
      numbers->SetName(name);
      numbers->SetNumberOfComponents(components);
      numbers->SetNumberOfTuples(count);
      for (vtkIdType v = 0; v < numbers->GetNumberOfValues(); ++v)
      {
        numbers->SetValue(v, chance.number(low, high));
      }
      array = numbers;
    }
    probes->GetPointData()->AddArray(array);
  };
  if (!chance.oneIn(15))
  {
    add("Displacement", 3, -reach, reach);
  }
  if (chance.oneIn(2))
  {
    add("Radius", 1, 0.0, 4.0);
  }
  if (chance.oneIn(3))
  {
    add("Anchor", 1, chance.of({ 0.0, 1.0 }), 1.0);
  }
  if (chance.oneIn(4))
  {
    add("Tolerance", 1, 0.0, 4.0);
  }
  if (chance.oneIn(4))
  {
    add("Rotation", 3, -90.0, 90.0);
  }
  if (chance.oneIn(8))
  {
    add("Centre", 3, -reach, reach);
  }
  if (chance.oneIn(8))
  {
    add("Body", 1, chance.of({ -1.0, 1.0 }), chance.of({ -1.0, 2.0 }));
  }
  return probes;
}

/// A sphere, whole or with a hole, or polygons and strips of any points, most of them degenerate.
vtkSmartPointer<vtkPolyData> RandomSurface(Chance& chance, vtkImageData* image)
{
  auto surface = vtkSmartPointer<vtkPolyData>::New();
  const int kind = chance.below(10);
  if (kind < 4)
  {
    double centre[3];
    RandomPlace(chance, image, centre);
    vtkNew<vtkSphereSource> sphere;
    sphere->SetCenter(centre);
    sphere->SetRadius(std::fabs(chance.number(0.2, 5.0)));
    sphere->SetThetaResolution(chance.between(3, 12));
    sphere->SetPhiResolution(chance.between(3, 12));
    sphere->SetEndTheta(chance.oneIn(4) ? 200.0 : 360.0);
    sphere->SetOutputPointsPrecision(chance.of({ vtkAlgorithm::SINGLE_PRECISION, vtkAlgorithm::DOUBLE_PRECISION }));
    sphere->Update();
    surface->ShallowCopy(sphere->GetOutput());
    return surface;
  }
  if (kind == 4)
  {
    return surface; // empty
  }
  const int count = chance.between(1, 12);
  surface->SetPoints(RandomPoints(chance, image, count));
  vtkNew<vtkCellArray> polygons;
  vtkNew<vtkCellArray> strips;
  vtkNew<vtkCellArray> lines;
  for (int n = chance.below(8); n > 0; --n)
  {
    vtkCellArray* cells = chance.of({ polygons.Get(), polygons.Get(), strips.Get(), lines.Get() });
    const int corners = chance.of({ 0, 1, 2, 3, 3, 3, 4, 5, 8 });
    cells->InsertNextCell(corners);
    for (int c = 0; c < corners; ++c)
    {
      cells->InsertCellPoint(chance.below(count));
    }
  }
  surface->SetPolys(polygons);
  surface->SetStrips(strips);
  surface->SetLines(lines);
  return surface;
}

vtkSmartPointer<vtkPiecewiseFunction> RandomFunction(Chance& chance)
{
  auto function = vtkSmartPointer<vtkPiecewiseFunction>::New();
  for (int n = chance.below(5); n > 0; --n)
  {
    function->AddPoint(chance.number(-50.0, 500.0), chance.number(0.0, 0.95),
      chance.oneIn(5) ? chance.number(0, 1) : 0.5, chance.oneIn(5) ? chance.number(0, 1) : 0.0);
  }
  function->SetClamping(!chance.oneIn(5));
  return function;
}

//------------------------------------------------------------------------------
/// The good scene: tissue, bone, air, two probes, a cut and a carve.
struct Good
{
  vtkSmartPointer<vtkImageData> Image = MakeImage({ { 0, 9, 2, 9, 0, 6 } }, VTK_FLOAT);
  vtkSmartPointer<vtkPolyData> Probes = MakeProbes(
    { { { { 2.0, 5.0, 3.0 } }, { { 1.2, 0.4, 0.0 } }, 1.2 }, { { { 7.0, 6.0, 2.0 } }, { { -0.3, 0.0, 0.9 } } } });
  vtkSmartPointer<vtkPolyData> Cuts =
    MakeBlade({ { { { 4.6, 1.0, -1.0 } }, { { 4.6, 6.4, -1.0 } }, { { 4.6, 6.4, 9.0 } }, { { 4.6, 1.0, 9.0 } } } });
  vtkNew<vtkSphereSource> Carves;
  vtkSmartPointer<vtkPiecewiseFunction> Material = vtkSmartPointer<vtkPiecewiseFunction>::New();

  Good()
  {
    Fill(this->Image->GetPointData()->GetScalars(), this->Image,
      [](int i, int j, int k) { return i == 9 && j < 3 ? 0 : 50 + 40 * ((i + 2 * j + 3 * k) % 5); });
    this->Carves->SetCenter(2.2, 7.3, 4.1);
    this->Carves->SetRadius(1.3);
    this->Carves->Update();
    this->Material->AddPoint(50.0, 0.4);
    this->Material->AddPoint(200.0, 0.1);
    this->Material->AddPoint(210.0, 0.0);
  }

  void Apply(vtkChainMailDeformation* filter) const
  {
    filter->SetInputData(this->Image);
    filter->RemoveAllProbes();
    filter->RemoveAllCuts();
    filter->RemoveAllCarves();
    filter->SetInputDataObject(1, this->Probes);
    filter->SetInputDataObject(2, this->Cuts);
    filter->SetInputDataObject(3, this->Carves->GetOutput());
    filter->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS, vtkDataSetAttributes::SCALARS);
    filter->SetMaterialPreset(vtkChainMailDeformation::MATERIAL_FUNCTION);
    filter->SetMaterialFunction(this->Material);
    filter->SetConstraintArray("");
    filter->SetTissueThreshold(10.0);
    filter->SetAnchorRigid(false);
    filter->SetAnchoredFaces(1, 0, 0, 0, 0, 0);
    filter->SetModeToFromRest();
    filter->SetPropagationMethodToEnvelope();
    filter->SetPropagationIterations(0);
    filter->SetConflictPolicyToLimit();
    filter->SetPropagationTimes(true);
    filter->SetRelaxationMethodToProjected();
    filter->SetRelaxationPresetToCustom();
    filter->CoarseToFineOff();
    filter->RotationsOff();
    filter->SetPoissonRatio(0.0);
    filter->SetElasticRecovery(1.0);
    filter->SetRelaxationIterations(12);
    filter->SetRelaxationTolerance(0.0);
    filter->SetModelReduction(1);
    filter->SetInterpolationToLinear();
    filter->ClearLabelArrays();
    filter->SetBackgroundValue(-1.0);
    filter->SetOutputPadding(2);
    filter->SetOutputMagnification(1);
    filter->UseOutputBoundsOff();
    filter->SetDevice("");
    filter->SetBrickSize(0, 0, 0);
    filter->SetAbortExecute(0);
  }
};

/// All arrays of both outputs.
std::vector<vtkSmartPointer<vtkAbstractArray>> Results(vtkChainMailDeformation* filter)
{
  std::vector<vtkSmartPointer<vtkAbstractArray>> arrays;
  for (vtkImageData* output : { filter->GetOutput(), filter->GetModelOutput() })
  {
    for (int a = 0; a < output->GetPointData()->GetNumberOfArrays(); ++a)
    {
      auto copy = vtkSmartPointer<vtkAbstractArray>::Take(output->GetPointData()->GetAbstractArray(a)->NewInstance());
      copy->DeepCopy(output->GetPointData()->GetAbstractArray(a));
      arrays.push_back(copy);
    }
  }
  return arrays;
}

//------------------------------------------------------------------------------
/// Changes some settings.
void ChangeSettings(Chance& chance, vtkChainMailDeformation* filter, vtkImageData* image)
{
  const auto now = [&] { return chance.oneIn(6); };
  // An enumerated property; seldom a value that stands for nothing.
  const auto choice = [&](int last) {
    return chance.oneIn(20) ? chance.of({ -1, last + 1, VTK_INT_MAX }) : chance.between(0, last);
  };
  if (now())
  {
    filter->SetMaterialPreset(choice(2));
  }
  if (now())
  {
    filter->SetMaterialFunction(chance.oneIn(3) ? nullptr : RandomFunction(chance));
  }
  if (now())
  {
    filter->SetConstraintArray(chance.of({ "", "", "Fractions", "Scan", "Labels", "Words", "nowhere" }));
  }
  if (now())
  {
    filter->SetTissueThreshold(chance.number(-100.0, 200.0));
  }
  if (now())
  {
    filter->SetAnchorRigid(chance.oneIn(2));
    const auto face = [&] { return chance.of({ 0, 0, 1, -5 }); };
    const int faces[6] = { face(), face(), face(), face(), face(), face() };
    filter->SetAnchoredFaces(faces);
  }
  if (chance.oneIn(3))
  {
    filter->SetMode(choice(1));
  }
  if (now())
  {
    filter->SetPropagationMethod(choice(1));
  }
  if (now())
  {
    filter->SetPropagationIterations(chance.of({ 0, 1, 2, 7, -3, VTK_INT_MAX }));
  }
  if (now())
  {
    filter->SetConflictPolicy(choice(2));
  }
  if (now())
  {
    filter->SetPropagationTimes(chance.oneIn(2));
  }
  if (now())
  {
    filter->SetRelaxationMethod(choice(1));
  }
  if (now())
  {
    filter->SetRelaxationPreset(chance.oneIn(3) ? choice(3) : 0);
    filter->SetCoarseToFine(chance.oneIn(2));
    filter->SetRotations(chance.oneIn(3));
    filter->SetPoissonRatio(chance.oneIn(2) ? chance.number(-0.2, 0.6) : 0.0);
  }
  if (now())
  {
    filter->SetElasticRecovery(chance.number(-0.2, 1.2));
  }
  if (now())
  {
    filter->SetRelaxationIterations(chance.of({ 0, 1, 5, 40, -1, VTK_INT_MIN }));
  }
  if (now())
  {
    filter->SetRelaxationTolerance(chance.number(0.0, 0.1));
    filter->SetRelaxationError(chance.oneIn(3) ? chance.number(0.0, 0.1) : 0.0);
  }
  if (now())
  {
    filter->SetModelReduction(
      chance.oneIn(6) ? chance.of({ 0, 3, -2, 16, VTK_INT_MIN, VTK_INT_MAX }) : chance.of({ 1, 2, 2, 4, 8 }));
  }
  if (now())
  {
    filter->SetInterpolation(choice(1));
  }
  if (now())
  {
    filter->ClearLabelArrays();
    filter->AddLabelArray(chance.of({ "Labels", "Scan", "Words", "nowhere", "" }));
  }
  if (now())
  {
    filter->SetBackgroundValue(chance.oddNumber());
  }
  if (now())
  {
    // A padding that nobody's memory holds must be an error; one that just fits would take the machine's.
    const bool line = image->GetNumberOfPoints() > 0 && image->GetDataDimension() < 2;
    filter->SetOutputPadding(line ? chance.of({ 0, 5, 4096, VTK_INT_MAX }) : chance.of({ -2, 0, 0, 1, 3, 12 }));
  }
  if (now())
  {
    filter->SetOutputMagnification(chance.of({ -1, 1, 1, 2, 3, 9 }));
    filter->SetUseOutputBounds(chance.oneIn(3));
    double bounds[6];
    for (double& bound : bounds)
    {
      bound = chance.oneIn(8) ? chance.oddNumber() : chance.of({ -20.0, -3.0, 0.0, 2.0, 5.0, 11.0, 60.0 });
    }
    filter->SetOutputBounds(bounds);
  }
  if (chance.oneIn(30))
  {
    filter->SetDevice("no such device");
  }
  else if (now())
  {
    filter->SetDevice("");
  }
  if (now())
  {
    filter->SetBrickSize(
      chance.of({ 0, 4, 8, 16, 5, -4 }), chance.of({ 0, 2, 4, 16, 1 }), chance.of({ 0, 2, 8, 4, VTK_INT_MAX }));
  }
  if (now())
  {
    filter->SetInputArrayToProcess(0, 0, 0,
      chance.of({ vtkDataObject::FIELD_ASSOCIATION_POINTS, vtkDataObject::FIELD_ASSOCIATION_POINTS,
        vtkDataObject::FIELD_ASSOCIATION_CELLS, vtkDataObject::FIELD_ASSOCIATION_NONE }),
      chance.of({ "Scan", "Scan", "Fractions", "Words", "OfCells", "nowhere" }));
  }
  if (chance.oneIn(10))
  {
    filter->Reset();
  }
}

class Player
{
public:
  Player()
  {
    vtkNew<vtkChainMailDeformation> fresh;
    EventLog log(fresh);
    this->Scene.Apply(fresh);
    fresh->Update();
    const std::string errors = log.TakeErrors();
    if (!errors.empty())
    {
      throw std::runtime_error("the good scene fails: " + errors);
    }
    this->Expected = Results(fresh);
  }

  void Play(std::uint64_t number)
  {
    Chance chance(number);
    vtkNew<vtkChainMailDeformation> filter;
    EventLog log(filter);
    int executiveErrors = 0;
    vtkNew<vtkCallbackCommand> count;
    count->SetClientData(&executiveErrors);
    count->SetCallback([](vtkObject*, unsigned long, void* errors, void*) { ++*static_cast<int*>(errors); });
    filter->GetExecutive()->AddObserver(vtkCommand::ErrorEvent, count);
    int progressLeft = -1;
    vtkNew<vtkCallbackCommand> stop;
    stop->SetClientData(&progressLeft);
    stop->SetCallback(
      [](vtkObject* caller, unsigned long, void* left, void*)
      {
        if ((*static_cast<int*>(left))-- == 0)
        {
          static_cast<vtkAlgorithm*>(caller)->SetAbortExecute(1);
        }
      });
    filter->AddObserver(vtkCommand::ProgressEvent, stop);

    this->Scene.Apply(filter);
    vtkSmartPointer<vtkImageData> image = this->Scene.Image;
    for (int step = chance.between(1, 8); step > 0; --step)
    {
      if (chance.oneIn(3))
      {
        image = RandomImage(chance);
        filter->SetInputData(image);
      }
      const int port = chance.below(5); // 4: none
      if (port == 1)
      {
        filter->RemoveAllProbes();
      }
      for (int n = chance.below(3); port >= 1 && port <= 3 && n > 0; --n)
      {
        if (port == 1)
        {
          filter->AddInputDataObject(port, RandomProbes(chance, image));
        }
        else
        {
          filter->AddInputDataObject(port, RandomSurface(chance, image));
        }
      }
      if (chance.oneIn(5))
      {
        filter->RemoveAllCuts();
      }
      if (chance.oneIn(5))
      {
        filter->RemoveAllCarves();
      }
      ChangeSettings(chance, filter, image);
      progressLeft = chance.oneIn(12) ? chance.below(12) : -1;

      filter->Update();
      const bool failed = !log.TakeErrors().empty() || executiveErrors > 0;
      const bool stopped = filter->GetAbortExecute() != 0;
      log.TakeWarnings();
      executiveErrors = 0;
      progressLeft = -1;
      filter->SetAbortExecute(0);
      this->Check(filter, image, failed, stopped);
      if (failed && chance.oneIn(3))
      {
        this->Recover(filter, log, executiveErrors);
        image = this->Scene.Image;
      }
    }
    this->Recover(filter, log, executiveErrors);
  }

private:
  static void Require(bool holds, const std::string& what)
  {
    if (!holds)
    {
      throw std::runtime_error(what);
    }
  }

  void Check(vtkChainMailDeformation* filter, vtkImageData* image, bool failed, bool stopped)
  {
    vtkImageData* volume = filter->GetOutput();
    vtkImageData* model = filter->GetModelOutput();
    const bool empty =
      volume->GetPointData()->GetNumberOfArrays() == 0 && model->GetPointData()->GetNumberOfArrays() == 0;
    const bool says = !ErrorOf(volume).empty(); // also later, as the pipeline does not ask a second time
    if (failed || says || image->GetNumberOfPoints() == 0)
    {
      Require(empty || says, "an update that failed has outputs that do not say so");
      return;
    }
    if (stopped && empty)
    {
      return;
    }
    const int reduction = filter->GetModelReduction();
    Require(reduction == 1 || reduction == 2 || reduction == 4 || reduction == 8,
      "a reduction of the model that there is not was no error");
    // A wish to stop that comes after the last question whether to is too late: then the outputs are complete.
    Require(model->GetNumberOfPoints() == image->GetNumberOfPoints(), "the model is not on the image's grid");
    vtkPointData* in = image->GetPointData();
    vtkPointData* out = volume->GetPointData();
    Require(in->GetNumberOfArrays() == out->GetNumberOfArrays(), "an array is missing");
    for (int a = 0; a < in->GetNumberOfArrays(); ++a)
    {
      vtkAbstractArray* before = in->GetAbstractArray(a);
      vtkAbstractArray* after = out->GetAbstractArray(a);
      Require(before->GetDataType() == after->GetDataType() &&
                before->GetNumberOfComponents() == after->GetNumberOfComponents() &&
                after->GetNumberOfTuples() == volume->GetNumberOfPoints(),
        "an array changed its type, components or number of tuples");
    }
    vtkDataArray* displacement = model->GetPointData()->GetArray("Displacement");
    Require(displacement != nullptr, "there is no Displacement");
    for (vtkIdType v = 0; v < displacement->GetNumberOfTuples(); ++v)
    {
      for (int c = 0; c < 3; ++c)
      {
        Require(!std::isnan(displacement->GetComponent(v, c)), "a displacement is not a number");
      }
    }
    Require(!std::isnan(Field(volume, "MaxLinkExcess")), "MaxLinkExcess is not a number");
  }

  void Recover(vtkChainMailDeformation* filter, EventLog& log, const int& executiveErrors)
  {
    this->Scene.Apply(filter);
    filter->Update();
    filter->Update(); // as every view does that shows it
    const std::string errors = log.TakeErrors();
    Require(errors.empty(), "a good scene fails: " + errors);
    Require(executiveErrors == 0, "a good scene is refused by the pipeline");
    const auto results = Results(filter);
    Require(results.size() == this->Expected.size(), "a good scene has other arrays than from a fresh filter");
    for (std::size_t a = 0; a < results.size(); ++a)
    {
      Require(SameBits(results[a], this->Expected[a]),
        std::string("a good scene differs from that of a fresh filter: ") + results[a]->GetName());
    }
  }

  Good Scene;
  std::vector<vtkSmartPointer<vtkAbstractArray>> Expected;
};

}

int main(int argc, char* argv[])
{
  if (argc < 2)
  {
    std::cerr << "FuzzDeformation SECONDS [SEED [SCENES]]\n";
    return EXIT_FAILURE;
  }
  const double seconds = std::atof(argv[1]);
  std::uint64_t seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
  const long scenes = argc > 3 ? std::atol(argv[3]) : std::numeric_limits<long>::max();
  vtkNew<Silence> silence;
  vtkOutputWindow::SetInstance(silence);
  vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);

  const auto start = std::chrono::steady_clock::now();
  long played = 0;
  try
  {
    Player player;
    for (; played < scenes; ++played, ++seed)
    {
      const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
      if (elapsed.count() > seconds)
      {
        break;
      }
      std::cout << "scene " << seed << std::endl;
      SetAlarm(patience);
      player.Play(seed);
    }
  }
  catch (const std::exception& error)
  {
    std::cerr << "FAILED: " << error.what() << "\nOnce more: FuzzDeformation 60 " << seed << " 1\n";
    return EXIT_FAILURE;
  }
  SetAlarm(0);
  std::cout << played << " scenes played\n";
  return EXIT_SUCCESS;
}
