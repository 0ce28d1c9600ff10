#pragma once

#include "SerialChainMail.h"

#include <cstdint>

namespace baseline
{

/// Over-relaxation on one grid with a fixed factor, as it is found in textbooks: elements in two colours, each to the
/// weighted mean of its neighbours over-relaxed by omega, and then into the limits of its links; rigid bodies (links
/// without give) as one unknown each, last. Counts sweeps; plain C++, in double precision.
class OverRelaxation
{
public:
  OverRelaxation(const std::array<int, 3>& size, const std::vector<float>& constraint);

  /// Where relaxation starts. `held`: elements that stay.
  void start(const State& state, const std::vector<char>& held);

  void sweep(double omega);

  double energy() const;
  State state() const;

private:
  struct Box
  {
    double weight = 0.0;
    double sum = 0.0;
    double low;
    double high;
  };
  void sweepAxis(int axis, double omega);
  void add(Box& box, int axis, std::size_t i, std::size_t j) const;
  double relaxed(const Box& box, double u, double omega) const;
  template <typename Visit> void eachNeighbour(std::size_t i, Visit&& visit) const;

  std::array<int, 3> size_;
  std::vector<double> constraint_;
  std::vector<char> held_;
  std::array<std::vector<double>, 3> u_;
  std::vector<std::vector<std::size_t>> bodies_;
};

}
