#pragma once

#include "Machine.h"
#include "Simulation.h"

#include <cstdint>
#include <functional>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

/// What the benchmarks share: options, timing, the check of what was computed, and the record of the results.
namespace bench
{

/// Something that is missing here: the benchmark ends with the status of a skipped test.
struct Skip : std::runtime_error
{
  using std::runtime_error::runtime_error;
};

/// Something to be timed. The clock runs in `run` alone, which must have finished on the device when it returns.
struct Task
{
  std::function<void()> prepare; ///< may be empty
  std::function<void()> run;
  std::function<void()> check; ///< throws where what `run` left must not be reported; may be empty
};

/// What was measured.
struct Result
{
  std::string scene;
  std::string method;
  std::vector<double> milliseconds;      ///< one value a repetition; empty where only `figures` count
  std::map<std::string, double> figures; ///< whatever else was counted, by a name that has its unit
};

double median(std::vector<double> values);

/// One run of one benchmark.
class Session
{
public:
  /// Options: --small, --size=N, --repeats=N, --seed=N, --device=NAME, --json=FILE. `id` is that of the table of
  /// targets.
  Session(int argc, char** argv, std::string id, std::string title);

  bool small() const { return this->small_; } ///< seconds are what it may take: shows that it runs, not how fast
  /// Sizes of blocks to measure: these, or the one that --size asks for, or a small one.
  std::vector<int> sizes(const std::vector<int>& all) const;
  /// Of scenes that are drawn at random.
  std::uint64_t seed() const { return this->seed_; }
  const std::string& device() const { return this->device_; }
  /// On the device of this run.
  chainmail::Simulation simulate(std::shared_ptr<const chainmail::Model> model, chainmail::Settings settings = {});
  Machine& machine() { return this->machine_; }

  /// Milliseconds of each task, all in turn and that many times, so that whatever else the machine does meets all of
  /// them alike. A round before the first is not counted: kernels are compiled and memory is touched.
  std::vector<std::vector<double>> time(const std::vector<Task>& tasks) const;
  std::vector<double> time(const Task& task) const { return this->time(std::vector<Task>{ task })[0]; }

  /// Milliseconds of the first time, for what is only looked over.
  double once(const Task& task) const;

  /// Prints a result, beside what the machine's memory could do at that moment, and writes it to the file with those
  /// before.
  void report(const Result& result);

private:
  void write() const;

  struct Entry
  {
    Result result;
    Bandwidth bandwidth;
    double load = 0.0;
  };

  std::string id_;
  std::string title_;
  bool small_ = false;
  int size_ = 0;
  int repeats_ = 5;
  std::uint64_t seed_ = 1;
  std::string device_;
  std::string json_;
  Machine machine_;
  std::vector<Entry> entries_;
};

/// How far a link may be beyond its limit [fraction of the spacing] where displacements are as large as this
/// [spacings]: to 1e-5 up to about 100 voxels, and a few units of the last place of float32 beyond.
double roundingOf(double largestDisplacement);

/// Throws unless the state is one that may be reported: every displacement finite, every link within its limit but for
/// the rounding of float32.
void requireSound(const chainmail::Simulation& simulation);

/// A benchmark's main: runs `body` and turns exceptions into an exit status, 125 for Skip, as ctest is told.
int run(
  int argc, char** argv, const std::string& id, const std::string& title, const std::function<void(Session&)>& body);

}
