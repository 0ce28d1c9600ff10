// SPDX-License-Identifier: BSD-3-Clause
// What the pipeline gives to an update: the image, and the datasets of Probes, Cuts and Carves taken apart into their
// leaves, so that composite data and data of several processes are one list.

#ifndef Inputs_h
#define Inputs_h

#include "Fingerprint.h"

#include "vtkImageData.h"
#include "vtkPolyData.h"
#include "vtkSmartPointer.h"

#include <array>
#include <string>
#include <tuple>
#include <vector>

class vtkInformationVector;

namespace vtkChainMail
{

/// The filter's input ports.
enum Ports
{
  IMAGE = 0,
  PROBES = 1,
  CUTS = 2,
  CARVES = 3,
  NUMBER_OF_PORTS
};

/// One dataset of Probes, Cuts or Carves: what is connected, or a leaf of it where that is composite.
struct Leaf
{
  int Port = 0;
  int Input = 0;   ///< number of the connection
  int Block = -1;  ///< flat index in a composite dataset, -1: it is none
  int Process = 0; ///< of a parallel server
  /// Points with their arrays (Probes), or points, polygons and strips (Cuts, Carves).
  vtkSmartPointer<vtkPolyData> Data;

  /// "Probes input 0", with block and process where that is not clear: for messages.
  std::string ToString() const;

  /// Of all that an update reads of it.
  Fingerprint GetFingerprint() const;
};

struct Inputs
{
  /// What is wrong with them, in a sentence for the user; empty: nothing.
  std::string Problem;
  /// Null where the process has none.
  vtkSmartPointer<vtkImageData> Image;
  std::array<int, 6> WholeExtent{ { 0, -1, 0, -1, 0, -1 } };
  /// In order of port, input, block and process.
  std::vector<Leaf> Leaves;

  /// Of all that can change an output.
  Fingerprint GetFingerprint() const;
};

/// This process's own. Empty datasets are left out.
Inputs CollectInputs(vtkInformationVector** inputs);

/// Tells whether an update has anything to do.
class InputWatch
{
public:
  /// Whether no property of the filter and nothing in its inputs changed since this was last asked. `inputs` are those
  /// of `connected`, `filterTime` is when a property changed last.
  bool IsUnchanged(vtkInformationVector** connected, const Inputs& inputs, vtkMTimeType filterTime);

private:
  vtkMTimeType FilterTime = 0;
  std::vector<std::tuple<vtkDataObject*, vtkMTimeType, vtkMTimeType>> Times; // of each dataset, and when it was made
  Fingerprint Contents = 0;
};

}

#endif
