// SPDX-License-Identifier: BSD-3-Clause
// Files of landmarks: their content as written, and their axes.

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
  bool SaysAxes = false; ///< whether the file or its format defines its axes
  PatientAxes Axes = LPS;
  std::string Who; ///< what defines them, for messages: "the file", "the format of elastix"
  std::vector<std::array<double, 3>> Places;
  std::vector<std::array<double, 3>> Targets; ///< one for each place; none where the file has no pairs
  std::vector<std::string> Labels;            ///< one for each place; empty text where a landmark has no label
  bool AreIndices = false;                    ///< whether places are voxel indices, from the image's first voxel
  int LeftOut = 0;                            ///< number of landmarks without a place
};

/// Reads Slicer's .mrk.json and .fcsv, point files of elastix, and tables. The format is recognised by the content
/// (also by the name .fcsv). Throws chainmail::InputError.
std::vector<LandmarkList> ReadLandmarks(const std::string& fileName);

/// Whether a file looks like one of these (also by the name .fcsv), for choosing a reader.
bool IsLandmarkFile(const std::string& fileName);

}

#endif
