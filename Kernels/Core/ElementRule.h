#pragma once

// The rule of one element (element.clh) compiled for the host, once in float and once in double.

#include <cmath>

#define CHAINMAIL_INLINE inline
#define AS_MASK(v) (std::signbit(v) ? -1 : 0)
#define PLASTIC // with a slack of 0 this makes no difference

namespace chainmail::rule
{

/// In float: the same as on the device, to the bit.
namespace single
{

using real = float;
using mask = int;

inline real fabs(real v)
{
  return std::fabs(v);
}
inline real sqrt(real v)
{
  return std::sqrt(v);
}
inline real min(real a, real b)
{
  return b < a ? b : a;
}
inline real max(real a, real b)
{
  return a < b ? b : a;
}
inline real select(real a, real b, mask c)
{
  return c != 0 ? b : a;
}

#include "element.clh"
#include "spin.clh"
#undef REAL

}

/// In double: for sums that need more digits.
namespace wide
{

using real = double;
using mask = int;

inline real fabs(real v)
{
  return std::fabs(v);
}
inline real sqrt(real v)
{
  return std::sqrt(v);
}
inline real min(real a, real b)
{
  return b < a ? b : a;
}
inline real max(real a, real b)
{
  return a < b ? b : a;
}
inline real select(real a, real b, mask c)
{
  return c != 0 ? b : a;
}

#define REAL(number) number
#define WIDE
#include "element.clh"
#include "spin.clh"
#undef WIDE
#undef REAL

}

using single::Link;
using single::linkOf;

/// The signed constraint of an element (see element.clh), marked as held or as not held.
inline float asHeld(float c, bool held)
{
  return held ? -std::fabs(c) : c;
}

}

#undef WEIGHT_EPSILON
#undef PLASTIC
#undef AS_MASK
#undef CHAINMAIL_INLINE
