// SPDX-License-Identifier: BSD-3-Clause
// What the filter tells the pipeline before an update, and asks of it.

#ifndef Pipeline_h
#define Pipeline_h

#include <vector>

class vtkImageData;
class vtkInformation;
class vtkInformationVector;

namespace vtkChainMail
{

/// The times at which any input changes. An input that changes with time changes the outputs: the scan, or a probe
/// alone.
struct MergedTimes
{
  MergedTimes(vtkInformationVector** inputs, int ports);

  /// Tells the times to an output, or that there are none.
  void Tell(vtkInformation* output) const;

  std::vector<double> Steps; ///< ascending
  double Range[2];           ///< the first is larger than the second where there are none
};

/// Gives `image`, which gets no points' data, the place of an image that is still to come, as far as it is known.
void DescribeImage(vtkInformation* info, vtkImageData* image);

/// Asks for all of all inputs, whatever is asked of the outputs, since a wave can come from anywhere.
void AskForAll(vtkInformationVector** inputs, int ports);

/// Asks all outputs for the piece that one of them, the first where that is negative, is asked for: they are made
/// together, and the executive then takes all of them for the same piece.
void AskAlike(vtkInformationVector* outputs, int asked);

}

#endif
