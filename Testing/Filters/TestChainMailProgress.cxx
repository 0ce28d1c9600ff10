// SPDX-License-Identifier: BSD-3-Clause
// Progress events rise from 0 to 1 and come often; a stop asked for at any of them is heeded, is no error, and the next
// update is as if nothing had happened.

#include "FilterTest.h"

using namespace FilterTest;

namespace
{

struct Watch
{
  std::vector<double> Seen;
  std::size_t StopAfter = 0; // events; 0: never
};

}

int TestChainMailProgress(int, char*[])
{
  Checks check;
  Noise noise(7);
  auto image = MakeImage({ { 0, 31, 0, 23, 0, 19 } }, VTK_SHORT);
  Fill(image->GetPointData()->GetScalars(), image, [&](int, int, int) { return noise.Next() % 100; });
  vtkNew<vtkPiecewiseFunction> material;
  material->AddPoint(0.0, 0.4);
  material->AddPoint(99.0, 0.1);
  auto probes = MakeProbes({ { { { 16.0, 12.0, 10.0 } }, { { 2.0, 1.0, 0.0 } } } });
  auto blade = MakeBlade(
    { { { { 20.5, -1.0, -1.0 } }, { { 20.5, 15.0, -1.0 } }, { { 20.5, 15.0, 30.0 } }, { { 20.5, -1.0, 30.0 } } } });

  vtkNew<vtkChainMailDeformation> filter;
  EventLog log(filter);
  filter->SetInputData(image);
  filter->SetInputDataObject(1, probes);
  filter->SetInputDataObject(2, blade);
  filter->SetTissueThreshold(10.0);
  filter->SetMaterialFunction(material);
  filter->SetRelaxationTolerance(0.0);

  Watch watch;
  vtkNew<vtkCallbackCommand> observer;
  observer->SetClientData(&watch);
  observer->SetCallback(
    [](vtkObject* caller, unsigned long, void* client, void* share)
    {
      auto* w = static_cast<Watch*>(client);
      w->Seen.push_back(*static_cast<double*>(share));
      if (w->StopAfter > 0 && w->Seen.size() >= w->StopAfter)
      {
        vtkAlgorithm::SafeDownCast(caller)->AbortExecuteOn();
      }
    });
  filter->AddObserver(vtkCommand::ProgressEvent, observer);

  filter->Update();
  const std::vector<double> all = watch.Seen;
  check.That(all.size() > 40, "an event for every relaxation iteration, and more");
  bool rises = true;
  for (std::size_t n = 0; n < all.size(); ++n)
  {
    rises = rises && all[n] >= 0.0 && all[n] <= 1.0 && (n == 0 || all[n] >= all[n - 1]);
  }
  check.That(rises, "progress rises within [0, 1]");
  check.That(all.front() < 0.1, "it starts low");
  check.Equal(all.back(), 1.0, "it ends at 1");
  vtkNew<vtkImageData> expected;
  expected->DeepCopy(filter->GetOutput());
  vtkNew<vtkImageData> expectedModel;
  expectedModel->DeepCopy(filter->GetModelOutput());

  // Stopped at the n-th event, of a first update and of one where only the probe changed.
  for (bool fresh : { true, false })
  {
    for (std::size_t n = 1; n < all.size(); ++n)
    {
      const std::string where =
        std::string(fresh ? "first update" : "probe changed") + ", stopped at event " + std::to_string(n) + ": ";
      watch = Watch();
      if (fresh)
      {
        // Everything has to be done again.
        filter->SetTissueThreshold(50.0);
        filter->Update();
        filter->SetTissueThreshold(10.0);
      }
      else
      {
        probes->GetPointData()->GetArray("Displacement")->SetTuple3(0, -1.0, 0.0, 1.0);
        probes->Modified();
        filter->Update();
        probes->GetPointData()->GetArray("Displacement")->SetTuple3(0, 2.0, 1.0, 0.0);
        probes->Modified();
      }
      vtkNew<vtkImageData> before;
      before->ShallowCopy(filter->GetOutput());
      vtkNew<vtkImageData> beforeModel;
      beforeModel->ShallowCopy(filter->GetModelOutput());
      watch = Watch();
      watch.StopAfter = n;
      filter->Update();
      const std::size_t seen = watch.Seen.size();
      if (seen < n || (seen == n && watch.Seen.back() == 1.0))
      {
        // All was done before it. An update that does less has fewer events.
        check.That(n > 40, where + "enough places to stop");
        filter->AbortExecuteOff();
        break;
      }
      // One more from the filter before it asks, and one from the executive, at the end.
      check.That(seen <= n + 2, where + "heeded at once, " + std::to_string(seen - n) + " further events");
      check.That(SameBits(filter->GetOutput()->GetPointData()->GetScalars(), before->GetPointData()->GetScalars()),
        where + "the volume is the last good one");
      check.That(SameBits(filter->GetModelOutput()->GetPointData()->GetArray("Displacement"),
                   beforeModel->GetPointData()->GetArray("Displacement")),
        where + "and so is the model");
      check.Contains(ErrorOf(filter->GetOutput()), "stopped", where + "it says so");
      check.Equal(log.TakeErrors(), std::string(), where + "no error");

      // VTK leaves the flag up until somebody who wants the output takes it down.
      watch = Watch();
      filter->AbortExecuteOff();
      filter->Update();
      check.That(SameBits(filter->GetOutput()->GetPointData()->GetScalars(), expected->GetPointData()->GetScalars()),
        where + "then the volume is right");
      check.That(SameBits(filter->GetModelOutput()->GetPointData()->GetArray("Displacement"),
                   expectedModel->GetPointData()->GetArray("Displacement")),
        where + "then the displacements are right");
    }
  }
  check.Equal(log.TakeErrors(), std::string(), "no errors");
  return check.Finish();
}
