// SPDX-License-Identifier: BSD-3-Clause
// Holds the complete outputs that the filter shows, also after an update that failed.

#ifndef Shown_h
#define Shown_h

#include "Inputs.h"

#include "vtkImageData.h"
#include "vtkSmartPointer.h"

#include <array>
#include <string>

namespace vtkChainMail
{

class Shown
{
public:
  /// Sets both outputs after an update that succeeded with this image.
  void Set(const std::array<vtkSmartPointer<vtkImageData>, 2>& outputs, vtkImageData* image);

  /// After an update that failed: keeps the last outputs, with the error in their field array Error. If there are none
  /// for an image with this extent, or their magnification differs from the announced one, `magnification`, shows the
  /// image as it is.
  void Again(const Inputs& inputs, const std::string& error, int magnification);

  /// A complete output. Null before the first update, and where another process computes.
  vtkImageData* Get(int port) const { return this->Outputs[port]; }

private:
  std::array<vtkSmartPointer<vtkImageData>, 2> Outputs;
  std::array<int, 6> ImageExtent{ { 0, -1, 0, -1, 0, -1 } }; // of the image from which the outputs were made
};

}

#endif
