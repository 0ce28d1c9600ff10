// SPDX-License-Identifier: BSD-3-Clause
// What the pipeline is told before an update.

#ifndef Pipeline_h
#define Pipeline_h

#include <vector>

class vtkInformation;
class vtkInformationVector;

namespace vtkChainMail
{

/// Times at which what comes in changes: whatever changes with time changes the outputs, be it the scan, or a probe
/// while the scan does not.
struct MergedTimes
{
  MergedTimes(vtkInformationVector** inputs, int ports);

  /// Tells them of an output; where there are none, that there are none.
  void Tell(vtkInformation* output) const;

  std::vector<double> Steps; ///< ascending
  double Range[2];           ///< the first larger than the second: none
};

/// Asks for all of all inputs, whatever is asked of the outputs: a wave can come from anywhere.
void AskForAll(vtkInformationVector** inputs, int ports);

}

#endif
