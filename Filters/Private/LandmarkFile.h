// SPDX-License-Identifier: BSD-3-Clause
// Files of landmarks: what is in them, as it stands there, and along which axes.

#ifndef LandmarkFile_h
#define LandmarkFile_h

#include "PatientAxes.h"

#include <array>
#include <string>
#include <vector>

namespace vtkChainMail
{

/// Landmarks that have their axes in common.
struct LandmarkList
{
  bool SaysAxes = false; ///< whether the file or its format tells which way its axes go
  PatientAxes Axes = LPS;
  std::string Who; ///< of whom a message says so: "the file", "the format of elastix"
  std::vector<std::array<double, 3>> Places;
  std::vector<std::array<double, 3>> Targets; ///< as many, or none where the file has no pairs
  std::vector<std::string> Labels;            ///< as many; empty where a landmark has none
  bool AreIndices = false;                    ///< voxels of an image, counted from its first one
  int LeftOut = 0;                            ///< landmarks without a place
};

/// Reads Slicer's .mrk.json and .fcsv, point files of elastix, and tables; by their contents, whatever their name.
/// Throws chainmail::InputError.
std::vector<LandmarkList> ReadLandmarks(const std::string& fileName);

/// Whether a file looks like one of these, for the list of readers of a file.
bool IsLandmarkFile(const std::string& fileName);

}

#endif
