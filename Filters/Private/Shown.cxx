// SPDX-License-Identifier: BSD-3-Clause
#include "Shown.h"

#include "Outputs.h"

#include "vtkFieldData.h"
#include "vtkMultiProcessStream.h"
#include "vtkNew.h"
#include "vtkStringArray.h"

#include <cmath>

namespace vtkChainMail
{

void Shown::Set(const std::array<vtkSmartPointer<vtkImageData>, 2>& outputs, vtkImageData* whole)
{
  this->Outputs = outputs;
  this->ImageExtent = ExtentOf(whole);
}

void Shown::Again(
  const Team& team, const Inputs& inputs, const std::string& error, int magnification, const Request& request)
{
  // What is to be shown is the same in all processes.
  const Exchange& exchange = team.GetLink();
  vtkImageData* image = inputs.GetWhole();
  vtkMultiProcessStream about;
  about << (image != nullptr);
  for (const int e : ExtentOf(image))
  {
    about << e;
  }
  about << (image ? image->GetSpacing()[0] : 1.0);
  exchange.FromRoot(about);
  bool hasImage;
  Extent extent;
  double spacing;
  about >> hasImage;
  for (int& e : extent)
  {
    about >> e;
  }
  about >> spacing;
  // Downstream filters expect the announced extent. A result of another image has another extent, and with another
  // magnification extents count other voxels.
  const bool isAsFine =
    this->Outputs[0] && hasImage && std::lround(spacing / this->Outputs[0]->GetSpacing()[0]) == magnification;
  for (std::size_t port = 0; port < this->Outputs.size(); ++port)
  {
    auto& shown = this->Outputs[port];
    bool fits = shown && hasImage && extent == this->ImageExtent && (isAsFine || port == 1);
    fits = fits && (request ? ExtentOf(shown) == (*request)[port] : shown->GetNumberOfPoints() > 0);
    fits = exchange.All(fits);
    auto again = vtkSmartPointer<vtkImageData>::New();
    if (fits)
    {
      again->ShallowCopy(shown);
    }
    else
    {
      if (inputs.Image && port == 0 && !team.IsSpread())
      {
        again->ShallowCopy(inputs.Image); // has its own field data object
      }
      else if (image)
      {
        again->CopyStructure(image);
      }
      again = request ? exchange.Deliver(again, (*request)[port]) : again;
      if (team.IsSpread() && port == 0)
      {
        const Extent wanted = Common((*request)[port], extent);
        Steps steps; // without memory for the voxels there are none
        steps.Exchange(
          [&]
          {
            const vtkSmartPointer<vtkImageData> voxels = team.Fetch(wanted);
            again = voxels ? voxels : again;
          });
      }
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
