// SPDX-License-Identifier: BSD-3-Clause
#include "Shown.h"

#include "Outputs.h"

#include "vtkFieldData.h"
#include "vtkNew.h"
#include "vtkStringArray.h"

#include <algorithm>
#include <cmath>

namespace vtkChainMail
{

void Shown::Set(const std::array<vtkSmartPointer<vtkImageData>, 2>& outputs, vtkImageData* image)
{
  this->Outputs = outputs;
  image->GetExtent(this->ImageExtent.data());
}

void Shown::Again(const Inputs& inputs, const std::string& error, int magnification)
{
  int extent[6] = { 0, -1, 0, -1, 0, -1 };
  if (inputs.Image)
  {
    inputs.Image->GetExtent(extent);
  }
  // Downstream filters expect the announced extent. A result of another image has another extent, and with another
  // magnification extents count other voxels.
  const bool isAsFine = this->Outputs[0] && inputs.Image &&
                        std::lround(inputs.Image->GetSpacing()[0] / this->Outputs[0]->GetSpacing()[0]) == magnification;
  for (auto& shown : this->Outputs)
  {
    const bool fits = shown && inputs.Image && std::equal(extent, extent + 6, this->ImageExtent.begin()) &&
                      shown->GetNumberOfPoints() > 0 && (isAsFine || &shown != &this->Outputs[0]);
    auto again = vtkSmartPointer<vtkImageData>::New();
    if (fits)
    {
      again->ShallowCopy(shown);
    }
    else if (inputs.Image && &shown == &this->Outputs[0])
    {
      again->ShallowCopy(inputs.Image); // has its own field data object
    }
    else if (inputs.Image)
    {
      again->CopyStructure(inputs.Image);
    }
    if (!fits)
    {
      Outputs::RemoveFigures(again->GetFieldData());
    }
    vtkNew<vtkStringArray> message;
    message->SetName("Error");
    message->InsertNextValue(error);
    again->GetFieldData()->AddArray(message);
    shown = again;
  }
}

}
