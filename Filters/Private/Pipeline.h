// SPDX-License-Identifier: BSD-3-Clause
// What the filter sets in the pipeline's information before an update, and requests from it.

#ifndef Pipeline_h
#define Pipeline_h

#include <vector>

class vtkImageData;
class vtkInformation;
class vtkInformationVector;

namespace vtkChainMail
{

/// The times at which any input changes. Any such input changes the outputs, be it the scan or only a probe.
struct MergedTimes
{
  MergedTimes(vtkInformationVector** inputs, int ports);

  /// Sets the times in the information of an output, or removes them.
  void Tell(vtkInformation* output) const;

  std::vector<double> Steps; ///< ascending
  double Range[2];           ///< Range[0] > Range[1] where there are none
};

/// Gives `image` the geometry of an input that is not updated yet, as far as its pipeline information has it. No
/// arrays.
void DescribeImage(vtkInformation* info, vtkImageData* image);

/// Requests the whole of all inputs, whatever is requested of the outputs, because a wave can come from anywhere.
void AskForAll(vtkInformationVector** inputs, int ports);

/// Requests one piece of the input of a port, after AskForAll(), as one of several processes that have a piece each. A
/// source that cannot give pieces gives everything to the first of them.
void AskForPiece(vtkInformationVector* inputs, int piece, int pieces);

/// Requests the same piece of all outputs as of port `asked` (the first, where `asked` is negative). All are made
/// together, and the executive then considers all of them up to date for this piece.
void AskAlike(vtkInformationVector* outputs, int asked);

}

#endif
