// SPDX-License-Identifier: BSD-3-Clause
// The centroids of the bodies in an image of labels, also where the image is distributed over processes.

#ifndef BodyMiddles_h
#define BodyMiddles_h

#include "RigidMotion.h"

#include <array>
#include <map>
#include <string>
#include <vector>

class vtkImageData;
class vtkInformation;

namespace vtkChainMail
{

class BodyMiddles
{
public:
  /// Finds the centroids of all bodies that have a motion on any process. All processes have to call this. `info` is
  /// the pipeline information of `labels`, with the whole extent. Returns an error message, or an empty text.
  std::string Find(
    vtkImageData* labels, vtkInformation* info, const std::string& arrayName, const std::vector<BodyMotion>& motions);

  /// The centroid of a body in world axes. Returns false where the body has no voxel.
  bool Get(long long body, std::array<double, 3>& middle) const;

private:
  std::map<long long, std::array<double, 3>> Middles;
};

}

#endif
