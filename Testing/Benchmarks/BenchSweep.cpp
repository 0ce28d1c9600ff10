// B5: relaxation sweeps over tissue that is all in motion, against the bytes that memory can move: an element-update
// reads and writes 3 floats and reads a byte of constraint, 25 bytes in all; and on a processor against the same
// arithmetic in plain C++. B14: the same tissue with rotations, against itself without.

#include "Settling.h"

#include <map>
#include <string>

namespace
{

void dense(bench::Session& session, const bench::Block& block, const std::string& name)
{
  constexpr double bytesPerUpdate = 25.0;
  const auto [milliseconds, plain] = bench::denseSweeps(session, block);
  const double updates = double(block.grid.voxels()) / (1e-3 * bench::median(milliseconds));
  const bench::Bandwidth bandwidth = session.machine().measure();
  std::map<std::string, double> figures{ { "updates [M/s]", 1e-6 * updates },
    { "share of triad / 25 B", updates * bytesPerUpdate * 1e-9 / bandwidth.deviceTriad },
    { "share of copy / 25 B", updates * bytesPerUpdate * 1e-9 / bandwidth.deviceCopy } };
  const std::string scene = block.text() + ", " + name;
  if (!plain.empty())
  {
    const double median = bench::median(plain);
    figures["times plain C++"] = median / bench::median(milliseconds);
    session.report({ scene, "plain C++", plain, { { "updates [M/s]", 1e-3 * double(block.grid.voxels()) / median } } });
  }
  session.report({ scene, "one sweep", milliseconds, figures });
}

void turning(bench::Session& session, const bench::Block& block, const std::string& name)
{
  const auto [with, without] = bench::turningSweeps(session, block);
  const double median = bench::median(without);
  session.report({ block.text() + ", " + name, "a sweep with rotations", with,
    { { "times one without", bench::median(with) / median }, { "one without [ms]", median } } });
}

bench::Block withBone(bench::Block block)
{
  bench::addRods(block);
  return block;
}

}

int main(int argc, char** argv)
{
  return bench::run(argc, argv, "B5", "dense relaxation sweeps",
    [](bench::Session& session)
    {
      for (const int n : session.sizes({ 64, 128, 192 }))
      {
        dense(session, bench::heterogeneousBlock({ n, n, n }), "heterogeneous");
      }
      for (const int n : session.sizes({ 128 }))
      {
        dense(session, bench::Block({ n, n, n }), "homogeneous");
        dense(session, withBone(bench::heterogeneousBlock({ n, n, n })), "heterogeneous with bone");
      }
      for (const int n : session.sizes({ 64, 128 }))
      {
        turning(session, bench::heterogeneousBlock({ n, n, n }), "heterogeneous");
        turning(session, withBone(bench::heterogeneousBlock({ n, n, n })), "heterogeneous with bone");
      }
    });
}
