#pragma once

// Numbers in messages, as a person writes them: "0.35", "16777217", "1e+30".

#include "Model.h"

#include <cmath>
#include <cstdio>
#include <string>

namespace chainmail
{

/// Whole numbers are written in full up to a million billions, others with up to `digits` digits if needed.
inline std::string toString(double number, int digits = 7)
{
  const bool isWhole = std::fabs(number) < 1e15 && std::nearbyint(number) == number;
  // With fewer digits than the number has before the point, %g would print an exponent.
  const bool isLong = std::fabs(number) < 1e15 && std::fabs(number) >= std::pow(10.0, digits) - 0.5;
  char text[32];
  if (isWhole || isLong)
  {
    std::snprintf(text, sizeof(text), "%.0f", number);
  }
  else
  {
    std::snprintf(text, sizeof(text), "%.*g", digits, number);
  }
  return number == 0.0 ? "0" : text; // and not "-0"
}

inline std::string toString(const Vector3& v)
{
  return "(" + toString(v[0]) + ", " + toString(v[1]) + ", " + toString(v[2]) + ")";
}

/// A number of voxels along each axis.
inline std::string toString(const Index3& size)
{
  return std::to_string(size[0]) + " x " + std::to_string(size[1]) + " x " + std::to_string(size[2]);
}

}
