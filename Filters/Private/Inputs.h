// SPDX-License-Identifier: BSD-3-Clause
// The inputs of an update: the image, and the datasets of the other ports as one list of leaves. So composite data and
// data of several processes are handled alike.

#ifndef Inputs_h
#define Inputs_h

#include "Fingerprint.h"

#include "vtkImageData.h"
#include "vtkPolyData.h"
#include "vtkSmartPointer.h"

#include <array>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

class vtkInformationVector;

namespace vtkChainMail
{

class SpreadImage;

/// The filter's input ports.
enum Ports
{
  IMAGE = 0,
  PROBES = 1,
  CUTS = 2,
  CARVES = 3,
  REGIONS = 4,
  NUMBER_OF_PORTS
};

/// What a port takes.
struct PortKind
{
  const char* Name;   ///< for messages
  const char* Type;   ///< the class that a dataset has to be of
  const char* Points; ///< what its points are, for messages; null where the port takes no points
};

/// For each port its kind.
extern const std::array<PortKind, NUMBER_OF_PORTS> PortKinds;

/// One dataset of Probes, Cuts, Carves or Regions: a connected dataset, or a leaf of a connected composite dataset.
struct InputDataset
{
  int Port = 0;
  int Input = 0;         ///< number of the connection
  int Block = -1;        ///< flat index in a composite dataset; -1 where it is none
  std::string BlockName; ///< the user's name for the block; may be empty
  int Process = 0;       ///< the process of a parallel server that has it
  /// Points with their arrays (Probes, Regions), or points, polygons and strips (Cuts, Carves).
  vtkSmartPointer<vtkPolyData> Data;

  /// The name for messages: "Probes input 0", with block and process where there are several.
  std::string ToString() const;

  /// The fingerprint of all that an update may read of this dataset.
  Fingerprint GetFingerprint() const;
};

struct Inputs
{
  /// What is wrong with the inputs, in a sentence for the user; empty where nothing is.
  std::string Problem;
  /// Null where the process has no image. Where the image is spread: the root's own part.
  vtkSmartPointer<vtkImageData> Image;
  std::shared_ptr<SpreadImage> Spread; ///< on the root, where the image is spread; else null
  bool IsReleased = false;             ///< whether VTK frees the image after the update (ReleaseDataFlag)
  std::array<int, 6> WholeExtent{ { 0, -1, 0, -1, 0, -1 } };
  /// In the order of port, input, block and process.
  std::vector<InputDataset> Leaves;

  /// An image with the geometry of the whole image; null where there is none.
  vtkImageData* GetWhole() const;

  /// The fingerprints of everything in the image, and in the leaves, that can change an output.
  Fingerprint GetImageFingerprint() const;
  Fingerprint GetLeavesFingerprint() const;
};

/// The inputs of this process. Empty datasets are left out.
Inputs CollectInputs(vtkInformationVector** inputs);

/// Detects whether an update has anything to do.
class InputWatch
{
public:
  /// Whether no property of the filter and nothing in its inputs has changed since the last call. `inputs` are the
  /// contents of `connected`; `filterTime` is when a property last changed.
  bool IsUnchanged(vtkInformationVector** connected, const Inputs& inputs, vtkMTimeType filterTime);
  /// Whether the last call of IsUnchanged() found the image as in the call before.
  bool IsImageUnchanged() const { return this->SameImage; }

private:
  /// The datasets of some ports with their times of modification and update, and the fingerprint of their contents.
  struct Watched
  {
    std::vector<std::tuple<vtkDataObject*, vtkMTimeType, vtkMTimeType>> Times;
    Fingerprint Contents = 0;
  };

  vtkMTimeType FilterTime = 0;
  std::string Problem;
  bool SameImage = false;
  Watched Image; // separate from the leaves because it is large and seldom changes
  Watched Leaves;
};

}

#endif
