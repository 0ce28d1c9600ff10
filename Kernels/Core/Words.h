#pragma once

// Numbers in messages, as one would type them: "0.35", "1000000", "1e+30".

#include "Model.h"

#include <cstdio>
#include <string>

namespace chainmail
{

inline std::string written(double number)
{
  char text[32];
  std::snprintf(text, sizeof(text), "%.7g", number);
  return text;
}

inline std::string written(const Vector3& v)
{
  return "(" + written(v[0]) + ", " + written(v[1]) + ", " + written(v[2]) + ")";
}

}
