// SPDX-License-Identifier: BSD-3-Clause
// Files of matrices: their content as written, and their axes.

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
  bool SaysAxes = false; ///< whether the format defines its axes
  PatientAxes Axes = LPS;
  std::string Who;                 ///< what defines them, for messages
  std::vector<BodyMotion> Motions; ///< in these axes; a body without a label in the file is -1
};

/// Reads transforms of ITK (text, and Matlab's binary format, but not HDF5), 4 x 4 numbers, and tables of a label and
/// 16 numbers a row. The format is recognised by the content, whatever the name. Throws chainmail::InputError.
MatrixFile ReadMatrices(const std::string& fileName);

/// Whether the content of a file looks like one of these; also true for HDF5, for its error message.
bool IsMatrixFile(const std::string& fileName);

}

#endif
