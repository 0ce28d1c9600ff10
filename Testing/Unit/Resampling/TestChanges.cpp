// Incremental resampling: where something changed it gives the result of a complete one, elsewhere nothing.

#include "Blades.h"
#include "Picture.h"

#include <algorithm>
#include <functional>

namespace
{

using namespace chainmail;

/// A picture that is updated by the changes.
class KeptPicture
{
public:
  KeptPicture(const Simulation& simulation, const Index3& padding)
    : simulation_(simulation)
    , padding_(padding)
    , size_(simulation.model().grid().size)
  {
    std::size_t voxels = 1;
    for (int a = 0; a < 3; ++a)
    {
      this->size_[a] += 2 * padding[a];
      voxels *= static_cast<std::size_t>(this->size_[a]);
    }
    this->offset.assign(3 * voxels, 0.0f);
  }

  /// Returns the number of voxels in the boxes.
  std::size_t update()
  {
    std::size_t visited = 0;
    this->lowestX = this->size_[0];
    const auto visit = [&](const Index3& voxel, const float* from)
    {
      this->lowestX = std::min(this->lowestX, voxel[0]);
      const std::size_t row =
        (voxel[1] + this->padding_[1]) + static_cast<std::size_t>(this->size_[1]) * (voxel[2] + this->padding_[2]);
      const std::size_t at = (voxel[0] + this->padding_[0]) + this->size_[0] * row;
      std::copy(from, from + 3, this->offset.begin() + 3 * static_cast<std::ptrdiff_t>(at));
      ++visited;
    };
    this->resampled = this->simulation_.resample(this->padding_, visitEach(visit), this->resampled.number);
    return visited;
  }

  std::vector<float> offset;
  Resampled resampled;
  int lowestX = 0; ///< lowest x of the voxels that the last update visited

private:
  const Simulation& simulation_;
  Index3 padding_;
  Index3 size_;
};

using Step = std::function<void(Simulation&)>;

/// Random steps of all kinds that change the output.
Step randomStep(const Scene& scene, Random& random, std::vector<Probe>& held)
{
  switch (random.below(10))
  {
  case 0:
    return [](Simulation& s) { s.reset(); };
  case 1:
    return [](Simulation& s) { s.restoreTopology(); };
  case 2:
  {
    const Surface surface = planeAcrossX(random(2.0, scene.grid.size[0] - 3.0));
    return [surface](Simulation& s) { s.cut(surface); };
  }
  case 3:
  {
    const Index3 p = randomElement(scene, random);
    const Surface surface = sphere(scene.place(p[0], p[1], p[2]), random(1.0, 3.0), 6, 8);
    return [surface](Simulation& s) { s.carve(surface); };
  }
  case 4:
    return [](Simulation& s) { s.relax(3, 0.0); };
  case 5:
    return [](Simulation& s) { s.relax(100, 1e-2); };
  case 6:
    held.clear();
    return [](Simulation& s) { s.hold({}); };
  default:
  {
    const double far = random.below(3) == 0 ? 9.0 : 2.5;
    if (held.empty() || random.below(2) == 0)
    {
      held.push_back(probeAt(scene, randomElement(scene, random), {}, random(0.0, 2.0)));
    }
    held.back().displacement = { random(-far, far), random(-far, far), random(-far, far) };
    const std::vector<Probe> probes = held;
    const int iterations = random.below(2) == 0 ? 0 : 2;
    return [probes, iterations](Simulation& s)
    {
      try
      {
        s.hold(probes);
      }
      catch (const ProbeError&)
      {
        // The tissue at this place was carved away.
      }
      s.propagate(iterations);
    };
  }
  }
}

TEST(ResampleChanges, AreThoseOfAWholeResampling)
{
  for (int round = 0; round < 6; ++round)
  {
    Random random(100 + round);
    const Scene scene = randomScene({ 30, 18, 14 }, round % 3 == 2 ? 3 : 1, 40 + round, 0.2, 0.05);
    const Index3 brick = brickSizes()[round % 2];
    const Index3 padding = round % 4 < 2 ? Index3{ 0, 0, 0 } : Index3{ 3, 1, 2 };
    Settings settings;
    settings.device = testDevice();
    settings.brickSize = brick;
    settings.modelReduction = round == 5 ? 2 : 1;
    Simulation kept(scene.model(), settings);
    Simulation fresh(scene.model(), settings);
    for (Simulation* one : { &kept, &fresh })
    {
      one->setPropagation(
        round % 2 == 0 ? PropagationMethod::Envelope : PropagationMethod::Timestamp, ConflictPolicy::Limit);
      one->setRelaxation(round == 3 ? RelaxationMethod::Paper : RelaxationMethod::Projected, 1.0);
    }
    KeptPicture picture(kept, padding);
    std::vector<Probe> held;
    for (int n = 0; n < 25; ++n)
    {
      const Step step = randomStep(scene, random, held);
      step(kept);
      step(fresh);
      if (n % 3 == 2)
      {
        continue; // two steps at once
      }
      picture.update();
      resample(fresh, { 0, 5, 0 }); // another padding, so the next resampling starts anew
      const Picture whole = resample(fresh, padding);
      ASSERT_TRUE(sameBits(picture.offset, whole.offset)) << "round " << round << ", step " << n;
      ASSERT_EQ(picture.resampled.atRest,
        std::all_of(whole.offset.begin(), whole.offset.end(), [](float o) { return o == 0.0f; }))
        << "round " << round << ", step " << n;
    }
  }
}

TEST(ResampleChanges, AreLocal)
{
  const Scene scene({ 96, 32, 32 });
  Simulation simulation = simulate(scene, { 8, 8, 8 });
  KeptPicture picture(simulation, { 0, 0, 0 });
  EXPECT_EQ(picture.update(), 0u);
  EXPECT_TRUE(picture.resampled.atRest);

  Probe left = probeAt(scene, { 12, 16, 16 }, { 2.0, 0.5, 0.0 });
  Probe right = probeAt(scene, { 80, 16, 16 }, { -2.0, 0.0, 0.5 });
  simulation.pull({ left, right });
  EXPECT_GT(picture.update(), 0u);
  EXPECT_LT(picture.lowestX, 12);
  EXPECT_FALSE(picture.resampled.atRest);
  EXPECT_EQ(picture.update(), 0u) << "nothing changed";

  right.displacement[0] -= 0.5;
  simulation.pull({ left, right });
  EXPECT_GT(picture.update(), 0u);
  EXPECT_GT(picture.lowestX, 48) << "the left side is as it was";

  simulation.reset();
  picture.update();
  EXPECT_TRUE(picture.resampled.atRest);
  EXPECT_TRUE(std::all_of(picture.offset.begin(), picture.offset.end(), [](float o) { return o == 0.0f; }));
}

TEST(ResampleChanges, GoOnFromAnyEarlierOne)
{
  const Scene scene({ 40, 24, 16 });
  Simulation simulation = simulate(scene, { 8, 8, 8 });
  KeptPicture pictures[2] = { KeptPicture(simulation, { 0, 0, 0 }), KeptPicture(simulation, { 0, 0, 0 }) };
  for (int n = 0; n < 6; ++n)
  {
    simulation.pull({ probeAt(scene, { 20, 12, 8 }, { 0.7 * (n % 4), 0.3 * n, 0.0 }) });
    simulation.relax(2, 0.0);
    pictures[n % 2].update();
    EXPECT_TRUE(sameBits(pictures[n % 2].offset, resample(simulation).offset)) << n;
  }
  const auto nothing = [](const std::vector<ResampledBox>&) {};
  messageOf<InputError>([&] { simulation.resample({ 0, 0, 0 }, nothing, 1000); });
  const std::uint64_t number = simulation.resample({ 1, 0, 0 }, nothing).number;
  messageOf<InputError>([&] { simulation.resample({ 0, 0, 0 }, nothing, number); });
}

}
