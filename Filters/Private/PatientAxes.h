// SPDX-License-Identifier: BSD-3-Clause
// The two ways in which world axes go through a patient, and the way from one to the other.

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

/// The factors of x, y and z from one to the other, which is the same both ways.
inline double SignOf(PatientAxes from, PatientAxes to, int axis)
{
  return from != to && axis < 2 ? -1.0 : 1.0;
}

/// A place or a vector, counted along the other axes.
inline void Convert(double p[3], PatientAxes from, PatientAxes to)
{
  for (int a = 0; a < 3; ++a)
  {
    p[a] = SignOf(from, to, a) * p[a] + 0.0; // no -0
  }
}

/// What files of points or matrices are taken for: a property of their readers.
enum FileAxes
{
  AS_THE_FILE_SAYS = 0,
  FILE_IS_LPS = 1,
  FILE_IS_RAS = 2
};

/// Chooses the axes of a file, and says in words why. `said`: whether the file or its format tells; if not it is taken
/// to have the scan's own axes.
struct AxesOfFile
{
  PatientAxes Axes = LPS;
  std::string Reason;

  AxesOfFile(bool said, PatientAxes inFile, const std::string& who, int chosen, PatientAxes world)
  {
    if (chosen != AS_THE_FILE_SAYS)
    {
      this->Axes = chosen == FILE_IS_LPS ? LPS : RAS;
      this->Reason = "read as " + NameOf(this->Axes) + ", as FileWorld says";
      if (said && inFile != this->Axes)
      {
        this->Reason += ", although " + who + " says " + NameOf(inFile);
      }
    }
    else if (said)
    {
      this->Axes = inFile;
      this->Reason = who + " says " + NameOf(inFile);
    }
    else
    {
      this->Axes = world;
      this->Reason = who + " does not say which way its axes go, taken for the scan's own, " + NameOf(world) +
                     " (FileWorld says otherwise)";
    }
  }

  /// The whole sentence, with what was done.
  std::string ToString(PatientAxes world) const
  {
    return this->Reason + "; the scan's world is " + NameOf(world) + ": " +
           (this->Axes == world ? "nothing converted" : "x and y changed their signs") + ".";
  }
};

}

#endif
