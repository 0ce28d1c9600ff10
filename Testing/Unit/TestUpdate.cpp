// Simulation::update() does what the single calls do, to the bit, and says which of its parts begins.

#include "Blades.h"

#include <cmath>
#include <limits>

namespace
{

using namespace chainmail;

/// What update() is to do, by the single calls.
UpdateResult updateByCalls(Simulation& simulation, const Update& update, const Method& before)
{
  const Method& method = update.method;
  if (update.fromRest)
  {
    simulation.reset();
  }
  if (method.propagation != before.propagation || method.conflict != before.conflict)
  {
    simulation.setPropagation(method.propagation, method.conflict);
  }
  simulation.setRelaxation(method.relaxation, method.elasticRecovery);
  simulation.setCoarseToFine(method.coarseToFine);
  simulation.setPropagationTimes(update.propagationTimes);
  simulation.hold(update.probes);
  UpdateResult result;
  result.propagation = simulation.propagate(method.propagationIterations);
  result.relaxation = simulation.relax(method.relaxationIterations, method.relaxationTolerance);
  result.probes = simulation.probes();
  result.statistics = simulation.measure();
  return result;
}

void expectSame(const UpdateResult& a, const UpdateResult& b)
{
  EXPECT_EQ(a.propagation.iterations, b.propagation.iterations);
  EXPECT_EQ(a.propagation.finished, b.propagation.finished);
  EXPECT_EQ(a.propagation.shared, b.propagation.shared);
  EXPECT_EQ(a.relaxation.iterations, b.relaxation.iterations);
  EXPECT_EQ(a.relaxation.largestMove, b.relaxation.largestMove);
  EXPECT_EQ(a.relaxation.converged, b.relaxation.converged);
  EXPECT_EQ(a.relaxation.coarseStep, b.relaxation.coarseStep);
  EXPECT_EQ(a.relaxation.coarseDrop, b.relaxation.coarseDrop);
  ASSERT_EQ(a.probes.size(), b.probes.size());
  for (std::size_t n = 0; n < a.probes.size(); ++n)
  {
    EXPECT_EQ(a.probes[n].reached, b.probes[n].reached);
    EXPECT_EQ(a.probes[n].force, b.probes[n].force);
    EXPECT_EQ(a.probes[n].elements, b.probes[n].elements);
    EXPECT_EQ(a.probes[n].rotated, b.probes[n].rotated);
    EXPECT_EQ(a.probes[n].torque, b.probes[n].torque);
  }
  EXPECT_EQ(a.statistics.energy, b.statistics.energy);
  EXPECT_EQ(a.statistics.maxLinkExcess, b.statistics.maxLinkExcess);
  EXPECT_EQ(a.statistics.displaced, b.statistics.displaced);
  EXPECT_EQ(a.statistics.allocated, b.statistics.allocated);
  EXPECT_EQ(a.statistics.deviceBytes, b.statistics.deviceBytes);
}

std::vector<float> times(const Simulation& simulation)
{
  const Model& model = simulation.model();
  std::vector<float> values(model.grid().voxels() * model.axes());
  simulation.propagationTimes(values.data());
  return values;
}

Method methodOf(PropagationMethod propagation, RelaxationMethod relaxation)
{
  Method method;
  method.propagation = propagation;
  method.relaxation = relaxation;
  method.relaxationIterations = 12;
  method.relaxationTolerance = 1e-4;
  return method;
}

struct Twins
{
  Simulation one;
  Simulation other;
  Method before; // the defaults of a new simulation

  UpdateResult update(const Update& update)
  {
    UpdateResult found = this->one.update(update);
    expectSame(found, updateByCalls(this->other, update, this->before));
    this->before = update.method;
    EXPECT_TRUE(sameBits(displacements(this->one), displacements(this->other)));
    EXPECT_TRUE(sameBits(times(this->one), times(this->other)));
    return found;
  }
};

TEST(Update, IsTheSingleCallsFromRestAndWithProbesThatStay)
{
  Scene scene = randomScene({ 18, 14, 12 }, 1, 11);
  scene.anchors.faces[4] = true;
  const std::vector<Probe> probes = compatibleProbes(scene, 3, 2.0, 12, 2.0);
  for (const auto propagation : { PropagationMethod::Envelope, PropagationMethod::Timestamp })
  {
    for (const auto relaxation : { RelaxationMethod::Projected, RelaxationMethod::Paper })
    {
      SCOPED_TRACE(testing::Message() << static_cast<int>(propagation) << " " << static_cast<int>(relaxation));
      Twins twins{ simulate(scene), simulate(scene), {} };
      Update update;
      update.method = methodOf(propagation, relaxation);
      update.propagationTimes = true;
      update.probes = { probes[0], probes[1] };
      EXPECT_GT(twins.update(update).statistics.displaced, 0u);

      // The first probe stays and moves on, the second is released, the third is new. Waves remain under way.
      update.probes = { probes[0], probes[2] };
      update.probes[0].displacement[0] *= 0.5;
      update.method.propagationIterations = 1;
      const bool finished = twins.update(update).propagation.finished;
      if (propagation == PropagationMethod::Timestamp)
      {
        EXPECT_FALSE(finished);
      }
      // Nothing moves: the update continues these waves.
      update.method.propagationIterations = 0;
      EXPECT_TRUE(twins.update(update).propagation.finished);

      update.fromRest = true;
      update.probes = { probes[2] };
      twins.update(update);
      update.probes.clear();
      EXPECT_EQ(twins.update(update).statistics.displaced, 0u);
    }
  }
}

TEST(Update, FinishesWavesOnlyWhereTheirMethodChanges)
{
  const Scene scene({ 24, 10, 10 }, 0.1f);
  Twins twins{ simulate(scene), simulate(scene), {} };
  Update update;
  update.method = methodOf(PropagationMethod::Timestamp, RelaxationMethod::Projected);
  update.method.propagationIterations = 2;
  update.probes = { probeAt(scene, { 1, 5, 5 }, { 3.0, 0.0, 0.0 }) };
  EXPECT_FALSE(twins.update(update).propagation.finished);
  EXPECT_FALSE(twins.update(update).propagation.finished) << "it goes on by two links";
  update.method.conflict = ConflictPolicy::Latest;
  EXPECT_TRUE(twins.update(update).propagation.finished) << "another policy finishes the wave first";
  update.method = methodOf(PropagationMethod::Envelope, RelaxationMethod::Paper);
  update.method.elasticRecovery = 0.5;
  twins.update(update);
  update.method = methodOf(PropagationMethod::Envelope, RelaxationMethod::Projected);
  update.method.coarseToFine = true;
  update.probes[0].displacement = { 1.0, 1.0, 0.0 };
  EXPECT_TRUE(twins.update(update).relaxation.coarseStep.has_value());
}

TEST(Update, SaysWhichPartBeginsAndStopsThere)
{
  const Scene scene({ 12, 10, 10 }, 0.2f);
  Simulation simulation = simulate(scene);
  Update update;
  update.method = methodOf(PropagationMethod::Envelope, RelaxationMethod::Projected);
  update.probes = { probeAt(scene, { 3, 5, 5 }, { 1.0, 0.0, 0.0 }) };
  const std::vector<UpdatePart> all = { UpdatePart::Propagate, UpdatePart::Relax, UpdatePart::Measure };
  for (std::size_t last = 0; last <= all.size(); ++last)
  {
    std::vector<UpdatePart> begun;
    const auto begins = [&](UpdatePart part)
    {
      begun.push_back(part);
      return begun.size() <= last;
    };
    if (last == all.size())
    {
      EXPECT_GT(simulation.update(update, begins).statistics.displaced, 0u);
      EXPECT_EQ(begun, all);
      continue;
    }
    EXPECT_THROW(simulation.update(update, begins), Aborted);
    EXPECT_EQ(begun, std::vector<UpdatePart>(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(last) + 1));
    EXPECT_EQ(simulation.measure().displaced, 0u);
    EXPECT_TRUE(simulation.probes().empty());
  }
}

TEST(Update, FailsAsTheSingleCallsDo)
{
  const Scene scene({ 12, 10, 10 }, 0.2f);
  Simulation simulation = simulate(scene);
  Update good;
  good.method = methodOf(PropagationMethod::Envelope, RelaxationMethod::Projected);
  good.probes = { probeAt(scene, { 3, 5, 5 }, { 1.0, 0.0, 0.0 }) };
  simulation.update(good);
  const std::vector<float> before = displacements(simulation);

  Update bad = good;
  bad.probes.push_back(good.probes[0]);
  bad.probes[1].radius = -1.0;
  try
  {
    simulation.update(bad);
    ADD_FAILURE() << "nothing was thrown";
  }
  catch (const ProbeError& error)
  {
    EXPECT_EQ(error.probe, 1u);
  }
  bad = good;
  bad.method.elasticRecovery = 1.5;
  EXPECT_TRUE(contains(messageOf<InputError>([&] { simulation.update(bad); }), "elastic recovery"));
  bad = good;
  bad.method.conflict = ConflictPolicy::Share;
  bad.method.propagation = PropagationMethod::Timestamp;
  EXPECT_TRUE(contains(messageOf<InputError>([&] { simulation.update(bad); }), "Share"));
  bad = good;
  for (const double error : { -0.1, std::numeric_limits<double>::quiet_NaN() })
  {
    bad.method.relaxationError = error;
    EXPECT_TRUE(contains(messageOf<InputError>([&] { simulation.update(bad); }), "0 or more"));
  }
  bad = good;
  bad.method.relaxationIterations = -1;
  EXPECT_TRUE(contains(messageOf<InputError>([&] { simulation.update(bad); }), "0 or more"));
  EXPECT_TRUE(sameBits(displacements(simulation), before));
  EXPECT_EQ(simulation.probes().size(), 1u);
}

}
