// SPDX-License-Identifier: BSD-3-Clause
// Carves of several parts in one dataset, as Glyph and Append Geometry make them: what any of them encloses goes,
// hollows stay, and the filter says what it does where parts face different ways.

#include "FilterTest.h"

#include "vtkAppendPolyData.h"
#include "vtkDataArraySelection.h"
#include "vtkGlyph3D.h"
#include "vtkMath.h"
#include "vtkReverseSense.h"
#include "vtkSphereSource.h"

#include <array>
#include <cmath>
#include <vector>

using namespace FilterTest;

namespace
{

struct Ball
{
  std::array<double, 3> Centre;
  double Radius;

  /// The distance from the sphere, positive inside. Its triangles lie below it by no more than 2 %.
  double Depth(const double x[3]) const
  {
    return this->Radius - std::sqrt(vtkMath::Distance2BetweenPoints(x, this->Centre.data()));
  }
};

vtkSmartPointer<vtkPolyData> Surface(const Ball& ball, bool reversed = false)
{
  vtkNew<vtkSphereSource> sphere;
  sphere->SetCenter(ball.Centre[0], ball.Centre[1], ball.Centre[2]);
  sphere->SetRadius(ball.Radius);
  sphere->SetThetaResolution(32);
  sphere->SetPhiResolution(32);
  sphere->SetOutputPointsPrecision(vtkAlgorithm::DOUBLE_PRECISION);
  vtkNew<vtkReverseSense> reverse;
  reverse->SetInputConnection(sphere->GetOutputPort());
  reverse->SetReverseCells(reversed);
  reverse->Update();
  return reverse->GetOutput();
}

vtkSmartPointer<vtkPolyData> Append(const std::vector<vtkSmartPointer<vtkPolyData>>& parts)
{
  vtkNew<vtkAppendPolyData> append;
  append->SetOutputPointsPrecision(vtkAlgorithm::DOUBLE_PRECISION);
  for (const auto& part : parts)
  {
    append->AddInputData(part);
  }
  append->Update();
  return append->GetOutput();
}

/// Tissue from 0 to 24 along each axis.
struct Bench
{
  vtkSmartPointer<vtkImageData> Image = MakeImage({ { 0, 24, 0, 24, 0, 24 } });
  vtkNew<vtkChainMailDeformation> Filter;
  EventLog Log{ this->Filter };

  explicit Bench(int mode = vtkChainMailDeformation::MODE_FROM_REST)
  {
    this->Image->SetOrigin(-3.0, 5.0, 11.0);
    this->Image->SetDirectionMatrix(0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0); // mirrored
    this->Image->GetPointData()->GetScalars()->Fill(50.0);
    this->Filter->SetMode(mode);
    this->Filter->SetInputData(this->Image);
    this->Filter->SetTissueThreshold(10.0);
    this->Filter->SetMaterialFunction(ConstantMaterial(0.3));
  }

  std::array<double, 3> At(double i, double j, double k)
  {
    const double index[3] = { i, j, k };
    std::array<double, 3> x;
    this->Image->TransformContinuousIndexToPhysicalPoint(index, x.data());
    return x;
  }

  /// Carves, and returns how many voxels are not as `inside(x)` says: 1 carved, 0 not, -1 either.
  template <typename F> int Wrong(Checks& check, vtkPolyData* surface, const std::string& where, F&& inside)
  {
    this->Filter->SetInputDataObject(3, surface);
    this->Filter->Update();
    check.Equal(this->Log.TakeErrors(), std::string(), where + ": no error");
    vtkDataArray* element = this->Filter->GetModelOutput()->GetPointData()->GetArray("Element");
    int wrong = 0;
    int gone = 0;
    for (vtkIdType v = 0; v < element->GetNumberOfTuples(); ++v)
    {
      double x[3];
      this->Image->GetPoint(v, x);
      const int should = inside(x);
      const bool carved = element->GetTuple1(v) == 0.0;
      gone += carved;
      wrong += should >= 0 && carved != (should == 1);
    }
    check.That(gone > 300, where + ": something is carved");
    return wrong;
  }
};

/// 1 in any of the balls, 0 outside all, -1 near a sphere.
int InAny(const double x[3], const std::vector<Ball>& balls)
{
  double depth = -1e9;
  for (const Ball& ball : balls)
  {
    depth = std::max(depth, ball.Depth(x));
  }
  return depth > 0.12 ? 1 : depth < -1e-3 ? 0 : -1;
}

}

int TestChainMailParts(int, char*[])
{
  Checks check;
  const std::string nothing;
  Bench bench;

  // Nine balls by Glyph.
  std::vector<Ball> nine;
  vtkNew<vtkPoints> places;
  places->SetDataTypeToDouble();
  for (int n = 0; n < 9; ++n)
  {
    const Ball ball{ bench.At(6.1 + 5.7 * (n % 3), 6.3 + 5.6 * (n / 3), 11.7 + 0.7 * (n % 2)), 4.1 };
    nine.push_back(ball);
    places->InsertNextPoint(ball.Centre.data());
  }
  vtkNew<vtkPolyData> points;
  points->SetPoints(places);
  for (const bool reversed : { false, true })
  {
    vtkNew<vtkGlyph3D> glyph;
    glyph->SetInputData(points);
    glyph->SetSourceData(Surface({ { { 0, 0, 0 } }, 4.1 }, reversed));
    glyph->SetScaleModeToDataScalingOff();
    glyph->SetOutputPointsPrecision(vtkAlgorithm::DOUBLE_PRECISION);
    glyph->Update();
    const std::string where = reversed ? "nine balls inside out" : "nine balls";
    check.Equal(
      bench.Wrong(check, glyph->GetOutput(), where, [&](const double* x) { return InAny(x, nine); }), 0, where);
    check.Equal(bench.Log.TakeWarnings(), nothing, where + ": no warning");
  }

  // Two by Append Geometry, also where one faces the other way, which is said once.
  const Ball left{ bench.At(9.2, 12.1, 12.3), 6.2 };
  const Ball right{ bench.At(15.3, 12.4, 11.9), 5.3 };
  const auto both = [&](const double* x) { return InAny(x, { left, right }); };
  check.Equal(bench.Wrong(check, Append({ Surface(left), Surface(right) }), "two balls", both), 0, "two balls");
  check.Equal(bench.Log.TakeWarnings(), nothing, "two balls: no warning");
  const auto mixed = Append({ Surface(left), Surface(right, true) });
  check.Equal(bench.Wrong(check, mixed, "one inside out", both), 0, "one inside out");
  const std::string warning = bench.Log.TakeWarnings();
  check.Contains(warning, "Carves input 0: 1 of its 2 parts have normals opposite to those of the other parts",
    "one inside out: named");
  check.Contains(warning, "Hollows found: 0.", "one inside out: no hollow");
  check.Contains(warning, "Generate Surface Normals", "one inside out: what to do");
  bench.Filter->Modified();
  check.Equal(bench.Wrong(check, mixed, "again", both), 0, "again");
  check.Equal(bench.Log.TakeWarnings(), nothing, "once");

  // A hollow.
  const Ball outer{ bench.At(12.1, 12.2, 11.8), 9.3 };
  const Ball inner{ bench.At(11.6, 12.3, 12.4), 5.2 };
  const auto shell = [&](const double* x)
  {
    const int hole = InAny(x, { inner });
    return hole == 0 ? InAny(x, { outer }) : hole == 1 ? 0 : -1;
  };
  const auto solid = [&](const double* x) { return InAny(x, { outer }); };
  check.Equal(bench.Wrong(check, Append({ Surface(inner, true), Surface(outer) }), "a shell", shell), 0, "a shell");
  check.Contains(bench.Log.TakeWarnings(), "Hollows found: 1.", "a shell: one hollow");
  check.Equal(bench.Wrong(check, Append({ Surface(inner), Surface(outer, true) }), "a shell inside out", shell), 0,
    "a shell inside out");
  check.Equal(bench.Log.TakeWarnings(), nothing, "a shell inside out: the same was said before");
  check.Equal(bench.Wrong(check, Append({ Surface(inner), Surface(outer) }), "a ball in a ball", solid), 0,
    "a ball in a ball of the same sense is nothing more");
  check.Equal(bench.Log.TakeWarnings(), nothing, "a ball in a ball: no warning");

  // Triangles that face any way, as some programs write them.
  const auto messy = Append({ Surface(inner), Surface(outer) });
  for (vtkIdType c = 0; c < messy->GetNumberOfCells(); c += 3)
  {
    messy->ReverseCell(c);
  }
  check.Equal(bench.Wrong(check, messy, "any way", shell), 0, "any way: a part within another is a hollow");
  check.Contains(bench.Log.TakeWarnings(), "2 of its 2 parts have triangles that face both ways", "any way: said");

  // In Interactive mode, at the current deformation; the warning comes once while the surface moves.
  Bench live(vtkChainMailDeformation::MODE_INTERACTIVE);
  check.Equal(live.Wrong(check, Append({ Surface(left), Surface(right) }), "live", both), 0, "live: two balls");
  check.Equal(live.Log.TakeWarnings(), nothing, "live: no warning");
  live.Filter->Reset();
  live.Filter->Update();
  for (double shift = 0.0; shift < 1.5; shift += 0.5)
  {
    Ball moved = right;
    moved.Centre[1] += shift;
    live.Filter->SetInputDataObject(3, Append({ Surface(left), Surface(moved, true) }));
    live.Filter->Update();
    check.Equal(live.Log.TakeErrors(), nothing, "live: no error");
    const std::string said = live.Log.TakeWarnings();
    check.Equal(said.find("normals opposite to those of the other parts") != std::string::npos, shift == 0.0,
      "live: once while it moves");
  }
  return check.Finish();
}
