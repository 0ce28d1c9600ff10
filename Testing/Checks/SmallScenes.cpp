// Small scenes that make the engine run every kernel, in all variants that the tissue chooses, for tools that make
// everything many hundred times slower (oclgrind.sh, valgrind.sh). Whether the results are right is for the unit tests;
// here only what must hold of any state is looked at.
//
//     SmallScenes            plays all
//     SmallScenes NUMBER     plays one, from 0 on
//     SmallScenes --count    prints how many there are

#include "../Unit/Random.h"
#include "Simulation.h"

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace
{

using namespace chainmail;

void require(bool holds, const char* what)
{
  if (!holds)
  {
    throw std::runtime_error(what);
  }
}

/// Tissue of random constraints with bone and holes.
class Tissue
{
public:
  Tissue(const Index3& size, int axes)
    : axes_(axes)
  {
    this->grid_.size = size;
    this->grid_.spacing = { 1.0, 0.5, 2.0 };
    Random random(static_cast<std::uint64_t>(axes));
    for (std::size_t v = 0; v < this->grid_.voxels(); ++v)
    {
      const Index3 at = this->grid_.indexOf(v);
      const bool bone = at[0] >= 3 && at[0] < 5 && at[1] >= 2 && at[1] < 4;
      this->scalars_.push_back(!bone && random(0.0, 1.0) < 0.1 ? 0.0f : 1.0f);
      for (int a = 0; a < axes; ++a)
      {
        this->constraints_.push_back(bone && a != 1 ? 0.0f : static_cast<float>(random(0.05, 0.4)));
      }
    }
    this->scalars_[0] = 1.0f;
  }

  std::shared_ptr<const Model> model(bool anchored) const
  {
    ArrayView scalars;
    scalars.data = this->scalars_.data();
    scalars.type = ArrayView::Type::Float32;
    Material material;
    material.tissueThreshold = 0.5;
    material.constraintArray.data = this->constraints_.data();
    material.constraintArray.type = ArrayView::Type::Float32;
    material.constraintArray.components = this->axes_;
    Anchors anchors;
    anchors.faces.fill(false);
    anchors.faces[1] = anchored;
    return std::make_shared<Model>(this->grid_, scalars, material, anchors);
  }

private:
  Grid grid_;
  int axes_;
  std::vector<float> constraints_;
  std::vector<float> scalars_;
};

Probe probe(const Vector3& position, const Vector3& displacement, double radius = 1.5)
{
  Probe probe;
  probe.position = position;
  probe.displacement = displacement;
  probe.radius = radius;
  return probe;
}

/// A rectangle across the grid at this x [mm].
Surface blade(double x)
{
  return { { { x, -1.0, -1.0 }, { x, 2.2, -1.0 }, { x, 2.2, 40.0 }, { x, -1.0, 40.0 } },
    { { { 0, 1, 2 } }, { { 0, 2, 3 } } } };
}

Surface octahedron(const Vector3& c, double r)
{
  return { { { c[0] - r, c[1], c[2] }, { c[0] + r, c[1], c[2] }, { c[0], c[1] - r, c[2] }, { c[0], c[1] + r, c[2] },
             { c[0], c[1], c[2] - r }, { c[0], c[1], c[2] + r } },
    { { { 0, 2, 4 } }, { { 2, 1, 4 } }, { { 1, 3, 4 } }, { { 3, 0, 4 } }, { { 2, 0, 5 } }, { { 1, 2, 5 } },
      { { 3, 1, 5 } }, { { 0, 3, 5 } } } };
}

/// Reads all that can be read of the model.
void lookAt(const Simulation& simulation)
{
  const std::size_t voxels = simulation.model().grid().voxels();
  const std::size_t axes = static_cast<std::size_t>(simulation.model().axes());
  std::vector<float> u(3 * voxels);
  std::vector<float> times(axes * voxels);
  std::vector<int> numbers(axes * voxels);
  std::vector<std::uint8_t> bytes(voxels);
  simulation.displacements(u.data());
  for (const float value : u)
  {
    require(std::isfinite(value), "a displacement is not finite");
  }
  simulation.propagationTimes(times.data());
  simulation.wavefronts(numbers.data());
  simulation.clusters(numbers.data());
  simulation.elements(bytes.data());
  simulation.links(bytes.data());
  require(std::isfinite(simulation.measure().energy), "the energy is not finite");
  for (const ProbeResult& result : simulation.probes())
  {
    require(std::isfinite(result.force[0]), "a force is not finite");
  }
}

void resample(const Simulation& simulation)
{
  std::size_t covered = 0;
  simulation.resample({ 2, 1, 1 },
    [&](const std::vector<ResampledBox>& boxes)
    {
      for (const ResampledBox& box : boxes)
      {
        covered += box.voxels();
        require(!std::isinf(box.offset[0]), "an offset is infinite");
      }
    });
  require(covered > 0, "no voxel changed");
}

/// What of the engine a scene uses.
struct Way
{
  Index3 brick;
  int axes;
  PropagationMethod propagation;
  ConflictPolicy policy;
  RelaxationMethod relaxation;
  double recovery;
  bool coarseToFine;
  int reduction;
  bool rotations = false;
  double poissonRatio = 0.0;
};

void play(const Way& way, const Index3& size)
{
  const Tissue tissue(size, way.axes);
  Settings settings;
  const char* device = std::getenv("CHAINMAIL_TEST_DEVICE");
  settings.device = device ? device : "";
  settings.brickSize = way.brick;
  settings.modelReduction = way.reduction;
  settings.rotations = way.rotations;
  settings.poissonRatio = way.poissonRatio;
  Simulation simulation(tissue.model(way.axes == 1), settings);
  simulation.setPropagation(way.propagation, way.policy);
  simulation.setPropagationTimes(true);
  simulation.setRelaxation(way.relaxation, way.recovery);
  simulation.setCoarseToFine(way.coarseToFine);
  const double depth = size[2] > 1 ? 4.0 : 0.0; // [mm]

  // Apart, so that they are in conflict, and one of them by the bone.
  const std::vector<Probe> apart{ probe({ 3.0, 1.0, depth }, { -0.9, 0.3, 0.0 }),
    probe({ 6.0, 1.0, depth }, { 2.5, 0.2, 0.0 }, 0.0) };
  simulation.pull(apart);
  simulation.relax(3, 0.0);
  lookAt(simulation);
  resample(simulation);

  // Cut and carved as it is now, then further on, step by step, with tissue relaxing in between.
  require(simulation.cut(blade(4.7)) > 0, "nothing was cut");
  if (size[2] > 1)
  {
    require(simulation.carve(octahedron({ 1.0, 2.0, depth + 2.0 }, 1.3)) > 0, "nothing was carved");
  }
  simulation.hold({ probe({ 3.0, 1.0, depth }, { -1.4, 0.0, 0.0 }), apart[1] });
  for (int step = 0; step < 3 && !simulation.propagate(1).finished; ++step)
  {
    simulation.relax(1, 0.0);
  }
  simulation.propagate();
  simulation.relax(3, 0.0);
  lookAt(simulation);
  resample(simulation);

  simulation.hold({});
  simulation.relax(2, 0.0);
  simulation.restoreTopology();
  simulation.pull({ apart[0] });
  lookAt(simulation);
  if (way.coarseToFine && !way.rotations)
  {
    // Tissue that has settled is known better by the finest grid than by coarser ones: the way back is gone in part.
    simulation.relax(30, 0.0);
    simulation.pull({ probe({ 3.0, 1.0, depth }, { -0.901, 0.3, 0.0 }) });
    require(simulation.relax(4, 0.0).coarseStep.value_or(1.0) < 1.0, "coarser grids mend what had settled");
  }
}

}

int main(int argc, char** argv)
{
  using P = PropagationMethod;
  using C = ConflictPolicy;
  using R = RelaxationMethod;
  const Index3 small{ 4, 2, 2 };
  const Index3 large{ 8, 4, 8 };
  const Index3 block{ 7, 6, 4 };
  const std::vector<std::function<void()>> scenes{
    [&] {
      play({ small, 1, P::Envelope, C::Limit, R::Projected, 1.0, false, 1 }, block);
    },
    [&] {
      play({ large, 3, P::Envelope, C::Latest, R::Projected, 0.7, false, 1 }, block);
    },
    [&] {
      play({ large, 1, P::Envelope, C::Share, R::Projected, 1.0, true, 1 }, { 9, 6, 4 });
    },
    [&] {
      play({ small, 3, P::Timestamp, C::Limit, R::Paper, 0.7, false, 1 }, block);
    },
    [&] {
      play({ large, 1, P::Timestamp, C::Latest, R::Paper, 1.0, false, 1 }, block);
    },
    [&] {
      play({ small, 1, P::Envelope, C::Limit, R::Projected, 1.0, true, 1 }, { 9, 6, 4 });
    },
    [&] {
      play({ large, 3, P::Timestamp, C::Latest, R::Projected, 0.7, true, 1 }, { 9, 6, 4 });
    },
    [&] {
      play({ small, 1, P::Envelope, C::Limit, R::Projected, 1.0, false, 1 }, { 7, 6, 1 });
    },
    [&] {
      play({ small, 3, P::Timestamp, C::Latest, R::Paper, 0.5, false, 1 }, { 7, 6, 1 });
    },
    [&] {
      play({ small, 1, P::Envelope, C::Limit, R::Projected, 1.0, false, 2 }, { 14, 12, 4 });
    },
    [&] {
      play({ small, 1, P::Envelope, C::Limit, R::Projected, 1.0, false, 1, true }, block);
    },
    [&] {
      play({ large, 1, P::Envelope, C::Latest, R::Projected, 1.0, true, 1, true, 0.3 }, { 9, 6, 4 });
    },
    [&] {
      play({ large, 3, P::Envelope, C::Limit, R::Projected, 1.0, false, 1, true, 0.45 }, { 7, 6, 1 });
    },
  };
  const std::string argument = argc > 1 ? argv[1] : "";
  if (argument == "--count")
  {
    std::cout << scenes.size() << '\n';
    return 0;
  }
  const int only = argument.empty() ? -1 : std::atoi(argument.c_str());
  try
  {
    for (int n = 0; n < static_cast<int>(scenes.size()); ++n)
    {
      if (only < 0 || n == only)
      {
        std::cout << "scene " << n << std::endl;
        scenes[n]();
      }
    }
  }
  catch (const std::exception& error)
  {
    std::cerr << "FAILED: " << error.what() << '\n';
    return 1;
  }
  std::cout << "all played" << std::endl;
  return 0;
}
