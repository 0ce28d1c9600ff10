#include "Rotations.h"

#include "ElementRule.h"

namespace chainmail
{

float Rotations::restOffset(const float* spinI, const float* spinJ, int direction, int axis) const
{
  const int along = direction / 2;
  float byI[3];
  float byJ[3];
  rule::single::rotationOffsetOfAxis(spinI, along, byI);
  rule::single::rotationOffsetOfAxis(spinJ, along, byJ);
  const float half = direction % 2 == 0 ? -0.5f : 0.5f;
  return half * (byI[axis] + byJ[axis]) * (this->proportions.s[along] / this->proportions.s[axis]);
}

}
