// SPDX-License-Identifier: BSD-3-Clause
// How much of its displacement and rotation a probe reached, as numbers and as text.

#ifndef HowFar_h
#define HowFar_h

#include "Types.h"

#include "vtkMath.h"

#include <algorithm>
#include <string>

namespace vtkChainMail
{

class HowFar
{
public:
  HowFar() = default;
  HowFar(const chainmail::Probe& probe, const chainmail::ProbeResult& result)
    : Asked(vtkMath::Norm(probe.displacement.data()))
    , Reached(vtkMath::Norm(result.reached.data()))
    , AskedAngle(probe.rotates ? vtkMath::DegreesFromRadians(vtkMath::Norm(probe.rotation.data())) : 0.0)
    , ReachedAngle(vtkMath::DegreesFromRadians(vtkMath::Norm(result.rotated.data())))
  {
  }

  /// The smaller one of the reached shares of displacement and rotation. A displacement up to `leastLength` [mm], or a
  /// rotation up to a thousandth of a degree, counts as reached.
  double GetShare(double leastLength = 0.0) const
  {
    constexpr double leastAngle = 1e-3;
    const double ofWay = this->Asked > leastLength ? this->Reached / this->Asked : 1.0;
    const double ofAngle = this->AskedAngle > leastAngle ? this->ReachedAngle / this->AskedAngle : 1.0;
    return std::min(ofWay, ofAngle);
  }

  /// "reached 2 of 3 mm and turned by 4 of 5 degrees", or one of the two. `write` formats the numbers.
  template <typename Write> std::string ToString(const Write& write) const
  {
    const auto of = [&write](double reached, double asked) { return write(reached) + " of " + write(asked); };
    std::string text;
    if (this->Asked > 0.0 || this->AskedAngle == 0.0)
    {
      text = "reached " + of(this->Reached, this->Asked) + " mm";
    }
    if (this->AskedAngle > 0.0)
    {
      text += (text.empty() ? "" : " and ") + ("rotated by " + of(this->ReachedAngle, this->AskedAngle)) + " degrees";
    }
    return text;
  }

private:
  double Asked = 0.0; ///< [mm]
  double Reached = 0.0;
  double AskedAngle = 0.0; ///< [degrees]
  double ReachedAngle = 0.0;
};

}

#endif
