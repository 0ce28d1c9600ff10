// SPDX-License-Identifier: BSD-3-Clause
// Holds the complete outputs that the filter shows, also after an update that failed.

#ifndef Shown_h
#define Shown_h

#include "ImageParts.h"
#include "Inputs.h"
#include "Team.h"

#include "vtkImageData.h"
#include "vtkSmartPointer.h"

#include <array>
#include <optional>
#include <string>

namespace vtkChainMail
{

class Shown
{
public:
  /// What this process shows of an output; none: all.
  using Request = std::optional<std::array<Extent, 2>>;

  /// Sets both outputs after an update that succeeded with an image of this geometry.
  void Set(const std::array<vtkSmartPointer<vtkImageData>, 2>& outputs, vtkImageData* whole);

  /// After an update that failed: keeps the last outputs, with the error in their field array Error. If there are none
  /// for an image with this extent, or their magnification differs from the announced one, `magnification`, shows the
  /// image as it is. All processes call this together; `inputs` are those of all processes, on the root.
  void Again(
    const Team& team, const Inputs& inputs, const std::string& error, int magnification, const Request& request);

  /// An output, or this process's part of it. Null before the first update.
  vtkImageData* Get(int port) const { return this->Outputs[port]; }

private:
  std::array<vtkSmartPointer<vtkImageData>, 2> Outputs;
  Extent ImageExtent{ { 0, -1, 0, -1, 0, -1 } }; // of the image from which the outputs were made
};

}

#endif
