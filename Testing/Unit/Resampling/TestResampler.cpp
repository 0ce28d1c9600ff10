// A Resampler shows a part of the output as the simulation itself does, to the bit, from what was exported for it
// alone. Values of voxels can be read for boxes.

#include "Blades.h"
#include "Picture.h"
#include "Resampler.h"

#include <cmath>
#include <cstring>

namespace
{

using namespace chainmail;

/// The whole output of one kind, and a part of it that a Resampler keeps up to date.
struct Part
{
  Index3 padding;
  CutSurfaces cuts;
  OutputDetail detail;
  Resampler resampler{ testDevice() };
  Picture shown;
  Resampled last;

  Part(const Simulation& simulation, const Index3& padding, CutSurfaces cuts, const OutputDetail& detail)
    : padding(padding)
    , cuts(cuts)
    , detail(detail)
  {
    for (int a = 0; a < 3; ++a)
    {
      const int end = simulation.model().grid().size[a] - 1 + padding[a];
      this->shown.first[a] = detail.finer * std::max(-padding[a], detail.first[a]);
      this->shown.size[a] = detail.finer * std::min(end, detail.last[a]) - this->shown.first[a] + 1;
    }
    this->restart();
  }

  void restart()
  {
    const std::size_t voxels =
      static_cast<std::size_t>(this->shown.size[0]) * this->shown.size[1] * this->shown.size[2];
    this->shown.offset.assign(3 * voxels, 0.0f);
    this->shown.coverage.assign(voxels, 1.0f);
    this->last = Resampled();
  }

  /// Continues from the last update.
  void update()
  {
    const auto visit = [&](const std::vector<ResampledBox>& boxes)
    {
      for (const ResampledBox& box : boxes)
      {
        box.forCovered(
          [&](const Index3& voxel, const float* offset, float coverage)
          {
            ASSERT_TRUE(this->shown.contains(voxel[0], voxel[1], voxel[2]));
            const std::size_t at = this->shown.at(voxel[0], voxel[1], voxel[2]);
            std::copy(offset, offset + 3, this->shown.offset.begin() + 3 * static_cast<std::ptrdiff_t>(at));
            this->shown.coverage[at] = coverage;
          });
      }
    };
    try
    {
      this->last = this->resampler.resample(visit, this->last.number);
    }
    catch (const InputError&) // another simulation
    {
      this->restart();
      this->last = this->resampler.resample(visit);
    }
  }

  /// The number of values that differ from those of the simulation.
  std::size_t wrong(const Simulation& simulation) const
  {
    const Picture whole = resample(simulation, this->padding, this->cuts, this->detail);
    std::size_t count = 0;
    for (std::size_t n = 0; n < this->shown.offset.size(); ++n)
    {
      // Every NaN says the same.
      const float a = whole.offset[n], b = this->shown.offset[n];
      count += std::isnan(a) && std::isnan(b) ? 0 : std::memcmp(&a, &b, sizeof(a)) != 0;
    }
    return count + (whole.coverage == this->shown.coverage ? 0 : 1);
  }

  /// The number of voxels whose offset leads out of what the part says that it shows.
  std::size_t strays() const
  {
    const Sources sources = this->resampler.sources();
    std::size_t count = 0;
    this->shown.each(
      [&](int i, int j, int k)
      {
        const float* offset = this->shown.offset.data() + 3 * this->shown.at(i, j, k);
        const int at[3] = { i, j, k };
        const bool rests = offset[0] == 0.0f && offset[1] == 0.0f && offset[2] == 0.0f;
        const VoxelBox& box = rests ? sources.resting : sources.moved;
        bool inside = true;
        for (int a = 0; a < 3 && !std::isnan(offset[0]); ++a)
        {
          const double end = this->grid[a] - 1;
          const double place = std::clamp(static_cast<double>(at[a]) / this->detail.finer + offset[a], 0.0, end);
          inside = inside && std::floor(place) >= box.first[a] && std::ceil(place) <= box.first[a] + box.size[a] - 1;
        }
        count += inside ? 0 : 1;
      });
    return count;
  }

  Index3 grid{};
};

OutputDetail detailOf(const Index3& first, const Index3& last, int finer = 1)
{
  OutputDetail detail;
  detail.first = first;
  detail.last = last;
  detail.finer = finer;
  return detail;
}

/// Updates all parts as different processes would, and compares them with the simulation.
void expectSame(const Simulation& simulation, std::vector<Part>& parts, const std::string& when)
{
  for (Part& part : parts)
  {
    const int number = static_cast<int>(&part - parts.data());
    simulation.exportTissue(part.padding, part.cuts, { { number, part.detail, part.resampler.version() } },
      [&](std::size_t, const std::vector<char>& message) { part.resampler.take(message); });
    part.update();
    part.grid = simulation.model().grid().size;
    EXPECT_EQ(part.wrong(simulation), 0u) << when;
    EXPECT_EQ(part.strays(), 0u) << when;
  }
}

std::vector<Part> partsOf(const Simulation& simulation)
{
  std::vector<Part> parts;
  for (const CutSurfaces cuts : { CutSurfaces::Stepped, CutSurfaces::Smooth })
  {
    parts.emplace_back(simulation, Index3{ 0, 0, 0 }, cuts, detailOf({ 0, 0, 0 }, { 8, 40, 40 }));
    parts.emplace_back(simulation, Index3{ 3, 2, 0 }, cuts, detailOf({ 8, -9, 0 }, { 40, 9, 6 }));
    parts.emplace_back(simulation, Index3{ 1, 1, 1 }, cuts, detailOf({ 17, 3, -1 }, { 23, 17, 20 }, 2));
  }
  return parts;
}

/// A life with drags, cuts, carves, a reset and restored tissue.
void liveThrough(Simulation& simulation, const Scene& scene, std::vector<Part>& parts)
{
  expectSame(simulation, parts, "at rest");
  Probe first = probeAt(scene, { 5, 6, 11 }, { 1.4, -1.1, 2.3 }, 1.8);
  const Probe second = probeAt(scene, { 16, 12, 3 }, { -3.7, 1.2, 0.4 }, 1.8);
  simulation.pull({ first, second });
  simulation.relax(5, 0.0);
  expectSame(simulation, parts, "pulled");
  first.displacement = { 6.2, 2.5, -4.4 };
  simulation.pull({ first, second });
  expectSame(simulation, parts, "dragged");
  simulation.cut(sheet(-2.0, -2.0, 3.0, 9, 7, [](double x, double y) { return 7.3 + 0.21 * x - 0.13 * y; }));
  expectSame(simulation, parts, "cut");
  simulation.pull({ second });
  simulation.relax(5, 0.0);
  expectSame(simulation, parts, "opened");
  simulation.carve(sphere({ 14.2, 6.3, 4.1 }, 2.9, 12, 16));
  expectSame(simulation, parts, "carved");
  simulation.reset();
  expectSame(simulation, parts, "reset");
  simulation.pull({ first });
  simulation.restoreTopology();
  simulation.pull({ second });
  expectSame(simulation, parts, "restored");
}

TEST(Resampler, ShowsWhatTheSimulationShows)
{
  const Scene scene = randomScene({ 22, 17, 14 }, 1, 5, 0.2);
  for (const Index3& brick : brickSizes())
  {
    Simulation simulation = simulate(scene, brick);
    std::vector<Part> parts = partsOf(simulation);
    liveThrough(simulation, scene, parts);
    const Scene next = randomScene({ 22, 17, 14 }, 3, 6, 0.4);
    Simulation other = simulate(next, brick);
    Random random(3);
    other.pull({ probeAt(next, randomElement(next, random), { 2.0, 1.0, -2.0 }, 2.0) });
    expectSame(other, parts, "another simulation");
  }
}

TEST(Resampler, ShowsReducedModelsAndThoseThatRotate)
{
  const Scene scene = randomScene({ 22, 17, 14 }, 1, 7, 0.2);
  Settings settings;
  settings.device = testDevice();
  settings.modelReduction = 2;
  Simulation reduced(scene.model(), settings);
  std::vector<Part> parts = partsOf(reduced);
  liveThrough(reduced, scene, parts);
  settings.modelReduction = 1;
  settings.rotations = true;
  settings.poissonRatio = 0.3;
  Simulation rotating(scene.model(), settings);
  liveThrough(rotating, scene, parts);
}

/// Every export is for its own part: together they cover the output.
TEST(Resampler, GetsOnlyTheTissueOfItsPart)
{
  const Scene scene({ 120, 20, 20 });
  Simulation simulation = simulate(scene);
  simulation.pull({ probeAt(scene, { 10, 10, 10 }, { 2.0, 1.0, -2.0 }, 2.0) });
  std::vector<std::size_t> bytes(2, 0);
  std::vector<Resampler> resamplers;
  resamplers.emplace_back(testDevice());
  resamplers.emplace_back(testDevice());
  simulation.exportTissue({ 0, 0, 0 }, CutSurfaces::Stepped,
    { { 1, detailOf({ 0, 0, 0 }, { 40, 19, 19 }), {} }, { 2, detailOf({ 80, 0, 0 }, { 119, 19, 19 }), {} } },
    [&](std::size_t n, const std::vector<char>& message)
    {
      bytes.at(n) += message.size();
      resamplers[n].take(message);
    });
  for (std::size_t n = 0; n < 2; ++n)
  {
    const VoxelBox sources = resamplers[n].sources().resting;
    EXPECT_EQ(resamplers[n].sources().moved.voxels() > 0, n == 0);
    EXPECT_EQ(resamplers[n].resample([](const std::vector<ResampledBox>&) {}).atRest, n == 1);
    EXPECT_TRUE(n == 0 || (sources.first == Index3{ 80, 0, 0 } && sources.size == Index3{ 40, 20, 20 }));
  }
  EXPECT_LT(bytes[1], 1000u);
  EXPECT_GT(bytes[0], 12 * 125u);
}

/// Messages of an export, and how many bytes they have.
struct Export
{
  std::vector<std::vector<char>> messages;

  Export(const Simulation& simulation, const Resampler& to)
  {
    simulation.exportTissue({ 0, 0, 0 }, CutSurfaces::Stepped, { { 1, OutputDetail(), to.version() } },
      [&](std::size_t, const std::vector<char>& message) { this->messages.push_back(message); });
  }
  std::size_t bytes() const
  {
    std::size_t sum = 0;
    for (const std::vector<char>& message : this->messages)
    {
      sum += message.size();
    }
    return sum;
  }
};

/// Displacements are sent where they have changed since what a Resampler holds. One that got only some of the messages
/// holds nothing.
TEST(Resampler, GetsOnlyWhatHasChanged)
{
  const Scene scene({ 160, 64, 64 });
  Simulation simulation = simulate(scene);
  const Probe one = probeAt(scene, { 30, 32, 32 }, { 8.0, 1.0, -2.0 }, 2.0);
  Probe other = probeAt(scene, { 130, 32, 32 }, { 1.0, 0.0, 0.0 }, 2.0);
  simulation.pull({ one, other });
  Part part(simulation, { 0, 0, 0 }, CutSurfaces::Stepped, OutputDetail());
  const Export all(simulation, part.resampler);
  ASSERT_GT(all.messages.size(), 1u);
  part.resampler.take(all.messages.front());
  EXPECT_TRUE(part.resampler.version() == TissueVersion()) << "displacements have not come yet";
  EXPECT_THROW(part.update(), InputError);

  const Export again(simulation, part.resampler);
  EXPECT_EQ(again.bytes(), all.bytes()) << "it begins anew";
  for (const std::vector<char>& message : again.messages)
  {
    part.resampler.take(message);
  }
  part.update();
  EXPECT_EQ(part.wrong(simulation), 0u);

  const Export nothing(simulation, part.resampler);
  EXPECT_EQ(nothing.messages.size(), 1u);
  EXPECT_LT(nothing.bytes(), all.bytes() / 10);
  part.resampler.take(nothing.messages.front());

  other.displacement[1] = 0.5;
  simulation.pull({ one, other });
  const Export some(simulation, part.resampler);
  EXPECT_GT(some.bytes(), nothing.bytes());
  EXPECT_LT(some.bytes(), all.bytes() / 4);
  for (const std::vector<char>& message : some.messages)
  {
    part.resampler.take(message);
  }
  part.update();
  EXPECT_EQ(part.wrong(simulation), 0u);
}

TEST(Readout, ABoxHoldsWhatTheGridHoldsThere)
{
  const Scene scene = randomScene({ 22, 17, 14 }, 3, 8, 0.2, 0.3);
  for (const int reduction : { 1, 2 })
  {
    Settings settings;
    settings.device = testDevice();
    settings.modelReduction = reduction;
    Simulation simulation(scene.model(), settings);
    simulation.setPropagationTimes(true);
    simulation.cut(sheet(-2.0, -2.0, 3.0, 9, 7, [](double x, double y) { return 7.3 + 0.21 * x - 0.13 * y; }));
    simulation.carve(sphere({ 14.2, 6.3, 4.1 }, 2.9, 12, 16));
    simulation.pull({ probeAt(scene, { 5, 6, 11 }, { 1.4, -1.1, 2.3 }, 1.8) });
    const std::size_t voxels = scene.grid.voxels();
    const VoxelBox box{ { 3, 5, 2 }, { 13, 12, 9 } };
    const auto expectCrop = [&](const auto& all, const auto& part, std::size_t values, const char* what)
    {
      std::size_t wrong = 0, set = 0;
      scene.each(
        [&](int i, int j, int k)
        {
          for (std::size_t c = 0; box.contains(i, j, k) && c < values; ++c)
          {
            wrong += all[values * scene.grid.at(i, j, k) + c] != part[values * box.at(i, j, k) + c];
            set += part[values * box.at(i, j, k) + c] != 0;
          }
        });
      EXPECT_EQ(wrong, 0u) << what;
      EXPECT_GT(set, 0u) << what;
    };
    std::vector<float> u(3 * voxels), uBox(3 * box.voxels(), 7.0f), times(3 * voxels), timesBox(3 * box.voxels(), 7.0f);
    simulation.displacements(u.data());
    simulation.displacements(box, uBox.data());
    expectCrop(u, uBox, 3, "displacements");
    simulation.propagationTimes(times.data());
    simulation.propagationTimes(box, timesBox.data());
    expectCrop(times, timesBox, 3, "times");
    std::vector<int> all(3 * voxels), part(3 * box.voxels(), 7);
    simulation.wavefronts(all.data());
    simulation.wavefronts(box, part.data());
    expectCrop(all, part, 3, "wavefronts");
    simulation.clusters(all.data());
    simulation.clusters(box, part.data());
    expectCrop(all, part, 3, "clusters");
    std::vector<std::uint8_t> bytes(voxels), bytesBox(box.voxels(), 7);
    simulation.elements(bytes.data());
    simulation.elements(box, bytesBox.data());
    expectCrop(bytes, bytesBox, 1, "elements");
    simulation.links(bytes.data());
    simulation.links(box, bytesBox.data());
    expectCrop(bytes, bytesBox, 1, "links");
  }
}

}
