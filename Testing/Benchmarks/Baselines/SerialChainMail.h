#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace baseline
{

/// Displacements of a block, an array for each axis, x fastest; fractions of the spacing.
using State = std::array<std::vector<float>, 3>;

/// Serial ChainMail over a block of tissue without air, in the two published orders. Link limits are means of the
/// constraints at their ends, and a shift puts an element into the box of the neighbour that pulls it, axis by axis.
///
/// - First moved, first processed: S. Gibson, "3D ChainMail: a fast algorithm for deforming volumetric objects", 1997.
///   Right for homogeneous tissue.
/// - Largest violation first: M. Schill, S. Gibson, H.-J. Bender, R. Maenner, "Biomechanical simulation of the vitreous
///   humor in the eye using an enhanced ChainMail algorithm", 1998. Right for heterogeneous tissue, too: the largest
///   violation is that of the link over which the deformation arrives first.
class SerialChainMail
{
public:
  SerialChainMail(const std::array<int, 3>& size, std::vector<float> constraint);

  const State& state() const { return this->state_; }

  /// Everything back to its rest place.
  void reset();

  /// Moves one element to this displacement and what must follow, from rest. Both return how many elements moved.
  std::size_t pullFirstMovedFirst(std::size_t element, const std::array<double, 3>& displacement);
  std::size_t pullLargestViolationFirst(std::size_t element, const std::array<double, 3>& displacement);

private:
  bool place(std::size_t element, const std::array<double, 3>& displacement);
  template <typename Visit> void eachNeighbour(std::size_t element, Visit&& visit) const;

  std::array<int, 3> size_;
  std::vector<float> constraint_;
  State state_;
  std::vector<char> moved_;
};

}
