// SPDX-License-Identifier: BSD-3-Clause
// Carves: closed surfaces take away the elements inside them, wherever the image lies. What is left behaves as if the
// carved voxels had been air from the start; what was carved shows the background, all else is as it was, to the bit.

#include "FilterTest.h"

#include "vtkDataArraySelection.h"

#include "vtkCubeSource.h"
#include "vtkFloatArray.h"
#include "vtkMatrix3x3.h"
#include "vtkPlaneSource.h"
#include "vtkSphereSource.h"
#include "vtkStripper.h"

#include <algorithm>

using namespace FilterTest;

namespace
{

vtkDataArray* Array(vtkDataSet* data, const char* name)
{
  return data->GetPointData()->GetArray(name);
}

/// A sphere's polyhedron in world space, and whether a point is inside it: behind every face, since it is convex.
struct Ball
{
  vtkNew<vtkSphereSource> Source;

  Ball(double x, double y, double z, double radius)
  {
    this->Source->SetCenter(x, y, z);
    this->Source->SetRadius(radius);
    this->Source->SetThetaResolution(11);
    this->Source->SetPhiResolution(9);
    this->Source->SetOutputPointsPrecision(vtkAlgorithm::DOUBLE_PRECISION);
    this->Source->Update();
  }

  /// The distance from the surface, positive inside: no more than the true one.
  double Depth(const double x[3])
  {
    vtkPolyData* surface = this->Source->GetOutput();
    double centre[3];
    this->Source->GetCenter(centre);
    double depth = std::numeric_limits<double>::infinity();
    for (vtkIdType c = 0; c < surface->GetNumberOfCells(); ++c)
    {
      double p[3][3];
      for (int corner = 0; corner < 3; ++corner)
      {
        surface->GetPoint(surface->GetCell(c)->GetPointId(corner), p[corner]);
      }
      double a[3];
      double b[3];
      double normal[3];
      double toX[3];
      double toCentre[3];
      vtkMath::Subtract(p[1], p[0], a);
      vtkMath::Subtract(p[2], p[0], b);
      vtkMath::Cross(a, b, normal);
      if (vtkMath::Normalize(normal) == 0.0)
      {
        continue; // at a pole
      }
      vtkMath::Subtract(x, p[0], toX);
      vtkMath::Subtract(centre, p[0], toCentre);
      const double side = vtkMath::Dot(normal, toCentre) > 0.0 ? 1.0 : -1.0;
      depth = std::min(depth, side * vtkMath::Dot(normal, toX));
    }
    return depth;
  }
};

vtkSmartPointer<vtkImageData> Scan(int components = 1)
{
  auto image = MakeImage({ { 4, 21, -3, 12, 0, 13 } }, VTK_SHORT, components);
  Noise noise(17);
  Fill(image->GetPointData()->GetScalars(), image, [&](int, int, int) { return 20 + noise.Next() % 80; });
  vtkNew<vtkFloatArray> other;
  other->SetName("Other");
  for (vtkIdType p = 0; p < image->GetNumberOfPoints(); ++p)
  {
    other->InsertNextValue(static_cast<float>(1.0 + noise.Uniform()));
  }
  image->GetPointData()->AddArray(other);
  return image;
}

void Configure(vtkChainMailDeformation* filter, vtkImageData* image)
{
  vtkNew<vtkPiecewiseFunction> material;
  material->AddPoint(20.0, 0.4);
  material->AddPoint(90.0, 0.05);
  material->AddPoint(91.0, 0.0);
  filter->SetInputData(image);
  filter->SetMaterialFunction(material);
  filter->SmoothCutsOff(); // the oracles tell which voxels are inside, and not in which share
  filter->SetTissueThreshold(10.0);
  filter->PropagationTimesOn();
}

/// Which elements are inside, and that the rest of both outputs is untouched.
void TestInside(Checks& check)
{
  for (bool turned : { false, true })
  {
    auto image = Scan(2);
    if (turned)
    {
      image->SetSpacing(0.5, 0.75, 1.5);
      image->SetOrigin(-31.0, 12.5, 470.0);
      image->SetDirectionMatrix(0.6, 0.0, 0.8, 0.0, -1.0, 0.0, -0.8, 0.0, 0.6);
    }
    int middle[3] = { 12, 4, 6 };
    double centre[3];
    image->TransformIndexToPhysicalPoint(middle, centre);
    Ball ball(centre[0] + 0.013, centre[1] - 0.021, centre[2] + 0.017, turned ? 3.3 : 4.2);
    vtkNew<vtkChainMailDeformation> filter;
    filter->GetModelArraySelection()->EnableAllArrays();
    EventLog log(filter);
    Configure(filter, image);
    filter->SetBackgroundValue(-7.0);
    filter->SetCarvesConnection(ball.Source->GetOutputPort());
    filter->Update();
    check.Equal(log.TakeErrors() + log.TakeWarnings(), std::string(), "no error");
    vtkImageData* model = filter->GetModelOutput();
    vtkImageData* volume = filter->GetOutput();
    const std::string where = turned ? "turned: " : "straight: ";
    int inside = 0;
    for (vtkIdType p = 0; p < image->GetNumberOfPoints(); ++p)
    {
      double x[3];
      image->GetPoint(p, x);
      const double depth = ball.Depth(x);
      // Surfaces are rounded to 1/4096 of a voxel.
      if (std::fabs(depth) < 1e-3)
      {
        continue;
      }
      const bool carved = depth > 0.0;
      inside += carved;
      check.Equal(Array(model, "Element")->GetTuple1(p), carved ? 0.0 : 1.0, where + "Element");
      check.Equal(Array(volume, "Scan")->GetComponent(p, 1), carved ? -7.0 : Array(image, "Scan")->GetComponent(p, 1),
        where + "background inside, the input's value outside");
      check.Equal(Array(model, "Cluster")->GetTuple1(p) >= 0.0,
        !carved && Array(image, "Scan")->GetComponent(p, 0) > 90.0, where + "Cluster");
      check.Equal(Array(model, "Constraint")->GetTuple1(p) > 0.0,
        !carved && Array(image, "Scan")->GetComponent(p, 0) < 91.0, where + "Constraint");
    }
    check.That(inside > 50, where + "something is carved");
    double range[2];
    Array(image, "Other")->GetRange(range);
    check.Equal(Array(volume, "Other")->GetTuple1(image->FindPoint(centre)), range[0],
      where + "other arrays show their smallest");
    check.Equal(Field(volume, "DisplacedElements"), 0.0, where + "nothing moved");

    // The same surface in other words.
    vtkNew<vtkImageData> expected;
    expected->ShallowCopy(model);
    vtkNew<vtkStripper> strips;
    strips->SetInputConnection(ball.Source->GetOutputPort());
    strips->Update();
    check.That(strips->GetOutput()->GetNumberOfStrips() > 0, where + "there are strips");
    filter->SetCarvesConnection(strips->GetOutputPort());
    filter->Update();
    check.That(SameBits(Array(filter->GetModelOutput(), "Element"), Array(expected, "Element")), where + "strips");

    // A ball in the ball that faces the other way, in the same input, leaves its own inside: a shell. In an input of
    // its own it adds nothing.
    Ball core(centre[0], centre[1], centre[2], turned ? 1.6 : 2.1);
    vtkNew<vtkPolyData> shell;
    vtkNew<vtkPoints> points;
    points->SetDataTypeToDouble();
    vtkNew<vtkCellArray> triangles;
    for (Ball* one : { &ball, &core })
    {
      vtkPolyData* surface = one->Source->GetOutput();
      const vtkIdType first = points->GetNumberOfPoints();
      for (vtkIdType p = 0; p < surface->GetNumberOfPoints(); ++p)
      {
        points->InsertNextPoint(surface->GetPoint(p));
      }
      for (vtkIdType c = 0; c < surface->GetNumberOfCells(); ++c)
      {
        vtkCell* cell = surface->GetCell(c);
        const int way = one == &core ? 1 : 0;
        triangles->InsertNextCell(
          { first + cell->GetPointId(0), first + cell->GetPointId(1 + way), first + cell->GetPointId(2 - way) });
      }
    }
    shell->SetPoints(points);
    shell->SetPolys(triangles);
    filter->SetInputDataObject(3, shell);
    filter->Update();
    check.Equal(Array(filter->GetModelOutput(), "Element")->GetTuple1(image->FindPoint(centre)), 1.0,
      where + "the core of a shell stays");
    check.That(!SameBits(Array(filter->GetModelOutput(), "Element"), Array(expected, "Element")), where + "a shell");
    filter->SetCarvesConnection(ball.Source->GetOutputPort());
    filter->AddCarvesConnection(core.Source->GetOutputPort());
    filter->Update();
    check.That(SameBits(Array(filter->GetModelOutput(), "Element"), Array(expected, "Element")),
      where + "a ball in another input");

    // Without them all is back.
    filter->RemoveAllCarves();
    filter->Update();
    check.That(SameBits(Array(filter->GetOutput(), "Scan"), Array(image, "Scan")), where + "back, bit for bit");
    Array(filter->GetModelOutput(), "Element")->GetRange(range);
    check.Equal(range[0], 1.0, where + "all tissue");
  }
}

/// Pulled, what is left is where it would be had the carved voxels been air.
void TestAsAir(Checks& check)
{
  auto image = Scan();
  vtkNew<vtkCubeSource> box; // every side has its own corners
  box->SetBounds(11.6, 13.4, -5.0, 9.3, -2.0, 20.0);
  auto blade = MakeBlade(
    { { { { 15.4, -9.0, 2.6 } }, { { 15.4, 20.0, 2.6 } }, { { 15.4, 20.0, 30.0 } }, { { 15.4, -9.0, 30.0 } } } });
  auto probes = MakeProbes({ { { { 9.0, 4.0, 6.0 } }, { { 1.5, 0.5, 0.25 } }, 1.5 } });
  vtkNew<vtkChainMailDeformation> carved;
  carved->GetModelArraySelection()->EnableAllArrays();
  vtkNew<vtkChainMailDeformation> air;
  air->GetModelArraySelection()->EnableAllArrays();
  Configure(carved, image);
  carved->SetCarvesConnection(box->GetOutputPort());

  vtkNew<vtkImageData> hollow;
  hollow->DeepCopy(image);
  vtkIdType gone = 0;
  for (vtkIdType p = 0; p < hollow->GetNumberOfPoints(); ++p)
  {
    double x[3];
    hollow->GetPoint(p, x);
    if (x[0] > 11.6 && x[0] < 13.4 && x[1] < 9.3)
    {
      Array(hollow, "Scan")->SetTuple1(p, 0.0);
      ++gone;
    }
  }
  Configure(air, hollow);
  for (vtkChainMailDeformation* filter : { carved.Get(), air.Get() })
  {
    filter->SetInputDataObject(1, probes);
    filter->SetInputDataObject(2, blade);
    filter->Update();
  }
  check.That(gone > 100, "something is carved");
  check.That(Field(carved->GetOutput(), "DisplacedElements") > 300.0, "the rest is pulled");
  for (const char* name : { "Displacement", "Constraint", "Element", "Cluster", "PropagationTime", "Wavefront" })
  {
    check.That(SameBits(Array(carved->GetModelOutput(), name), Array(air->GetModelOutput(), name)),
      std::string(name) + " as if the carved voxels were air");
  }
  check.Equal(Field(carved->GetOutput(), "Energy"), Field(air->GetOutput(), "Energy"), "the same energy");

  // The stages of an update: the same surfaces again are no news, one that moved is.
  const auto ran = [&](int time) { return Field(carved->GetOutput(), "Milliseconds", time) > 0.0; };
  carved->Modified();
  carved->Update();
  check.That(!ran(UPLOAD) && !ran(PROPAGATE) && !ran(RELAX) && ran(RESAMPLE), "nothing is deformed again");
  box->SetBounds(11.6, 13.4, -5.0, 8.3, -2.0, 20.0);
  carved->Update();
  check.That(!ran(UPLOAD) && ran(PROPAGATE) && ran(RELAX) && ran(DOWNLOAD), "another box is carved, in the same model");
  check.That(!SameBits(Array(carved->GetModelOutput(), "Element"), Array(air->GetModelOutput(), "Element")),
    "it takes other elements");
}

/// What cannot be carved with, and extremes.
void TestErrors(Checks& check)
{
  auto image = Scan();
  vtkNew<vtkChainMailDeformation> filter;
  filter->GetModelArraySelection()->EnableAllArrays();
  EventLog log(filter);
  Configure(filter, image);
  Ball ball(12.0, 4.0, 6.0, 2.3);
  vtkNew<vtkPlaneSource> plane;
  plane->SetOrigin(12.0, -9.0, -9.0);
  plane->SetPoint1(12.0, 30.0, -9.0);
  plane->SetPoint2(12.0, -9.0, 30.0);
  filter->SetCarvesConnection(ball.Source->GetOutputPort());
  filter->Update();
  check.Equal(log.TakeErrors(), std::string(), "a closed surface");
  vtkNew<vtkImageData> good;
  good->ShallowCopy(filter->GetModelOutput());
  const auto recovers = [&](const std::string& where)
  {
    filter->SetCarvesConnection(ball.Source->GetOutputPort());
    filter->RemoveAllProbes();
    filter->Update();
    check.Equal(log.TakeErrors(), std::string(), where + ": no error later");
    check.That(
      SameBits(Array(filter->GetModelOutput(), "Element"), Array(good, "Element")), where + ": all is well later");
  };
  filter->AddCarvesConnection(plane->GetOutputPort());
  filter->Update();
  std::string errors = log.TakeErrors();
  check.Contains(errors, "Carves input 1", "a plane is named");
  check.Contains(errors, "not closed", "and what is wrong with it");
  check.Contains(ErrorOf(filter->GetOutput()), "not closed", "the volume is the last good one, and says so");
  recovers("plane");

  ball.Source->SetEndTheta(300.0);
  filter->Update();
  check.Contains(log.TakeErrors(), "Carves input 0", "a ball with a slice missing");
  ball.Source->SetEndTheta(360.0);
  recovers("slice missing");

  vtkNew<vtkPolyData> nowhere;
  nowhere->DeepCopy(ball.Source->GetOutput());
  nowhere->GetPoints()->SetPoint(3, 1.0, std::nan(""), 2.0);
  filter->SetInputDataObject(3, nowhere);
  filter->Update();
  errors = log.TakeErrors();
  check.Contains(errors, "Carves input 0, point 3", "a point that is nowhere");
  check.Contains(errors, "finite", "and what is wrong with it");
  recovers("a point that is nowhere");

  filter->SetInputDataObject(1, MakeProbes({ { { { 12.0, 4.0, 6.0 } }, { { 1.0, 0.0, 0.0 } } } }));
  filter->Update();
  check.Contains(
    log.TakeErrors(), "Probes input 0, point 0 at (12, 4, 6): the probe holds no tissue", "carved at rest");
  recovers("a probe in carved tissue");

  vtkNew<vtkPolyData> nothing;
  filter->AddInputDataObject(3, nothing);
  filter->Update();
  check.Equal(log.TakeErrors(), std::string(), "an empty surface");
  check.That(SameBits(Array(filter->GetModelOutput(), "Element"), Array(good, "Element")), "carves nothing");

  // All there is.
  vtkNew<vtkCubeSource> all;
  all->SetBounds(-100.0, 100.0, -100.0, 100.0, -100.0, 100.0);
  filter->SetCarvesConnection(all->GetOutputPort());
  filter->SetBackgroundValue(3.0);
  filter->Update();
  check.Equal(log.TakeErrors(), std::string(), "all is carved");
  double range[2];
  Array(filter->GetModelOutput(), "Element")->GetRange(range);
  check.Equal(range[1], 0.0, "no element is left");
  Array(filter->GetOutput(), "Scan")->GetRange(range);
  check.That(range[0] == 3.0 && range[1] == 3.0, "nothing but background");
  recovers("all was carved");

  // A single slice.
  auto slice = MakeImage({ { 0, 10, 0, 10, 7, 7 } }, VTK_SHORT);
  slice->GetPointData()->GetScalars()->Fill(50);
  filter->SetInputData(slice);
  Ball disc(5.0, 5.0, 7.0, 2.5);
  filter->SetCarvesConnection(disc.Source->GetOutputPort());
  filter->Update();
  check.Equal(log.TakeErrors(), std::string(), "a slice");
  check.Equal(Array(filter->GetModelOutput(), "Element")->GetTuple1(5 * 11 + 5), 0.0, "a slice: carved inside");
  check.Equal(Array(filter->GetModelOutput(), "Element")->GetTuple1(5 * 11 + 8), 1.0, "a slice: not outside");
}

}

int TestChainMailCarves(int, char*[])
{
  Checks check;
  TestInside(check);
  TestAsAir(check);
  TestErrors(check);
  return check.Finish();
}
