#include "CompileAhead.h"

#include "Context.h"
#include "Simulation.h"

#include <atomic>
#include <exception>
#include <list>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <utility>

namespace chainmail
{

namespace
{

/// A small block of soft tissue, anchored at one face, with a bone in it.
std::shared_ptr<const Model> smallModel()
{
  Grid grid;
  grid.size = { 24, 24, 24 };
  return std::make_shared<const Model>(grid, 1,
    [grid](std::size_t first, int count, float* out)
    {
      for (int n = 0; n < count; ++n)
      {
        const Index3 at = grid.indexOf(first + n);
        const bool bone = at[1] / 4 == 1 && at[2] / 4 == 1 && at[0] / 4 > 0;
        out[n] = bone ? 0.0f : at[0] == 0 ? -0.1f : 0.1f;
      }
    });
}

/// What most scenes do, to its end or until `stop`.
void useKernels(const Settings& settings, const std::atomic<bool>& stop)
{
  Simulation simulation(smallModel(), settings);
  simulation.setProgress([&](double) { return !stop; });
  simulation.setCompiling([&] { return !stop; });
  simulation.setCoarseToFine(true);
  Probe probe;
  probe.position = { 18.0, 12.0, 12.0 };
  probe.displacement = { 1.5, 0.5, -0.5 };
  probe.radius = 2.0;
  simulation.pull({ probe });
  simulation.relax(10, 1e-3);
  simulation.resample({ 0, 0, 0 }, [](const ResampledBox&) {});
}

/// Uses the compiler in the calling thread, for the reason that Programs::makeReady() has.
void useCompiler(Context& context)
{
  const cl::Buffer numbers = context.allocate(64, "a first kernel");
  context.launchOver(context.kernel("scatter.cl", "", "scatter"), 1, numbers, cl_uint(1), cl_int(1), numbers, numbers);
  context.queue().finish();
}

/// The threads of all calls. They are made after the drivers were loaded, and so end before they do.
class Users
{
public:
  ~Users()
  {
    this->stop_ = true;
    for (std::thread& thread : this->threads_)
    {
      thread.join();
    }
  }

  void add(const Settings& settings)
  {
    const std::lock_guard<std::mutex> lock(this->mutex_);
    if (this->known_.insert({ settings.device, settings.brickSize }).second)
    {
      this->threads_.emplace_back(
        [this, settings]
        {
          try
          {
            useKernels(settings, this->stop_);
          }
          catch (const std::exception&)
          {
          }
        });
    }
  }

private:
  std::mutex mutex_;
  std::set<std::pair<std::string, Index3>> known_;
  std::list<std::thread> threads_;
  std::atomic<bool> stop_{ false };
};

}

void compileAhead(const Settings& settings)
{
  try
  {
    Settings plain;
    plain.device = settings.device;
    plain.brickSize = settings.brickSize;
    const std::shared_ptr<Context> context = Context::of(plain.device);
    if (context->isKept("scatter.cl", "")) // all simulations use it
    {
      return;
    }
    useCompiler(*context);
    static Users users;
    users.add(plain);
  }
  catch (const std::exception&)
  {
  }
}

}
