// SPDX-License-Identifier: BSD-3-Clause
// The matrices of ITK's transforms by their names and parameters.

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
  std::string Type; ///< as "AffineTransform_double_3_3"
  std::vector<double> Parameters;
  std::vector<double> Fixed; ///< the centre, of most
};

/// The matrix of what a file has: of one transform, or of several that are one (CompositeTransform). Throws
/// chainmail::InputError where it has none, or several that do not belong together.
BodyMotion MotionOf(const std::vector<ItkTransform>& transforms);

}

#endif
