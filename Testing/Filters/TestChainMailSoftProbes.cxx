// SPDX-License-Identifier: BSD-3-Clause
// Soft probes: the point array Tolerance of the Probes input, in both modes, against a closed form.

#include "FilterTest.h"

#include <limits>

using namespace FilterTest;

namespace
{

/// A row of five voxels that ends at two anchored faces, along the world's y axis. Each link is as a spring of 1 / (D
/// h) with D h = 0.2 mm, and the middle hangs on two and two of them: on 1 / 0.2. A soft probe of tolerance T that
/// pulls it by t then gets t 0.2 / (0.2 + T).
struct Bench
{
  vtkSmartPointer<vtkImageData> Image = MakeImage({ { 0, 4, 0, 0, 0, 0 } });
  vtkNew<vtkChainMailDeformation> Filter;
  vtkSmartPointer<vtkPolyData> Probes;
  EventLog Log{ this->Filter };

  explicit Bench(int mode)
  {
    Fill(this->Image->GetPointData()->GetScalars(), this->Image, [](int, int, int) { return 100; });
    this->Image->SetSpacing(0.5, 0.5, 0.5);
    this->Image->SetDirectionMatrix(0, -1, 0, 1, 0, 0, 0, 0, 1);
    this->Filter->SetInputData(this->Image);
    this->Filter->SetMaterialFunction(ConstantMaterial(0.4));
    this->Filter->SetTissueThreshold(10.0);
    this->Filter->SetRelaxationIterations(200);
    this->Filter->SetRelaxationTolerance(1e-6);
    this->Filter->SetMode(mode);
    this->Pull(0.3);
  }

  void Pull(double tolerance, double displacement = 0.3)
  {
    this->Probes = MakeProbes({ { { { 0.0, 1.0, 0.0 } }, { { 0.0, displacement, 0.0 } } } });
    vtkNew<vtkDoubleArray> tolerances;
    tolerances->SetName("Tolerance");
    tolerances->InsertNextValue(tolerance);
    this->Probes->GetPointData()->AddArray(tolerances);
  }

  /// Updates until tissue has settled. Returns warnings.
  std::string Update(Checks& check, const std::string& where)
  {
    this->Filter->SetInputDataObject(1, this->Probes);
    int updates = 0;
    do
    {
      this->Filter->Update();
      check.Equal(this->Log.TakeErrors(), std::string(), where + ": no error");
    } while (this->Filter->GetNeedsUpdate() && ++updates < 20);
    check.That(updates < 20, where + ": it settles");
    return this->Log.TakeWarnings();
  }

  double Get(const char* name, int component = 0) { return Field(this->Filter->GetOutput(), name, component); }
};

const int modes[] = { vtkChainMailDeformation::MODE_FROM_REST, vtkChainMailDeformation::MODE_INTERACTIVE };

void TestSoftProbesPull(Checks& check)
{
  for (const int mode : modes)
  {
    Bench bench(mode);
    // It gets less than half of what it asks for, which is no reason to warn.
    check.Equal(bench.Update(check, "soft"), std::string(), "soft: no warning");
    check.Near(bench.Get("ProbeReached", 1), 0.12, 1e-5, "soft: reached");
    check.Near(bench.Get("ProbeReached", 0), 0.0, 1e-6, "soft: along the world's axes");
    check.Near(bench.Get("ProbeForce", 1), 1.2, 1e-4, "soft: force");
    check.Near(bench.Get("Energy"), 0.18, 1e-5, "soft: energy");
    check.Contains(bench.Filter->GetReport(), "Probe 1 softly reached 0.12 of 0.3 mm.", "soft: report");

    bench.Pull(0.05);
    bench.Update(check, "less tolerance");
    check.Near(bench.Get("ProbeReached", 1), 0.24, 1e-5, "less tolerance: reached");
    bench.Pull(0.05, -0.1);
    bench.Update(check, "another target");
    check.Near(bench.Get("ProbeReached", 1), -0.08, 1e-5, "another target: reached");
    bench.Pull(0.0, 0.2);
    bench.Update(check, "not soft");
    check.Near(bench.Get("ProbeReached", 1), 0.2, 1e-6, "not soft: reached");
    bench.Pull(0.3);
    bench.Update(check, "soft again");
    check.Near(bench.Get("ProbeReached", 1), 0.12, 1e-5, "soft again: reached");
    bench.Probes = MakeProbes({});
    bench.Update(check, "gone");
    check.Near(bench.Get("Energy"), 0.0, 1e-8, "gone: energy");
  }
}

void TestNothingMovesWithoutRelaxation(Checks& check)
{
  Bench bench(vtkChainMailDeformation::MODE_FROM_REST);
  bench.Filter->SetRelaxationIterations(0);
  check.Equal(bench.Update(check, "no relaxation"), std::string(), "no relaxation: no warning");
  check.Equal(bench.Get("DisplacedElements"), 0.0, "no relaxation: nothing moves");
  check.Contains(bench.Filter->GetReport(), "Probe 1 is soft and moves nothing, because RelaxationIterations is 0.",
    "no relaxation: report");
}

void TestBadTolerancesAreErrors(Checks& check)
{
  Bench bench(vtkChainMailDeformation::MODE_INTERACTIVE);
  bench.Update(check, "good");
  for (const double tolerance : { -0.5, std::nan(""), std::numeric_limits<double>::infinity() })
  {
    bench.Pull(tolerance);
    bench.Filter->SetInputDataObject(1, bench.Probes);
    bench.Filter->Update();
    check.Contains(bench.Log.TakeErrors(), "point 0 at (0, 1, 0): the tolerance is ", "a bad tolerance");
  }
  vtkNew<vtkDoubleArray> three;
  three->SetName("Tolerance");
  three->SetNumberOfComponents(3);
  three->InsertNextTuple3(1, 1, 1);
  bench.Pull(0.3);
  bench.Probes->GetPointData()->AddArray(three);
  bench.Filter->SetInputDataObject(1, bench.Probes);
  bench.Filter->Update();
  check.Contains(bench.Log.TakeErrors(), "the point array \"Tolerance\" has to hold 1 number", "three tolerances");
  bench.Pull(0.3);
  bench.Update(check, "good again");
  check.Near(bench.Get("ProbeReached", 1), 0.12, 1e-5, "good again: reached");
}

}

int TestChainMailSoftProbes(int, char*[])
{
  Checks check;
  TestSoftProbesPull(check);
  TestNothingMovesWithoutRelaxation(check);
  TestBadTolerancesAreErrors(check);
  return check.Finish();
}
