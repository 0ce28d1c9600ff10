// SPDX-License-Identifier: BSD-3-Clause
// What the filter's outputs show, also where an update fails.

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
  /// Both outputs of an update that succeeded, made from this image.
  void Set(const std::array<vtkSmartPointer<vtkImageData>, 2>& outputs, vtkImageData* image);

  /// Of an update that failed: what was shown last stays, and says so in the field array Error; where there is nothing
  /// yet that is of such an image, the image as it is.
  void Again(const Inputs& inputs, const std::string& error);

  /// An output, whole. Null before the first update, and where another process computes.
  vtkImageData* Get(int port) const { return this->Outputs[port]; }

private:
  std::array<vtkSmartPointer<vtkImageData>, 2> Outputs;
  std::array<int, 6> ImageExtent{ { 0, -1, 0, -1, 0, -1 } }; // of the image that they were made from
};

}

#endif
