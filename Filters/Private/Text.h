// SPDX-License-Identifier: BSD-3-Clause
// Formats numbers and lists for messages.

#ifndef Text_h
#define Text_h

#include "Format.h"

#include "vtkFieldData.h"

#include <cmath>
#include <string>

namespace vtkChainMail
{

inline std::string ToString(double number)
{
  return chainmail::toString(number);
}

/// Writes a place as "(1, 2, 3)".
inline std::string ToString(const double p[3])
{
  return chainmail::toString(chainmail::Vector3{ p[0], p[1], p[2] });
}

inline bool IsFinite(const double p[3])
{
  return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
}

/// Writes "It has: a, b.", for messages about the name of an array that is missing.
inline std::string ListArrays(vtkFieldData* arrays)
{
  std::string list;
  for (int a = 0; a < arrays->GetNumberOfArrays(); ++a)
  {
    const char* name = arrays->GetArrayName(a);
    if (name)
    {
      list += (list.empty() ? "" : ", ") + std::string(name);
    }
  }
  return list.empty() ? "It has none." : "It has: " + list + ".";
}

}

#endif
