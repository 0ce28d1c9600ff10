#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace baseline
{

/// Sweeps of over-relaxation over a block, as one would write them by hand for a processor: plain C++ on whole arrays
/// with a border of air, the two colours apart so that the compiler makes vectors, two threads. The arithmetic of an
/// element is that of the engine; there are no bricks, nothing is skipped, and there is no bone. The yardstick of what
/// the engine's sweep could reach here.
class DenseSweep
{
public:
  /// Constraints as fractions of the spacing, one for each voxel.
  DenseSweep(const std::array<int, 3>& size, const std::vector<float>& constraint);

  /// Whether this processor has the instructions that the sweep was compiled for.
  static bool runsHere();

  /// Displacements to start from, by axis. `held`: elements that stay.
  void start(const std::array<std::vector<float>, 3>& state, const std::vector<char>& held);
  void sweep(float omega);
  std::array<std::vector<float>, 3> state() const;

private:
  std::size_t at(int n, int j, int k) const
  {
    return static_cast<std::size_t>(n + 1) + this->strideY_ * (j + 1) + this->strideZ_ * (k + 1);
  }
  template <typename F> void each(const F& f) const;
  void relaxLayers(int colour, int first, int last, float omega);

  std::array<int, 3> size_;
  int half_; ///< elements of one colour in a row
  std::size_t strideY_;
  std::size_t strideZ_;
  std::vector<float> given_;
  std::array<std::vector<float>, 2> constraint_;               ///< by colour; negative where held, infinite in air
  std::array<std::array<std::vector<float>, 3>, 2> displaced_; ///< by colour and axis
};

}
