// B1: the paper's figure 12. A homogeneous block of 126^3 elements, one corner held, the opposite one pulled so far
// that the wave moves all tissue between: propagation, then relaxation. The engine relaxes to within 1 % of the lowest
// energy that the constraints allow; the published methods take the iterations that the paper reports, wherever that
// gets them.

#include "Baselines/PublishedChainMail.h"
#include "Settling.h"

#include <cmath>

namespace
{

using namespace chainmail;
using baseline::PublishedChainMail;
using Launch = PublishedChainMail::Launch;

constexpr double tolerance = 1e-4;
constexpr int paperIterations = 619;
constexpr double paperMilliseconds = 458.0; // on its GTX 670, blocks of 16 x 4 x 4
constexpr double share = 0.9;               // of what the links between the corners stretch

double reachOf(const bench::Block& block)
{
  const Index3& n = block.grid.size;
  return share * block.constraint(0) * (n[0] + n[1] + n[2] - 3);
}

std::string text(const Index3& size)
{
  return std::to_string(size[0]) + " x " + std::to_string(size[1]) + " x " + std::to_string(size[2]);
}

std::string nameOf(const PublishedChainMail::Method& method)
{
  return std::string(method.timestamps ? "the paper's method" : "SP-ChainMail") +
         (method.launch == Launch::Whole ? ", no blocks" : ", blocks " + text(method.block));
}

/// Energy, and the largest violation of a link's limit as a fraction of the spacing.
struct Figures
{
  double energy = 0.0;
  double excess = 0.0;
};

Figures figuresOf(const bench::Block& block, const baseline::State& state)
{
  Figures figures;
  const Index3& n = block.grid.size;
  for (int a = 0; a < 3; ++a)
  {
    for (std::size_t v = 0; v < block.material.size(); ++v)
    {
      const Index3 p = block.grid.indexOf(v);
      const std::size_t stride[3] = { 1, std::size_t(n[0]), std::size_t(n[0]) * n[1] };
      for (int d = 0; d < 3; ++d)
      {
        if (p[d] + 1 < n[d])
        {
          const double limit = 0.5 * (block.constraint(v) + block.constraint(v + stride[d]));
          const double strain = std::fabs(double(state[a][v]) - state[a][v + stride[d]]);
          figures.energy += strain * strain / (limit + 1e-6);
          figures.excess = std::max(figures.excess, strain - limit);
        }
      }
    }
  }
  if (!std::isfinite(figures.energy))
  {
    throw std::runtime_error("a published method ends with displacements that are not finite");
  }
  return figures;
}

/// The published methods in one form and one size of blocks.
class Published
{
public:
  Published(bench::Session& session, const bench::Block& block, const PublishedChainMail::Method& method)
    : block_(block)
    , most_(session.small() ? paperIterations / 10 : paperIterations)
    , chainMail_(session.device(), block.grid.size, block.constraints(), method)
  {
    // Some drivers compile a kernel when it first runs.
    this->chainMail_.pull(0, { 0.5, 0.5, 0.5 });
    this->chainMail_.propagate();
    this->chainMail_.relax(1, 0.0);
  }

  bench::Task task()
  {
    bench::Task task;
    task.prepare = [this]
    {
      this->chainMail_.reset();
      this->chainMail_.hold(this->block_.material.size() - 1);
      const double reach = reachOf(this->block_);
      this->chainMail_.pull(0, { -reach, -reach, -reach });
    };
    task.run = [this]
    {
      this->waveIterations_ = this->chainMail_.propagate();
      this->iterations_ = this->chainMail_.relax(this->most_, tolerance);
    };
    return task;
  }

  /// `optimum`: the lowest energy that the constraints allow.
  std::map<std::string, double> figures(double optimum) const
  {
    const Figures figures = figuresOf(this->block_, this->chainMail_.state());
    return { { "propagation iterations", double(this->waveIterations_) },
      { "relaxation iterations", double(this->iterations_) }, { "energy over optimum", figures.energy / optimum },
      { "largest link excess", figures.excess },
      { "bytes per element", double(this->chainMail_.deviceBytes()) / double(this->block_.material.size()) } };
  }

private:
  const bench::Block& block_;
  int most_;
  PublishedChainMail chainMail_;
  int waveIterations_ = 0;
  int iterations_ = 0;
};

/// The engine with one size of bricks.
class Engine
{
public:
  Engine(bench::Session& session, const bench::Block& block, const Index3& brick)
    : simulation_(session.simulate(block.model(), settings(brick)))
  {
    const Index3& n = block.grid.size;
    const double reach = reachOf(block);
    Probe held = bench::probeAt({ n[0] - 1, n[1] - 1, n[2] - 1 }, {});
    held.anchor = true;
    this->probes_ = { held, bench::probeAt({ 0, 0, 0 }, { -reach, -reach, -reach }) };
    this->simulation_.setCoarseToFine(true);
    // Some drivers compile a kernel when it first runs.
    this->simulation_.pull({ bench::probeAt({ 0, 0, 0 }, { 0.5, 0.5, 0.5 }) });
    this->simulation_.relax(1, tolerance);
    this->simulation_.reset();
  }

  double findOptimum()
  {
    this->simulation_.pull(this->probes_);
    const double optimum = bench::convergedEnergy(this->simulation_);
    bench::requireSound(this->simulation_);
    return optimum;
  }

  /// Sweeps to within 1 % of the optimum; the same for bricks of any size.
  int sweeps(double optimum)
  {
    const auto start = [this]
    {
      this->simulation_.reset();
      this->simulation_.pull(this->probes_);
    };
    return bench::sweepsToSettle(this->simulation_, start, optimum, 1000, tolerance);
  }

  bench::Task task(int sweeps)
  {
    this->sweeps_ = sweeps;
    bench::Task task;
    task.prepare = [this] { this->simulation_.reset(); };
    task.run = [this]
    {
      this->simulation_.pull(this->probes_);
      this->simulation_.relax(this->sweeps_, tolerance);
    };
    task.check = [this] { bench::requireSound(this->simulation_); };
    return task;
  }

  std::string name() const { return "engine, bricks " + text(this->simulation_.brickSize()); }

  std::map<std::string, double> figures(double optimum) const
  {
    const Statistics statistics = this->simulation_.measure();
    return { { "sweeps on the finest grid", double(this->sweeps_) },
      { "energy over optimum", statistics.energy / optimum }, { "largest link excess", statistics.maxLinkExcess },
      { "bytes per element", double(statistics.deviceBytes) / double(this->simulation_.model().elements()) } };
  }

private:
  static Settings settings(const Index3& brick)
  {
    Settings settings;
    settings.brickSize = brick;
    return settings;
  }

  Simulation simulation_;
  std::vector<Probe> probes_;
  int sweeps_ = 0;
};

void paperBlock(bench::Session& session, int n)
{
  const bench::Block block({ n, n, n });
  const std::string scene = block.text() + ", homogeneous";
  Engine engine(session, block, {});
  const double optimum = engine.findOptimum();
  const int sweeps = engine.sweeps(optimum);

  // Every size of blocks once, to find the best and to draw the figure.
  const std::vector<Index3> blocks = session.small() ? std::vector<Index3>{ { 8, 4, 4 }, { 16, 16, 16 } }
                                                     : std::vector<Index3>{ { 4, 4, 4 }, { 8, 4, 4 }, { 16, 4, 4 },
                                                         { 16, 8, 8 }, { 16, 16, 16 }, { 32, 32, 32 } };
  PublishedChainMail::Method best[2];
  for (const bool timestamps : { false, true })
  {
    double fastest = 0.0;
    for (const Index3& size : blocks)
    {
      const PublishedChainMail::Method method{ timestamps ? Launch::Listed : Launch::PerBlock, timestamps, size };
      Published published(session, block, method);
      const std::vector<double> milliseconds{ session.once(published.task()) };
      session.report({ scene + ", figure 12", nameOf(method), milliseconds, published.figures(optimum) });
      if (fastest == 0.0 || milliseconds[0] < fastest)
      {
        fastest = milliseconds[0];
        best[timestamps] = method;
      }
    }
  }
  const std::vector<Index3> bricks = session.small() ? std::vector<Index3>{ { 8, 4, 4 }, { 16, 16, 16 } }
                                                     : std::vector<Index3>{ { 8, 4, 4 }, { 16, 4, 4 }, { 16, 8, 8 },
                                                         { 32, 8, 8 }, { 32, 16, 16 }, { 64, 32, 32 } };
  std::vector<std::unique_ptr<Engine>> engines;
  std::vector<bench::Task> ofEngines;
  for (const Index3& size : bricks)
  {
    engines.push_back(std::make_unique<Engine>(session, block, size));
    ofEngines.push_back(engines.back()->task(sweeps));
  }
  const auto ofBricks = session.time(ofEngines);
  for (std::size_t n = 0; n < engines.size(); ++n)
  {
    session.report({ scene + ", figure 12", engines[n]->name(), ofBricks[n], engines[n]->figures(optimum) });
  }
  engines.clear();

  // The best of each, and those without blocks, side by side.
  std::vector<PublishedChainMail::Method> methods{ best[0], best[1] };
  for (const bool timestamps : { false, true })
  {
    methods.push_back({ Launch::Whole, timestamps, { 64, 4, 1 } });
  }
  std::vector<std::unique_ptr<Published>> published;
  std::vector<bench::Task> tasks{ engine.task(sweeps) };
  for (const PublishedChainMail::Method& method : methods)
  {
    published.push_back(std::make_unique<Published>(session, block, method));
    tasks.push_back(published.back()->task());
  }
  const auto milliseconds = session.time(tasks);
  std::map<std::string, double> figures = engine.figures(optimum);
  figures["times the paper's GPU"] = paperMilliseconds / bench::median(milliseconds[0]);
  session.report({ scene, engine.name(), milliseconds[0], figures });
  for (std::size_t m = 0; m < methods.size(); ++m)
  {
    figures = published[m]->figures(optimum);
    figures["times the engine"] = bench::median(milliseconds[m + 1]) / bench::median(milliseconds[0]);
    session.report({ scene, nameOf(methods[m]), milliseconds[m + 1], figures });
  }
}

}

int main(int argc, char** argv)
{
  return bench::run(argc, argv, "B1", "the paper's figure 12: propagation and relaxation of a whole block",
    [](bench::Session& session)
    {
      for (const int n : session.sizes({ 126 }))
      {
        paperBlock(session, n);
      }
    });
}
