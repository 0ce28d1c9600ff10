#include "Constraints.h"
#include "Error.h"
#include "Random.h"
#include "Scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace
{

using namespace chainmail;

/// One row of voxels.
Grid rowOf(int n)
{
  Grid grid;
  grid.size = { n, 1, 1 };
  return grid;
}

Anchors noAnchors()
{
  Anchors anchors;
  anchors.faces.fill(false);
  return anchors;
}

template <typename T>
ArrayView view(const std::vector<T>& data, ArrayView::Type type, int components = 1, int component = 0)
{
  ArrayView v;
  v.data = data.data();
  v.type = type;
  v.components = components;
  v.component = component;
  return v;
}

Material percent(double threshold)
{
  Material material;
  material.tissueThreshold = threshold;
  material.constraint = [](double scalar) { return scalar / 100.0; };
  return material;
}

std::vector<float> rowOf(const Model& model, int j = 0, int k = 0)
{
  std::vector<float> row(static_cast<std::size_t>(model.grid().size[0]) * model.axes());
  model.row(0, j, k, model.grid().size[0], row.data());
  return row;
}

const float air = -std::numeric_limits<float>::infinity();

template <typename T> void readsType(ArrayView::Type type)
{
  // Two components, of which the second one is the scalar. 19 is the highest air, 20 the lowest tissue.
  const std::vector<T> data{ T(99), T(20), T(99), T(0), T(99), T(50), T(99), T(19), T(99), T(73) };
  const Model model(rowOf(5), view(data, type, 2, 1), percent(20.0), noAnchors());
  EXPECT_EQ(model.axes(), 1);
  EXPECT_EQ(model.elements(), 3u);
  EXPECT_EQ(model.nonFinite(), 0u);
  EXPECT_EQ(rowOf(model), (std::vector<float>{ 0.2f, air, 0.5f, air, 0.73f }));
}

TEST(Model, ReadsEveryScalarType)
{
  readsType<std::int8_t>(ArrayView::Type::Int8);
  readsType<std::uint8_t>(ArrayView::Type::UInt8);
  readsType<std::int16_t>(ArrayView::Type::Int16);
  readsType<std::uint16_t>(ArrayView::Type::UInt16);
  readsType<std::int32_t>(ArrayView::Type::Int32);
  readsType<std::uint32_t>(ArrayView::Type::UInt32);
  readsType<std::int64_t>(ArrayView::Type::Int64);
  readsType<std::uint64_t>(ArrayView::Type::UInt64);
  readsType<float>(ArrayView::Type::Float32);
  readsType<double>(ArrayView::Type::Float64);
}

TEST(Model, NegativeScalarsOfSmallTypes)
{
  const std::vector<std::int16_t> hounsfield{ -1024, -500, -499, 0, 3071, -32768, 32767 };
  Material material;
  material.tissueThreshold = -499.5;
  material.constraint = [](double scalar) { return scalar < 0 ? 0.5 : scalar > 3000 ? 0.0 : 0.25; };
  const Model model(rowOf(7), view(hounsfield, ArrayView::Type::Int16), material, noAnchors());
  EXPECT_EQ(rowOf(model), (std::vector<float>{ air, air, 0.5f, 0.25f, 0.0f, air, 0.0f }));
}

TEST(Model, ScalarsFromTheCeilingOnAreAir)
{
  const std::vector<std::uint16_t> data{ 10, 20, 99, 65534, 65535 };
  for (const bool byArray : { false, true })
  {
    const std::vector<float> fractions(5, 0.25f);
    Material material = percent(20.0);
    material.constraint = [](double) { return 0.25; };
    material.constraintArray = byArray ? view(fractions, ArrayView::Type::Float32) : ArrayView();
    material.tissueCeiling = 65534.0;
    const Model model(rowOf(5), view(data, ArrayView::Type::UInt16), material, noAnchors());
    EXPECT_EQ(rowOf(model), (std::vector<float>{ air, 0.25f, 0.25f, air, air }));
  }
}

TEST(Model, ScalarsThatAreNotFiniteAreAirAndCounted)
{
  const float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<float> data{ 30.0f, nan, inf, -inf, 40.0f };
  const Model model(rowOf(5), view(data, ArrayView::Type::Float32), percent(0.0), noAnchors());
  EXPECT_EQ(model.elements(), 2u);
  EXPECT_EQ(model.nonFinite(), 3u);
  EXPECT_EQ(rowOf(model), (std::vector<float>{ 0.3f, air, air, air, 0.4f }));
}

TEST(Model, ConstraintArrayWinsOverTheFunction)
{
  const std::vector<std::uint8_t> scalars{ 50, 0, 60 };
  const std::vector<double> one{ 0.125, 7.0, 0.0 }; // bad values in air do not matter
  Material material = percent(10.0);
  material.constraintArray = view(one, ArrayView::Type::Float64);
  const Model isotropic(rowOf(3), view(scalars, ArrayView::Type::UInt8), material, noAnchors());
  EXPECT_EQ(rowOf(isotropic), (std::vector<float>{ 0.125f, air, 0.0f }));

  const std::vector<float> three{ 0.1f, 0.2f, 0.3f, 9.0f, 9.0f, 9.0f, 0.0f, 0.5f, 0.25f };
  material.constraintArray = view(three, ArrayView::Type::Float32, 3);
  const Model anisotropic(rowOf(3), view(scalars, ArrayView::Type::UInt8), material, noAnchors());
  EXPECT_EQ(anisotropic.axes(), 3);
  EXPECT_EQ(anisotropic.elements(), 2u);
  EXPECT_EQ(rowOf(anisotropic), (std::vector<float>{ 0.1f, 0.2f, 0.3f, air, air, air, 0.0f, 0.5f, 0.25f }));
}

TEST(Model, RegionsHaveConstraintsOfTheirOwn)
{
  Grid grid;
  grid.size = { 6, 3, 2 };
  grid.spacing = { 1.0, 2.0, 4.0 };
  std::vector<std::uint8_t> scalars(grid.voxels(), 30);
  scalars[grid.at(3, 1, 0)] = 0; // air remains air
  Material material = percent(10.0);
  material.regions = { { { 2.0, 2.0, 0.0 }, 2.0, 0.5 }, { { 0.0, 2.0, 0.0 }, 0.5, 0.0 } };
  const Model model(grid, view(scalars, ArrayView::Type::UInt8), material, noAnchors());
  EXPECT_EQ(rowOf(model, 1, 0), (std::vector<float>{ 0.0f, 0.5f, 0.5f, air, 0.5f, 0.3f }));
  EXPECT_EQ(
    rowOf(model, 0, 0), (std::vector<float>{ 0.3f, 0.3f, 0.5f, 0.3f, 0.3f, 0.3f })); // at the radius of the probe
  EXPECT_EQ(rowOf(model, 1, 1), std::vector<float>(6, 0.3f));
  float part[2];
  model.row(4, 1, 0, 2, part);
  EXPECT_EQ(part[0], 0.5f);
  EXPECT_EQ(part[1], 0.3f);
  const auto refused = [&](const Region& region)
  {
    material.regions = { region };
    return messageOf<InputError>([&] { Model(grid, view(scalars, ArrayView::Type::UInt8), material, noAnchors()); });
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(contains(refused({ { nan, 0.0, 0.0 }, 1.0, 0.5 }), "region"));
  EXPECT_TRUE(contains(refused({ {}, -1.0, 0.5 }), "region"));
  EXPECT_TRUE(contains(refused({ {}, 1.0, 1.0 }), "of a region"));
}

TEST(Model, PartsOfARow)
{
  std::vector<std::uint8_t> scalars(4 * 3 * 2);
  for (std::size_t n = 0; n < scalars.size(); ++n)
  {
    scalars[n] = static_cast<std::uint8_t>(n);
  }
  Grid grid;
  grid.size = { 4, 3, 2 };
  const Model model(grid, view(scalars, ArrayView::Type::UInt8), percent(0.0), noAnchors());
  float two[2];
  model.row(1, 2, 1, 2, two);
  EXPECT_EQ(two[0], 0.21f);
  EXPECT_EQ(two[1], 0.22f);
}

TEST(Model, AnchoredFacesCarryTheSign)
{
  const int n[3] = { 5, 4, 3 };
  std::vector<std::uint8_t> scalars(5 * 4 * 3, 25);
  scalars[0] = 0; // air in an anchored corner remains air
  Grid grid;
  grid.size = { n[0], n[1], n[2] };
  Material material = percent(10.0);
  for (int face = 0; face < 6; ++face)
  {
    Anchors anchors = noAnchors();
    anchors.faces[face] = true;
    const Model model(grid, view(scalars, ArrayView::Type::UInt8), material, anchors);
    for (int k = 0; k < n[2]; ++k)
    {
      for (int j = 0; j < n[1]; ++j)
      {
        const std::vector<float> row = rowOf(model, j, k);
        for (int i = 0; i < n[0]; ++i)
        {
          const int p[3] = { i, j, k };
          const bool held = p[face / 2] == (face % 2 == 0 ? 0 : n[face / 2] - 1);
          const float expected = i + j + k == 0 ? air : held ? -0.25f : 0.25f;
          EXPECT_EQ(row[i], expected) << face << ": " << i << ' ' << j << ' ' << k;
        }
      }
    }
  }
}

TEST(Model, RigidAnchorsAreNegativeZero)
{
  const std::vector<std::uint8_t> scalars{ 0, 30, 0 };
  Anchors anchors = noAnchors();
  Material material = percent(0.0);
  for (const bool held : { false, true })
  {
    anchors.rigid = held;
    const std::vector<float> row = rowOf(Model(rowOf(3), view(scalars, ArrayView::Type::UInt8), material, anchors));
    EXPECT_EQ(row, (std::vector<float>{ 0.0f, 0.3f, 0.0f }));
    EXPECT_EQ(std::signbit(row[0]), held);
    EXPECT_FALSE(std::signbit(row[1]));
    EXPECT_EQ(std::signbit(row[2]), held);
  }
}

TEST(Model, RigidOnOneAxisIsRigidEnoughForAnAnchor)
{
  const std::vector<std::uint8_t> scalars{ 1, 1 };
  const std::vector<float> three{ 0.1f, 0.0f, 0.3f, 0.1f, 0.2f, 0.3f };
  Anchors anchors = noAnchors();
  anchors.rigid = true;
  Material material = percent(0.5);
  material.constraintArray = view(three, ArrayView::Type::Float32, 3);
  const std::vector<float> row = rowOf(Model(rowOf(2), view(scalars, ArrayView::Type::UInt8), material, anchors));
  EXPECT_TRUE(std::signbit(row[0]) && std::signbit(row[1]) && std::signbit(row[2]));
  EXPECT_FALSE(std::signbit(row[3]) || std::signbit(row[4]) || std::signbit(row[5]));
}

TEST(Model, RefusesWhatItCannotUse)
{
  const std::vector<std::uint8_t> scalars{ 10, 20, 30 };
  const ArrayView good = view(scalars, ArrayView::Type::UInt8);
  const auto message = [&](const Grid& grid, const ArrayView& array, const Material& material)
  { return messageOf<InputError>([&] { Model(grid, array, material, noAnchors()); }); };

  EXPECT_TRUE(contains(message(rowOf(0), good, percent(0)), "empty"));
  for (const double spacing : { 0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity() })
  {
    Grid grid = rowOf(3);
    grid.spacing[1] = spacing;
    EXPECT_TRUE(contains(message(grid, good, percent(0)), "spacing")) << spacing;
  }
  // One layer too many; and 2^64 voxels, which overflow to 0 in 64 bits.
  for (const Index3& size : { Index3{ 1 << 13, 1 << 13, (1 << 12) + 1 }, Index3{ 1 << 22, 1 << 22, 1 << 20 } })
  {
    Grid huge = rowOf(1);
    huge.size = size;
    EXPECT_FALSE(huge.fits());
    EXPECT_TRUE(contains(message(huge, good, percent(0)), "voxels"));
  }
  Grid largest = rowOf(1);
  largest.size = { 1 << 13, 1 << 13, 1 << 12 };
  EXPECT_TRUE(largest.fits());

  const std::string allAir = message(rowOf(3), good, percent(31.0));
  EXPECT_TRUE(contains(allAir, "air") && contains(allAir, "threshold")) << allAir;
  const std::vector<float> nan(3, std::nanf(""));
  EXPECT_TRUE(contains(message(rowOf(3), view(nan, ArrayView::Type::Float32), percent(0)), "air"));

  EXPECT_FALSE(message(rowOf(3), {}, percent(0)).empty());
  EXPECT_FALSE(message(rowOf(3), good, Material{}).empty());

  // 1 is outside of [0, 1), also after rounding to float.
  for (const double bad : { 1.0, 1.0 - 1e-12, -0.01, 5.0, std::nan("") })
  {
    Material material;
    material.constraint = [&](double scalar) { return scalar == 20.0 ? bad : 0.5; };
    const std::string text = message(rowOf(3), good, material);
    EXPECT_TRUE(contains(text, "constraint") && contains(text, "20")) << text;

    const std::vector<double> array{ 0.5, bad, 0.5 };
    material.constraintArray = view(array, ArrayView::Type::Float64);
    EXPECT_TRUE(contains(message(rowOf(3), good, material), "constraint array")) << bad;
  }
  const std::vector<float> two(6, 0.5f);
  Material material;
  material.constraintArray = view(two, ArrayView::Type::Float32, 2);
  EXPECT_TRUE(contains(message(rowOf(3), good, material), "2 components"));
}

TEST(Model, LargestConstraintBelowOneIsTaken)
{
  const std::vector<float> most{ std::nextafterf(1.0f, 0.0f) };
  const std::vector<std::uint8_t> scalars{ 1 };
  Material material = percent(0.0);
  material.constraintArray = view(most, ArrayView::Type::Float32);
  EXPECT_EQ(rowOf(Model(rowOf(1), view(scalars, ArrayView::Type::UInt8), material, noAnchors())), most);
}

// The sign of a constraint marks a held element (element.clh). So -0 as an input is 0.
TEST(Model, AConstraintOfMinusZeroHoldsNothing)
{
  const std::vector<double> scalars{ 50.0, 50.0, 50.0, 0.0 };
  const std::vector<float> fractions{ -0.0f, 0.5f, 0.0f, -0.0f };
  Material byFunction = percent(20.0);
  byFunction.constraint = [](double) { return -0.0; };
  Material byArray = percent(20.0);
  byArray.constraintArray = view(fractions, ArrayView::Type::Float32);
  Material byRegion = percent(20.0);
  byRegion.regions.push_back({ { { 1.0, 0.0, 0.0 } }, 0.5, -0.0 });
  for (const Material& material : { byFunction, byArray, byRegion })
  {
    const Model model(rowOf(4), view(scalars, ArrayView::Type::Float64), material, noAnchors());
    const std::vector<float> row = rowOf(model);
    for (int i = 0; i < 3; ++i)
    {
      EXPECT_FALSE(std::signbit(row[i])) << i;
    }
    EXPECT_EQ(row[3], air);
    EXPECT_GE(std::count(row.begin(), row.end(), 0.0f), 1);
  }
}

/// A view of an array that is read row by row. What was read before is overwritten by the next row.
template <typename T> ArrayView elsewhere(const std::vector<T>& values, ArrayView view)
{
  const auto row = std::make_shared<std::vector<T>>();
  view.data = nullptr;
  view.read = [&values, row, components = view.components](std::size_t first, int count)
  {
    std::fill(row->begin(), row->end(), T(77));
    row->assign(values.begin() + static_cast<std::ptrdiff_t>(components * first),
      values.begin() + static_cast<std::ptrdiff_t>(components * (first + count)));
    return row->data();
  };
  return view;
}

/// A scan of floats with air, padding and values that are not finite, and a material for it.
struct FloatScan
{
  Grid grid;
  std::vector<float> values;
  ArrayView scalars;
  Material material;

  explicit FloatScan(Random& random)
  {
    for (int& size : this->grid.size)
    {
      size = random.between(1, 9);
    }
    this->values.resize(this->grid.voxels());
    std::generate(this->values.begin(), this->values.end(),
      [&]
      {
        return random.oneIn(9) ? random.of({ std::nanf(""), std::numeric_limits<float>::infinity(), 3000.0f })
                               : static_cast<float>(random(-100.0, 100.0));
      });
    this->scalars.data = this->values.data();
    this->scalars.type = ArrayView::Type::Float32;
    this->material.tissueThreshold = 0.0;
    this->material.tissueCeiling = 3000.0;
    this->material.constraint = [](double value) { return value / 200.0; };
  }

  /// The boxes of some processes.
  std::vector<VoxelBox> parts(Random& random) const
  {
    std::vector<VoxelBox> parts{ VoxelBox::all(this->grid) };
    for (int n = random.below(5); n > 0; --n)
    {
      VoxelBox& part = parts[static_cast<std::size_t>(random.below(static_cast<int>(parts.size())))];
      const int axis = random.below(3);
      VoxelBox other = part;
      part.size[axis] = random.between(0, part.size[axis]);
      other.first[axis] += part.size[axis];
      other.size[axis] -= part.size[axis];
      parts.push_back(other);
    }
    return parts;
  }

  TissueCounts count(Random& random) const
  {
    const Constraints constraints(this->grid, this->scalars, this->material);
    TissueCounts all;
    for (const VoxelBox& part : this->parts(random))
    {
      all.add(constraints.count(part));
    }
    return all;
  }
};

// What is counted in parts and added is what one pass over all counts, and the first voxel that is wrong is the same.
TEST(Model, CountsOfPartsAddUp)
{
  Random random(8);
  for (int trial = 0; trial < 200; ++trial)
  {
    FloatScan scan(random);
    const auto isTissue = [](float value) { return value >= 0.0f && value < 3000.0f; };
    const TissueCounts found = scan.count(random);
    EXPECT_EQ(found.badVoxel, TissueCounts::none);
    EXPECT_EQ(
      found.elements, static_cast<std::size_t>(std::count_if(scan.values.begin(), scan.values.end(), isTissue)));
    EXPECT_EQ(found.nonFinite, static_cast<std::size_t>(std::count_if(scan.values.begin(), scan.values.end(),
                                 [](float value) { return !std::isfinite(value); })));

    const double limit = random(0.0, 100.0);
    scan.material.constraint = [limit](double value) { return value > limit ? 1.0 + value : 0.5; };
    const auto bad = std::find_if(
      scan.values.begin(), scan.values.end(), [&](float value) { return isTissue(value) && value > limit; });
    const TissueCounts failed = scan.count(random);
    EXPECT_EQ(failed.badVoxel,
      bad == scan.values.end() ? TissueCounts::none : static_cast<std::size_t>(bad - scan.values.begin()));
    std::string serial;
    try
    {
      const Model model(scan.grid, scan.scalars, scan.material, Anchors());
    }
    catch (const InputError& error)
    {
      serial = error.what();
    }
    EXPECT_TRUE(failed.problem == serial || (failed.problem.empty() && serial.find("all air") != std::string::npos));
  }
}

// Where tissue is counted elsewhere, no row is read.
TEST(Model, TissueMayBeCountedElsewhere)
{
  Random random(9);
  FloatScan scan(random);
  bool isRead = false;
  ArrayView elsewhere = scan.scalars;
  elsewhere.data = nullptr;
  elsewhere.read = [&](std::size_t, int) -> const void*
  {
    isRead = true;
    return nullptr;
  };
  Material material = scan.material;
  material.count = []
  {
    TissueCounts counts;
    counts.elements = 7;
    counts.nonFinite = 2;
    return counts;
  };
  const Model model(scan.grid, elsewhere, material, Anchors());
  EXPECT_EQ(model.elements(), 7u);
  EXPECT_EQ(model.nonFinite(), 2u);
  material.count = [] { return TissueCounts(); };
  EXPECT_THROW(Model(scan.grid, elsewhere, material, Anchors()), InputError) << "all is air";
  material.count = []
  {
    TissueCounts counts;
    counts.elements = 7;
    counts.badVoxel = 3;
    counts.problem = "what is wrong";
    return counts;
  };
  EXPECT_THROW(Model(scan.grid, elsewhere, material, Anchors()), InputError);
  EXPECT_FALSE(isRead);
}

TEST(Model, ArraysMayBeElsewhere)
{
  const Scene scene = randomScene({ 13, 9, 7 }, 3, 4, 0.3);
  std::vector<float> scalars = scene.scalar;
  scalars[40] = scalars[41] = std::numeric_limits<float>::quiet_NaN();
  ArrayView scalar;
  scalar.data = scalars.data();
  scalar.type = ArrayView::Type::Float32;
  Material material;
  material.tissueThreshold = 0.5;
  material.constraintArray.data = scene.constraint.data();
  material.constraintArray.type = ArrayView::Type::Float32;
  material.constraintArray.components = 3;
  Material byFunction = material;
  byFunction.constraintArray = ArrayView();
  byFunction.constraint = [](double value) { return 0.3 * value; };
  for (const Material& here : { material, byFunction })
  {
    Material there = here;
    if (here.constraintArray)
    {
      there.constraintArray = elsewhere(scene.constraint, here.constraintArray);
    }
    const Model known(scene.grid, scalar, here, Anchors());
    const Model read(scene.grid, elsewhere(scalars, scalar), there, Anchors());
    EXPECT_EQ(known.elements(), read.elements());
    EXPECT_EQ(known.nonFinite(), 2u);
    EXPECT_EQ(read.nonFinite(), 2u);
    ASSERT_EQ(known.axes(), read.axes());
    std::vector<float> a(static_cast<std::size_t>(5 * known.axes())), b(a.size());
    for (int k = 0; k < 7; ++k)
    {
      for (int j = 0; j < 9; ++j)
      {
        known.row(4, j, k, 5, a.data());
        read.row(4, j, k, 5, b.data());
        EXPECT_TRUE(sameBits(a, b)) << j << " " << k;
      }
    }
  }
}

}
