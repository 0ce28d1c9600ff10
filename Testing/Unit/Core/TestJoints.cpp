// Bodies of rigid tissue and the joints between them: by labels, by thickness, and under a pull.

#include "Scene.h"

#include "Error.h"
#include "Joints.h"

#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <set>
#include <string>

namespace
{

using namespace chainmail;

/// A scene whose rigid voxels have labels.
struct Labelled
{
  Scene scene;
  std::vector<std::int32_t> labels;
  Joints joints;

  explicit Labelled(const Index3& size, float everywhere = 0.3f)
    : scene(size, everywhere)
    , labels(scene.grid.voxels(), 0)
  {
  }

  void useLabels()
  {
    this->joints.labels.data = this->labels.data();
    this->joints.labels.type = ArrayView::Type::Int32;
  }

  /// A box of bone between two corners.
  void bone(const Index3& first, const Index3& last, std::int32_t label)
  {
    this->scene.each(
      [&](int i, int j, int k)
      {
        if (i >= first[0] && j >= first[1] && k >= first[2] && i <= last[0] && j <= last[1] && k <= last[2])
        {
          this->scene.give(i, j, k, 0.0f);
          this->labels[this->scene.grid.at(i, j, k)] = label;
        }
      });
  }

  std::shared_ptr<const Model> model() const
  {
    Material material;
    material.tissueThreshold = 0.5;
    material.constraintArray.data = this->scene.constraint.data();
    material.constraintArray.type = ArrayView::Type::Float32;
    material.constraintArray.components = this->scene.components;
    material.joints = this->joints;
    ArrayView scalars;
    scalars.data = this->scene.scalar.data();
    scalars.type = ArrayView::Type::Float32;
    return std::make_shared<Model>(this->scene.grid, scalars, material, this->scene.anchors);
  }

  Simulation simulate(int reduction = 1) const
  {
    Settings settings;
    settings.device = testDevice();
    settings.modelReduction = reduction;
    return Simulation(this->model(), settings);
  }
};

std::vector<float> constraints(const Model& model)
{
  std::vector<float> all(model.grid().voxels());
  for (int k = 0; k < model.grid().size[2]; ++k)
  {
    for (int j = 0; j < model.grid().size[1]; ++j)
    {
      model.row(0, j, k, model.grid().size[0], all.data() + model.grid().at(0, j, k));
    }
  }
  return all;
}

/// Five bones in a row, as in a finger with its metacarpal: the first one touches the face x-, and each touches the
/// next across a bridge of 3 x 3 voxels.
Labelled finger()
{
  Labelled hand({ 63, 17, 17 });
  hand.scene.anchors.faces[0] = true;
  for (int n = 0; n < 5; ++n)
  {
    hand.bone({ 12 * n, 4, 4 }, { 12 * n + 10, 12, 12 }, n + 1);
    if (n < 4)
    {
      hand.bone({ 12 * n + 11, 7, 7 }, { 12 * n + 11, 9, 9 }, n + 1);
    }
  }
  return hand;
}

/// The sizes of all bodies [voxels], ascending.
std::multiset<std::size_t> sizes(const Simulation& simulation)
{
  std::multiset<std::size_t> sizes;
  for (const RigidBody& body : simulation.bodies())
  {
    sizes.insert(body.elements);
  }
  return sizes;
}

/// Joints and bodies by their definition, voxel by voxel, without lists of pairs and without a union-find structure.
/// Tissue stiffer than joints belongs to the nearest body within three steps.
std::vector<int> bodiesByRule(const Labelled& tissue, std::vector<char>& joint)
{
  const Index3 size = tissue.scene.grid.size;
  const int count = size[0] * size[1] * size[2];
  const auto rigid = [&](int n) { return tissue.scene.scalar[n] != 0.0f && tissue.scene.constraint[n] == 0.0f; };
  std::map<int, int> voxelsOf;
  for (int n = 0; n < count; ++n)
  {
    voxelsOf[tissue.labels[n]] += rigid(n) ? 1 : 0;
  }
  const auto touch = [&](int n, int m)
  {
    const int dx = n % size[0] - m % size[0];
    const int dy = n / size[0] % size[1] - m / size[0] % size[1];
    const int dz = n / size[0] / size[1] - m / size[0] / size[1];
    return dx * dx + dy * dy + dz * dz == 1;
  };
  const auto isReplacedBy = [&](int one, int other)
  {
    if (one == 0 || other == 0)
    {
      return one == 0;
    }
    return voxelsOf[one] != voxelsOf[other] ? voxelsOf[one] > voxelsOf[other] : one > other;
  };
  constexpr int none = std::numeric_limits<int>::min();
  std::vector<int> owner(count, none);
  for (int n = 0; n < count; ++n)
  {
    owner[n] = rigid(n) ? tissue.labels[n] : none;
  }
  for (int step = 0; step < 3; ++step)
  {
    const std::vector<int> before = owner;
    for (int n = 0; n < count; ++n)
    {
      const int label = tissue.labels[n];
      const bool isBodys = label != 0 && voxelsOf[label] > 0;
      for (int m = 0; m < count; ++m)
      {
        if (before[n] == none && before[m] != none && touch(n, m) && tissue.scene.scalar[n] != 0.0f &&
            tissue.scene.constraint[n] < static_cast<float>(tissue.joints.constraint) &&
            (!isBodys || label == before[m]))
        {
          // Voxels without a label first, then lower labels before higher ones.
          const bool isBetter = owner[n] == none || (owner[n] != 0 && (before[m] == 0 || before[m] < owner[n]));
          owner[n] = isBetter ? before[m] : owner[n];
        }
      }
    }
  }
  joint.assign(count, 0);
  for (int n = 0; n < count; ++n)
  {
    for (int m = 0; m < count; ++m)
    {
      if (owner[n] != none && owner[m] != none && touch(n, m) && owner[n] != owner[m] &&
          (rigid(n) == rigid(m) ? isReplacedBy(owner[n], owner[m]) : !rigid(n)))
      {
        joint[n] = 1;
      }
    }
  }
  // Every voxel takes the lowest number among its neighbours, until nothing changes.
  std::vector<int> body(count, -1);
  for (int n = 0; n < count; ++n)
  {
    body[n] = rigid(n) && !joint[n] ? n : -1;
  }
  for (bool changed = true; changed;)
  {
    changed = false;
    for (int n = 0; n < count; ++n)
    {
      for (int m = 0; m < count; ++m)
      {
        if (body[n] >= 0 && body[m] >= 0 && body[m] < body[n] && touch(n, m))
        {
          body[n] = body[m];
          changed = true;
        }
      }
    }
  }
  return body;
}

TEST(Joints, LabelsDivideBodiesAsTheRuleSays)
{
  for (int seed = 0; seed < 12; ++seed)
  {
    Random random(700 + seed);
    Labelled tissue({ 9, 7, 6 });
    tissue.scene = randomScene(tissue.scene.grid.size, 1, 710 + seed, 0.1, 0.35 + 0.05 * (seed % 6));
    for (std::int32_t& label : tissue.labels)
    {
      label = seed % 3 == 0 ? random.below(3) - 1 : random.below(2 + seed) * 1000;
    }
    tissue.useLabels();
    tissue.joints.constraint = 0.375;
    std::vector<char> joint;
    const std::vector<int> expected = bodiesByRule(tissue, joint);

    const Simulation simulation = tissue.simulate();
    const std::vector<float> c = constraints(simulation.model());
    const std::vector<float> before = constraints(*tissue.scene.model());
    const std::vector<int> found = clusters(simulation);
    std::map<int, int> names;
    for (std::size_t n = 0; n < expected.size(); ++n)
    {
      EXPECT_EQ(c[n], joint[n] ? std::max(0.375f, before[n]) : before[n]) << "seed " << seed << ", voxel " << n;
      EXPECT_EQ(simulation.model().isJoint(n), joint[n] != 0);
      ASSERT_EQ(found[n] >= 0, expected[n] >= 0) << "seed " << seed << ", voxel " << n;
      if (found[n] >= 0)
      {
        EXPECT_EQ(names.emplace(found[n], expected[n]).first->second, expected[n]);
      }
    }
    const std::set<int> bodies(expected.begin(), expected.end());
    EXPECT_EQ(simulation.bodies().size(), bodies.size() - bodies.count(-1));
    EXPECT_EQ(names.size(), bodies.size() - bodies.count(-1));
  }
}

TEST(Joints, FiveBonesInARowAreOneBodyAndWithLabelsFive)
{
  Labelled hand = finger();
  const Probe pull = probeAt(hand.scene, { 58, 8, 8 }, { 0.0, 0.0, 1.0 });
  {
    Simulation one = hand.simulate();
    EXPECT_EQ(one.bodies().size(), 1u);
    EXPECT_EQ(one.bodies()[0].limiter.what, Limiter::What::Face);
    EXPECT_EQ(one.bodies()[0].limiter.face, 0);
    EXPECT_EQ(one.pull({ pull })[0].reached[2], 0.0);
  }
  hand.useLabels();
  Simulation five = hand.simulate();
  const std::vector<RigidBody> bodies = five.bodies();
  ASSERT_EQ(bodies.size(), 5u);
  for (std::size_t n = 0; n < 5; ++n)
  {
    EXPECT_EQ(bodies[n].limiter.what, n == 0 ? Limiter::What::Face : Limiter::What::Nothing);
  }
  EXPECT_NEAR(five.pull({ pull })[0].reached[2], 1.0, 1e-6);
  EXPECT_EQ(five.bodies()[4].limiter.what, Limiter::What::Probe);
  EXPECT_EQ(five.bodies()[4].limiter.probe, 0u);
  five.relax(200, 1e-5);
  EXPECT_LE(five.measure().maxLinkExcess, 1e-5);
  // Every bone moves as one, and less than the bone before it.
  const std::vector<int> numbers = clusters(five);
  const std::vector<float> u = displacements(five);
  std::array<std::set<float>, 5> places;
  for (std::size_t n = 0; n < numbers.size(); ++n)
  {
    if (numbers[n] >= 0)
    {
      places[numbers[n]].insert(u[3 * n + 2]);
    }
  }
  for (std::size_t n = 0; n < 5; ++n)
  {
    EXPECT_EQ(places[n].size(), 1u);
    EXPECT_GT(*places[n].begin(), n == 0 ? -1e-6f : *places[n - 1].begin());
  }
  EXPECT_EQ(*places[0].begin(), 0.0f);
}

TEST(Joints, ThinBridgesAreJoints)
{
  // The bridges are 3 voxels wide, the bones 9. A larger size divides no less, however thick the bones are.
  Labelled hand = finger();
  for (int size = 0; size <= 12; ++size)
  {
    hand.joints.size = size;
    EXPECT_EQ(hand.simulate().bodies().size(), size >= 4 ? 5u : 1u) << "joints of " << size << " voxels";
  }
  // Bones keep their voxels, except where a bridge begins.
  hand.joints.size = 4;
  const Simulation simulation = hand.simulate();
  std::size_t rigid = 0;
  for (const std::size_t one : sizes(simulation))
  {
    rigid += one;
  }
  EXPECT_EQ(rigid, 5u * 11u * 9u * 9u);
}

TEST(Joints, MarrowCountsAsBone)
{
  // A tube of bone that a face of the image cuts open, with walls of one voxel, and a ball of bone that touches it.
  for (int axis = 0; axis < 3; ++axis)
  {
    Labelled tissue({ 30, 30, 30 });
    const auto box = [&](int from, int to, int reach, float value)
    {
      tissue.scene.each(
        [&](int i, int j, int k)
        {
          const Index3 p{ i, j, k };
          if (p[axis] >= from && p[axis] <= to && std::abs(p[(axis + 1) % 3] - 14) <= reach &&
              std::abs(p[(axis + 2) % 3] - 14) <= reach)
          {
            tissue.scene.give(i, j, k, value);
          }
        });
    };
    box(0, 14, 4, 0.0f);
    box(0, 13, 3, 0.2f);
    box(15, 15, 1, 0.0f);
    box(16, 24, 4, 0.0f);
    tissue.scene.anchors.faces[2 * axis] = true;
    EXPECT_EQ(tissue.simulate().bodies().size(), 1u);
    tissue.joints.size = 4;
    const Simulation simulation = tissue.simulate();
    ASSERT_EQ(simulation.bodies().size(), 2u);
    std::set<int> held;
    for (const RigidBody& body : simulation.bodies())
    {
      held.insert(static_cast<int>(body.limiter.what));
    }
    EXPECT_EQ(held.size(), 2u); // the tube by the face, the ball by nothing
  }
}

TEST(Joints, BoneWithoutALabelIsABodyOfItsOwnOrPartOfTheNearest)
{
  // A labelled bone with a rim that has no label, and a bone without a label that touches the rim.
  Labelled tissue({ 40, 20, 20 });
  tissue.bone({ 4, 4, 4 }, { 16, 15, 15 }, 0);
  tissue.bone({ 5, 5, 5 }, { 15, 14, 14 }, 7);
  tissue.bone({ 17, 5, 5 }, { 30, 14, 14 }, 0);
  tissue.useLabels();
  // The labelled bone is unchanged. So is the other one. Of the rim, which becomes a joint, the edges remain.
  EXPECT_EQ(sizes(tissue.simulate()), (std::multiset<std::size_t>{ 12u * 12u * 13u - 1100u - 640u, 1100u, 1400u }));
  // The rim is thinner than three voxels, except where the other bone covers it: these 100 voxels belong to that bone.
  // Around them a layer becomes a joint: 100 voxels below, and 40 of the rim beside them.
  tissue.joints.size = 3;
  EXPECT_EQ(
    sizes(tissue.simulate()), (std::multiset<std::size_t>{ 1400u + 100u, 12u * 12u * 13u - 100u - 100u - 40u }));
}

TEST(Joints, EveryTypeOfLabelWillDo)
{
  Labelled tissue({ 8, 4, 4 });
  tissue.bone({ 0, 0, 0 }, { 3, 3, 3 }, 3);
  tissue.bone({ 4, 0, 0 }, { 7, 3, 3 }, 5);
  const auto count = [&](const auto& labels, ArrayView::Type type)
  {
    tissue.joints.labels.data = labels.data();
    tissue.joints.labels.type = type;
    return tissue.simulate().bodies().size();
  };
  const auto converted = [&](auto like)
  { return std::vector<decltype(like)>(tissue.labels.begin(), tissue.labels.end()); };
  using Type = ArrayView::Type;
  EXPECT_EQ(count(converted(std::int8_t()), Type::Int8), 2u);
  EXPECT_EQ(count(converted(std::uint8_t()), Type::UInt8), 2u);
  EXPECT_EQ(count(converted(std::int16_t()), Type::Int16), 2u);
  EXPECT_EQ(count(converted(std::uint16_t()), Type::UInt16), 2u);
  EXPECT_EQ(count(converted(std::uint32_t()), Type::UInt32), 2u);
  EXPECT_EQ(count(converted(std::uint64_t()), Type::UInt64), 2u);
  EXPECT_EQ(count(converted(float()), Type::Float32), 2u);
  std::vector<std::int64_t> huge = converted(std::int64_t());
  for (std::int64_t& label : huge)
  {
    label += std::int64_t(1) << 60; // a double cannot distinguish such labels
  }
  EXPECT_EQ(count(huge, Type::Int64), 2u);
  std::vector<double> doubles = converted(double());
  for (std::size_t n = 0; n < doubles.size(); ++n)
  {
    doubles[n] = n % 8 < 4 ? std::numeric_limits<double>::quiet_NaN() : doubles[n];
  }
  EXPECT_EQ(count(doubles, Type::Float64), 2u); // NaN is no label
  doubles[13] = 0.5;
  EXPECT_TRUE(contains(messageOf<InputError>([&] { count(doubles, Type::Float64); }), "whole numbers"));
  doubles[13] = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(contains(messageOf<InputError>([&] { count(doubles, Type::Float64); }), "whole numbers"));
}

TEST(Joints, WhatCannotBeUsedIsRefused)
{
  Labelled tissue({ 8, 4, 4 });
  tissue.bone({ 0, 0, 0 }, { 7, 3, 3 }, 1);
  tissue.useLabels();
  tissue.joints.labels.components = 3;
  EXPECT_TRUE(contains(messageOf<InputError>([&] { tissue.model(); }), "3 components"));
  tissue.joints.labels.components = 1;
  tissue.joints.size = -1;
  EXPECT_TRUE(contains(messageOf<InputError>([&] { tissue.model(); }), "-1"));
  tissue.joints.size = 0;
  for (const double constraint : { -0.1, 1.1, std::numeric_limits<double>::quiet_NaN() })
  {
    tissue.joints.constraint = constraint;
    EXPECT_TRUE(contains(messageOf<InputError>([&] { tissue.model(); }), "of the joints"));
  }
  tissue.joints.constraint = 0.5;
  EXPECT_TRUE(contains(messageOf<InputError>([&] { tissue.simulate(2); }), "ModelReduction"));
  // Without joints nothing changes.
  tissue.joints.constraint = 0.0;
  EXPECT_EQ(tissue.simulate(2).bodies().size(), 1u);
}

TEST(Joints, NothingChangesWithoutThem)
{
  Labelled hand = finger();
  EXPECT_FALSE(hand.model()->isDivided());
  EXPECT_TRUE(hand.model()->joints().empty());
  hand.useLabels();
  hand.joints.constraint = 0.0;
  EXPECT_FALSE(hand.model()->isDivided());
  EXPECT_EQ(constraints(*hand.model()), constraints(*hand.scene.model()));
  // Where no bodies touch there are no joints, and the bits are the same.
  hand.labels.assign(hand.labels.size(), 4);
  hand.joints.constraint = 0.5;
  EXPECT_TRUE(hand.model()->isDivided());
  EXPECT_EQ(constraints(*hand.model()), constraints(*hand.scene.model()));
}

TEST(Joints, CutsAndCarvesDivideBodiesFurther)
{
  Labelled hand = finger();
  hand.useLabels();
  Simulation simulation = hand.simulate();
  Surface blade; // through the second bone
  blade.points = { { 17.5, -5.0, -5.0 }, { 17.5, 40.0, -5.0 }, { 17.5, -5.0, 40.0 } };
  blade.triangles = { { { 0, 1, 2 } } };
  EXPECT_GT(simulation.cut(blade), 0u);
  EXPECT_EQ(simulation.bodies().size(), 6u);
  simulation.restoreTopology();
  EXPECT_EQ(simulation.bodies().size(), 5u);
  // The first bone is anchored as rigid tissue, too.
  hand.scene.anchors.rigid = true;
  hand.scene.anchors.faces[0] = false;
  EXPECT_EQ(hand.simulate().bodies()[0].limiter.what, Limiter::What::Rigid);
}

TEST(Joints, BodiesOfTissueThatDiffersByAxis)
{
  Labelled tissue({ 12, 5, 5 });
  tissue.scene = Scene(tissue.scene.grid.size, 0.2f, 3);
  tissue.bone({ 1, 1, 1 }, { 5, 3, 3 }, 1);
  tissue.bone({ 6, 1, 1 }, { 10, 3, 3 }, 2);
  tissue.useLabels();
  tissue.joints.constraint = 0.25;
  const Simulation simulation = tissue.simulate();
  EXPECT_EQ(simulation.bodies().size(), 2u);
  float c[3];
  simulation.model().row(
    6, 2, 2, 1, c); // of two bodies of the same size the one with the larger label becomes the joint
  EXPECT_EQ(c[0], 0.25f);
  EXPECT_EQ(c[2], 0.25f);
}

// Nodes of the watershed have 32-bit numbers. The error comes before bone takes more than one bit for each voxel.
TEST(Joints, AreNotLookedForAmongTooManyVoxelsOfBone)
{
  Joints joints;
  joints.size = 3;
  const auto read = [](std::size_t, int count, float* out) { std::fill_n(out, count, 0.0f); };
  try
  {
    findJoints({ { 2048, 2048, 512 }, { 1.0, 1.0, 1.0 } }, 1, read, joints);
    FAIL() << "no error";
  }
  catch (const InputError& error)
  {
    EXPECT_NE(std::string(error.what()).find("set JointSize to 0"), std::string::npos) << error.what();
  }
}

// Labels may be elsewhere, too. Each row is read in two passes at most.
TEST(Joints, LabelsMayBeElsewhere)
{
  Labelled hand = finger();
  hand.scene.give(17, 4, 4, 0.1f);
  hand.useLabels();
  for (const double constraint : { 0.5, 1.0 })
  {
    hand.joints.constraint = constraint;
    const std::shared_ptr<const Model> expected = hand.model();
    Labelled elsewhere = hand;
    std::vector<std::int32_t> row;
    std::map<std::size_t, int> reads;
    elsewhere.joints.labels.data = nullptr;
    elsewhere.joints.labels.read = [&](std::size_t first, int count) -> const void*
    {
      ++reads[first];
      row.assign(hand.labels.begin() + static_cast<std::ptrdiff_t>(first),
        hand.labels.begin() + static_cast<std::ptrdiff_t>(first) + count);
      return row.data();
    };
    const std::shared_ptr<const Model> model = elsewhere.model();
    EXPECT_EQ(model->joints(), expected->joints());
    EXPECT_EQ(model->linksOfJoints(), expected->linksOfJoints());
    EXPECT_GT(model->joints().size() + model->linksOfJoints().size(), 0u);
    for (const auto& [first, times] : reads)
    {
      EXPECT_EQ(first % static_cast<std::size_t>(hand.scene.grid.size[0]), 0u);
      EXPECT_LE(times, 2);
    }
  }
}

TEST(Joints, CoarserGridsTellBodiesApart)
{
  // Bones that touch on their whole faces.
  Labelled hand({ 63, 17, 17 });
  hand.scene.anchors.faces[0] = true;
  for (int n = 0; n < 5; ++n)
  {
    hand.bone({ 12 * n, 4, 4 }, { 12 * n + 11, 12, 12 }, n + 1);
  }
  hand.useLabels();
  const Probe pull = probeAt(hand.scene, { 58, 8, 8 }, { 0.0, 0.0, 1.5 });
  const auto energy = [&](bool coarse, int sweeps)
  {
    Simulation simulation = hand.simulate();
    simulation.setCoarseToFine(coarse);
    simulation.pull({ pull });
    simulation.relax(sweeps, 1e-6);
    EXPECT_LE(simulation.measure().maxLinkExcess, 1e-5);
    return simulation.measure().energy;
  };
  // measured: 0.28; with coarser grids that join the bones: 0.45
  EXPECT_LT(energy(true, 5), 0.35 * energy(false, 5));
  const double optimum = energy(false, 1000);
  EXPECT_NEAR(energy(true, 1000), optimum, 1e-5 * optimum);
}

// --- Free joints

/// Two bones 9 voxels wide, a voxel apart, in a sleeve of 5 voxels. The first one is anchored at the face x-.
Labelled knuckle()
{
  Labelled knuckle({ 36, 19, 19 }, 0.38f);
  knuckle.scene.anchors.faces[0] = true;
  knuckle.bone({ 0, 5, 5 }, { 16, 13, 13 }, 1);
  knuckle.bone({ 18, 5, 5 }, { 33, 13, 13 }, 2);
  knuckle.useLabels();
  return knuckle;
}

/// The rotation of the second bone, whose probe requests 30 degrees about the middle of the joint [degrees].
double bendOf(const Labelled& tissue)
{
  Settings settings;
  settings.device = testDevice();
  settings.rotations = true;
  Simulation simulation(tissue.model(), settings);
  Probe probe;
  probe.position = tissue.scene.place(26, 9, 9);
  probe.centre = tissue.scene.place(17, 9, 9);
  probe.rotates = true;
  probe.rotation = { 0.0, 0.0, 30.0 * 3.14159265358979323846 / 180.0 };
  const ProbeResult result = simulation.pull({ probe })[0];
  simulation.relax(20, 0.0);
  EXPECT_LE(simulation.measure().maxLinkExcess, 2e-5);
  return result.rotated[2] * 180.0 / 3.14159265358979323846;
}

// A free joint bends much further than a soft one, whose layer is limited by its constraint.
TEST(FreeJoints, BendFarther)
{
  Labelled tissue = knuckle();
  tissue.joints.constraint = 0.9;
  const double soft = bendOf(tissue);
  tissue.joints.constraint = 1.0;
  const double free = bendOf(tissue);
  EXPECT_LT(soft, 15.0);
  EXPECT_GT(free, 20.0);
  EXPECT_LE(free, 30.0 + 1e-9);
}

// A link is missing where its ends, up to the margin, are nearest to different bodies, and nowhere else. The nearest
// body is found by a search of its own, over the faces of voxels.
TEST(FreeJoints, LinksAreMissingWhereTwoBodiesMeet)
{
  Labelled tissue = knuckle();
  tissue.joints.constraint = 1.0;
  tissue.joints.margin = 3;
  const Grid& grid = tissue.scene.grid;
  std::vector<int> owner(grid.voxels(), 0), distance(grid.voxels(), 1000);
  for (std::size_t n = 0; n < grid.voxels(); ++n)
  {
    owner[n] = tissue.labels[n];
    distance[n] = owner[n] != 0 ? 0 : 1000;
  }
  const auto forSteps = [&](std::size_t n, const auto& f)
  {
    const Index3 at = grid.indexOf(n);
    for (int d = 0; d < 6; ++d)
    {
      Index3 next = at;
      next[d / 2] += d % 2 == 0 ? -1 : 1;
      if (grid.contains(next[0], next[1], next[2]))
      {
        f(d, grid.at(next[0], next[1], next[2]));
      }
    }
  };
  for (int step = 1; step <= 3; ++step)
  {
    for (const int body : { 1, 2 }) // at the same distance the lower number counts
    {
      for (std::size_t n = 0; n < grid.voxels(); ++n)
      {
        if (distance[n] == step - 1 && owner[n] == body)
        {
          forSteps(n,
            [&](int, std::size_t next)
            {
              if (owner[next] == 0)
              {
                owner[next] = body;
                distance[next] = step;
              }
            });
        }
      }
    }
  }
  Simulation simulation = tissue.simulate();
  std::vector<std::uint8_t> links(grid.voxels());
  const auto expectLinks = [&]
  {
    simulation.links(links.data());
    std::size_t missing = 0;
    for (std::size_t n = 0; n < grid.voxels(); ++n)
    {
      forSteps(n,
        [&](int d, std::size_t next)
        {
          const bool differ = owner[n] != 0 && owner[next] != 0 && owner[n] != owner[next];
          missing += differ ? 1 : 0;
          ASSERT_EQ((links[n] >> d & 1) == 0, differ) << n << ' ' << d;
        });
    }
    EXPECT_GT(missing, 2u * 150); // more than the bones' own faces, of 81 links
  };
  expectLinks();
  // restoreTopology() does not bring them back.
  Surface blade;
  blade.points = { { 8.5, -1.0, -1.0 }, { 8.5, 40.0, -1.0 }, { 8.5, -1.0, 40.0 } };
  blade.triangles = { { { 0, 1, 2 } } };
  EXPECT_GT(simulation.cut(blade), 0u);
  simulation.restoreTopology();
  expectLinks();
  EXPECT_EQ(simulation.bodies().size(), 2u);
}

// The output is continuous across a joint that opens, until the joint is cut.
TEST(FreeJoints, PicturesShowNoGap)
{
  Labelled tissue = knuckle();
  tissue.joints.constraint = 1.0;
  const auto nowhere = [&](bool cuts)
  {
    Simulation simulation = tissue.simulate();
    if (cuts)
    {
      Surface blade;
      blade.points = { { 17.5, -1.0, -1.0 }, { 17.5, 50.0, -1.0 }, { 17.5, -1.0, 50.0 } };
      blade.triangles = { { { 0, 1, 2 } } };
      EXPECT_GT(simulation.cut(blade), 0u);
    }
    Probe probe;
    probe.position = tissue.scene.place(26, 9, 9);
    probe.displacement = { 1.5, 0.0, 0.0 };
    EXPECT_NEAR(simulation.pull({ probe })[0].reached[0], 1.5, 1e-5);
    std::size_t count = 0;
    simulation.resample({ 0, 0, 0 },
      [&](const std::vector<ResampledBox>& boxes)
      {
        for (const ResampledBox& box : boxes)
        {
          box.forVoxels([&](const Index3& at, const float* offset)
            { count += std::isnan(offset[0]) && at[0] > 14 && at[0] < 24 && std::abs(at[1] - 9) < 4 ? 1 : 0; });
        }
      });
    return count;
  };
  EXPECT_EQ(nowhere(false), 0u);
  EXPECT_GT(nowhere(true), 20u);
}

// A small piece of bone without a label belongs to the labelled body that it touches.
TEST(FreeJoints, CrumbsBelongToBodies)
{
  Labelled tissue = knuckle();
  tissue.bone({ 8, 14, 9 }, { 9, 14, 9 }, 0);
  tissue.joints.constraint = 1.0;
  EXPECT_EQ(tissue.simulate().bodies().size(), 2u);
  tissue.bone({ 2, 14, 0 }, { 15, 16, 18 }, 0); // 798 voxels, with 2673 in the other, are not small
  EXPECT_EQ(tissue.simulate().bodies().size(), 3u);
}

// Stiff tissue with the label of a body (marrow), beside bone without one that is divided by its thickness.
TEST(FreeJoints, MarrowOfALabelledBodyTouchesBoneThatIsDivided)
{
  Labelled tissue = knuckle();
  const auto withBone = [&](int size)
  {
    Labelled with = tissue;
    with.joints.constraint = 1.0;
    with.joints.size = size;
    with.bone({ 2, 14, 0 }, { 15, 16, 18 }, 0); // 798 voxels
    for (int i = 4; i < 14; ++i)
    {
      with.scene.give(i, 13, 9, 0.3f);
      with.labels[with.scene.grid.at(i, 13, 9)] = 1;
    }
    return with.simulate().bodies().size();
  };
  EXPECT_EQ(withBone(0), 3u);
  EXPECT_EQ(withBone(2), 3u);
}

}
