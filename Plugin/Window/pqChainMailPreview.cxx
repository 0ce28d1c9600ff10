// SPDX-License-Identifier: BSD-3-Clause
#include "pqChainMailPreview.h"

#include "vtkAlgorithm.h"
#include "vtkAlgorithmOutput.h"
#include "vtkCallbackCommand.h"
#include "vtkChainMailDeformation.h"
#include "vtkCommand.h"
#include "vtkDataArraySelection.h"
#include "vtkExtractVOI.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkSMDoubleVectorProperty.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMPropertyIterator.h"
#include "vtkSMProxy.h"
#include "vtkSMRepresentationProxy.h"
#include "vtkSMSessionProxyManager.h"
#include "vtkSMSourceProxy.h"
#include "vtkStreamingDemandDrivenPipeline.h"
#include "vtkTimerLog.h"

#include "pqUndoStack.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace
{
// As many as a drag begins with; the fewest along an axis of a volume that has more; and what still shows where the
// tissue goes.
constexpr double FirstVoxels = 1e6;
constexpr int FewestVoxels = 24;
constexpr int LargestStep = 4;

/// Another proxy with the same settings and no inputs, which nobody sees.
vtkSmartPointer<vtkSMProxy> CloneOf(vtkSMProxy* proxy)
{
  vtkSmartPointer<vtkSMProxy> twin;
  twin.TakeReference(proxy->GetSessionProxyManager()->NewProxy(proxy->GetXMLGroup(), proxy->GetXMLName()));
  twin->Copy(proxy, "vtkSMInputProperty");
  twin->UpdateVTKObjects();
  twin->PrototypeOn(); // nothing for Undo
  return twin;
}

vtkAlgorithm* AlgorithmOf(vtkSMProxy* proxy)
{
  return vtkAlgorithm::SafeDownCast(proxy->GetClientSideObject());
}

/// Whether a filter takes what a source makes.
bool HasFiltersBehind(vtkSMProxy* source)
{
  bool has = false;
  for (unsigned int n = 0; n < source->GetNumberOfConsumers(); ++n)
  {
    vtkSMProxy* consumer = source->GetConsumerProxy(n);
    has = has || (vtkSMSourceProxy::SafeDownCast(consumer) && !vtkSMRepresentationProxy::SafeDownCast(consumer));
  }
  return has;
}

/// Whether a connection comes from a source, perhaps through the filter that ParaView puts behind each.
bool IsFrom(vtkAlgorithmOutput* connection, vtkAlgorithm* source)
{
  vtkAlgorithm* producer = connection->GetProducer();
  return producer == source || (producer->IsA("vtkPVPostFilter") && producer->GetInputAlgorithm() == source);
}
}

//------------------------------------------------------------------------------
bool pqChainMailPreview::canShow(vtkSMProxy* deformation)
{
  auto* filter = vtkChainMailDeformation::SafeDownCast(deformation->GetClientSideObject());
  if (filter == nullptr || filter->GetMode() != vtkChainMailDeformation::MODE_FROM_REST ||
      !std::string(filter->GetBodyArray() ? filter->GetBodyArray() : "").empty() || filter->GetJointSize() != 0)
  {
    return false;
  }
  if (HasFiltersBehind(deformation))
  {
    return false;
  }
  auto* image = vtkImageData::SafeDownCast(filter->GetInputDataObject(0, 0));
  return image && image->GetDataDimension() == 3;
}

//------------------------------------------------------------------------------
pqChainMailPreview::pqChainMailPreview(vtkSMProxy* deformation, vtkSMProxy* dragged)
  : Deformation(deformation)
  , Dragged(dragged)
{
  BEGIN_UNDO_EXCLUDE();
  this->Clone = CloneOf(deformation);
  this->DraggedClone = CloneOf(dragged);
  END_UNDO_EXCLUDE();
  this->Filter = vtkChainMailDeformation::SafeDownCast(this->Clone->GetClientSideObject());
  this->Filter->SetController(nullptr);
  // The deformation itself will say what is wrong, once, when the drag has ended.
  vtkNew<vtkCallbackCommand> silence;
  silence->SetCallback([](vtkObject*, unsigned long, void*, void*) {});
  this->Filter->AddObserver(vtkCommand::ErrorEvent, silence);
  this->Filter->AddObserver(vtkCommand::WarningEvent, silence);
}

//------------------------------------------------------------------------------
pqChainMailPreview::~pqChainMailPreview() = default;

//------------------------------------------------------------------------------
void pqChainMailPreview::begin()
{
  BEGIN_UNDO_EXCLUDE();
  this->Clone->Copy(this->Deformation, "vtkSMInputProperty");
  vtkSMPropertyHelper(this->Clone, "RelaxationPreset").Set(vtkChainMailDeformation::RELAXATION_FAST);
  this->Clone->UpdateVTKObjects();
  this->DraggedClone->Copy(this->Dragged, "vtkSMInputProperty");
  this->DraggedClone->UpdateVTKObjects();
  END_UNDO_EXCLUDE();
  this->Filter->GetModelArraySelection()->DisableAllArrays();
  this->end();
  this->connect();
  const std::array<int, 6> extent = this->extentOfScan();
  const double voxels = (extent[1] - extent[0] + 1.0) * (extent[3] - extent[2] + 1.0) * (extent[5] - extent[4] + 1.0);
  if (this->Step == 0)
  {
    this->Step = std::clamp(static_cast<int>(std::ceil(std::cbrt(voxels / FirstVoxels))), 1, LargestStep);
  }
  else if (this->Step > 1 && this->Milliseconds > 0.0 &&
           this->Milliseconds * std::pow(this->Step / (this->Step - 1.0), 3) < this->allowedMilliseconds)
  {
    --this->Step;
  }
  this->Milliseconds = this->LastMilliseconds = 0.0;
  this->thin();
}

//------------------------------------------------------------------------------
void pqChainMailPreview::end()
{
  this->Thinned->SetInputConnection(nullptr);
  for (int port = 0; port < this->Filter->GetNumberOfInputPorts(); ++port)
  {
    this->Filter->SetInputConnection(port, nullptr);
  }
}

//------------------------------------------------------------------------------
void pqChainMailPreview::connect()
{
  vtkAlgorithm* whole = AlgorithmOf(this->Deformation);
  vtkAlgorithm* dragged = AlgorithmOf(this->Dragged);
  this->Thinned->SetInputConnection(whole->GetInputConnection(0, 0));
  this->Filter->SetInputConnection(0, this->Thinned->GetOutputPort());
  for (int port = 1; port < whole->GetNumberOfInputPorts(); ++port)
  {
    for (int n = 0; n < whole->GetNumberOfInputConnections(port); ++n)
    {
      vtkAlgorithmOutput* source = whole->GetInputConnection(port, n);
      this->Filter->AddInputConnection(
        port, IsFrom(source, dragged) ? AlgorithmOf(this->DraggedClone)->GetOutputPort() : source);
    }
  }
}

//------------------------------------------------------------------------------
std::array<int, 6> pqChainMailPreview::extentOfScan()
{
  // What the deformation read the last time may be another image than what it would read now.
  std::array<int, 6> extent{ { 0, -1, 0, -1, 0, -1 } };
  this->Thinned->GetInputAlgorithm()->UpdateInformation();
  this->Thinned->GetInputInformation()->Get(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT(), extent.data());
  return extent;
}

//------------------------------------------------------------------------------
void pqChainMailPreview::thin()
{
  std::array<int, 6> extent = this->extentOfScan();
  int step[3];
  for (int a = 0; a < 3; ++a)
  {
    step[a] = std::max(1, std::min(this->Step, (extent[2 * a + 1] - extent[2 * a] + 1) / FewestVoxels));
  }
  this->Thinned->SetVOI(extent.data());
  this->Thinned->SetSampleRate(step);
  const int padding = vtkSMPropertyHelper(this->Deformation, "OutputPadding").GetAsInt();
  this->Filter->SetOutputPadding((padding + this->Step - 1) / this->Step);
  this->Filter->SetOutputMagnification(1);
  // As much as of the scan's own voxels.
  this->Filter->SetScalarSmoothing(
    vtkSMPropertyHelper(this->Deformation, "ScalarSmoothing").GetAsDouble() / this->Step);
}

//------------------------------------------------------------------------------
vtkImageData* pqChainMailPreview::update(double time)
{
  const auto properties = vtkSmartPointer<vtkSMPropertyIterator>::Take(this->Dragged->NewPropertyIterator());
  for (properties->Begin(); !properties->IsAtEnd(); properties->Next())
  {
    auto* from = vtkSMDoubleVectorProperty::SafeDownCast(properties->GetProperty());
    auto* to = vtkSMDoubleVectorProperty::SafeDownCast(this->DraggedClone->GetProperty(properties->GetKey()));
    for (unsigned int n = 0; from && to && n < from->GetNumberOfUncheckedElements(); ++n)
    {
      to->SetElement(n, from->GetUncheckedElement(n));
    }
  }
  this->DraggedClone->UpdateVTKObjects();
  vtkNew<vtkTimerLog> timer;
  timer->StartTimer();
  this->Filter->UpdateTimeStep(time);
  timer->StopTimer();
  this->Milliseconds = 1e3 * timer->GetElapsedTime();
  this->adapt();
  return this->Filter->GetOutput();
}

//------------------------------------------------------------------------------
void pqChainMailPreview::adapt()
{
  // The first update of a model takes longer than those to come, and one slow one may be chance.
  const bool isSlow = std::min(this->Milliseconds, this->LastMilliseconds) > 1.3 * this->allowedMilliseconds;
  this->LastMilliseconds = this->Milliseconds;
  if (isSlow && this->Step < LargestStep)
  {
    ++this->Step;
    this->LastMilliseconds = 0.0;
    this->thin();
  }
}
