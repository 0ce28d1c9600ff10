// SPDX-License-Identifier: BSD-3-Clause
// Carries datasets through a deformation that is given by its model at rest.

#ifndef Carrying_h
#define Carrying_h

#include "CarryMap.h"
#include "ImageParts.h"

#include "vtkFloatArray.h"
#include "vtkImageData.h"
#include "vtkSmartPointer.h"
#include "vtkUnsignedCharArray.h"

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <vector>

class vtkDataArray;
class vtkPointSet;

namespace vtkChainMail
{

/// A deformation, read from the model at rest.
class Carrying
{
public:
  /// Throws InputError where the model lacks an array or one cannot be used.
  explicit Carrying(vtkImageData* model);

  struct Options
  {
    bool Backward = false;
    bool Nearest = false;
    double Background = 0.0; ///< NaN: the value that fits the array
    std::function<bool(const std::string&)> IsLabelArray;
    std::function<void(double)> Progress; ///< may throw
  };

  /// Gives `output` everything of `input` except cell normals, with its points moved and its point normals rotated.
  void Carry(vtkPointSet* input, const Options& options, vtkPointSet* output) const;

  /// Gives `output` the grid of `input` and its point arrays, resampled within `extent`. Returns the names of the cell
  /// arrays that are left out.
  std::vector<std::string> Carry(
    vtkImageData* input, const Options& options, const Extent& extent, vtkImageData* output) const;

private:
  using Matrix = std::array<double, 9>;

  void TurnNormals(vtkPointSet* input, const Options& options, vtkPointSet* output) const;

  vtkSmartPointer<vtkImageData> Model; // only its grid
  vtkSmartPointer<vtkFloatArray> Displacement;
  vtkSmartPointer<vtkUnsignedCharArray> Element;
  vtkSmartPointer<vtkUnsignedCharArray> Links; // null where nothing is cut or carved
  chainmail::Vector3 First;                    // index of the first voxel
  Matrix ToVoxels;                             // from a vector in world axes to voxels
  Matrix ToWorld;
  std::unique_ptr<chainmail::CarryMap> Map;
};

}

#endif
