// Resampling against closed forms. Offsets are in voxels: the material at voxel y came from y + offset.

#include "../../Oracles/Resampling.h"
#include "Blades.h"
#include "Picture.h"

#include <cmath>

namespace
{

using namespace chainmail;

void expectNothingChanged(const Picture& picture)
{
  for (const float o : picture.offset)
  {
    ASSERT_EQ(o, 0.0f);
  }
}

/// Whether an element is within one voxel, diagonals included: the tissue and its skirt.
bool nearTissue(const Scene& scene, int i, int j, int k)
{
  for (int c = -1; c <= 1; ++c)
  {
    for (int b = -1; b <= 1; ++b)
    {
      for (int a = -1; a <= 1; ++a)
      {
        if (scene.grid.contains(i + a, j + b, k + c) && scene.tissue(scene.grid.at(i + a, j + b, k + c)))
        {
          return true;
        }
      }
    }
  }
  return false;
}

bool isTissue(const Scene& scene, int i, int j, int k)
{
  return scene.grid.contains(i, j, k) && scene.tissue(scene.grid.at(i, j, k));
}

/// An asymmetric rigid body in air.
Scene lump(const Index3& size, const Vector3& centre, double radius)
{
  Scene scene(size, 0.0f);
  scene.each(
    [&](int i, int j, int k)
    {
      const double x = i - centre[0], y = j - centre[1], z = k - centre[2];
      const bool inside = x * x + y * y + z * z <= radius * radius && !(x > 1 && y > 1 && z > 0);
      scene.scalar[scene.grid.at(i, j, k)] = inside ? 1.0f : 0.0f;
    });
  return scene;
}

/// The output's value at voxel y: 1 in tissue, 0 in air, trilinear between voxel centres; 0 where it is vacated.
double shownTissue(const Scene& scene, const Picture& picture, int i, int j, int k)
{
  if (picture.vacated(i, j, k))
  {
    return 0.0;
  }
  const Vector3 o = picture(i, j, k);
  const double x[3] = { i + o[0], j + o[1], k + o[2] };
  int low[3];
  double t[3];
  for (int a = 0; a < 3; ++a)
  {
    low[a] = static_cast<int>(std::floor(x[a]));
    t[a] = x[a] - low[a];
  }
  double sum = 0.0;
  for (int n = 0; n < 8; ++n)
  {
    const int p[3] = { n & 1, n >> 1 & 1, n >> 2 };
    const double w = (p[0] ? t[0] : 1 - t[0]) * (p[1] ? t[1] : 1 - t[1]) * (p[2] ? t[2] : 1 - t[2]);
    sum += isTissue(scene, low[0] + p[0], low[1] + p[1], low[2] + p[2]) ? w : 0.0;
  }
  return sum;
}

TEST(Resample, AtRestNothingChanges)
{
  Scene scene = randomScene({ 17, 13, 9 }, 1, 1, 0.3);
  for (const Index3& brick : brickSizes())
  {
    Simulation simulation = simulate(scene, brick);
    expectNothingChanged(resample(simulation));
    simulation.cut(planeAcrossX(7.5));
    simulation.cut(sphere({ 9, 6, 4 }, 3.0, 10, 12));
    expectNothingChanged(resample(simulation));
    expectNothingChanged(resample(simulation, { 3, 0, 2 }));
    Random random(3);
    simulation.pull({ probeAt(scene, randomElement(scene, random), { 2.0, 1.0, 0.0 }) });
    simulation.reset();
    expectNothingChanged(resample(simulation));
  }
}

TEST(Resample, WholeVoxelTranslationIsExact)
{
  for (const Index3& brick : brickSizes())
  {
    for (const Index3& shift : { Index3{ 3, -2, 4 }, Index3{ -1, 0, 0 }, Index3{ 0, 0, 1 }, Index3{ -4, 3, -3 } })
    {
      SCOPED_TRACE(testing::Message() << "shift " << shift[0] << ' ' << shift[1] << ' ' << shift[2]);
      Scene scene = lump({ 24, 22, 20 }, { 11, 10, 9 }, 4.6);
      scene.grid.spacing = { 0.5, 1.0, 2.0 }; // powers of two, so the conversion of millimetres to voxels is exact
      Simulation simulation = simulate(scene, brick);
      simulation.pull({ probeAt(scene, { 11, 10, 9 }, { 0.5 * shift[0], 1.0 * shift[1], 2.0 * shift[2] }) });
      const Picture picture = resample(simulation);
      const Vector3 back{ -1.0 * shift[0], -1.0 * shift[1], -1.0 * shift[2] };
      picture.each(
        [&](int i, int j, int k)
        {
          const int x = i - shift[0], y = j - shift[1], z = k - shift[2];
          if (isTissue(scene, x, y, z) || nearTissue(scene, x, y, z))
          {
            // Tissue and the partial-volume voxels around it are the shifted input.
            ASSERT_EQ(picture(i, j, k), back) << i << ' ' << j << ' ' << k;
          }
          else if (isTissue(scene, i, j, k))
          {
            ASSERT_TRUE(picture.vacated(i, j, k)) << i << ' ' << j << ' ' << k;
          }
          else if (!nearTissue(scene, i, j, k))
          {
            ASSERT_EQ(picture(i, j, k), (Vector3{ 0, 0, 0 })) << i << ' ' << j << ' ' << k;
          }
        });
    }
  }
}

/// The displacement between elements, trilinear [voxels].
Vector3 displacementAt(const Grid& grid, const std::vector<float>& u, const Vector3& x)
{
  int low[3];
  double t[3];
  for (int a = 0; a < 3; ++a)
  {
    low[a] = std::min(static_cast<int>(std::floor(x[a])), grid.size[a] - 2);
    t[a] = x[a] - low[a];
  }
  Vector3 sum{};
  for (int n = 0; n < 8; ++n)
  {
    const int p[3] = { n & 1, n >> 1 & 1, n >> 2 };
    const double w = (p[0] ? t[0] : 1 - t[0]) * (p[1] ? t[1] : 1 - t[1]) * (p[2] ? t[2] : 1 - t[2]);
    for (int a = 0; a < 3; ++a)
    {
      sum[a] += w * u[3 * grid.at(low[0] + p[0], low[1] + p[1], low[2] + p[2]) + a];
    }
  }
  return sum;
}

// A block of which more voxels are displaced than one batch has (Resampling.cpp). Wherever batches meet, every voxel
// gets the material that is there: from x, if x and the displacement at x lead to the voxel.
TEST(Resample, EveryVoxelOfSeveralBatchesShowsTheMaterialThatIsThere)
{
  const Scene scene({ 210, 172, 160 }, 0.05f);
  Simulation simulation = simulate(scene);
  simulation.pull({ probeAt(scene, { 105, 86, 80 }, { 16.0, -18.0, 17.0 }) });
  const std::vector<float> u = displacements(simulation);
  const Picture picture = resample(simulation);
  std::size_t displaced = 0;
  double off = 0.0;
  picture.each(
    [&](int i, int j, int k)
    {
      if (picture.vacated(i, j, k))
      {
        return;
      }
      const Vector3 o = picture(i, j, k);
      const Vector3 x{ i + o[0], j + o[1], k + o[2] };
      displaced += picture.visits[picture.at(i, j, k)];
      for (int a = 0; a < 3; ++a)
      {
        if (x[a] < 0.0 || x[a] > scene.grid.size[a] - 1)
        {
          return; // from beyond the outermost elements
        }
      }
      const Vector3 there = displacementAt(scene.grid, u, x);
      for (int a = 0; a < 3; ++a)
      {
        off = std::max(off, std::fabs(there[a] + o[a]));
      }
    });
  EXPECT_GT(displaced, std::size_t(1) << 22);
  EXPECT_LT(off, 2e-5); // measured: 3.2e-6

  // Voxels that show nothing although an element is in them, with others all around it.
  std::size_t holes = 0;
  const Index3& size = scene.grid.size;
  scene.each(
    [&](int i, int j, int k)
    {
      const float* own = u.data() + 3 * scene.grid.at(i, j, k);
      const int x = static_cast<int>(std::lround(i + own[0]));
      const int y = static_cast<int>(std::lround(j + own[1]));
      const int z = static_cast<int>(std::lround(k + own[2]));
      const bool inside = std::min({ i, j, k, size[0] - 1 - i, size[1] - 1 - j, size[2] - 1 - k }) > 0;
      holes += inside && scene.grid.contains(x, y, z) && picture.vacated(x, y, z) ? 1 : 0;
    });
  EXPECT_EQ(holes, 0u);
}

TEST(Resample, LessThanAMillionthOfAVoxelIsRest)
{
  for (const Index3& brick : brickSizes())
  {
    for (const double far : { 9e-7, 1.1e-6 })
    {
      SCOPED_TRACE(far);
      const Scene scene = lump({ 24, 22, 20 }, { 11, 10, 9 }, 4.6);
      Simulation simulation = simulate(scene, brick);
      simulation.pull({ probeAt(scene, { 11, 10, 9 }, { far, 0.0, 0.0 }) });
      EXPECT_EQ(simulation.resample({ 0, 0, 0 }, [](const std::vector<ResampledBox>&) {}).atRest, far < 1e-6);
      const Picture picture = resample(simulation);
      if (far < 1e-6)
      {
        expectNothingChanged(picture);
        continue;
      }
      // Coordinates in a cell are rounded like numbers near 1.
      EXPECT_NEAR(picture(11, 10, 9)[0], -far, 1.2e-7);
    }
  }
}

TEST(Resample, TissueUpToTheBorderMovesIntoThePadding)
{
  // Without air everything is shown, also the outermost layers, and the rest is vacated.
  Scene scene({ 9, 8, 7 }, 0.0f);
  Simulation simulation = simulate(scene, { 4, 4, 4 });
  simulation.pull({ probeAt(scene, { 4, 4, 3 }, { 2.0, -3.0, 1.0 }) });
  const Picture picture = resample(simulation, { 4, 5, 3 });
  EXPECT_EQ(picture.size, (Index3{ 17, 18, 13 }));
  int shown = 0, vacated = 0;
  picture.each(
    [&](int i, int j, int k)
    {
      if (isTissue(scene, i - 2, j + 3, k - 1))
      {
        ++shown;
        ASSERT_EQ(picture(i, j, k), (Vector3{ -2, 3, -1 })) << i << ' ' << j << ' ' << k;
      }
      else if (isTissue(scene, i, j, k))
      {
        ++vacated;
        ASSERT_TRUE(picture.vacated(i, j, k)) << i << ' ' << j << ' ' << k;
      }
    });
  EXPECT_EQ(shown, 9 * 8 * 7);
  EXPECT_EQ(vacated, 9 * 8 * 7 - 7 * 5 * 6);

  // Without padding, tissue outside of the image is missing and the rest is shown.
  const Picture cropped = resample(simulation);
  cropped.each(
    [&](int i, int j, int k)
    {
      const bool comesFromInside = isTissue(scene, i - 2, j + 3, k - 1);
      ASSERT_EQ(comesFromInside, !cropped.vacated(i, j, k)) << i << ' ' << j << ' ' << k;
    });
}

// Trilinear interpolation preserves the sum of an image under any translation if the voxels at the border move along.
// An eroded border would reduce the sum, a dilated one would increase it.
TEST(Resample, BordersNeitherErodeNorGrow)
{
  for (const Vector3& shift : { Vector3{ 0.5, 0, 0 }, Vector3{ 0.37, -0.61, 0.25 }, Vector3{ -2.25, 1.75, 3.5 } })
  {
    SCOPED_TRACE(testing::Message() << "shift " << shift[0] << ' ' << shift[1] << ' ' << shift[2]);
    Scene scene = lump({ 24, 22, 20 }, { 11, 10, 9 }, 4.6);
    Simulation simulation = simulate(scene);
    simulation.pull({ probeAt(scene, { 11, 10, 9 }, shift) });
    const Picture picture = resample(simulation);
    double elements = 0.0, shown = 0.0;
    picture.each(
      [&](int i, int j, int k)
      {
        elements += isTissue(scene, i, j, k);
        shown += shownTissue(scene, picture, i, j, k);
        if (isTissue(scene, i, j, k) && !picture.vacated(i, j, k) && shownTissue(scene, picture, i, j, k) > 0.0)
        {
          for (int a = 0; a < 3; ++a)
          {
            ASSERT_NEAR(picture(i, j, k)[a], -shift[a], 1e-5);
          }
        }
      });
    EXPECT_NEAR(shown, elements, 1e-4 * elements);
  }
}

TEST(Resample, LinearStretchIsTheAnalyticPreimage)
{
  // Uniform limits and every link at its limit: u(x) = slope * x exactly, for a stretch and for a compression, with a
  // shear along y.
  const int n = 16;
  for (const double slope : { 0.25, -0.25, 0.4, -0.3 })
  {
    SCOPED_TRACE(slope);
    Scene scene({ n, 9, 8 }, static_cast<float>(std::abs(slope)));
    scene.anchors.faces[0] = true;
    const double t = slope * (n - 1);
    std::vector<Probe> probes;
    for (int k = 0; k < 8; ++k)
    {
      for (int j = 0; j < 9; ++j)
      {
        probes.push_back(probeAt(scene, { n - 1, j, k }, { t, t / 2, 0.0 }));
      }
    }
    Simulation simulation = simulate(scene);
    simulation.pull(probes);
    simulation.relax(2000, 1e-6); // for the shear, which is linear only after relaxation
    oracle::LinearField field;
    field.gradient[0][0] = slope;
    field.gradient[1][0] = slope / 2;
    const Index3 padding{ 8, 8, 0 };
    const Picture picture = resample(simulation, padding);
    int inside = 0;
    picture.each(
      [&](int i, int j, int k)
      {
        const oracle::Vector3 x = field.preimage({ double(i), double(j), double(k) });
        if (x[0] < 0.01 || x[0] > n - 1.01 || x[1] < 0.01 || x[1] > 7.99)
        {
          return;
        }
        ++inside;
        // Relaxation leaves an error of 2e-4 voxels (see TestRelaxation); that of the inversion is far smaller.
        ASSERT_NEAR(picture(i, j, k)[0], x[0] - i, 5e-4) << i << ' ' << j << ' ' << k;
        ASSERT_NEAR(picture(i, j, k)[1], x[1] - j, 5e-4) << i << ' ' << j << ' ' << k;
        ASSERT_NEAR(picture(i, j, k)[2], 0.0, 5e-4);
      });
    EXPECT_GT(inside, static_cast<int>((n - 2) * (1 + slope)) * 5 * 6);
  }
}

TEST(Resample, TwoHalvesPulledApartAreWholeAndLeaveTheGap)
{
  // The blade is between voxels, close to voxels and exactly on them.
  for (const double at : { 9.5, 9.1, 9.9, 10.0 })
  {
    SCOPED_TRACE(at);
    Scene scene({ 24, 12, 11 }, 0.0f);
    scene.each(
      [&](int i, int j, int k)
      {
        if (i < 5 || i > 17 || j < 2 || j > 9 || k < 2 || k > 8)
        {
          scene.air(i, j, k);
        }
      });
    for (const Index3& brick : brickSizes())
    {
      Simulation simulation = simulate(scene, brick);
      ASSERT_EQ(simulation.cut(planeAcrossX(at)), 8u * 7u);
      const std::vector<int> label = clusters(simulation);
      const int leftLabel = label[scene.grid.at(6, 5, 5)];
      const int edge = label[scene.grid.at(10, 5, 5)] == leftLabel ? 11 : 10; // first layer of the right half
      simulation.pull(
        { probeAt(scene, { 6, 5, 5 }, { -2.0, 1.0, 0.0 }), probeAt(scene, { 16, 5, 5 }, { 3.0, 0.0, -1.0 }) });
      const Picture picture = resample(simulation);
      int left = 0, right = 0, gap = 0;
      picture.each(
        [&](int i, int j, int k)
        {
          const bool fromLeft = isTissue(scene, i + 2, j - 1, k) && i + 2 < edge;
          const bool fromRight = isTissue(scene, i - 3, j, k + 1) && i - 3 >= edge;
          ASSERT_FALSE(fromLeft && fromRight);
          if (fromLeft)
          {
            ++left;
            ASSERT_EQ(picture(i, j, k), (Vector3{ 2, -1, 0 })) << i << ' ' << j << ' ' << k;
          }
          else if (fromRight)
          {
            ++right;
            ASSERT_EQ(picture(i, j, k), (Vector3{ -3, 0, 1 })) << i << ' ' << j << ' ' << k;
          }
          else if (isTissue(scene, i, j, k) && i >= edge - 2 && i < edge + 3)
          {
            // Between the halves is background, except where the border of one half moves along the other axes.
            const bool borderOfOne = !isTissue(scene, i, j - 1, k) || !isTissue(scene, i, j, k + 1);
            gap += picture.vacated(i, j, k);
            ASSERT_TRUE(picture.vacated(i, j, k) || borderOfOne) << i << ' ' << j << ' ' << k;
          }
        });
      EXPECT_EQ(left, (edge - 5) * 8 * 7);
      EXPECT_EQ(right, (18 - edge) * 8 * 7);
      EXPECT_EQ(gap, 5 * 8 * 7); // two voxels to the left and three to the right, over the whole cross section
    }
  }
}

TEST(Resample, ACurvedCutLosesNoTissue)
{
  Scene scene({ 22, 20, 34 }, 0.0f);
  scene.each(
    [&](int i, int j, int k)
    {
      if (i < 3 || i > 18 || j < 3 || j > 16 || k < 8 || k > 25)
      {
        scene.air(i, j, k);
      }
    });
  Simulation simulation = simulate(scene);
  simulation.cut(sheet(
    -1.0, -1.0, 0.5, 50, 46, [](double x, double y) { return 16.0 + 3.0 * std::sin(0.5 * x) * std::cos(0.4 * y); }));
  const std::vector<int> label = clusters(simulation);
  const int below = label[scene.grid.at(5, 5, 9)], above = label[scene.grid.at(5, 5, 24)];
  ASSERT_NE(below, above);
  simulation.pull({ probeAt(scene, { 5, 5, 9 }, { 0.0, 0.0, -3.0 }), probeAt(scene, { 5, 5, 24 }, { 0.0, 0.0, 4.0 }) });
  const Picture picture = resample(simulation);
  int lost = 0, gap = 0;
  scene.each(
    [&](int i, int j, int k)
    {
      const std::size_t v = scene.grid.at(i, j, k);
      if (scene.tissue(v))
      {
        const int to = label[v] == below ? k - 3 : k + 4;
        const Vector3 expected{ 0.0, 0.0, static_cast<double>(k - to) };
        lost += picture(i, j, to) != expected;
      }
      gap += scene.tissue(v) && picture.vacated(i, j, k);
    });
  EXPECT_EQ(lost, 0);
  // Every column opens by exactly seven voxels.
  EXPECT_EQ(gap, 16 * 14 * 7);
}

TEST(Resample, OffsetsAreOfTheSameBitsForEveryBrickAndRun)
{
  Scene scene = randomScene({ 26, 22, 18 }, 1, 8, 0.1, 0.05);
  scene.anchors.faces[0] = true;
  const std::vector<Probe> probes = compatibleProbes(scene, 3, 3.0, 9);
  std::vector<float> first;
  for (int run = 0; run < 4; ++run)
  {
    Simulation simulation = simulate(scene, brickSizes()[run % 3]);
    simulation.cut(planeAcrossX(12.5));
    simulation.pull(probes);
    simulation.relax(10, 0.0);
    const Picture picture = resample(simulation, { 2, 1, 3 });
    if (run == 0)
    {
      first = picture.offset;
    }
    std::size_t different = 0;
    for (std::size_t n = 0; n < first.size(); ++n)
    {
      const bool same = first[n] == picture.offset[n] || (std::isnan(first[n]) && std::isnan(picture.offset[n]));
      different += !same;
    }
    EXPECT_EQ(different, 0u) << "run " << run;
  }
}

// Every voxel shows material that the displacement field maps there.
TEST(Resample, OffsetsInvertTheDisplacementField)
{
  Scene scene({ 22, 20, 18 }, 0.3f);
  scene.anchors.faces.fill(true);
  Simulation simulation = simulate(scene);
  simulation.pull({ probeAt(scene, { 11, 10, 9 }, { 2.0, -1.6, 1.2 }) });
  simulation.relax(40, 0.0);
  const std::vector<oracle::Vector3> u = state(simulation);
  const Picture picture = resample(simulation);
  int checked = 0;
  picture.each(
    [&](int i, int j, int k)
    {
      ASSERT_FALSE(picture.vacated(i, j, k)) << "a hole at " << i << ' ' << j << ' ' << k;
      const Vector3 o = picture(i, j, k);
      const double x[3] = { i + o[0], j + o[1], k + o[2] };
      int low[3];
      double t[3];
      for (int a = 0; a < 3; ++a)
      {
        low[a] = std::min(std::max(static_cast<int>(std::floor(x[a])), 0), scene.grid.size[a] - 2);
        t[a] = x[a] - low[a];
        ASSERT_GT(t[a], -2e-3);
        ASSERT_LT(t[a], 1 + 2e-3);
      }
      for (int a = 0; a < 3; ++a)
      {
        double moved = x[a];
        for (int n = 0; n < 8; ++n)
        {
          const double w = (n & 1 ? t[0] : 1 - t[0]) * (n & 2 ? t[1] : 1 - t[1]) * (n & 4 ? t[2] : 1 - t[2]);
          moved += w * u[scene.grid.at(low[0] + (n & 1), low[1] + (n >> 1 & 1), low[2] + (n >> 2))][a];
        }
        const int y[3] = { i, j, k };
        ASSERT_NEAR(moved, y[a], 5e-4) << i << ' ' << j << ' ' << k;
      }
      ++checked;
    });
  EXPECT_EQ(checked, 22 * 20 * 18);
}

TEST(Resample, SingleSlice)
{
  for (int axis = 0; axis < 3; ++axis)
  {
    Index3 size{ 20, 20, 20 };
    size[axis] = 1;
    Scene scene(size, 0.0f);
    scene.each(
      [&](int i, int j, int k)
      {
        const int p[3] = { i, j, k };
        for (int a = 0; a < 3; ++a)
        {
          if (a != axis && (p[a] < 6 || p[a] > 12))
          {
            scene.air(i, j, k);
          }
        }
      });
    Index3 grabbed{ 9, 9, 9 }, shift{ 3, -2, 4 };
    grabbed[axis] = shift[axis] = 0;
    Simulation simulation = simulate(scene);
    simulation.pull({ probeAt(scene, grabbed, { 1.0 * shift[0], 1.0 * shift[1], 1.0 * shift[2] }) });
    const Picture picture = resample(simulation);
    int shown = 0;
    picture.each(
      [&](int i, int j, int k)
      {
        if (isTissue(scene, i - shift[0], j - shift[1], k - shift[2]))
        {
          ++shown;
          ASSERT_EQ(picture(i, j, k), (Vector3{ -1.0 * shift[0], -1.0 * shift[1], -1.0 * shift[2] }));
        }
        else if (isTissue(scene, i, j, k) && !nearTissue(scene, i - shift[0], j - shift[1], k - shift[2]))
        {
          ASSERT_TRUE(picture.vacated(i, j, k));
        }
      });
    EXPECT_EQ(shown, 49);
  }
}

// A column of equal layers that moves along them shows the same in each layer except the outermost. A single layer
// alone shows the same, too, including the air at its border.
TEST(Resample, ASingleSliceShowsWhatALayerOfAColumnDoes)
{
  const auto shape = [](int axis, int thickness)
  {
    Index3 size{ 22, 20, 18 };
    size[axis] = thickness;
    Scene scene(size, 0.0f);
    scene.each(
      [&](int i, int j, int k)
      {
        const Vector3 p{ i - 9.0, j - 8.0, k - 8.0 };
        const double x = p[(axis + 1) % 3], y = p[(axis + 2) % 3];
        if (x * x + 2.0 * y * y > 20.0 || (x > 1 && y > 1) || (x == -2 && y == 0))
        {
          scene.air(i, j, k);
        }
      });
    return scene;
  };
  for (int axis = 0; axis < 3; ++axis)
  {
    for (const double step : { 0.4, 1.0, 2.3 })
    {
      SCOPED_TRACE(testing::Message() << "flat along axis " << axis << ", moved by " << step);
      Index3 grabbed{ 9, 8, 8 };
      Vector3 shift{ step, -1.5 * step, 0.8 * step };
      shift[axis] = 0.0;
      std::vector<Picture> pictures;
      for (const int thickness : { 1, 7 })
      {
        const Scene scene = shape(axis, thickness);
        grabbed[axis] = thickness / 2;
        Simulation simulation = simulate(scene);
        simulation.pull({ probeAt(scene, grabbed, shift) });
        pictures.push_back(resample(simulation));
      }
      int moved = 0, vacated = 0;
      pictures[0].each(
        [&](int i, int j, int k)
        {
          Index3 middle{ i, j, k };
          middle[axis] = 3;
          const Vector3 layer = pictures[1](middle[0], middle[1], middle[2]);
          EXPECT_EQ(pictures[0].vacated(i, j, k), std::isnan(layer[0])) << i << ' ' << j << ' ' << k;
          if (!std::isnan(layer[0]))
          {
            const Vector3 alone = pictures[0](i, j, k);
            for (int a = 0; a < 3; ++a)
            {
              ASSERT_NEAR(alone[a], layer[a], 1e-5)
                << i << ' ' << j << ' ' << k; // the residual at which Newton's method stops
            }
          }
          moved += layer != Vector3{ 0, 0, 0 };
          vacated += std::isnan(layer[0]);
        });
      EXPECT_GT(moved, 40);
      if (step > 1.0)
      {
        EXPECT_GT(vacated, 20);
      }
    }
  }
}

// Two bodies at the same place: the winner does not depend on the run, and both are complete elsewhere.
TEST(Resample, OverlapShowsOneOfTheTwo)
{
  Scene scene({ 26, 12, 12 }, 0.0f);
  scene.each(
    [&](int i, int j, int k)
    {
      const bool first = i >= 3 && i <= 8, second = i >= 15 && i <= 20;
      if (!(first || second) || j < 3 || j > 8 || k < 3 || k > 8)
      {
        scene.air(i, j, k);
      }
    });
  std::vector<float> before;
  for (int run = 0; run < 3; ++run)
  {
    Simulation simulation = simulate(scene, brickSizes()[run]);
    simulation.pull(
      { probeAt(scene, { 5, 5, 5 }, { 9.0, 0.0, 0.0 }) }); // to 12..17, which overlaps 15..17 of the other body
    const Picture picture = resample(simulation);
    for (int i = 12; i <= 20; ++i)
    {
      const Vector3 o = picture(i, 5, 5);
      const bool mayMove = i <= 17, mayRest = i >= 15;
      EXPECT_TRUE((mayMove && o == Vector3{ -9, 0, 0 }) || (mayRest && o == Vector3{ 0, 0, 0 })) << i << ": " << o[0];
    }
    for (int i = 3; i <= 8; ++i)
    {
      EXPECT_TRUE(picture.vacated(i, 5, 5));
    }
    if (run == 0)
    {
      before = picture.offset;
    }
    for (std::size_t n = 0; n < before.size(); ++n)
    {
      ASSERT_TRUE(before[n] == picture.offset[n] || (std::isnan(before[n]) && std::isnan(picture.offset[n])));
    }
  }
}

TEST(Resample, OnlyWhatChangedIsVisited)
{
  Scene scene({ 80, 80, 80 }, 0.4f);
  Simulation simulation = simulate(scene);
  simulation.pull({ probeAt(scene, { 40, 40, 40 }, { 1.5, 0.0, 0.0 }) });
  const Picture picture = resample(simulation);
  std::size_t visited = 0;
  for (const int v : picture.visits)
  {
    visited += v;
  }
  EXPECT_GT(visited, 0u);
  EXPECT_LT(visited, scene.grid.voxels() / 4);
}

// --- Carved tissue

TEST(Resample, CarvedTissueAtRestLeavesItsVoxelsAndNothingElse)
{
  Scene scene = randomScene({ 21, 17, 13 }, 1, 61, 0.2);
  for (const Index3& brick : brickSizes())
  {
    Simulation simulation = simulate(scene, brick);
    simulation.cut(planeAcrossX(12.5));
    std::vector<std::uint8_t> before(scene.grid.voxels()), after(scene.grid.voxels());
    simulation.elements(before.data());
    ASSERT_GT(simulation.carve(sphere({ 9.2, 8.1, 6.3 }, 4.2, 9, 12)), 100u);
    simulation.elements(after.data());
    for (const Index3& padding : { Index3{ 0, 0, 0 }, Index3{ 3, 1, 2 } })
    {
      const Picture picture = resample(simulation, padding);
      picture.each(
        [&](int i, int j, int k)
        {
          const bool inside = scene.grid.contains(i, j, k);
          const std::size_t v = inside ? scene.grid.at(i, j, k) : 0;
          if (inside && before[v] && !after[v])
          {
            ASSERT_TRUE(picture.vacated(i, j, k)) << i << ' ' << j << ' ' << k;
          }
          else
          {
            ASSERT_EQ(picture(i, j, k), (Vector3{ 0, 0, 0 })) << i << ' ' << j << ' ' << k;
          }
        });
    }
    simulation.restoreTopology();
    expectNothingChanged(resample(simulation));
  }
}

TEST(Resample, OnlyWhatWasCarvedIsVisited)
{
  Scene scene({ 80, 80, 80 }, 0.4f);
  Simulation simulation = simulate(scene, { 8, 8, 8 });
  simulation.carve(sphere({ 41.0, 40.0, 39.0 }, 6.0, 9, 12));
  const Picture picture = resample(simulation);
  std::size_t visited = 0;
  picture.each(
    [&](int i, int j, int k)
    {
      const std::size_t v = picture.at(i, j, k);
      visited += picture.visits[v];
      ASSERT_TRUE(picture.visits[v] || !picture.vacated(i, j, k));
    });
  EXPECT_GT(visited, 0u);
  EXPECT_LE(visited, 3u * 3u * 3u * 512u);
}

// A rigid body with a hole moves by whole voxels: the hole moves with it.
TEST(Resample, AHoleMovesWithItsTissue)
{
  for (const Index3& brick : brickSizes())
  {
    for (const Index3& shift : { Index3{ 3, -2, 4 }, Index3{ -1, 0, 0 }, Index3{ 0, 0, 1 }, Index3{ 2, 2, 2 } })
    {
      SCOPED_TRACE(testing::Message() << "shift " << shift[0] << ' ' << shift[1] << ' ' << shift[2]);
      Scene scene = lump({ 26, 24, 22 }, { 12, 11, 10 }, 6.6);
      Simulation simulation = simulate(scene, brick);
      ASSERT_GT(simulation.carve(sphere({ 12.2, 11.1, 10.3 }, 3.3, 9, 12)), 80u);
      std::vector<std::uint8_t> left(scene.grid.voxels());
      simulation.elements(left.data());
      simulation.pull({ probeAt(scene, { 7, 11, 10 }, { 1.0 * shift[0], 1.0 * shift[1], 1.0 * shift[2] }) });
      const Picture picture = resample(simulation);
      int shown = 0, hole = 0;
      picture.each(
        [&](int i, int j, int k)
        {
          const int x = i - shift[0], y = j - shift[1], z = k - shift[2];
          const bool came = isTissue(scene, x, y, z);
          if (came && left[scene.grid.at(x, y, z)])
          {
            ++shown;
            ASSERT_EQ(picture(i, j, k), (Vector3{ -1.0 * shift[0], -1.0 * shift[1], -1.0 * shift[2] }))
              << i << ' ' << j << ' ' << k;
          }
          else if (came && isTissue(scene, i, j, k))
          {
            ++hole;
            ASSERT_TRUE(picture.vacated(i, j, k)) << i << ' ' << j << ' ' << k;
          }
        });
      EXPECT_EQ(shown, std::count(left.begin(), left.end(), 1));
      EXPECT_GT(hole, 40);
    }
  }
}

// Moves by fractions of a voxel: the remaining tissue extends half way to a carved neighbour, in either direction.
TEST(Resample, WhatIsLeftKeepsItsHalfOfACarvedCell)
{
  for (const double shift : { 0.3, 0.45, 0.55, 0.8, -0.3, -0.45, -0.55, -0.8 })
  {
    SCOPED_TRACE(shift);
    Scene scene({ 24, 10, 9 }, 0.0f);
    Simulation simulation = simulate(scene, { 8, 4, 4 });
    // Two halves: 0 .. 9 moves, 14 .. 23 is at rest.
    ASSERT_EQ(simulation.carve(box({ 9.5, -1.0, -1.0 }, { 13.5, 20.0, 20.0 })), 4u * 10u * 9u);
    simulation.pull({ probeAt(scene, { 4, 4, 4 }, { shift, 0.0, 0.0 }) });
    const Picture picture = resample(simulation);
    picture.each(
      [&](int i, int j, int k)
      {
        // Layer 9 and half of the distance to layer 10 are at up to 9.5 + shift now; nothing is below 0 + shift.
        const bool shown = i >= shift && i < 9.5 + shift;
        if (i >= 14)
        {
          ASSERT_EQ(picture(i, j, k)[0], 0.0) << i;
        }
        else if (shown)
        {
          ASSERT_NEAR(picture(i, j, k)[0], -shift, 1e-5) << i;
        }
        else
        {
          ASSERT_TRUE(picture.vacated(i, j, k)) << i;
        }
      });
  }
}

TEST(Resample, TissueMovesThroughAHole)
{
  for (const Index3& brick : brickSizes())
  {
    // A body moves through a channel that was carved into another one.
    Scene scene({ 34, 14, 14 }, 0.0f);
    scene.each(
      [&](int i, int j, int k)
      {
        const bool body = i >= 2 && i <= 6 && j >= 5 && j <= 8 && k >= 5 && k <= 8;
        const bool block = i >= 12 && i <= 26;
        if (!body && !block)
        {
          scene.air(i, j, k);
        }
      });
    Simulation simulation = simulate(scene, brick);
    ASSERT_EQ(simulation.carve(box({ 11.5, 2.5, 2.5 }, { 26.5, 11.5, 11.5 })), 15u * 9u * 9u);
    simulation.pull({ probeAt(scene, { 4, 6, 6 }, { 15.0, 0.0, 0.0 }) });
    const Picture picture = resample(simulation);
    picture.each(
      [&](int i, int j, int k)
      {
        const bool channel = i >= 12 && i <= 26 && j >= 3 && j <= 11 && k >= 3 && k <= 11;
        if (i >= 17 && i <= 21 && j >= 5 && j <= 8 && k >= 5 && k <= 8)
        {
          ASSERT_EQ(picture(i, j, k), (Vector3{ -15, 0, 0 })) << i << ' ' << j << ' ' << k;
        }
        else if (i >= 16 && i <= 22 && j >= 4 && j <= 9 && k >= 4 && k <= 9)
        {
          ASSERT_EQ(picture(i, j, k), (Vector3{ -15, 0, 0 })) << "the border of the body comes along";
        }
        else if (channel)
        {
          ASSERT_TRUE(picture.vacated(i, j, k)) << i << ' ' << j << ' ' << k;
        }
        else if (i >= 12 && i <= 26)
        {
          ASSERT_EQ(picture(i, j, k), (Vector3{ 0, 0, 0 })) << i << ' ' << j << ' ' << k;
        }
      });
  }
}

// Deformed, carved and deformed further: every voxel shows remaining tissue, and every remaining element is shown.
TEST(Resample, NothingCarvedIsShownAndNothingElseIsLost)
{
  Scene scene({ 26, 22, 20 }, 0.3f);
  scene.anchors.faces.fill(true);
  std::vector<float> first;
  for (const Index3& brick : brickSizes())
  {
    Simulation simulation = simulate(scene, brick);
    const Probe probe = probeAt(scene, { 13, 11, 5 }, { 1.4, -1.2, 1.0 });
    simulation.pull({ probe });
    ASSERT_GT(simulation.carve(sphere({ 13.2, 11.1, 12.3 }, 4.3, 12, 16)), 250u);
    simulation.pull({ probeAt(scene, { 13, 11, 5 }, { 1.4, -1.2, 2.2 }) });
    simulation.relax(30, 0.0);
    std::vector<std::uint8_t> left(scene.grid.voxels());
    simulation.elements(left.data());
    const std::vector<oracle::Vector3> u = state(simulation);
    const Picture picture = resample(simulation);
    std::size_t shown = 0;
    picture.each(
      [&](int i, int j, int k)
      {
        if (!picture.vacated(i, j, k))
        {
          const Vector3 o = picture(i, j, k);
          Index3 nearest;
          const int y[3] = { i, j, k };
          bool tie = false;
          for (int a = 0; a < 3; ++a)
          {
            const double x = y[a] + o[a];
            nearest[a] = static_cast<int>(std::lround(x));
            tie = tie || std::abs(std::abs(x - nearest[a]) - 0.5) < 1e-3;
          }
          shown += left[scene.grid.at(nearest[0], nearest[1], nearest[2])];
          ASSERT_TRUE(left[scene.grid.at(nearest[0], nearest[1], nearest[2])] || tie) << i << ' ' << j << ' ' << k;
        }
      });
    // The voxel nearest to the current place of a remaining element shows a place within half a cell of the element, or
    // of one of its neighbours.
    int lost = 0;
    scene.each(
      [&](int i, int j, int k)
      {
        const std::size_t v = scene.grid.at(i, j, k);
        if (left[v])
        {
          const int x = static_cast<int>(std::lround(i + u[v][0])), y = static_cast<int>(std::lround(j + u[v][1])),
                    z = static_cast<int>(std::lround(k + u[v][2]));
          const double away =
            std::max({ std::abs(i + u[v][0] - x), std::abs(j + u[v][1] - y), std::abs(k + u[v][2] - z) });
          lost += away < 0.2 && picture.vacated(x, y, z);
        }
      });
    EXPECT_EQ(lost, 0);
    EXPECT_GT(shown, scene.grid.voxels() - 450u);
    first = first.empty() ? picture.offset : first;
    for (std::size_t n = 0; n < first.size(); ++n)
    {
      ASSERT_TRUE(first[n] == picture.offset[n] || (std::isnan(first[n]) && std::isnan(picture.offset[n])));
    }
  }
}

TEST(Resample, CarvedSingleSlice)
{
  for (int axis = 0; axis < 3; ++axis)
  {
    SCOPED_TRACE(axis);
    Index3 size{ 16, 16, 16 };
    size[axis] = 1;
    Scene scene(size, 0.0f);
    Simulation simulation = simulate(scene, { 4, 4, 4 });
    Vector3 low{ 5.5, 5.5, 5.5 }, high{ 9.5, 9.5, 9.5 };
    low[axis] = -0.5;
    high[axis] = 0.5;
    ASSERT_EQ(simulation.carve(box(low, high)), 16u);
    Index3 grabbed{ 2, 2, 2 }, shift{ 1, 2, 3 };
    grabbed[axis] = shift[axis] = 0;
    for (const bool moved : { false, true })
    {
      if (moved)
      {
        simulation.pull({ probeAt(scene, grabbed, { 1.0 * shift[0], 1.0 * shift[1], 1.0 * shift[2] }) });
      }
      const Picture picture = resample(simulation);
      picture.each(
        [&](int i, int j, int k)
        {
          const int p[3] = { i, j, k };
          bool hole = true, inside = true;
          Vector3 back{};
          for (int a = 0; a < 3; ++a)
          {
            const int x = p[a] - (moved ? shift[a] : 0);
            back[a] = moved ? -1.0 * shift[a] : 0.0;
            hole = hole && (a == axis || (x >= 6 && x <= 9));
            inside = inside && x >= 0;
          }
          if (hole || !inside)
          {
            ASSERT_TRUE(picture.vacated(i, j, k)) << i << ' ' << j << ' ' << k;
          }
          else
          {
            ASSERT_EQ(picture(i, j, k), back) << i << ' ' << j << ' ' << k;
          }
        });
    }
  }
}

}
