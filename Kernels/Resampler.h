#pragma once

#include "Types.h"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace chainmail
{

/// Resamples a part of the output of a simulation that runs in another process: to the bit as Simulation::resample()
/// there, on a device that computes alike. Its memory grows with the tissue that moves into this part of the output.
///
/// Threads and errors: as for Simulation. After Aborted it can be used further.
class Resampler
{
public:
  /// Throws DeviceError where there is no such device (Settings::device).
  explicit Resampler(const std::string& device);
  ~Resampler();
  Resampler(Resampler&&) noexcept;
  Resampler& operator=(Resampler&&) noexcept;

  /// As in Simulation.
  void setProgress(std::function<bool(double)> progress);
  void setCompiling(std::function<bool()> compiling);

  /// Takes one of the messages of Simulation::exportTissue(). They have to come in their order.
  void take(const std::vector<char>& message);
  /// The tissue after the last message of an export; none before that, and after an error.
  TissueVersion version() const;

  /// The voxels of the grid that the part of the output may show.
  Sources sources() const;

  /// Resamples the part for which the tissue was exported. See Simulation::resample(). `since` names an earlier call of
  /// this function; the tissue of all calls since must be that of one simulation, with equal padding, cuts and detail.
  Resampled resample(const BoxVisitor& visit, std::uint64_t since = 0);

private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}
