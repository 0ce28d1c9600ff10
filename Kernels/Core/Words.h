#pragma once

// Numbers in messages, as a person writes them: "0.35", "16777217", "1e+30".

#include "Model.h"

#include <cmath>
#include <cstdio>
#include <string>

namespace chainmail
{

/// Whole numbers in full, up to a million billions; others with so many digits, if that many are needed.
inline std::string written(double number, int digits = 7)
{
  const bool isWhole = std::fabs(number) < 1e15 && std::nearbyint(number) == number;
  // Fewer digits than stand before the point would bring an exponent.
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

inline std::string written(const Vector3& v)
{
  return "(" + written(v[0]) + ", " + written(v[1]) + ", " + written(v[2]) + ")";
}

}
