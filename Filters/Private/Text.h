// SPDX-License-Identifier: BSD-3-Clause
// Words of messages.

#ifndef Text_h
#define Text_h

#include "vtkFieldData.h"

#include <cmath>
#include <sstream>
#include <string>

namespace vtkChainMail
{

/// "(1, 2, 3)".
inline std::string ToString(const double p[3])
{
  std::ostringstream text;
  text << "(" << p[0] << ", " << p[1] << ", " << p[2] << ")";
  return text.str();
}

inline bool IsFinite(const double p[3])
{
  return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
}

/// "It has: a, b." for messages about names that are not there.
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
