// SPDX-License-Identifier: BSD-3-Clause
// MODE_INTERACTIVE: the state is kept between updates, and only what changed is applied, at the current deformation. On
// a bar of elements a small oracle, which follows the documented rules and shares no code with the engine, says where
// every element has to be after every step.

#include "FilterTest.h"

#include "vtkFloatArray.h"

#include <algorithm>
#include <fstream>
#include <limits>
#include <unistd.h>

using namespace FilterTest;

namespace
{

// All lengths below are multiples of 1/16, so float arithmetic is exact and results are compared exactly.
const int length = 32;
const double limit = 0.375;
const double infinity = std::numeric_limits<double>::infinity();

/// A free bar of elements along x, 1 apart, with links of one limit.
class Bar
{
public:
  std::array<double, length> U{};
  std::array<bool, length> Present;
  std::array<bool, length> Linked; // element i to i + 1

  Bar()
  {
    this->Present.fill(true);
    this->Linked.fill(true);
  }

  double Place(int i) const { return i + this->U[i]; }

  /// The element that a probe of radius 0 grabs.
  int Nearest(double x) const
  {
    int nearest = -1;
    for (int i = 0; i < length; ++i)
    {
      if (this->Present[i] && (nearest < 0 || std::fabs(this->Place(i) - x) < std::fabs(this->Place(nearest) - x)))
      {
        nearest = i;
      }
    }
    return nearest;
  }

  void Move(int held, double to)
  {
    for (int step : { -1, 1 })
    {
      double distance = 0.0;
      for (int i = held; i >= 0 && i < length; i += step, distance += limit)
      {
        this->U[i] = std::min(std::max(this->U[i], to - distance), to + distance);
        const int next = i + step;
        if (next < 0 || next >= length || !this->Present[next] || !this->Linked[std::min(i, next)])
        {
          break;
        }
      }
    }
  }

  int Cut(double x)
  {
    int count = 0;
    for (int i = 0; i + 1 < length; ++i)
    {
      const bool crosses = (this->Place(i) < x) != (this->Place(i + 1) < x);
      count += crosses && this->Linked[i];
      this->Linked[i] = this->Linked[i] && !crosses;
    }
    return count;
  }

  int Carve(double from, double to)
  {
    int count = 0;
    for (int i = 0; i < length; ++i)
    {
      const bool inside = this->Place(i) > from && this->Place(i) < to;
      count += inside && this->Present[i];
      this->Present[i] = this->Present[i] && !inside;
    }
    return count;
  }
};

vtkSmartPointer<vtkPolyData> Knife(double x)
{
  return MakeBlade({ { { { x, -2.0, -2.0 } }, { { x, 2.0, -2.0 } }, { { x, 2.0, 2.0 } }, { { x, -2.0, 2.0 } } } });
}

/// The sides of a box, closed unless one is left out.
vtkSmartPointer<vtkPolyData> Box(double from, double to, bool closed = true)
{
  auto data = vtkSmartPointer<vtkPolyData>::New();
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (int corner = 0; corner < 8; ++corner)
  {
    points->InsertNextPoint(corner & 1 ? to : from, corner & 2 ? 2.0 : -2.0, corner & 4 ? 2.0 : -2.0);
  }
  const vtkIdType sides[6][4] = { { 0, 4, 6, 2 }, { 1, 3, 7, 5 }, { 0, 1, 5, 4 }, { 2, 6, 7, 3 }, { 0, 2, 3, 1 },
    { 4, 5, 7, 6 } };
  vtkNew<vtkCellArray> polygons;
  for (int side = closed ? 0 : 1; side < 6; ++side)
  {
    polygons->InsertNextCell(4, sides[side]);
  }
  data->SetPoints(points);
  data->SetPolys(polygons);
  return data;
}

vtkDataArray* Array(vtkDataSet* data, const char* name)
{
  return data->GetPointData()->GetArray(name);
}

/// A bar in world space, and a filter that works on it.
struct Bench
{
  vtkSmartPointer<vtkImageData> Image = MakeImage({ { 0, length - 1, 0, 0, 0, 0 } });
  vtkNew<vtkChainMailDeformation> Filter;
  EventLog Log{ Filter };

  Bench()
  {
    Fill(this->Image->GetPointData()->GetScalars(), this->Image, [](int i, int, int) { return 10 + i; });
    this->Filter->SetInputData(this->Image);
    this->Filter->SetMaterialFunction(ConstantMaterial(limit));
    this->Filter->SetTissueThreshold(0.0);
    this->Filter->SetAnchoredFaces(0, 0, 0, 0, 0, 0);
    this->Filter->SetRelaxationIterations(0);
    this->Filter->PropagationTimesOn();
    this->Filter->SetModeToInteractive();
  }

  void Probe(double x, double displacement)
  {
    this->Filter->SetInputDataObject(1, MakeProbes({ { { { x, 0.0, 0.0 } }, { { displacement, 0.0, 0.0 } } } }));
  }

  double Displacement(int i) { return Array(this->Filter->GetModelOutput(), "Displacement")->GetComponent(i, 0); }

  /// Updates and compares with the oracle.
  void Expect(Checks& check, const Bar& bar, const std::string& where)
  {
    this->Filter->Update();
    check.Equal(this->Log.TakeErrors(), std::string(), where + ": no error");
    if (this->Filter->GetModelOutput()->GetNumberOfPoints() != length)
    {
      check.That(false, where + ": there is a model");
      return;
    }
    for (int i = 0; i < length; ++i)
    {
      const std::string element = where + ": element " + std::to_string(i);
      check.Equal(Array(this->Filter->GetModelOutput(), "Element")->GetTuple1(i), bar.Present[i] ? 1.0 : 0.0,
        element + " is there");
      check.Equal(this->Displacement(i), bar.Present[i] ? bar.U[i] : 0.0, element);
    }
  }
};

/// Drags, cuts and carves, one after the other.
void TestSteps(Checks& check)
{
  Bench bench;
  Bar bar;
  vtkChainMailDeformation* filter = bench.Filter;

  // Dragged to and fro: what it passed stays where the way back does not reach it.
  bench.Probe(8.0, 3.0);
  bar.Move(8, 3.0);
  bench.Expect(check, bar, "drag");
  bench.Probe(8.0, -2.0);
  bar.Move(8, -2.0);
  bench.Expect(check, bar, "drag back");
  bench.Probe(8.0, 2.5);
  bar.Move(8, 2.5);
  bench.Expect(check, bar, "and again");
  check.Equal(Field(filter->GetOutput(), "ProbeReached"), 2.5, "reached, counted from where it grabbed");
  check.Equal(Array(filter->GetModelOutput(), "Wavefront")->GetTuple1(8), 3.0, "the third wave");
  {
    vtkNew<vtkChainMailDeformation> fromRest;
    fromRest->SetInputData(bench.Image);
    fromRest->SetMaterialFunction(ConstantMaterial(limit));
    fromRest->SetTissueThreshold(0.0);
    fromRest->SetAnchoredFaces(0, 0, 0, 0, 0, 0);
    fromRest->SetRelaxationIterations(0);
    fromRest->SetInputDataObject(1, MakeProbes({ { { { 8.0, 0.0, 0.0 } }, { { 2.5, 0.0, 0.0 } } } }));
    fromRest->Update();
    check.That(
      !SameBits(Array(fromRest->GetModelOutput(), "Displacement"), Array(filter->GetModelOutput(), "Displacement")),
      "from rest the tissue would be elsewhere");
  }

  // Nothing changed: nothing moves.
  filter->Modified();
  bench.Expect(check, bar, "again");

  // A knife finds the tissue where it is now: at rest it would have cut the link after element 12.
  const double knife = 12.53125;
  filter->SetInputDataObject(2, Knife(knife));
  check.Equal(bar.Cut(knife), 1, "the knife crosses one link");
  check.That(bar.Linked[12] && !bar.Linked[11], "another link than at rest");
  bench.Expect(check, bar, "cut");
  bench.Probe(8.0, -1.0);
  bar.Move(8, -1.0);
  bench.Expect(check, bar, "the far side stays");

  // The knife is still there, but has cut already: tissue goes through it whole.
  bench.Probe(8.0, 6.0);
  bar.Move(8, 6.0);
  bench.Expect(check, bar, "through the resting knife");
  bench.Probe(8.0, 0.0);
  bar.Move(8, 0.0);
  bench.Expect(check, bar, "and back whole");

  // Moved, it cuts again; removed, nothing changes; connected again, it cuts what is there now.
  filter->SetInputDataObject(2, Knife(5.28125));
  check.Equal(bar.Cut(5.28125), 1, "the moved knife crosses one link");
  bench.Probe(8.0, 1.0);
  bar.Move(8, 1.0);
  bench.Expect(check, bar, "moved knife");
  filter->RemoveAllCuts();
  bench.Probe(8.0, -4.0);
  bar.Move(8, -4.0);
  bench.Expect(check, bar, "no knife");
  filter->SetInputDataObject(2, Knife(5.28125));
  check.Equal(bar.Cut(5.28125), 1, "the same knife crosses another link");
  bench.Probe(8.0, -3.0);
  bar.Move(8, -3.0);
  check.Equal(bench.Log.TakeWarnings(), std::string(), "no warnings");
  bench.Expect(check, bar, "knife back");
  check.Contains(bench.Log.TakeWarnings(), "Cuts input 0 is back where it was before", "Undo would look the same");

  // Another knife beside it, and the order of the two, do not make the first cut again.
  bench.Probe(8.0, -5.0);
  bar.Move(8, -5.0);
  bench.Expect(check, bar, "before the second knife");
  filter->SetInputDataObject(2, Knife(25.28125));
  filter->AddInputDataObject(2, Knife(5.28125));
  check.Equal(bar.Cut(25.28125), 1, "the second knife");
  bench.Probe(8.0, -2.0);
  bar.Move(8, -2.0);
  bench.Expect(check, bar, "second knife");

  // Letting go leaves the tissue where it is; another probe grabs what is there now and counts from there.
  filter->RemoveAllProbes();
  bench.Expect(check, bar, "released");
  const int held = bar.Nearest(19.25);
  bench.Probe(19.25, 1.5);
  bar.Move(held, bar.U[held] + 1.5);
  bench.Expect(check, bar, "grabbed elsewhere");
  check.Equal(Field(filter->GetOutput(), "ProbeReached"), 1.5, "reached since it grabbed");
  const int displaced = bar.Nearest(8.0);
  check.That(displaced != 8, "another element is at the first place now");
  bench.Probe(8.0, 0.5);
  bar.Move(displaced, bar.U[displaced] + 0.5);
  bench.Expect(check, bar, "grabbed where tissue was displaced");

  // Carved where it is now. What is gone holds nothing together and is shown no more.
  check.That(bar.Carve(18.03125, 20.03125) > 0, "the box holds elements");
  filter->SetInputDataObject(3, Box(18.03125, 20.03125));
  bench.Expect(check, bar, "carved");
  filter->Modified();
  bench.Expect(check, bar, "not twice");
  const int beside = bar.Nearest(17.0);
  bench.Probe(17.0, -3.0);
  bar.Move(beside, bar.U[beside] - 3.0);
  bench.Expect(check, bar, "carved tissue holds nothing together");
  check.Equal(bar.Carve(23.03125, 24.53125) > 0, true, "the moved box holds more");
  filter->SetInputDataObject(3, Box(23.03125, 24.53125));
  bench.Expect(check, bar, "box moved");
  filter->RemoveAllCarves();
  bench.Expect(check, bar, "box removed");

  // Reset: the input, bit for bit, whatever is connected.
  filter->SetInputDataObject(3, Box(3.03125, 5.03125));
  filter->Reset();
  check.That(filter->GetNeedsUpdate(), "there is something to do after Reset()");
  bar = Bar();
  bench.Expect(check, bar, "reset");
  check.That(SameBits(Array(filter->GetOutput(), "Scan"), Array(bench.Image, "Scan")), "reset: the input's bits");
  check.Equal(Field(filter->GetOutput(), "ProbeReached"), 0.0, "reset: the probe holds nothing");
  check.Equal(Field(filter->GetOutput(), "Energy"), 0.0, "reset: no energy");
  check.Equal(Array(filter->GetModelOutput(), "Wavefront")->GetTuple1(17), 0.0, "reset: no wave came");
  check.Equal(Array(filter->GetModelOutput(), "PropagationTime")->GetTuple1(17), -1.0, "reset: none at no time");
  check.That(!filter->GetNeedsUpdate(), "reset: tissue at rest has settled");
  filter->Modified();
  bench.Expect(check, bar, "what is connected counts as seen");
  bench.Probe(17.0, -2.0);
  bar.Move(17, -2.0);
  bench.Expect(check, bar, "a probe that moves acts again, in whole tissue");
  filter->SetInputDataObject(3, Box(3.03125, 6.03125));
  check.Equal(bar.Carve(3.03125, 6.03125), 3, "the changed box holds three elements");
  bench.Expect(check, bar, "and a box that changes");
  check.Equal(bench.Log.TakeWarnings(), std::string(), "no other warnings");
}

/// Anything in any order.
void TestRandomSteps(Checks& check)
{
  for (unsigned seed = 1; seed <= 6; ++seed)
  {
    Noise noise(seed);
    const auto between = [&](double low, double high)
    { return std::round((low + (high - low) * noise.Uniform()) * 8.0) / 8.0; };
    Bench bench;
    Bar bar;
    double grip = 10.0;
    double base = 0.0; // displacement of the held element when it was grabbed
    int held = 10;
    double displacement = 0.0;
    bench.Probe(grip, displacement);
    bench.Expect(check, bar, "start");
    for (int step = 0; step < 60; ++step)
    {
      const std::string where = "seed " + std::to_string(seed) + ", step " + std::to_string(step);
      const double choice = noise.Uniform();
      if (choice < 0.15)
      {
        // Links are cut before the probe moves. A 32nd is no place of any element.
        const double x = between(0.0, length) + 1.0 / 32.0;
        bar.Cut(x);
        bench.Filter->SetInputDataObject(2, Knife(x));
      }
      else if (choice < 0.2)
      {
        const double x = between(0.0, length) + 1.0 / 32.0;
        const Bar before = bar;
        if (bar.Carve(x, x + 1.0) > 0 && !bar.Present[held])
        {
          bar = before; // its own tissue is another test's
        }
        else
        {
          bench.Filter->SetInputDataObject(3, Box(x, x + 1.0));
        }
      }
      else if (choice < 0.3)
      {
        // Where tissue lies on itself, which one is nearest is another test's.
        const int element = static_cast<int>(noise.Uniform() * length);
        const double place = bar.Place(element);
        int there = 0;
        for (int i = 0; i < length; ++i)
        {
          there += bar.Present[i] && bar.Place(i) == place;
        }
        if (bar.Present[element] && there == 1 && place != grip)
        {
          grip = place;
          held = element;
          base = bar.U[held];
        }
      }
      if (choice >= 0.2)
      {
        displacement = between(-4.0, 4.0);
      }
      bench.Probe(grip, displacement);
      bar.Move(held, base + displacement);
      bench.Expect(check, bar, where);
    }
  }
}

/// A block that is pulled, with relaxation.
struct Block
{
  vtkSmartPointer<vtkImageData> Image = MakeImage({ { 0, 11, 0, 9, 0, 8 } }, VTK_FLOAT);
  vtkSmartPointer<vtkPiecewiseFunction> Material = vtkSmartPointer<vtkPiecewiseFunction>::New();
  vtkSmartPointer<vtkPolyData> Knife = MakeBlade(
    { { { { 7.53, -1.0, -1.0 } }, { { 7.53, 5.3, -1.0 } }, { { 7.53, 5.3, 9.0 } }, { { 7.53, -1.0, 9.0 } } } });

  Block()
  {
    Noise noise(3);
    Fill(
      this->Image->GetPointData()->GetScalars(), this->Image, [&](int, int, int) { return 100.0 * noise.Uniform(); });
    this->Material->AddPoint(0.0, 0.4);
    this->Material->AddPoint(100.0, 0.1);
  }

  void Connect(vtkChainMailDeformation* filter)
  {
    filter->SetInputData(this->Image);
    filter->SetInputDataObject(2, this->Knife);
    filter->SetMaterialFunction(this->Material);
    filter->SetTissueThreshold(5.0);
    filter->SetRelaxationIterations(10);
  }
};

vtkSmartPointer<vtkPolyData> Pull(double x, double y, double z)
{
  return MakeProbes({ { { { 5.0, 4.0, 4.0 } }, { { x, y, z } }, 1.0 } });
}

bool SameOutputs(vtkChainMailDeformation* a, vtkChainMailDeformation* b)
{
  bool same = a->GetOutput()->GetNumberOfPoints() > 0;
  for (int port : { 0, 1 })
  {
    vtkPointData* ofA = vtkImageData::SafeDownCast(a->GetOutputDataObject(port))->GetPointData();
    vtkPointData* ofB = vtkImageData::SafeDownCast(b->GetOutputDataObject(port))->GetPointData();
    same = same && ofA->GetNumberOfArrays() == ofB->GetNumberOfArrays();
    for (int n = 0; same && n < ofA->GetNumberOfArrays(); ++n)
    {
      same = SameBits(ofA->GetAbstractArray(n), ofB->GetAbstractArray(ofA->GetArrayName(n)));
    }
  }
  return same;
}

/// Tissue settles over several updates, and then asks for no more.
void TestSettling(Checks& check)
{
  Block block;
  vtkNew<vtkChainMailDeformation> filter;
  block.Connect(filter);
  filter->SetModeToInteractive();
  filter->SetRelaxationIterations(5);
  filter->SetRelaxationTolerance(1e-4);
  filter->SetInputDataObject(1, Pull(1.25, 0.5, -0.75));
  filter->Update();
  int updates = 1;
  double energy = Field(filter->GetOutput(), "Energy");
  bool falls = true;
  int iterations = static_cast<int>(Field(filter->GetOutput(), "RelaxationIterationsUsed"));
  for (; filter->GetNeedsUpdate() && updates < 500; ++updates)
  {
    filter->Update();
    const double now = Field(filter->GetOutput(), "Energy");
    falls = falls && now <= energy * (1.0 + 1e-6); // rounding of a sum of some thousand floats
    energy = now;
    iterations += static_cast<int>(Field(filter->GetOutput(), "RelaxationIterationsUsed"));
  }
  check.That(updates > 3 && updates < 500, "settled after " + std::to_string(updates) + " updates");
  check.That(falls, "the energy never rises");
  check.That(Field(filter->GetOutput(), "MaxLinkExcess") <= 1e-5, "within the limits");
  const vtkMTimeType time = filter->GetOutput()->GetMTime();
  filter->Update();
  check.That(filter->GetOutput()->GetMTime() == time, "settled: Update() has nothing to do");
  filter->Modified();
  filter->Update();
  check.That(Field(filter->GetOutput(), "RelaxationIterationsUsed") >= 1.0, "Modified() makes it go on");
  check.Near(Field(filter->GetOutput(), "Energy"), energy, 1e-3 * energy, "with little left to gain");

  // The same tissue from rest, in one go. Both end within 1 % of the optimum: the tolerance is 1e-4 of the spacing.
  vtkNew<vtkChainMailDeformation> fromRest;
  block.Connect(fromRest);
  fromRest->SetRelaxationIterations(2000);
  fromRest->SetRelaxationTolerance(1e-4);
  fromRest->SetInputDataObject(1, Pull(1.25, 0.5, -0.75));
  fromRest->Update();
  check.Near(energy, Field(fromRest->GetOutput(), "Energy"), 0.01 * energy, "as from rest");
  check.That(!fromRest->GetNeedsUpdate(), "from rest nothing is ever left to do");
  check.That(iterations <= 4 * Field(fromRest->GetOutput(), "RelaxationIterationsUsed"),
    "in steps of 5 it takes " + std::to_string(iterations) + " iterations, not many more than in one go");

  // Released: elastic tissue goes back to rest, held by the faces of the image.
  filter->RemoveAllProbes();
  filter->Update();
  for (updates = 0; filter->GetNeedsUpdate() && updates < 500; ++updates)
  {
    filter->Update();
  }
  check.That(updates > 3 && updates < 500, "back at rest after " + std::to_string(updates) + " updates");
  check.That(Field(filter->GetOutput(), "Energy") < 1e-3 * energy, "released tissue goes back");

  // Plastic tissue stays.
  filter->SetElasticRecovery(0.0);
  filter->SetInputDataObject(1, Pull(1.25, 0.5, -0.75));
  filter->Update();
  const double reached = Field(filter->GetOutput(), "ProbeReached");
  check.That(reached > 0.5, "plastic tissue is pulled");
  vtkSmartPointer<vtkDataArray> before = Array(filter->GetModelOutput(), "Displacement");
  filter->RemoveAllProbes();
  filter->Update();
  double moved = 0.0;
  for (vtkIdType v = 0; v < before->GetNumberOfValues(); ++v)
  {
    moved = std::max(moved, std::fabs(before->GetVariantValue(v).ToDouble() -
                                      Array(filter->GetModelOutput(), "Displacement")->GetVariantValue(v).ToDouble()));
  }
  // A link at its limit, and what float rounding makes of it.
  check.That(moved <= 1e-5, "plastic tissue stays where it was pulled; it moved by " + std::to_string(moved));
  check.That(!filter->GetNeedsUpdate(), "and has settled at once");
}

/// A wave that takes several updates.
void TestWaves(Checks& check)
{
  Block block;
  for (int method : { vtkChainMailDeformation::PROPAGATION_ENVELOPE, vtkChainMailDeformation::PROPAGATION_TIMESTAMP })
  {
    const std::string where = method == vtkChainMailDeformation::PROPAGATION_ENVELOPE ? "envelope: " : "timestamp: ";
    vtkNew<vtkChainMailDeformation> whole;
    vtkNew<vtkChainMailDeformation> stepwise;
    for (vtkChainMailDeformation* filter : { whole.Get(), stepwise.Get() })
    {
      block.Connect(filter);
      filter->SetModeToInteractive();
      filter->SetPropagationMethod(method);
      filter->SetRelaxationIterations(0);
      filter->SetBrickSize(4, 2, 2); // so that an iteration does not see everything
      filter->SetInputDataObject(1, Pull(2.25, 0.5, -0.75));
    }
    whole->Update();
    check.That(!whole->GetNeedsUpdate(), where + "a wave that has ended needs no more");
    check.That(Field(whole->GetOutput(), "PropagationIterationsUsed") > 1.0, where + "it took some iterations");
    stepwise->SetPropagationIterations(1);
    stepwise->Update();
    check.That(stepwise->GetNeedsUpdate(), where + "after one iteration the wave is under way");
    check.That(!SameOutputs(whole, stepwise), where + "and not everywhere");
    int updates = 1;
    int iterations = static_cast<int>(Field(stepwise->GetOutput(), "PropagationIterationsUsed"));
    for (; stepwise->GetNeedsUpdate() && updates < 200; ++updates)
    {
      stepwise->Update();
      const int used = static_cast<int>(Field(stepwise->GetOutput(), "PropagationIterationsUsed"));
      check.That(used <= 1, where + "one iteration an update");
      iterations += used;
    }
    check.That(updates < 200, where + "the wave ends");
    check.Near(iterations, Field(whole->GetOutput(), "PropagationIterationsUsed"), 1.0, where + "as many iterations");
    check.That(SameOutputs(whole, stepwise), where + "the same bits in the end");
  }
}

/// From one mode to the other, and other tissue.
void TestSwitches(Checks& check)
{
  Block block;
  vtkNew<vtkChainMailDeformation> filter;
  block.Connect(filter);
  filter->SetInputDataObject(1, Pull(1.25, 0.5, -0.75));
  filter->Update();
  const auto fresh = [&](const std::function<void(vtkChainMailDeformation*)>& change, const std::string& what)
  {
    vtkNew<vtkChainMailDeformation> other;
    block.Connect(other);
    other->SetInputConnection(1, filter->GetInputConnection(1, 0));
    change(other);
    other->Update();
    check.That(SameOutputs(filter, other), what);
  };
  const auto nothing = [](vtkChainMailDeformation*) {};
  const auto interact = [&]
  {
    filter->SetInputDataObject(1, Pull(0.5, -0.75, 0.25));
    filter->Update();
    filter->SetInputDataObject(1, Pull(1.5, 0.75, 0.25));
    filter->Update();
  };

  filter->SetModeToInteractive();
  filter->Update();
  fresh(nothing, "Interactive starts from rest and applies all, as from rest");
  interact();
  filter->SetModeToFromRest();
  filter->Update();
  fresh(nothing, "from rest again: a function of the inputs alone");
  check.That(!filter->GetNeedsUpdate(), "from rest nothing is left to do");
  filter->SetModeToInteractive();
  filter->Update();
  fresh(nothing, "Interactive again starts from rest");

  interact();
  filter->SetTissueThreshold(30.0);
  filter->Update();
  fresh([](vtkChainMailDeformation* other) { other->SetTissueThreshold(30.0); }, "other tissue starts from rest");
  interact();
  block.Image->SetOrigin(0.25, 0.0, 0.0);
  block.Image->Modified();
  filter->Update();
  fresh([](vtkChainMailDeformation* other) { other->SetTissueThreshold(30.0); }, "another place starts from rest");

  // Reset() counts from when it is called, and from rest it is nothing.
  interact();
  filter->SetModeToFromRest();
  filter->Reset();
  filter->SetModeToInteractive();
  vtkNew<vtkFloatArray> before;
  before->DeepCopy(Array(filter->GetModelOutput(), "Displacement"));
  filter->SetRelaxationIterations(0);
  filter->Update();
  check.That(SameBits(Array(filter->GetModelOutput(), "Displacement"), before), "Reset() from rest does nothing");
}

/// What fails takes nothing with it.
void TestErrors(Checks& check)
{
  Bench bench;
  Bar bar;
  vtkChainMailDeformation* filter = bench.Filter;
  bench.Probe(8.0, 3.0);
  bar.Move(8, 3.0);
  bench.Expect(check, bar, "good");

  const auto fails = [&](const std::string& where, const std::vector<std::string>& parts)
  {
    filter->Update();
    const std::string errors = bench.Log.TakeErrors();
    for (const std::string& part : parts)
    {
      check.Contains(errors, part, where);
    }
    check.Contains(
      ErrorOf(filter->GetOutput()), parts.front(), where + ": the volume is the last good one, and says so");
    check.That(!filter->GetNeedsUpdate(), where + ": nothing settles");
    check.That(!filter->GetNeedsUpdate(), where + ": nothing goes on by itself");
  };

  // A probe outside, with a knife that came before it: the cut is made, at the deformation of that time.
  filter->SetInputDataObject(2, Knife(13.03125));
  filter->AddInputDataObject(1, MakeProbes({ { { { 90.0, 0.0, 0.0 } }, { { 1.0, 0.0, 0.0 } } } }));
  fails("probe outside", { "Probes input 1, point 0 at (90, 0, 0)", "holds no tissue" });
  bar.Cut(13.03125);
  bench.Probe(8.0, -2.0);
  bar.Move(8, -2.0);
  bench.Expect(check, bar, "after the probe outside");

  // A box with a hole, beside a good one, and a knife.
  filter->SetInputDataObject(2, Knife(3.03125));
  filter->SetInputDataObject(3, Box(25.03125, 27.03125));
  filter->AddInputDataObject(3, Box(20.03125, 22.03125, false));
  bench.Probe(8.0, 1.0);
  fails("open box", { "Carves input 1", "closed" });
  bar.Cut(3.03125);
  bar.Carve(25.03125, 27.03125);
  filter->SetInputDataObject(3, Box(25.03125, 27.03125));
  bar.Move(8, 1.0);
  bench.Expect(check, bar, "after the open box");

  // Tissue that cannot be used, found before the engine or by it.
  auto good = filter->GetMaterialFunction();
  filter->SetMaterialFunction(ConstantMaterial(1.5));
  fails("material", { "MaterialFunction is 1.5" });
  vtkSmartPointer<vtkPiecewiseFunction> same = ConstantMaterial(limit);
  filter->SetMaterialFunction(same);
  bench.Expect(check, bar, "after a bad material");
  check.That(good != nullptr, "there was a material");
  filter->SetTissueThreshold(1e6);
  fails("threshold", { "all air" });
  filter->SetTissueThreshold(0.0);
  bench.Expect(check, bar, "after all was air");
  filter->SetDevice("no such device");
  fails("device", { "no such device" });
  filter->SetDevice("");
  bench.Expect(check, bar, "after an unknown device");
  filter->SetBrickSize(5, 5, 5);
  fails("brick size", { "power" });
  filter->SetBrickSize(0, 0, 0);
  bench.Expect(check, bar, "after a bad brick size");
  bench.Probe(std::nan(""), 1.0);
  fails("probe nowhere", { "finite" });
  bench.Probe(8.0, 0.0);
  bar.Move(8, 0.0);
  bench.Expect(check, bar, "after a probe that is nowhere");
  filter->AddLabelArray("none such");
  fails("label array", { "none such" });
  filter->ClearLabelArrays();
  bench.Expect(check, bar, "after an unknown label array");

  // Reset() is not lost by an update that fails.
  filter->Reset();
  filter->SetTissueThreshold(1e6);
  fails("failing reset", { "all air" });
  filter->SetTissueThreshold(0.0);
  bar = Bar();
  bench.Expect(check, bar, "reset after all");

  // Stopped: at rest, released, but cut.
  filter->SetInputDataObject(2, Knife(15.53125));
  bar.Cut(15.53125);
  bench.Probe(8.0, 2.0);
  bar.Move(8, 2.0);
  bench.Expect(check, bar, "before the stop");
  for (int stopAt : { 1, 2, 3, 4, 5 })
  {
    int seen = 0;
    vtkNew<vtkCallbackCommand> observer;
    struct Watch
    {
      int Seen;
      int StopAt;
    } watch{ 0, stopAt };
    observer->SetClientData(&watch);
    observer->SetCallback(
      [](vtkObject* caller, unsigned long, void* client, void*)
      {
        auto* w = static_cast<Watch*>(client);
        if (++w->Seen == w->StopAt)
        {
          vtkAlgorithm::SafeDownCast(caller)->AbortExecuteOn();
        }
      });
    const unsigned long tag = filter->AddObserver(vtkCommand::ProgressEvent, observer);
    bench.Probe(8.0, 4.0 + stopAt);
    filter->Update();
    filter->RemoveObserver(tag);
    filter->AbortExecuteOff();
    seen = watch.Seen;
    const std::string where = "stopped at event " + std::to_string(stopAt);
    check.That(seen >= stopAt, where + ": it was stopped");
    check.That(filter->GetOutput()->GetNumberOfPoints() > 0, where + ": the last good output");
    check.Contains(ErrorOf(filter->GetOutput()), "stopped", where + ": it says so");
    check.Equal(bench.Log.TakeErrors(), std::string(), where + ": no error");
    check.That(!filter->GetNeedsUpdate(), where + ": nothing goes on by itself");
    bar.U.fill(0.0);
    bench.Probe(8.0, -3.0);
    bar.Move(8, -3.0);
    bench.Expect(check, bar, where + ", then another pull");
  }
}

/// A probe whose tissue others hold, or that was carved away, is warned about, once.
void TestEmptyHands(Checks& check)
{
  for (int mode : { vtkChainMailDeformation::MODE_FROM_REST, vtkChainMailDeformation::MODE_INTERACTIVE })
  {
    const std::string where = mode == vtkChainMailDeformation::MODE_FROM_REST ? "from rest: " : "interactive: ";
    Bench bench;
    bench.Filter->SetMode(mode);
    const auto probes = [&](double t)
    {
      bench.Filter->SetInputDataObject(1, MakeProbes({ { { { 8.0, 0.0, 0.0 } }, { { t, 0.0, 0.0 } }, 1.0 },
                                            { { { 8.0, 0.0, 0.0 } }, { { 0.5, 0.0, 0.0 } } } }));
      bench.Filter->Update();
      check.Equal(bench.Log.TakeErrors(), std::string(), where + "no error");
    };
    probes(1.0);
    const std::string warning = bench.Log.TakeWarnings();
    check.Contains(warning, "Probes input 0, point 1 at (8, 0, 0)", where + "the probe that holds nothing");
    check.Contains(warning, "no tissue of its own", where + "why");
    check.That(warning.find("point 0") == std::string::npos, where + "the other one holds something");
    probes(1.5);
    check.Equal(bench.Log.TakeWarnings(), std::string(), where + "a drag does not warn again");
    bench.Filter->SetRelaxationIterations(1);
    bench.Filter->Update();
    check.Equal(bench.Log.TakeWarnings(), std::string(), where + "nor does another property");
    bench.Filter->RemoveAllProbes();
    bench.Filter->Update();
    check.Equal(bench.Log.TakeWarnings(), std::string(), where + "no probes");
    probes(1.0);
    check.Contains(bench.Log.TakeWarnings(), "point 1", where + "again after it was gone");
  }

  Bench bench;
  bench.Probe(8.0, 1.0);
  bench.Filter->Update();
  check.Equal(bench.Log.TakeWarnings(), std::string(), "a probe that holds something");
  bench.Filter->SetInputDataObject(3, Box(8.53125, 9.53125)); // the element is at 9 now
  bench.Filter->Update();
  check.Contains(bench.Log.TakeWarnings(), "Probes input 0, point 0", "its tissue was carved away");
  bench.Filter->Modified();
  bench.Filter->Update();
  check.Equal(bench.Log.TakeWarnings(), std::string(), "that is said once");
}

long Pages()
{
  std::ifstream file("/proc/self/statm");
  long all = 0;
  long resident = 0;
  file >> all >> resident;
  return resident;
}

/// Many small updates need no more memory than some, and leave nothing behind: after the last Reset() all is as in a
/// filter that is new.
void TestManyUpdates(Checks& check, int updates)
{
  const int life = 100; // updates from one Reset() to the next
  const auto step = [](Bench& bench, int n)
  {
    bench.Probe(n / life % 2 ? 8.0 : 20.0, (n % 9) * 0.25 - 1.0);
    if (n % 20 == 0)
    {
      bench.Filter->SetInputDataObject(2, Knife(3.03125 + n / 20 % 25));
    }
    if (n % 200 == 100)
    {
      bench.Filter->SetInputDataObject(3, Box(28.03125, 28.53125 + n / 200 % 3));
    }
    if (n % life == life - 1)
    {
      bench.Filter->Reset();
    }
    bench.Filter->Update();
  };
  Bench bench;
  bench.Filter->SetRelaxationIterations(1);
  long early = 0;
  for (int n = 0; n < updates; ++n)
  {
    if (n == updates / 5)
    {
      early = Pages();
    }
    step(bench, n);
    if (n % life == life - 1)
    {
      check.That(SameBits(Array(bench.Filter->GetOutput(), "Scan"), Array(bench.Image, "Scan")),
        "update " + std::to_string(n) + ": at rest after Reset()");
    }
  }
  const double megabytes = static_cast<double>(Pages() - early) * sysconf(_SC_PAGESIZE) / 1e6;
  // A leak of one array of the bar in every update would be a megabyte in 8000; allocators and PoCL's queues breathe by
  // less than eight.
  const std::string growth =
    std::to_string(updates - updates / 5) + " updates took " + std::to_string(megabytes) + " MB more";
  std::cout << "NUMERICS: " << growth << "\n";
  check.That(megabytes < 8.0, growth);

  Bench fresh;
  fresh.Filter->SetRelaxationIterations(1);
  for (int n = updates - 2 * life; n < updates + life / 2; ++n)
  {
    step(fresh, n);
    if (n >= updates)
    {
      step(bench, n);
      check.That(SameOutputs(bench.Filter, fresh.Filter), "update " + std::to_string(n) + ": the bits of a new filter");
    }
  }
  check.That(Field(bench.Filter->GetOutput(), "DisplacedElements") > 0.0, "many updates: tissue is displaced");
  check.Equal(bench.Log.TakeErrors(), std::string(), "many updates: no error");
}

}

/// With a number as argument only that many updates are made.
int TestChainMailInteractive(int argc, char* argv[])
{
  Checks check;
  if (argc > 1)
  {
    TestManyUpdates(check, std::atoi(argv[1]));
    return check.Finish();
  }
  TestSteps(check);
  TestRandomSteps(check);
  TestSettling(check);
  TestWaves(check);
  TestSwitches(check);
  TestErrors(check);
  TestEmptyHands(check);
  TestManyUpdates(check, 2000);
  return check.Finish();
}
