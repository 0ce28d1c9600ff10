// The paper's table 1: a mass-spring model of 42 875 nodes and 196 520 tetrahedra against ChainMail with as many
// elements, and with 12.5 M. Two pulls, of a small and of a large share of the tissue, as many steps as ChainMail takes
// iterations a frame.

#include "Baselines/MassSpring.h"
#include "Settling.h"

#include <cmath>

namespace
{

using namespace chainmail;

constexpr int nodes = 35;
constexpr int steps = 20; // 10 + 10 iterations a frame

/// A pull upwards in the middle of the top of a block, the bottom held.
void springs(bench::Session& session, int n, double share)
{
  baseline::MassSpring model(session.device(), { n, n, n });
  std::vector<std::size_t> bottom;
  std::vector<std::size_t> patch;
  const double radius = 2.0 * share * n;
  for (int j = 0; j < n; ++j)
  {
    for (int i = 0; i < n; ++i)
    {
      const std::size_t v = static_cast<std::size_t>(i) + static_cast<std::size_t>(n) * j;
      bottom.push_back(v);
      if (std::hypot(i - n / 2, j - n / 2) <= 0.5 * radius)
      {
        patch.push_back(v + static_cast<std::size_t>(n) * n * (n - 1));
      }
    }
  }
  bench::Task task;
  task.prepare = [&]
  {
    model.reset();
    model.hold(bottom, { 0.0f, 0.0f, 0.0f });
    model.hold(patch, { 0.0f, 0.0f, 1.0f });
  };
  task.run = [&] { model.step(steps, 0.05f); };
  std::size_t shifted = 0;
  task.check = [&]
  {
    shifted = 0;
    for (const baseline::MassSpring::Place& u : model.displacements())
    {
      if (!std::isfinite(u[0] + u[1] + u[2]))
      {
        throw std::runtime_error("the mass-spring model exploded");
      }
      shifted += std::fabs(u[0]) + std::fabs(u[1]) + std::fabs(u[2]) > 0.01f ? 1 : 0;
    }
  };
  const std::vector<double> milliseconds = session.time(task);

  // How many steps it would take to come to rest.
  int toRest = steps;
  for (std::vector<baseline::MassSpring::Place> before; toRest < 20000; toRest += 10)
  {
    const auto now = model.displacements();
    float largest = before.empty() ? 1.0f : 0.0f;
    for (std::size_t v = 0; v < before.size(); ++v)
    {
      for (int a = 0; a < 3; ++a)
      {
        largest = std::max(largest, std::fabs(now[v][a] - before[v][a]));
      }
    }
    if (largest < 1e-3f)
    {
      break;
    }
    before = now;
    model.step(10, 0.05f);
  }
  session.report({ std::to_string(n) + "^3 nodes, a pull of " + std::to_string(patch.size()) + " nodes",
    "mass-spring, " + std::to_string(steps) + " steps", milliseconds,
    { { "nodes", double(n) * n * n }, { "tetrahedra", double(model.tetrahedra()) },
      { "springs", double(model.springs()) }, { "shifted", double(shifted) }, { "steps to rest", double(toRest) } } });
}

/// A step of a drag in the middle of a block whose wave moves this share of it; relaxation spreads it further.
void chainMail(bench::Session& session, int n, double share)
{
  const bench::Block block({ n, n, n });
  Simulation simulation = session.simulate(block.model());
  // A pull of so many links moves an octahedron of 4/3 links^3 elements.
  const double links = n * std::cbrt(0.75 * share);
  const double far = 0.25 * links;
  const auto hold = [&](double t) { simulation.hold({ bench::probeAt({ n / 2, n / 2, n / 2 }, { 0.0, 0.0, t }) }); };
  std::size_t reached = 0;
  bench::Task task;
  task.prepare = [&]
  {
    simulation.reset();
    hold(far - 1.0);
    simulation.propagate();
    simulation.relax(10, 1e-3);
    hold(far);
  };
  task.run = [&]
  {
    simulation.propagate(10);
    simulation.relax(10, 1e-3);
  };
  task.check = [&]
  {
    simulation.propagate();
    bench::requireSound(simulation);
    reached = simulation.measure().displaced;
  };
  const std::vector<double> milliseconds = session.time(task);
  session.report(
    { std::to_string(n) + "^3 elements, " + std::to_string(static_cast<int>(100 * share)) + " % moved by the wave",
      "ChainMail, 10 + 10 iterations", milliseconds,
      { { "elements", double(block.material.size()) }, { "displaced", double(reached) } } });
}

}

int main(int argc, char** argv)
{
  return bench::run(argc, argv, "Table 1", "mass-spring models and ChainMail, a frame",
    [](bench::Session& session)
    {
      for (const double share : { 0.05, 0.3 })
      {
        for (const int n : session.sizes({ nodes }))
        {
          springs(session, n, share);
          chainMail(session, n, share);
        }
        if (!session.small())
        {
          chainMail(session, 232, share);
        }
      }
    });
}
