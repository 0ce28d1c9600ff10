// SPDX-License-Identifier: BSD-3-Clause
// Files of matrices: what is in them, as it stands there, and along which axes.

#ifndef MatrixFile_h
#define MatrixFile_h

#include "PatientAxes.h"
#include "RigidMotion.h"

#include <string>
#include <vector>

namespace vtkChainMail
{

struct MatrixFile
{
  bool SaysAxes = false; ///< whether the format tells which way its axes go
  PatientAxes Axes = LPS;
  std::string Who;                 ///< of whom a message says so
  std::vector<BodyMotion> Motions; ///< in these axes; the bodies are those of the file, else -1
};

/// Reads transforms of ITK (text, Matlab's binary and, where this was built with HDF5, .h5), 4 x 4 numbers, and tables
/// of a label and 16 numbers a row; by their contents, whatever their name. Throws chainmail::InputError.
MatrixFile ReadMatrices(const std::string& fileName);

/// Whether a file looks like one of these.
bool IsMatrixFile(const std::string& fileName);

}

#endif
