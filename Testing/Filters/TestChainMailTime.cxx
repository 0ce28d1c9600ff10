// SPDX-License-Identifier: BSD-3-Clause
// Whatever changes with time changes the outputs: the scan, a probe or a blade while the scan does not. The outputs
// have the time steps of all of them.

#include "FilterTest.h"

#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkObjectFactory.h"
#include "vtkPolyDataAlgorithm.h"
#include "vtkStreamingDemandDrivenPipeline.h"

using namespace FilterTest;
using Pipeline = vtkStreamingDemandDrivenPipeline;

namespace
{

/// Polygons or points that depend on time.
class Timed : public vtkPolyDataAlgorithm
{
public:
  static Timed* New();
  vtkTypeMacro(Timed, vtkPolyDataAlgorithm);

  std::vector<double> Steps;
  std::function<vtkSmartPointer<vtkPolyData>(double)> At;

protected:
  Timed() { this->SetNumberOfInputPorts(0); }

  int RequestInformation(vtkInformation*, vtkInformationVector**, vtkInformationVector* output) override
  {
    vtkInformation* info = output->GetInformationObject(0);
    const double range[2] = { this->Steps.front(), this->Steps.back() };
    info->Set(Pipeline::TIME_STEPS(), this->Steps.data(), static_cast<int>(this->Steps.size()));
    info->Set(Pipeline::TIME_RANGE(), range, 2);
    return 1;
  }

  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector* output) override
  {
    vtkInformation* info = output->GetInformationObject(0);
    const double time =
      info->Has(Pipeline::UPDATE_TIME_STEP()) ? info->Get(Pipeline::UPDATE_TIME_STEP()) : this->Steps.front();
    vtkPolyData::GetData(info)->ShallowCopy(this->At(time));
    vtkPolyData::GetData(info)->GetInformation()->Set(vtkDataObject::DATA_TIME_STEP(), time);
    return 1;
  }
};

vtkStandardNewMacro(Timed);

}

int TestChainMailTime(int, char*[])
{
  Checks check;
  auto image = MakeImage({ { 0, 20, 0, 0, 0, 0 } });
  Fill(image->GetPointData()->GetScalars(), image, [](int i, int, int) { return 10 + i; });

  vtkNew<Timed> probes;
  probes->Steps = { 0.0, 1.0, 2.0 };
  probes->At = [](double time) { return MakeProbes({ { { { 10.0, 0.0, 0.0 } }, { { 0.3 + time, 0.0, 0.0 } } } }); };
  vtkNew<Timed> blades;
  blades->Steps = { 0.5, 2.0, 3.5 };
  blades->At = [](double time)
  {
    const double x = time < 3.0 ? 40.0 : 7.5; // beside the tissue until it strikes
    return MakeBlade({ { { { x, -1.0, -1.0 } }, { { x, 1.0, -1.0 } }, { { x, 1.0, 1.0 } }, { { x, -1.0, 1.0 } } } });
  };

  vtkNew<vtkChainMailDeformation> filter;
  EventLog log(filter);
  filter->SetInputData(image);
  filter->SetProbesConnection(probes->GetOutputPort());
  filter->SetTissueThreshold(1.0);
  filter->SetMaterialFunction(ConstantMaterial(0.5));
  filter->SetRelaxationIterations(0);

  const auto stepsOf = [&](int port)
  {
    filter->UpdateInformation();
    vtkInformation* info = filter->GetOutputInformation(port);
    const double* first = info->Get(Pipeline::TIME_STEPS());
    return first ? std::vector<double>(first, first + info->Length(Pipeline::TIME_STEPS())) : std::vector<double>();
  };
  check.That(stepsOf(0) == std::vector<double>{ 0.0, 1.0, 2.0 }, "the probes' steps");
  filter->SetCutsConnection(blades->GetOutputPort());
  for (int port : { 0, 1 })
  {
    check.That(stepsOf(port) == std::vector<double>{ 0.0, 0.5, 1.0, 2.0, 3.5 }, "the steps of probes and blades");
    const double* range = filter->GetOutputInformation(port)->Get(Pipeline::TIME_RANGE());
    check.That(range && range[0] == 0.0 && range[1] == 3.5, "their range");
  }

  const auto reachedAt = [&](double time)
  {
    filter->UpdateTimeStep(time);
    check.Equal(log.TakeErrors(), std::string(), "no error");
    return Field(filter->GetOutput(), "ProbeReached");
  };
  const auto displacedAt = [&](vtkIdType element)
  { return filter->GetModelOutput()->GetPointData()->GetArray("Displacement")->GetComponent(element, 0); };
  // Forwards, backwards and between the steps. 10 links of at most half a voxel hold the probe: 5 at most.
  for (const double time : { 0.0, 1.0, 2.0, 0.5, 1.0, 3.5, 0.0 })
  {
    check.Near(reachedAt(time), 0.3 + time, 1e-6, "the probe at time " + std::to_string(time));
    // Past the cut between the elements 7 and 8 nothing is pulled.
    check.Near(displacedAt(7), time == 3.5 ? 0.0 : std::max(0.0, 0.3 + time - 1.5), 1e-6, "tissue beyond the blade");
  }

  // Interactive: going to a time is an update like any other.
  filter->SetModeToInteractive();
  check.Near(reachedAt(1.0), 1.3, 1e-6, "interactive, at 1");
  check.Near(reachedAt(2.0), 2.3, 1e-6, "interactive, at 2");
  check.Near(reachedAt(0.0), 0.3, 1e-6, "interactive, back at 0");

  filter->SetProbesConnection(nullptr);
  filter->SetCutsConnection(nullptr);
  check.That(stepsOf(0).empty(), "no steps where nothing changes with time");
  return check.Finish();
}
