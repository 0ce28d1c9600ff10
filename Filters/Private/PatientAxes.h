// SPDX-License-Identifier: BSD-3-Clause
// The two conventions for world axes in a patient, and the conversion between them.

#ifndef PatientAxes_h
#define PatientAxes_h

#include <string>

namespace vtkChainMail
{

/// To the left, back and head (LPS: DICOM, ITK), or to the right, front and head (RAS: NIfTI, the scene of 3D Slicer).
enum PatientAxes
{
  LPS = 0,
  RAS = 1
};

inline std::string NameOf(PatientAxes axes)
{
  return axes == LPS ? "LPS" : "RAS";
}

/// The signs by which x, y and z are converted; the same in both directions.
inline double SignOf(PatientAxes from, PatientAxes to, int axis)
{
  return from != to && axis < 2 ? -1.0 : 1.0;
}

/// Converts a position or a vector from one convention to the other.
inline void Convert(double p[3], PatientAxes from, PatientAxes to)
{
  for (int a = 0; a < 3; ++a)
  {
    p[a] = SignOf(from, to, a) * p[a] + 0.0; // no -0
  }
}

/// How readers of points or matrices interpret the axes of a file: their property FileWorld.
enum FileAxes
{
  AS_THE_FILE_SAYS = 0,
  FILE_IS_LPS = 1,
  FILE_IS_RAS = 2
};

/// Chooses the axes of a file, with a text about the reason. `said`: whether the file or its format defines the axes;
/// if not, they are the scan's own. `chosen`: a FileAxes.
struct AxesOfFile
{
  PatientAxes Axes = LPS;
  std::string Reason;

  AxesOfFile(bool said, PatientAxes inFile, const std::string& who, int chosen, PatientAxes world)
  {
    if (chosen != AS_THE_FILE_SAYS)
    {
      this->Axes = chosen == FILE_IS_LPS ? LPS : RAS;
      this->Reason = "axes " + std::string(NameOf(this->Axes)) + ", from FileWorld";
      if (said && inFile != this->Axes)
      {
        this->Reason += ", in place of " + std::string(NameOf(inFile)) + " from " + who;
      }
    }
    else if (said)
    {
      this->Axes = inFile;
      this->Reason = "axes " + std::string(NameOf(inFile)) + ", from " + who;
    }
    else
    {
      this->Axes = world;
      this->Reason = "axes " + std::string(NameOf(world)) + ", the scan's own, because " + who +
                     " names none (set FileWorld to change this)";
    }
  }

  /// The whole sentence, with the conversion that was done.
  std::string ToString(PatientAxes world) const
  {
    return this->Reason + "; the scan has " + NameOf(world) +
           " (World): " + (this->Axes == world ? "nothing was converted" : "the signs of x and y were changed") + ".";
  }
};

}

#endif
