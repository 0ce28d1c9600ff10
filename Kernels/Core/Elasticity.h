#pragma once

#include "ElementRule.h"

#include <string>

namespace chainmail
{

/// The energy of strain: weight() * pull()^2 per link and axis, within the limits of links.
struct Elasticity
{
  /// 1 - elastic recovery, in [0, 1]: strain of a link up to this share of its limit costs no energy.
  float slack = 0.0f;
  bool limited = true; ///< whether relaxation keeps links within their limits, given a state that does

  /// The -D options of kernels that compute the energy. Without slack the element rule has less to compute.
  std::string ofLinks() const { return this->slack > 0.0f ? " -DPLASTIC" : ""; }
  /// The -D options of kernels that relax elements.
  std::string defines() const { return this->ofLinks() + (this->limited ? "" : " -DUNLIMITED"); }

  static double weight(double limit) { return rule::wide::linkWeight(limit); }

  /// The offset from u(i) to the nearest displacement at which a link to u(j) has no energy.
  double pull(double ui, double uj, double limit) const { return rule::wide::linkPull(ui, uj, limit, this->slack); }
};

}
