// SPDX-License-Identifier: BSD-3-Clause
// The matrices of ITK's transforms, from their type names and parameters.

#ifndef ItkTransform_h
#define ItkTransform_h

#include "RigidMotion.h"

#include <string>
#include <vector>

namespace vtkChainMail
{

/// A transform as ITK writes it, in whichever format.
struct ItkTransform
{
  std::string Type; ///< for example "AffineTransform_double_3_3"
  std::vector<double> Parameters;
  std::vector<double> Fixed; ///< for most types the centre of rotation
};

/// The matrix of a file's transform, or of the several transforms of one CompositeTransform. Throws
/// chainmail::InputError where there is none, or several without a CompositeTransform.
BodyMotion MotionOf(const std::vector<ItkTransform>& transforms);

}

#endif
