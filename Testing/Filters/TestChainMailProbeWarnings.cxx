// SPDX-License-Identifier: BSD-3-Clause
// Warnings about probes: one for each reason, which counts the probes, names the first few and is not repeated while
// they are dragged.

#include "FilterTest.h"

using namespace FilterTest;

namespace
{

const int side = 17;

struct Bench
{
  vtkSmartPointer<vtkImageData> Image = MakeImage({ { 0, side - 1, 0, side - 1, 0, side - 1 } });
  vtkNew<vtkChainMailDeformation> Filter;
  EventLog Log{ this->Filter };
  std::vector<FilterTest::Probe> Probes;

  explicit Bench(int mode = vtkChainMailDeformation::MODE_FROM_REST)
  {
    // Bone: a bar along x in the middle, which touches neither face.
    Fill(this->Image->GetPointData()->GetScalars(), this->Image,
      [](int i, int j, int k) { return i > 2 && i < 14 && j == 3 && k == 3 ? 200 : 100; });
    auto material = vtkSmartPointer<vtkPiecewiseFunction>::New();
    material->AddPoint(100.0, 0.25);
    material->AddPoint(200.0, 0.0);
    this->Filter->SetInputData(this->Image);
    this->Filter->SetMaterialFunction(material);
    this->Filter->SetTissueThreshold(10.0);
    this->Filter->SetRelaxationIterations(2);
    this->Filter->SetCoarseToFine(false);
    this->Filter->SetMode(mode);
  }

  /// The warnings of an update.
  std::string Update(Checks& check, const std::string& where)
  {
    this->Filter->SetInputDataObject(1, MakeProbes(this->Probes));
    this->Filter->Update();
    check.Equal(this->Log.TakeErrors(), std::string(), where + ": no error");
    return this->Log.TakeWarnings();
  }
};

int Count(const std::string& text, const std::string& part)
{
  int count = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
  {
    ++count;
  }
  return count;
}

FilterTest::Probe At(double x, double y, double z, const Vector& displacement, double radius = 0.0)
{
  return { { { x, y, z } }, displacement, radius };
}

const int modes[] = { vtkChainMailDeformation::MODE_FROM_REST, vtkChainMailDeformation::MODE_INTERACTIVE };

void TestEmptyHandsAreCounted(Checks& check)
{
  for (const int mode : modes)
  {
    Bench bench(mode);
    for (int n = 0; n < 20; ++n)
    {
      bench.Probes.push_back(At(8.0, 8.0, 8.0, { { 0.5, 0.0, 0.0 } }, n / 100.0));
    }
    const std::string warning = bench.Update(check, "empty handles");
    check.Equal(Count(warning, "Warning"), 1, "empty handles: one warning");
    check.Contains(warning, "19 of 20 probes have no tissue of their own", "empty handles: counted");
    check.Contains(warning,
      "They are Probes input 0, point 1 at (8, 8, 8); Probes input 0, point 2 at (8, 8, 8); Probes input 0, point 3 at "
      "(8, 8, 8); and 16 more.",
      "empty handles: the first are named");
    bench.Probes[0].Displacement[0] = 0.75;
    bench.Probes[7].Displacement[0] = 0.75;
    check.Equal(bench.Update(check, "empty handles"), std::string(), "empty handles: a drag does not warn again");
    // Interactive, the tissue has been pulled away from there: the next one grabs what came in its place.
    bench.Probes.push_back(At(8.0, 8.0, 8.0, { { 0.0, 0.0, 0.0 } }, 0.2));
    const std::string more = bench.Update(check, "one more");
    check.That(mode == vtkChainMailDeformation::MODE_INTERACTIVE
                 ? more.empty()
                 : more.find("Probes input 0, point 20 at (8, 8, 8): the probe has no tissue") != std::string::npos,
      "one more");
  }
}

/// A plane of probes whose neighbours ask for more than they leave each other.
void TestSharingIsCounted(Checks& check)
{
  for (const int mode : modes)
  {
    Bench bench(mode);
    for (int n = 0; n < 49; ++n)
    {
      bench.Probes.push_back(At(5.0 + n % 7, 5.0 + n / 7, 10.0, { { 0.0, 0.0, n % 2 == 0 ? 0.9 : 0.1 } }));
    }
    const std::string warning = bench.Update(check, "sharing");
    check.Equal(Count(warning, "Warning"), 1, "sharing: one warning");
    check.Contains(warning, "49 of 49 probes are in conflict with others", "sharing: counted");
    vtkDataArray* reached = bench.Filter->GetProbeReached();
    for (vtkIdType n = 0; n < 49; ++n)
    {
      // Neighbours are 0.25 voxels apart, around the mean of 0.5.
      check.Near(reached->GetComponent(n, 2), n % 2 == 0 ? 0.625 : 0.375, 1e-5, "sharing: what each got");
    }
    bench.Probes[0].Displacement[2] = 0.8;
    check.Equal(bench.Update(check, "sharing"), std::string(), "sharing: a drag does not warn again");
    bench.Probes.resize(1);
    check.Equal(bench.Update(check, "one"), std::string(), "one alone shares with nobody");
    bench.Filter->SetConflictPolicyToShare();
    bench.Probes = { At(5.0, 5.0, 10.0, { { 0.0, 0.0, 0.9 } }), At(6.0, 5.0, 10.0, { { 0.0, 0.0, 0.1 } }) };
    check.Equal(bench.Update(check, "asked for"), std::string(), "no warning of what was asked for");
  }
}

void TestWarningsCanBeTurnedOff(Checks& check)
{
  for (const int mode : modes)
  {
    Bench bench(mode);
    bench.Probes = { At(2.0, 8.0, 8.0, { { 44.0, 0.0, 0.0 } }), At(2.0, 8.0, 8.0, { { 44.0, 0.0, 0.0 } }) };
    vtkChainMailDeformation::SetGlobalProbeWarnings(false);
    const std::string warning = bench.Update(check, "off");
    vtkChainMailDeformation::SetGlobalProbeWarnings(true);
    check.Equal(warning, std::string(), "no warning while they are off");
    const std::string report = bench.Filter->GetReport();
    check.Contains(report, "Probe 1 reached 0.5 of 44 mm: held by the face x- of the scan.", "the report says it");
    check.Contains(report, "Probe 2 has no tissue of its own.", "and that a probe holds nothing");
    vtkDataArray* reached = bench.Filter->GetProbeReached();
    check.That(reached && reached->GetNumberOfTuples() == 2 && reached->GetComponent(0, 0) == 0.5, "what was reached");
    bench.Probes[0].Displacement[0] = 45.0;
    check.Contains(bench.Update(check, "on"), "reached 0.5 of 45 mm", "they come as soon as they are on again");
  }
}

void TestWhatHolds(Checks& check)
{
  for (const int mode : modes)
  {
    Bench bench(mode);
    bench.Probes = { At(2.0, 8.0, 8.0, { { 44.0, 0.0, 0.0 } }) };
    const std::string warning = bench.Update(check, "face");
    check.Equal(Count(warning, "Warning"), 1, "face: one warning");
    check.Contains(warning,
      "Probes input 0, point 0 at (2, 8, 8): reached 0.5 of 44 mm, because it is held by tissue that touches the face "
      "x- of "
      "the image (AnchoredFaces).",
      "face: which probe, how far, and what holds it");
    bench.Probes[0].Displacement[0] = 60.0;
    check.Equal(bench.Update(check, "face"), std::string(), "face: a drag does not warn again");
    bench.Filter->SetRelaxationIterations(3);
    check.Equal(bench.Update(check, "face"), std::string(), "face: nor does another property");
    bench.Probes[0].Displacement[0] = 0.9;
    check.Equal(bench.Update(check, "more than half"), std::string(), "more than half of it");
    bench.Probes[0].Displacement[0] = 1.1;
    check.Contains(bench.Update(check, "again"), "reached 0.5 of 1.1 mm", "again after it had enough");

    bench.Filter->SetAnchoredFaces(0, 0, 0, 0, 0, 0);
    bench.Probes = { At(8.0, 8.0, 8.0, { { 0.0, 1.0, 0.0 } }), At(10.0, 8.0, 8.0, { { 0.0, -9.0, 0.0 } }) };
    check.Contains(bench.Update(check, "probe"),
      "Probes input 0, point 1 at (10, 8, 8): reached 0.5 of 9 mm, because it is held by tissue that is gripped by "
      "Probes "
      "input 0, point 0 at (8, 8, 8).",
      "another probe");
    bench.Probes = { At(4.0, 3.0, 3.0, { { 0.0, 0.0, 0.0 } }), At(12.0, 3.0, 3.0, { { 0.0, 0.0, 9.0 } }) };
    bench.Probes[0].Anchor = true;
    check.Contains(bench.Update(check, "bone"),
      "point 1 at (12, 3, 3): reached 0 of 9 mm, because the bone in its grip is held by Probes input 0, point 0",
      "bone");
    bench.Filter->SetAnchorRigid(true);
    bench.Probes = { At(8.0, 4.0, 3.0, { { 0.0, 3.0, 4.0 } }) };
    check.Contains(bench.Update(check, "rigid"),
      "reached 0.177 of 5 mm, because it is held by tissue that is rigid and anchored (AnchorRigid).", "anchored bone");
  }
}

void TestManyShortProbes(Checks& check)
{
  for (const int mode : modes)
  {
    Bench bench(mode);
    for (int n = 1; n < side - 1; ++n)
    {
      bench.Probes.push_back(At(n, 1.0, 8.0, { { 0.0, n % 2 ? 30.0 : 0.25, 0.0 } }));
    }
    const std::string warning = bench.Update(check, "many");
    check.Equal(Count(warning, "Warning"), 1, "many: one warning");
    check.Contains(warning,
      "8 of 15 probes reached less than half of their displacements: Probes input 0, point 0 at (1, 1, 8): reached "
      "0.25 "
      "of 30 mm, because it is held by tissue that touches the face ",
      "many: counted");
    check.Contains(warning, "point 4 at (5, 1, 8)", "many: the third is named");
    check.Contains(warning, "; and 5 more.", "many: the others are counted");
    check.Equal(Count(warning, "point 6"), 0, "many: but not named");
  }
}

/// A wave that has not come to its end is no reason to warn.
void TestUnfinishedWaves(Checks& check)
{
  Bench bench(vtkChainMailDeformation::MODE_INTERACTIVE);
  bench.Filter->SetBrickSize(4, 2, 2);
  bench.Filter->SetPropagationIterations(1);
  bench.Probes = { At(8.0, 8.0, 8.0, { { 30.0, 0.0, 0.0 } }) };
  int updates = 0;
  std::string warning;
  do
  {
    warning = bench.Update(check, "unfinished");
    check.That(warning.empty() || !bench.Filter->GetNeedsUpdate() || updates > 0, "unfinished: not at once");
  } while (warning.empty() && ++updates < 100);
  check.That(updates > 0, "it took several updates");
  check.Equal(Count(warning, "Warning"), 1, "finished: one warning");
  check.Contains(warning, "reached 2 of 30 mm", "finished: how far it got");
  for (int n = 0; n < 5; ++n)
  {
    check.Equal(bench.Update(check, "settling"), std::string(), "said once");
  }
}

/// Nearly two thousand probes that fit together: no warnings, and each gets what it asks for.
void TestThousands(Checks& check)
{
  Bench bench;
  bench.Filter->SetPropagationTimes(true);
  bench.Filter->SetRelaxationIterations(0);
  for (int k = 2; k < side - 2; ++k)
  {
    for (int j = 4; j < side - 2; ++j)
    {
      for (int i = 2; i < side - 2; ++i)
      {
        bench.Probes.push_back(At(i, j, k, { { 0.25, -0.125, 0.125 * (i % 2) } }));
      }
    }
  }
  check.Equal(bench.Update(check, "thousands"), std::string(), "thousands: no warning");
  bool all = true;
  for (std::size_t n = 0; n < bench.Probes.size(); ++n)
  {
    for (int a = 0; a < 3; ++a)
    {
      all = all && Field(bench.Filter->GetOutput(), "ProbeReached", a, static_cast<vtkIdType>(n)) ==
                     bench.Probes[n].Displacement[a];
    }
  }
  check.That(all, "thousands: each gets what it asks for");
  double range[2];
  bench.Filter->GetModelOutput()->GetPointData()->GetArray("Wavefront")->GetRange(range);
  check.Equal(range[1], 1.0, "thousands: one wave");
}

}

int TestChainMailProbeWarnings(int, char*[])
{
  Checks check;
  TestEmptyHandsAreCounted(check);
  TestSharingIsCounted(check);
  TestWarningsCanBeTurnedOff(check);
  TestWhatHolds(check);
  TestManyShortProbes(check);
  TestUnfinishedWaves(check);
  TestThousands(check);
  return check.Finish();
}
