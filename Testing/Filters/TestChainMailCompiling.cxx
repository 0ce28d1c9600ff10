// SPDX-License-Identifier: BSD-3-Clause
// Where no kernel is compiled yet, an update says so in its progress text from the beginning, can be stopped meanwhile,
// and the next update is as if nothing had happened.

#include "../TemporaryFolder.h"
#include "FilterTest.h"

#include <stdlib.h>

using namespace FilterTest;

namespace
{

struct Watch
{
  bool Stops = false;
  std::vector<std::string> Texts; // of all events
};

vtkDataArray* DisplacementOf(vtkChainMailDeformation* filter)
{
  return filter->GetModelOutput()->GetPointData()->GetArray("Displacement");
}

}

int TestChainMailCompiling(int, char*[])
{
  const TemporaryFolder caches;
  for (const char* variable : { "CHAINMAIL_CACHE_DIR", "POCL_CACHE_DIR", "CUDA_CACHE_PATH" })
  {
    setenv(variable, caches.path.c_str(), 1); // before any driver is loaded
  }
  Checks check;
  auto image = MakeImage({ { 0, 15, 0, 11, 0, 9 } }, VTK_SHORT);
  Fill(image->GetPointData()->GetScalars(), image, [](int, int, int) { return 100.0; });
  vtkNew<vtkPiecewiseFunction> material;
  material->AddPoint(0.0, 0.2);
  auto probes = MakeProbes({ { { { 8.0, 6.0, 5.0 } }, { { 1.0, 0.5, 0.0 } } } });
  const auto prepare = [&](vtkChainMailDeformation* filter)
  {
    filter->SetInputData(image);
    filter->SetInputDataObject(1, probes);
    filter->SetTissueThreshold(10.0);
    filter->SetMaterialFunction(material);
  };

  vtkNew<vtkChainMailDeformation> filter;
  EventLog log(filter);
  prepare(filter);
  Watch watch;
  watch.Stops = true;
  vtkNew<vtkCallbackCommand> observer;
  observer->SetClientData(&watch);
  observer->SetCallback(
    [](vtkObject* caller, unsigned long, void* client, void*)
    {
      auto* w = static_cast<Watch*>(client);
      auto* algorithm = vtkAlgorithm::SafeDownCast(caller);
      const char* text = algorithm->GetProgressText();
      w->Texts.emplace_back(text ? text : "");
      if (w->Stops && w->Texts.back() == "Compiling kernels")
      {
        algorithm->AbortExecuteOn();
      }
    });
  filter->AddObserver(vtkCommand::ProgressEvent, observer);

  const auto count = [&] { return std::count(watch.Texts.begin(), watch.Texts.end(), "Compiling kernels"); };
  filter->Update();
  check.That(count() > 0, "the progress text says that kernels are compiled");
  check.Equal(log.TakeErrors(), std::string(), "to stop is no error");
  check.That(!DisplacementOf(filter), "the update was stopped while kernels were compiled");
  check.That(!filter->GetProgressText(), "the text does not outlive the update");

  watch = Watch();
  filter->SetProgressText("of the user");
  filter->AbortExecuteOff();
  filter->Modified();
  filter->Update();
  check.That(count() > 1, "further kernels are compiled");
  check.That(
    std::count(watch.Texts.begin(), watch.Texts.end(), "ChainMail: pulling") > 0, "then the text names the part");
  check.Equal(std::string(filter->GetProgressText()), std::string("of the user"), "the text of others stays");
  const std::size_t events = watch.Texts.size();
  filter->Update();
  check.Equal(watch.Texts.size(), events, "a text makes no update out of date");

  vtkNew<vtkChainMailDeformation> other;
  prepare(other);
  other->Update();
  check.That(SameBits(DisplacementOf(filter), DisplacementOf(other)), "the update after the stop is as any other");
  check.That(
    SameBits(filter->GetOutput()->GetPointData()->GetScalars(), other->GetOutput()->GetPointData()->GetScalars()),
    "its image, too");
  return check.Finish();
}
