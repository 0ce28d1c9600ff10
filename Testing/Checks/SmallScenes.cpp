// Small scenes that run every kernel in every variant. They are for tools that make a program several hundred times
// slower (oclgrind.sh, valgrind.sh). The unit tests check the results; the scenes check only what holds of any state.
//
//     SmallScenes            plays all scenes
//     SmallScenes NUMBER     plays one scene, counted from 0
//     SmallScenes --count    prints the number of scenes

#include "../Unit/Random.h"
#include "Simulation.h"

#include <cmath>
#include <cstdint>
#include <cstdlib>
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

/// Tissue with random constraints, bone and holes.
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

/// A rectangle across the grid at x [mm].
Surface blade(double x)
{
  return { { { x, -1.0, -1.0 }, { x, 2.2, -1.0 }, { x, 2.2, 40.0 }, { x, -1.0, 40.0 } },
    { { { 0, 1, 2 } }, { { 0, 2, 3 } } } };
}

/// With centre c and radius r [mm].
Surface octahedron(const Vector3& c, double r)
{
  return { { { c[0] - r, c[1], c[2] }, { c[0] + r, c[1], c[2] }, { c[0], c[1] - r, c[2] }, { c[0], c[1] + r, c[2] },
             { c[0], c[1], c[2] - r }, { c[0], c[1], c[2] + r } },
    { { { 0, 2, 4 } }, { { 2, 1, 4 } }, { { 1, 3, 4 } }, { { 3, 0, 4 } }, { { 2, 0, 5 } }, { { 1, 2, 5 } },
      { { 3, 1, 5 } }, { { 0, 3, 5 } } } };
}

/// Reads the whole state of the model. Numbers in it must be finite.
void readState(const Simulation& simulation)
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

constexpr Index3 smallBrick{ 4, 2, 2 };
constexpr Index3 largeBrick{ 8, 4, 8 };

/// The tissue of a scene and how the engine treats it.
struct Scene
{
  const char* description = "";
  Index3 voxels{ 7, 6, 4 };
  int axes = 1; ///< constraints of a voxel: one, or one for each of three axes

  Index3 brick = smallBrick;
  int modelReduction = 1;
  PropagationMethod propagation = PropagationMethod::Envelope;
  ConflictPolicy conflicts = ConflictPolicy::Limit;
  RelaxationMethod relaxation = RelaxationMethod::Projected;
  double elasticRecovery = 1.0;
  bool coarseToFine = false;
  bool rotations = false;
  double poissonRatio = 0.0;
};

/// oclgrind.sh names some scenes by their numbers, so new ones come last.
std::vector<Scene> allScenes()
{
  std::vector<Scene> scenes;
  const auto add = [&](const char* description) -> Scene&
  {
    Scene& scene = scenes.emplace_back();
    scene.description = description;
    return scene;
  };
  {
    add("defaults");
  }
  {
    Scene& scene = add("the latest probe wins, plastic tissue, anisotropic constraints");
    scene.axes = 3;
    scene.brick = largeBrick;
    scene.conflicts = ConflictPolicy::Latest;
    scene.elasticRecovery = 0.7;
  }
  {
    Scene& scene = add("probes share, coarse to fine");
    scene.voxels = { 9, 6, 4 };
    scene.brick = largeBrick;
    scene.conflicts = ConflictPolicy::Share;
    scene.coarseToFine = true;
  }
  {
    Scene& scene = add("timestamps and the published relaxation, anisotropic constraints");
    scene.axes = 3;
    scene.propagation = PropagationMethod::Timestamp;
    scene.relaxation = RelaxationMethod::Paper;
    scene.elasticRecovery = 0.7;
  }
  {
    Scene& scene = add("timestamps and the published relaxation, the latest probe wins");
    scene.brick = largeBrick;
    scene.propagation = PropagationMethod::Timestamp;
    scene.conflicts = ConflictPolicy::Latest;
    scene.relaxation = RelaxationMethod::Paper;
  }
  {
    Scene& scene = add("coarse to fine");
    scene.voxels = { 9, 6, 4 };
    scene.coarseToFine = true;
  }
  {
    Scene& scene = add("timestamps, coarse to fine, plastic tissue, anisotropic constraints");
    scene.voxels = { 9, 6, 4 };
    scene.axes = 3;
    scene.brick = largeBrick;
    scene.propagation = PropagationMethod::Timestamp;
    scene.conflicts = ConflictPolicy::Latest;
    scene.elasticRecovery = 0.7;
    scene.coarseToFine = true;
  }
  {
    Scene& scene = add("a slice");
    scene.voxels = { 7, 6, 1 };
  }
  {
    Scene& scene = add("a slice, timestamps and the published relaxation, anisotropic constraints");
    scene.voxels = { 7, 6, 1 };
    scene.axes = 3;
    scene.propagation = PropagationMethod::Timestamp;
    scene.conflicts = ConflictPolicy::Latest;
    scene.relaxation = RelaxationMethod::Paper;
    scene.elasticRecovery = 0.5;
  }
  {
    Scene& scene = add("a reduced model");
    scene.voxels = { 14, 12, 4 };
    scene.modelReduction = 2;
  }
  {
    Scene& scene = add("rotations");
    scene.rotations = true;
  }
  {
    Scene& scene = add("rotations and Poisson's ratio, coarse to fine");
    scene.voxels = { 9, 6, 4 };
    scene.brick = largeBrick;
    scene.conflicts = ConflictPolicy::Latest;
    scene.coarseToFine = true;
    scene.rotations = true;
    scene.poissonRatio = 0.3;
  }
  {
    Scene& scene = add("a slice, rotations and Poisson's ratio, anisotropic constraints");
    scene.voxels = { 7, 6, 1 };
    scene.axes = 3;
    scene.brick = largeBrick;
    scene.rotations = true;
    scene.poissonRatio = 0.45;
  }
  return scenes;
}

void play(const Scene& scene)
{
  const Tissue tissue(scene.voxels, scene.axes);
  Settings settings;
  const char* device = std::getenv("CHAINMAIL_TEST_DEVICE");
  settings.device = device ? device : "";
  settings.brickSize = scene.brick;
  settings.modelReduction = scene.modelReduction;
  settings.rotations = scene.rotations;
  settings.poissonRatio = scene.poissonRatio;
  const bool anchored = scene.axes == 1;
  Simulation simulation(tissue.model(anchored), settings);
  simulation.setPropagation(scene.propagation, scene.conflicts);
  simulation.setPropagationTimes(true);
  simulation.setRelaxation(scene.relaxation, scene.elasticRecovery);
  simulation.setCoarseToFine(scene.coarseToFine);
  const bool isSlice = scene.voxels[2] == 1;
  const double depth = isSlice ? 0.0 : 4.0; // [mm]

  // Two probes in conflict: they pull apart. The first one holds tissue at the bone.
  const std::vector<Probe> probes{ probe({ 3.0, 1.0, depth }, { -0.9, 0.3, 0.0 }),
    probe({ 6.0, 1.0, depth }, { 2.5, 0.2, 0.0 }, 0.0) };
  simulation.pull(probes);
  simulation.relax(3, 0.0);
  readState(simulation);
  resample(simulation);

  // Cuts and carves the deformed tissue. Then the probes pull on, with relaxation between the steps of the wave.
  require(simulation.cut(blade(4.7)) > 0, "nothing was cut");
  if (!isSlice)
  {
    require(simulation.carve(octahedron({ 1.0, 2.0, depth + 2.0 }, 1.3)) > 0, "nothing was carved");
  }
  simulation.hold({ probe({ 3.0, 1.0, depth }, { -1.4, 0.0, 0.0 }), probes[1] });
  for (int step = 0; step < 3 && !simulation.propagate(1).finished; ++step)
  {
    simulation.relax(1, 0.0);
  }
  simulation.propagate();
  simulation.relax(3, 0.0);
  readState(simulation);
  resample(simulation);

  // Releases the tissue, restores it, and pulls again.
  simulation.hold({});
  simulation.relax(2, 0.0);
  simulation.restoreTopology();
  simulation.pull({ probes[0] });
  readState(simulation);
  if (scene.coarseToFine && !scene.rotations)
  {
    // After a small pull, settled tissue is nearer to the optimum than its coarser grids can tell. So only a part of
    // their correction is kept.
    simulation.relax(30, 0.0);
    simulation.pull({ probe({ 3.0, 1.0, depth }, { -0.901, 0.3, 0.0 }) });
    require(simulation.relax(4, 0.0).coarseStep.value_or(1.0) < 1.0, "the whole correction of coarser grids is kept");
  }
}

}

int main(int argc, char** argv)
{
  const std::vector<Scene> scenes = allScenes();
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
        std::cout << "scene " << n << ": " << scenes[n].description << std::endl;
        play(scenes[n]);
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
