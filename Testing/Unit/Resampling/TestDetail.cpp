// Finer output and parts of it. Voxel finer * i has the place of grid point i, and offsets are in voxels of the grid.

#include "Blades.h"
#include "Device.h"
#include "Picture.h"

#include <cmath>

namespace
{

using namespace chainmail;

OutputDetail finer(int factor)
{
  OutputDetail detail;
  detail.finer = factor;
  return detail;
}

/// The finest smooth cut surfaces that the device computes; at most `wanted`.
int finestSmooth(int wanted)
{
  return chooseDevice(testDevice()).endsLoops() ? 2 : wanted;
}

/// Tissue with holes, cut, carved and partly pulled.
Simulation opened(const Scene& scene, const Index3& brick)
{
  Simulation simulation = simulate(scene, brick);
  simulation.cut(sheet(-2.0, -2.0, 3.0, 9, 4, [](double x, double y) { return 7.3 + 0.21 * x - 0.13 * y; }));
  simulation.carve(sphere({ 14.2, 6.3, 4.1 }, 2.9, 12, 16));
  Probe first = probeAt(scene, { 5, 6, 11 }, { 1.4, -1.1, 2.3 });
  Probe second = probeAt(scene, { 16, 12, 3 }, { -0.7, 1.2, 0.4 });
  first.radius = second.radius = 1.8; // some of these elements may be
  simulation.pull({ first, second });
  simulation.relax(12, 0.0);
  return simulation;
}

/// The number of different floats in two arrays; NaN equals NaN.
std::size_t different(const std::vector<float>& a, const std::vector<float>& b)
{
  std::size_t count = a.size() == b.size() ? 0 : std::max(a.size(), b.size());
  for (std::size_t n = 0; count < a.size() && n < a.size(); ++n)
  {
    count += a[n] == b[n] || (std::isnan(a[n]) && std::isnan(b[n])) ? 0 : 1;
  }
  return count;
}

TEST(Detail, GridPointsShowWhatTheyShowAnyway)
{
  Scene scene = randomScene({ 22, 17, 14 }, 1, 5, 0.2);
  scene.anchors.faces[0] = true;
  const Simulation simulation = opened(scene, { 8, 4, 8 });
  for (const CutSurfaces cuts : { CutSurfaces::Stepped, CutSurfaces::Smooth })
  {
    const Picture coarse = resample(simulation, { 2, 0, 3 }, cuts);
    for (int factor = 2; factor <= (cuts == CutSurfaces::Smooth ? finestSmooth(4) : 4); ++factor)
    {
      const Picture fine = resample(simulation, { 2, 0, 3 }, cuts, finer(factor));
      std::size_t others = 0;
      coarse.each(
        [&](int i, int j, int k)
        {
          const std::size_t at = 3 * coarse.at(i, j, k), there = 3 * fine.at(factor * i, factor * j, factor * k);
          for (int a = 0; a < 3; ++a)
          {
            const float expected = coarse.offset[at + a], got = fine.offset[there + a];
            others += expected == got || (std::isnan(expected) && std::isnan(got)) ? 0 : 1;
          }
        });
      // At a cut surface a larger voxel without tissue in its middle extends further to the tissue that it shows.
      const std::size_t values = 3 * 26 * 17 * 20;
      EXPECT_LE(others, cuts == CutSurfaces::Stepped ? 0 : values / 50) << factor;
    }
  }
}

TEST(Detail, BitsDoNotDependOnBricks)
{
  const Scene scene = randomScene({ 22, 17, 14 }, 1, 6, 0.2);
  for (const CutSurfaces cuts : { CutSurfaces::Stepped, CutSurfaces::Smooth })
  {
    const int factor = cuts == CutSurfaces::Smooth ? finestSmooth(3) : 3;
    const Picture first = resample(opened(scene, { 0, 0, 0 }), { 1, 1, 1 }, cuts, finer(factor));
    for (const Index3& brick : brickSizes())
    {
      const Picture other = resample(opened(scene, brick), { 1, 1, 1 }, cuts, finer(factor));
      EXPECT_EQ(different(first.offset, other.offset), 0u);
      EXPECT_EQ(different(first.coverage, other.coverage), 0u);
    }
  }
}

TEST(Detail, ABlockMovesByVoxelsThatTheGridDoesNotHave)
{
  Scene scene({ 24, 20, 18 }, 0.0f);
  scene.each(
    [&](int i, int j, int k)
    {
      if (i < 7 || i > 13 || j < 6 || j > 12 || k < 5 || k > 11)
      {
        scene.air(i, j, k);
      }
    });
  for (const int factor : { 2, 4 })
  {
    for (const Index3& brick : brickSizes())
    {
      Simulation simulation = simulate(scene, brick);
      simulation.pull({ probeAt(scene, { 10, 9, 8 }, { 3.5, -1.5, 0.0 }) });
      const Picture fine = resample(simulation, { 0, 0, 0 }, CutSurfaces::Stepped, finer(factor));
      std::size_t moved = 0, left = 0;
      const double f = factor;
      fine.each(
        [&](int i, int j, int k)
        {
          const auto lies = [](const Vector3& p, double beyond)
          {
            const bool inX = p[0] >= 7 - beyond && p[0] <= 13 + beyond, inY = p[1] >= 6 - beyond && p[1] <= 12 + beyond;
            return inX && inY && p[2] >= 5 - beyond && p[2] <= 11 + beyond;
          };
          const Vector3 here{ i / f, j / f, k / f }, from{ here[0] - 3.5, here[1] + 1.5, here[2] };
          if (lies(from, 1.0)) // tissue, and air next to it
          {
            ASSERT_EQ(fine(i, j, k), (Vector3{ -3.5, 1.5, 0.0 })) << i << ' ' << j << ' ' << k;
            ++moved;
          }
          else if (lies(here, 0.49))
          {
            ASSERT_TRUE(fine.vacated(i, j, k)) << i << ' ' << j << ' ' << k;
            ++left;
          }
          else if (!lies(here, 1.51) && !lies(from, 1.51))
          {
            ASSERT_EQ(fine(i, j, k), (Vector3{ 0, 0, 0 })) << i << ' ' << j << ' ' << k;
          }
        });
      EXPECT_EQ(moved, std::size_t(8 * factor + 1) * (8 * factor + 1) * (8 * factor + 1));
      EXPECT_GT(left, std::size_t(100 * factor * factor * factor));
    }
  }
}

/// The map x + u(x), with trilinear u, of a place [voxels] in a grid without air.
Vector3 forward(const Scene& scene, const std::vector<oracle::Vector3>& u, const Vector3& x)
{
  int low[3];
  double t[3];
  for (int a = 0; a < 3; ++a)
  {
    low[a] = std::min(std::max(static_cast<int>(std::floor(x[a])), 0), std::max(scene.grid.size[a] - 2, 0));
    t[a] = x[a] - low[a];
  }
  Vector3 moved = x;
  for (int n = 0; n < 8; ++n)
  {
    const double w = (n & 1 ? t[0] : 1 - t[0]) * (n & 2 ? t[1] : 1 - t[1]) * (n & 4 ? t[2] : 1 - t[2]);
    const auto along = [&](int axis, int step) { return std::min(low[axis] + step, scene.grid.size[axis] - 1); };
    for (int a = 0; a < 3; ++a)
    {
      moved[a] += w * u[scene.grid.at(along(0, n & 1), along(1, n >> 1 & 1), along(2, n >> 2))][a];
    }
  }
  return moved;
}

TEST(Detail, OffsetsInvertTheDisplacementField)
{
  for (const Index3& size : { Index3{ 22, 20, 18 }, Index3{ 22, 20, 1 }, Index3{ 1, 20, 18 }, Index3{ 22, 1, 18 } })
  {
    Scene scene(size, 0.3f);
    scene.anchors.faces.fill(true);
    Simulation simulation = simulate(scene);
    Vector3 far{ 2.0, -1.6, 1.2 };
    for (int a = 0; a < 3; ++a)
    {
      far[a] = size[a] == 1 ? 0.0 : far[a];
    }
    simulation.pull({ probeAt(scene, { size[0] / 2, size[1] / 2, size[2] / 2 }, far) });
    simulation.relax(40, 0.0);
    const std::vector<oracle::Vector3> u = state(simulation);
    for (const int factor : { 2, 3 })
    {
      const Picture picture = resample(simulation, { 0, 0, 0 }, CutSurfaces::Stepped, finer(factor));
      std::size_t checked = 0, moved = 0;
      double worst = 0.0;
      picture.each(
        [&](int i, int j, int k)
        {
          ASSERT_FALSE(picture.vacated(i, j, k)) << "a hole at " << i << ' ' << j << ' ' << k;
          const Vector3 o = picture(i, j, k);
          const Vector3 here{ i / double(factor), j / double(factor), k / double(factor) };
          const Vector3 there = forward(scene, u, { here[0] + o[0], here[1] + o[1], here[2] + o[2] });
          for (int a = 0; a < 3; ++a)
          {
            worst = std::max(worst, std::abs(there[a] - here[a]));
          }
          moved += o[0] != 0.0 || o[1] != 0.0 || o[2] != 0.0;
          ++checked;
        });
      const auto width = [&](int a) { return std::size_t(factor * (size[a] - 1) + 1); };
      EXPECT_EQ(checked, width(0) * width(1) * width(2));
      EXPECT_GT(moved, checked / 4);
      EXPECT_LT(worst, 5e-4); // the tolerance of the output without detail
      EXPECT_GT(worst, 0.0);
    }
  }
}

// Tissue that stays next to a cut has its wall at the blade's place, between grid points, too.
TEST(Detail, AWallIsWhereTheBladeWas)
{
  const auto height = [](double x, double y) { return 12.37 + 0.31 * (x - 12) + 0.17 * (y - 12); };
  Scene scene({ 26, 26, 26 }, 0.0f);
  Simulation simulation = simulate(scene);
  ASSERT_GT(simulation.cut(sheet(-40.0, -40.0, 10.0, 13, 13, height)), 400u);
  Probe held, pulled;
  held.anchor = true;
  pulled.position = scene.place(25, 25, 25);
  pulled.displacement = { 0.0, 0.0, 6.0 };
  simulation.hold({ held, pulled });
  simulation.propagate(0);
  for (int factor = 1; factor <= finestSmooth(3); ++factor)
  {
    const Picture fine = resample(simulation, { 0, 0, 0 }, CutSurfaces::Smooth, finer(factor));
    // Behind the wall is a gap of 6 voxels. 31 samples in a box of 1.25 voxels determine where it begins.
    const double gap = 5.0;
    double worst = 0.0, sum = 0.0;
    std::size_t columns = 0;
    for (int j = 6 * factor; j <= 19 * factor; ++j)
    {
      for (int i = 6 * factor; i <= 19 * factor; ++i)
      {
        double shown = 0.0;
        const double wall = height(i / double(factor), j / double(factor));
        for (int k = 0; k <= factor * (wall + gap); ++k)
        {
          shown += fine.covered(i, j, k) / factor;
          if (fine.covered(i, j, k) == 1.0)
          {
            ASSERT_EQ(fine(i, j, k), (Vector3{ 0, 0, 0 })) << i << ' ' << j << ' ' << k;
          }
        }
        const double off = shown - (wall + 0.5 / factor); // the lowest voxel begins at -0.5
        worst = std::max(worst, std::abs(off));
        sum += off;
        ++columns;
      }
    }
    ASSERT_GT(columns, std::size_t(150));
    std::cout << "NUMERICS: " << factor << " times as fine, a wall lies within " << worst
              << " voxels of the blade, and " << sum / columns << " behind it on average\n";
    EXPECT_LT(worst, 0.25 / factor);
    EXPECT_LT(std::abs(sum / columns), 0.03);
  }
}

TEST(Detail, APartShowsWhatTheWholeShows)
{
  const Scene scene = randomScene({ 22, 17, 14 }, 1, 8, 0.2);
  for (const Index3& brick : brickSizes())
  {
    const Simulation simulation = opened(scene, brick);
    for (const int factor : { 1, 2 })
    {
      OutputDetail part = finer(factor);
      const Picture whole = resample(simulation, { 3, 3, 3 }, CutSurfaces::Smooth, part);
      part.first = { -1, 4, 2 };
      part.last = { 11, 40, 13 };
      const Picture box = resample(simulation, { 3, 3, 3 }, CutSurfaces::Smooth, part);
      EXPECT_EQ(box.size, (Index3{ 12 * factor + 1, 15 * factor + 1, 11 * factor + 1 }));
      std::size_t wrong = 0;
      box.each(
        [&](int i, int j, int k)
        {
          const std::size_t at = box.at(i, j, k), there = whole.at(i, j, k);
          wrong += box.coverage[at] == whole.coverage[there] ? 0 : 1;
          for (int a = 0; a < 3; ++a)
          {
            const float one = box.offset[3 * at + a], other = whole.offset[3 * there + a];
            wrong += one == other || (std::isnan(one) && std::isnan(other)) ? 0 : 1;
          }
        });
      EXPECT_EQ(wrong, 0u);
    }
  }
}

/// Writes the boxes into a picture.
BoxVisitor into(Picture& picture)
{
  return [&picture](const std::vector<ResampledBox>& boxes)
  {
    for (const ResampledBox& box : boxes)
    {
      box.forCovered(
        [&picture](const Index3& voxel, const float* offset, float coverage)
        {
          const std::size_t at = picture.at(voxel[0], voxel[1], voxel[2]);
          std::copy_n(offset, 3, picture.offset.begin() + 3 * at);
          picture.coverage[at] = coverage;
        });
    }
  };
}

TEST(Detail, ChangesAreEnough)
{
  const Scene scene = randomScene({ 26, 17, 14 }, 1, 9, 0.1);
  Simulation simulation = simulate(scene, { 8, 4, 4 });
  const OutputDetail detail = finer(2);
  Picture followed = resample(simulation, { 1, 1, 1 }, CutSurfaces::Smooth, detail); // at rest
  std::uint64_t number = 0;
  Random random(4);
  for (int step = 0; step < 6; ++step)
  {
    if (step == 2)
    {
      simulation.cut(planeAcrossX(11.4));
    }
    if (step == 4)
    {
      simulation.reset();
    }
    else
    {
      simulation.pull({ probeAt(scene, randomElement(scene, random), { 1.3, 0.4 * step, -0.8 }) });
    }
    number = simulation.resample({ 1, 1, 1 }, into(followed), number, CutSurfaces::Smooth, detail).number;
    Picture whole = followed;
    std::fill(whole.offset.begin(), whole.offset.end(), 0.0f);
    std::fill(whole.coverage.begin(), whole.coverage.end(), 1.0f);
    simulation.resample({ 1, 1, 1 }, into(whole), 0, CutSurfaces::Smooth, detail);
    EXPECT_EQ(different(followed.offset, whole.offset), 0u) << step;
    EXPECT_EQ(different(followed.coverage, whole.coverage), 0u) << step;
  }
}

TEST(Detail, WhatCannotBeIsRefused)
{
  const Scene scene({ 4, 4, 4 }, 0.3f);
  const Simulation simulation = simulate(scene);
  const BoxVisitor nothing = [](const std::vector<ResampledBox>&) {};
  for (const int factor : { 0, -1, 5 })
  {
    EXPECT_NE(messageOf<InputError>(
                [&] {
                  simulation.resample({ 0, 0, 0 }, nothing, 0, CutSurfaces::Stepped, finer(factor));
                })
                .find("1 to 4 times"),
      std::string::npos);
  }
  EXPECT_NE(messageOf<InputError>(
              [&] {
                simulation.resample({ 1 << 30, 0, 0 }, nothing, 0, CutSurfaces::Stepped, finer(4));
              })
              .find("too many voxels"),
    std::string::npos);

  const Simulation cut = opened(randomScene({ 22, 17, 14 }, 1, 6, 0.2), { 0, 0, 0 });
  cut.resample({ 0, 0, 0 }, nothing, 0, CutSurfaces::Smooth, finer(finestSmooth(3)));
  if (finestSmooth(3) < 3)
  {
    EXPECT_NE(messageOf<InputError>(
                [&] {
                  cut.resample({ 0, 0, 0 }, nothing, 0, CutSurfaces::Smooth, finer(3));
                })
                .find("loops"),
      std::string::npos);
    cut.resample({ 0, 0, 0 }, nothing, 0, CutSurfaces::Stepped, finer(3));
  }
}

}
