// SPDX-License-Identifier: BSD-3-Clause
#include "vtkChainMailQuickMapper.h"

#include "vtkGPUVolumeRayCastMapper.h"
#include "vtkImageData.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkRenderWindow.h"
#include "vtkRenderer.h"
#include "vtkTimerLog.h"
#include "vtkVersionMacros.h"

#include <algorithm>
#include <iterator>

namespace
{
// Beyond the last one the picture would say little.
const int Steps[] = { 1, 2, 3, 4, 6 };
}

vtkStandardNewMacro(vtkChainMailQuickMapper);

//------------------------------------------------------------------------------
vtkChainMailQuickMapper::vtkChainMailQuickMapper()
{
  // Time is saved between the rays, which blurs. Along a ray samples are half a voxel apart: where they are farther
  // apart skin has rings, and jittered it has dots, as there is no time to take means of several pictures.
#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 3, 0)
  this->UseJitteringOff(); // which tells it to the other one before each picture
#else
  this->GPUMapper->UseJitteringOff();
#endif
  this->GPUMapper->LockSampleDistanceToInputSpacingOff();
  this->InteractiveAdjustSampleDistancesOff();
  this->AutoAdjustSampleDistancesOff();
}

//------------------------------------------------------------------------------
void vtkChainMailQuickMapper::SetImage(vtkImageData* image)
{
  this->Image = image;
}

//------------------------------------------------------------------------------
void vtkChainMailQuickMapper::Render(vtkRenderer* renderer, vtkVolume* volume)
{
  if (this->Image)
  {
    this->SetInputDataObject(this->Image);
  }
  auto* image = vtkImageData::SafeDownCast(this->GetInput());
  if (image)
  {
    const double* spacing = image->GetSpacing();
    this->SetSampleDistance(static_cast<float>(0.5 * std::min({ spacing[0], spacing[1], spacing[2] })));
  }
  this->GPUMapper->SetImageSampleDistance(this->Fine ? 1.0f : static_cast<float>(this->Step));
  vtkNew<vtkTimerLog> timer;
  timer->StartTimer();
  this->Superclass::Render(renderer, volume);
  renderer->GetRenderWindow()->WaitForCompletion(); // a graphics device goes on by itself
  timer->StopTimer();
  if (!this->Fine)
  {
    this->Milliseconds = 1e3 * timer->GetElapsedTime();
    this->FineMilliseconds = this->Milliseconds * this->Step * this->Step;
    this->Adapt();
  }
}

//------------------------------------------------------------------------------
void vtkChainMailQuickMapper::Adapt()
{
  // One slow frame may be chance; of two the faster one tells.
  const double milliseconds = std::min(this->Milliseconds, this->LastMilliseconds);
  this->LastMilliseconds = this->Milliseconds;
  const int* now = std::find(std::begin(Steps), std::end(Steps), this->Step);
  const int* wanted = now;
  if (milliseconds > 1.3 * this->AllowedMilliseconds)
  {
    wanted = std::min(now + 1, std::end(Steps) - 1);
  }
  else if (now != std::begin(Steps) && milliseconds > 0.0)
  {
    const double growth = static_cast<double>(now[0]) / now[-1];
    wanted = milliseconds * growth * growth < 0.8 * this->AllowedMilliseconds ? now - 1 : now;
  }
  if (wanted != now)
  {
    this->Step = *wanted;
    this->LastMilliseconds = 0.0;
  }
}
