// Smooth cut surfaces against closed forms: the share of each voxel that lies on the tissue's side of a plane or
// sphere.

#include "Blades.h"
#include "Picture.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace
{

using namespace chainmail;

Vector3 unit(Vector3 v)
{
  const double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  return { v[0] / length, v[1] / length, v[2] / length };
}

double dot(const Vector3& a, const Vector3& b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// The share of the voxel at (i, j, k) in which `isTissue(point)` holds.
template <typename F> double shareOf(int i, int j, int k, F&& isTissue)
{
  constexpr int n = 14;
  int count = 0;
  for (int c = 0; c < n * n * n; ++c)
  {
    const auto along = [](int at, int cell) { return at - 0.5 + (cell + 0.5) / n; };
    count += isTissue(Vector3{ along(i, c % n), along(j, c / n % n), along(k, c / (n * n)) }) ? 1 : 0;
  }
  return static_cast<double>(count) / (n * n * n);
}

/// A rigid block with the corner of the highest indices cut off by a plane and pulled away. The opposite corner is
/// held.
struct Halves
{
  static constexpr int size = 30;
  Scene scene;
  Vector3 normal;
  double height;
  Vector3 shift;

  Halves(const Vector3& direction, const Vector3& shift, int layers = size)
    : scene(Index3{ size, size, layers }, 0.0f)
    , normal(unit(direction))
    , height(dot(normal, { 14.61, 14.3, 14.17 }))
    , shift(shift)
  {
  }

  Surface blade() const
  {
    const Vector3& n = this->normal;
    const Vector3 u = unit(std::fabs(n[0]) < 0.9 ? Vector3{ 0.0, n[2], -n[1] } : Vector3{ n[1], -n[0], 0.0 });
    const Vector3 v{ n[1] * u[2] - n[2] * u[1], n[2] * u[0] - n[0] * u[2], n[0] * u[1] - n[1] * u[0] };
    Surface surface{ {}, { { 0, 1, 2 }, { 1, 3, 2 } } };
    for (int corner = 0; corner < 4; ++corner)
    {
      Vector3 point;
      for (int a = 0; a < 3; ++a)
      {
        point[a] = n[a] * this->height + (corner & 1 ? 90.0 : -90.0) * u[a] + (corner & 2 ? 90.0 : -90.0) * v[a];
      }
      surface.points.push_back(point);
    }
    return surface;
  }

  bool isBelow(const Vector3& p) const { return dot(this->normal, p) < this->height; }
  bool isTissue(const Vector3& p) const
  {
    return this->isBelow(p) || !this->isBelow({ p[0] - this->shift[0], p[1] - this->shift[1], p[2] - this->shift[2] });
  }

  Simulation opened(const Index3& brick = { 0, 0, 0 }) const
  {
    Simulation simulation = simulate(this->scene, brick);
    EXPECT_GT(simulation.cut(this->blade()), 0u);
    Probe probe;
    probe.position = this->scene.place(size - 1, size - 1, this->scene.grid.size[2] - 1);
    probe.displacement = this->shift;
    Probe held;
    held.anchor = true;
    simulation.hold({ probe, held });
    simulation.propagate(0);
    return simulation;
  }

  /// Calls f(i, j, k) for voxels far from the outer faces of both halves.
  template <typename F> void each(F&& f) const
  {
    const int layers = this->scene.grid.size[2];
    for (int k = layers == 1 ? 0 : 6; k < std::max(1, layers - 2); ++k)
    {
      for (int j = 6; j < size - 2; ++j)
      {
        for (int i = 6; i < size - 2; ++i)
        {
          f(i, j, k);
        }
      }
    }
  }
};

/// Angles [degrees] between the normal of the cut and the gradient of the output's coverage, 1 in tissue and 0 behind
/// cuts, at voxels of the wall; sorted.
std::vector<double> anglesAt(const Halves& halves, const Picture& picture)
{
  std::vector<double> angles;
  halves.each(
    [&](int i, int j, int k)
    {
      const Vector3 gradient{ picture.covered(i + 1, j, k) - picture.covered(i - 1, j, k),
        picture.covered(i, j + 1, k) - picture.covered(i, j - 1, k),
        picture.covered(i, j, k + 1) - picture.covered(i, j, k - 1) };
      const double length = std::sqrt(dot(gradient, gradient));
      if (length > 0.5)
      {
        const double cosine = std::fabs(dot(gradient, halves.normal)) / length;
        angles.push_back(std::acos(std::min(1.0, cosine)) * 180.0 / std::acos(-1.0));
      }
    });
  std::sort(angles.begin(), angles.end());
  return angles;
}

std::vector<Halves> scenes()
{
  return { { { 0.8, 0.45, 0.3 }, { 3.4, 1.2, 0.7 } }, { { 0.3, 0.9, 0.2 }, { 0.0, 4.3, 0.0 } },
    { { 1.0, 1.0, 1.0 }, { 2.1, 2.3, 1.9 } }, { { 1.0, 0.13, 0.07 }, { 3.0, 0.0, 0.0 } } };
}

TEST(CutSurfaces, AVoxelShowsTheShareOnTheTissuesSideOfAPlane)
{
  for (const Halves& halves : scenes())
  {
    const Simulation simulation = halves.opened();
    const Picture smooth = resample(simulation, { 0, 0, 0 }, CutSurfaces::Smooth);
    const Picture stepped = resample(simulation);
    double worst = 0.0, sum = 0.0, exact = 0.0;
    int partial = 0;
    halves.each(
      [&](int i, int j, int k)
      {
        const double expected = shareOf(i, j, k, [&](const Vector3& p) { return halves.isTissue(p); });
        const double got = smooth.covered(i, j, k);
        worst = std::max(worst, std::fabs(got - expected));
        partial += expected > 0.02 && expected < 0.98 ? 1 : 0;
        sum += got;
        exact += expected;
      });
    EXPECT_GT(partial, 300);
    // 31 samples fill a box of 1.25 voxels. At an axis-parallel plane the box alone causes an error of at most a tenth,
    // and the number of samples one of 0.05. The bound of both for any plane is 1 / 6 + 0.06.
    EXPECT_LT(worst, 1.0 / 6 + 0.06);
    EXPECT_GT(worst, 0.01);
    EXPECT_NEAR(sum, exact, 3e-3 * exact);

    const std::vector<double> angles = anglesAt(halves, smooth);
    const std::vector<double> before = anglesAt(halves, stepped);
    ASSERT_GT(angles.size(), 300u);
    const auto of = [](const std::vector<double>& all, double share) { return all[std::size_t(share * all.size())]; };
    std::cout << "NUMERICS: gradients at an oblique cut are off by " << of(angles, 0.5) << " degrees (median), "
              << of(angles, 0.9) << " (nine of ten); in steps " << of(before, 0.5) << ", " << of(before, 0.9)
              << "; coverage is off by up to " << worst << "\n";
    EXPECT_LT(of(angles, 0.5), 10.0);
    EXPECT_LT(of(angles, 0.9), 25.0);
  }
}

TEST(CutSurfaces, WhatIsClosedShowsNoGap)
{
  const Halves halves({ 0.8, 0.45, 0.3 }, { 0.0, 0.0, 0.0 });
  Simulation simulation = simulate(halves.scene);
  EXPECT_GT(simulation.cut(halves.blade()), 0u);
  const Picture rest = resample(simulation, { 0, 0, 0 }, CutSurfaces::Smooth);
  for (std::size_t n = 0; n < rest.coverage.size(); ++n)
  {
    ASSERT_EQ(rest.coverage[n], 1.0f);
    ASSERT_EQ(rest.offset[3 * n], 0.0f);
  }
  std::vector<Probe> both(2);
  both[1].position = halves.scene.place(29, 29, 29);
  for (Probe& probe : both)
  {
    probe.displacement = { 1.37, -0.71, 0.44 };
  }
  simulation.hold(both);
  simulation.propagate(0);
  const Picture moved = resample(simulation, { 0, 0, 0 }, CutSurfaces::Smooth);
  halves.each([&](int i, int j, int k) { EXPECT_EQ(moved.covered(i, j, k), 1.0) << i << " " << j << " " << k; });
}

TEST(CutSurfaces, BitsDoNotDependOnBricks)
{
  const Halves halves({ 0.8, 0.45, 0.3 }, { 3.4, 1.2, 0.7 });
  const Picture first = resample(halves.opened(), { 2, 2, 2 }, CutSurfaces::Smooth);
  for (const Index3& brick : brickSizes())
  {
    const Picture other = resample(halves.opened(brick), { 2, 2, 2 }, CutSurfaces::Smooth);
    EXPECT_EQ(std::memcmp(first.coverage.data(), other.coverage.data(), first.coverage.size() * sizeof(float)), 0);
    EXPECT_EQ(std::memcmp(first.offset.data(), other.offset.data(), first.offset.size() * sizeof(float)), 0);
  }
}

TEST(CutSurfaces, ACarvedBallIsRound)
{
  const Vector3 centre{ 14.3, 15.1, 13.8 };
  const double radius = 7.3;
  for (const Vector3& shift : { Vector3{}, Vector3{ 1.3, -0.4, 0.7 } })
  {
    const Halves halves({ 1.0, 0.0, 0.0 }, shift);
    Simulation simulation = simulate(halves.scene);
    EXPECT_GT(simulation.carve(sphere(centre, radius, 40, 60)), 0u);
    Probe probe;
    probe.displacement = shift;
    simulation.hold({ probe });
    simulation.propagate(0);
    const Picture smooth = resample(simulation, { 0, 0, 0 }, CutSurfaces::Smooth);
    double worst = 0.0, sum = 0.0, exact = 0.0;
    halves.each(
      [&](int i, int j, int k)
      {
        const double expected = shareOf(i, j, k,
          [&](const Vector3& p)
          {
            const Vector3 from{ p[0] - shift[0] - centre[0], p[1] - shift[1] - centre[1], p[2] - shift[2] - centre[2] };
            return dot(from, from) > radius * radius;
          });
        worst = std::max(worst, std::fabs(smooth.covered(i, j, k) - expected));
        sum += 1.0 - smooth.covered(i, j, k);
        exact += 1.0 - expected;
      });
    EXPECT_LT(worst, 0.35); // a box of samples at a ball with a radius of 7 voxels
    EXPECT_NEAR(sum, exact, 0.015 * exact) << "of which the facets are most";
    const Picture stepped = resample(simulation);
    const auto carved = [&](const Picture& picture)
    {
      int count = 0;
      halves.each([&](int i, int j, int k) { count += picture.covered(i, j, k) < 0.5 ? 1 : 0; });
      return count;
    };
    EXPECT_NEAR(carved(smooth), carved(stepped), 0.05 * carved(stepped));
  }
}

TEST(CutSurfaces, ChangesAloneGiveTheWholePicture)
{
  const Halves halves({ 0.8, 0.45, 0.3 }, { 3.4, 1.2, 0.7 });
  Simulation simulation = simulate(halves.scene, { 4, 2, 2 });
  const Index3 none{ 0, 0, 0 };
  std::vector<float> kept(halves.scene.grid.voxels(), 1.0f);
  const auto follow = [&](const std::vector<ResampledBox>& boxes)
  {
    for (const ResampledBox& box : boxes)
    {
      box.forCovered([&](const Index3& at, const float* o, float coverage)
        { kept[halves.scene.grid.at(at[0], at[1], at[2])] = std::isnan(o[0]) ? 0.0f : coverage; });
    }
  };
  const auto expectWhole = [&]
  {
    const Picture whole = resample(simulation, none, CutSurfaces::Smooth);
    halves.scene.each([&](int i, int j, int k)
      { ASSERT_EQ(kept[halves.scene.grid.at(i, j, k)], whole.covered(i, j, k)) << i << " " << j << " " << k; });
  };
  std::uint64_t number = simulation.resample(none, follow, 0, CutSurfaces::Smooth).number;
  simulation.cut(halves.blade());
  std::vector<Probe> probes(2);
  probes[0].anchor = true;
  probes[1].position = halves.scene.place(29, 29, 29);
  for (const double share : { 0.2, 1.0, 0.0 })
  {
    for (int a = 0; a < 3; ++a)
    {
      probes[1].displacement[a] = share * halves.shift[a];
    }
    simulation.hold(probes);
    simulation.propagate(0);
    number = simulation.resample(none, follow, number, CutSurfaces::Smooth).number;
    expectWhole();
  }
  simulation.carve(sphere({ 8.1, 9.3, 8.7 }, 3.6, 20, 30));
  number = simulation.resample(none, follow, number, CutSurfaces::Smooth).number;
  expectWhole();
  simulation.reset();
  simulation.resample(none, follow, number, CutSurfaces::Smooth);
  expectWhole();
  EXPECT_THROW(simulation.resample(none, follow, number, CutSurfaces::Stepped), InputError);
}

TEST(CutSurfaces, AnImageOfOneLayerHasAreasForVolumes)
{
  const Halves halves({ 0.8, 0.6, 0.0 }, { 3.4, 1.2, 0.0 }, 1);
  const Picture smooth = resample(halves.opened(), { 0, 0, 0 }, CutSurfaces::Smooth);
  double worst = 0.0, sum = 0.0, exact = 0.0;
  halves.each(
    [&](int i, int j, int k)
    {
      const double expected = shareOf(i, j, k, [&](const Vector3& p) { return halves.isTissue(p); });
      worst = std::max(worst, std::fabs(smooth.covered(i, j, k) - expected));
      sum += smooth.covered(i, j, k);
      exact += expected;
    });
  EXPECT_LT(worst, 1.0 / 6 + 0.06);
  EXPECT_GT(worst, 0.01);
  EXPECT_NEAR(sum, exact, 0.01 * exact);
}

/// Bent soft tissue, cut in this state and not yet pulled apart: the two sides fit, except for the sampling error of
/// neighbouring cells.
TEST(CutSurfaces, BentTissueIsCutWhereItIs)
{
  Halves halves({ 0.8, 0.45, 0.3 }, {});
  halves.scene.constraint.assign(halves.scene.grid.voxels(), 0.4f);
  halves.scene.anchors.faces[0] = true;
  Simulation simulation = simulate(halves.scene);
  Probe probe;
  probe.position = halves.scene.place(29, 29, 15);
  probe.displacement = { 4.3, -5.1, 2.7 };
  simulation.hold({ probe });
  simulation.propagate(0);
  simulation.relax(30, 0.0);
  EXPECT_GT(simulation.cut(halves.blade()), 500u);
  const Picture closed = resample(simulation, { 0, 0, 0 }, CutSurfaces::Smooth);
  const Picture whole = resample(simulation);
  double least = 1.0, sum = 0.0;
  int count = 0;
  halves.each(
    [&](int i, int j, int k)
    {
      if (whole.covered(i, j, k) == 1.0)
      {
        least = std::min(least, closed.covered(i, j, k));
        sum += closed.covered(i, j, k);
        ++count;
      }
    });
  EXPECT_GT(least, 0.8);
  EXPECT_GT(sum / count, 0.999);

  // Pulled apart to the limits of the links, the surfaces are smooth.
  std::vector<Probe> probes{ probe, Probe() };
  probes[0].displacement = { 8.6, -2.1, 5.4 };
  probes[1].position = halves.scene.place(0, 0, 15);
  probes[1].anchor = true;
  simulation.hold(probes);
  simulation.propagate(0);
  simulation.relax(60, 0.0);
  const Picture smooth = resample(simulation, { 8, 8, 8 }, CutSurfaces::Smooth);
  const Picture stepped = resample(simulation, { 8, 8, 8 });
  const auto of = [](const std::vector<double>& all, double share) { return all[std::size_t(share * all.size())]; };
  const std::vector<double> angles = anglesAt(halves, smooth), before = anglesAt(halves, stepped);
  ASSERT_GT(angles.size(), 100u);
  std::cout << "NUMERICS: in bent tissue " << of(angles, 0.5) << ", " << of(angles, 0.9) << "; in steps "
            << of(before, 0.5) << ", " << of(before, 0.9) << "\n";
  EXPECT_LT(of(angles, 0.5), 10.0);
  EXPECT_LT(of(angles, 0.9), 25.0);
}

TEST(CutSurfaces, NeitherTheOrderOfTrianglesMattersNorWhetherTheyComeTogether)
{
  const Halves halves({ 1.0, 0.0, 0.0 }, { 0.0, 0.0, 0.0 });
  Surface curved =
    sheet(-5.0, -5.0, 1.7, 24, 24, [](double x, double y) { return 14.2 + 3.0 * std::sin(x / 4.0 + y / 9.0); });
  Surface ball = sphere({ 14.3, 15.1, 13.8 }, 7.3, 12, 16);
  std::optional<Picture> first;
  for (int order = 0; order < 3; ++order)
  {
    Simulation simulation = simulate(halves.scene);
    Surface rest = curved;
    if (order == 2)
    {
      const auto half = curved.triangles.begin() + curved.triangles.size() / 2;
      simulation.cut({ curved.points, { curved.triangles.begin(), half } });
      rest.triangles.assign(half, curved.triangles.end());
    }
    simulation.cut(rest);
    simulation.carve(ball);
    Probe probe;
    probe.displacement = { 1.4, 0.3, -2.2 };
    simulation.hold({ probe });
    simulation.propagate(0);
    const Picture picture = resample(simulation, { 3, 3, 3 }, CutSurfaces::Smooth);
    if (first)
    {
      EXPECT_EQ(
        std::memcmp(first->coverage.data(), picture.coverage.data(), picture.coverage.size() * sizeof(float)), 0);
    }
    first = picture;
    std::reverse(curved.triangles.begin(), curved.triangles.end());
    std::reverse(ball.triangles.begin(), ball.triangles.end());
  }
}

TEST(CutSurfaces, ABladeThatMissesTissueChangesNothing)
{
  const Halves halves({ 0.8, 0.45, 0.3 }, { 3.4, 1.2, 0.7 });
  Simulation simulation = simulate(halves.scene);
  EXPECT_EQ(simulation.cut(planeAcrossX(29.8)), 0u);
  Probe probe;
  probe.displacement = halves.shift;
  simulation.hold({ probe });
  simulation.propagate(0);
  const Picture smooth = resample(simulation, { 4, 4, 4 }, CutSurfaces::Smooth);
  const Picture stepped = resample(simulation, { 4, 4, 4 });
  EXPECT_EQ(smooth.coverage, stepped.coverage);
  EXPECT_EQ(std::memcmp(smooth.offset.data(), stepped.offset.data(), smooth.offset.size() * sizeof(float)), 0);
}

TEST(CutSurfaces, ABladeThatCutsNothingMoreMayBeNearer)
{
  const Halves halves({ 1.0, 0.0, 0.0 }, { 3.3, 0.0, 0.0 });
  Simulation simulation = simulate(halves.scene, { 4, 2, 2 });
  EXPECT_GT(simulation.cut(planeAcrossX(14.2)), 0u);
  std::vector<Probe> probes(2);
  probes[0].anchor = true;
  probes[1].position = halves.scene.place(29, 29, 29);
  probes[1].displacement = halves.shift;
  simulation.hold(probes);
  simulation.propagate(0);
  const Index3 none{ 0, 0, 0 };
  Picture before = resample(simulation, none, CutSurfaces::Smooth);
  const std::uint64_t number = simulation
                                 .resample(
                                   none, [](const std::vector<ResampledBox>&) {}, 0, CutSurfaces::Smooth)
                                 .number;
  EXPECT_EQ(simulation.cut(planeAcrossX(14.05)), 0u) << "between what is apart already";
  const std::vector<float> was = before.coverage;
  const auto follow = [&](const std::vector<ResampledBox>& boxes)
  {
    for (const ResampledBox& box : boxes)
    {
      box.forCovered([&](const Index3& at, const float*, float coverage)
        { before.coverage[before.at(at[0], at[1], at[2])] = coverage; });
    }
  };
  simulation.resample(none, follow, number, CutSurfaces::Smooth);
  EXPECT_EQ(before.coverage, resample(simulation, none, CutSurfaces::Smooth).coverage);
  EXPECT_NE(before.coverage, was);
}

}
