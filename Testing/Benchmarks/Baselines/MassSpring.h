#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace baseline
{

/// A mass-spring model on a grid of nodes, in OpenCL: cubes of eight nodes are cut into five tetrahedra each, whose
/// edges are springs. After J. Georgii, R. Westermann: "Mass-spring systems on the GPU", Simulation Modelling Practice
/// and Theory 13 (2005), doi:10.1016/j.simpat.2005.08.004: point-centric, explicit Verlet integration. Unit spacing,
/// masses and stiffness.
class MassSpring
{
public:
  using Place = std::array<float, 3>;

  MassSpring(const std::string& device, const std::array<int, 3>& nodes);
  ~MassSpring();

  std::size_t tetrahedra() const;
  std::size_t springs() const;

  /// All nodes to their rest places, at rest, none held.
  void reset();

  /// Nodes that stay where they are put. Displacements are from the rest places.
  void hold(const std::vector<std::size_t>& nodes, const Place& displacement);

  /// Time goes on by so many steps. `damping`: share of the velocity that a step takes away.
  void step(int steps, float damping);

  /// Displacements from the rest places.
  std::vector<Place> displacements() const;

  /// Elastic and kinetic energy.
  double energy() const;

private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}
