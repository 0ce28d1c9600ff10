// SPDX-License-Identifier: BSD-3-Clause
// Where the bodies of an image of labels have their middle, also where the image is spread over processes.

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
  /// Finds the middles of all bodies that have a motion on any process, which all have to call this. `info` is that of
  /// the pipeline, with the whole extent. Returns what is wrong, empty where nothing is.
  std::string Find(
    vtkImageData* labels, vtkInformation* info, const std::string& arrayName, const std::vector<BodyMotion>& motions);

  /// The middle of a body in world axes. Returns false where it has no voxel.
  bool Get(long long body, std::array<double, 3>& middle) const;

private:
  std::map<long long, std::array<double, 3>> Middles;
};

}

#endif
