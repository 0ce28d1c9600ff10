// SPDX-License-Identifier: BSD-3-Clause
// Holds the whole outputs that the filter shows, also where an update fails.

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

  /// After an update that failed: keeps what was shown last, with the error in its field array Error. Where nothing was
  /// shown yet of an image with this extent, or the deformed image is not so many times as fine as that as readers
  /// expect, shows the image as it is.
  void Again(const Inputs& inputs, const std::string& error, int magnification);

  /// An output, whole. Null before the first update, and where another process computes.
  vtkImageData* Get(int port) const { return this->Outputs[port]; }

private:
  std::array<vtkSmartPointer<vtkImageData>, 2> Outputs;
  std::array<int, 6> ImageExtent{ { 0, -1, 0, -1, 0, -1 } }; // of the image from which the outputs were made
};

}

#endif
