// Propagation gives the same bits on every device: a few scenes, and a checksum of where each takes the tissue. The
// first ones were recorded with PoCL on a processor.
//
//     Checksums FILE             compares, and fails where a scene differs
//     Checksums --record FILE    writes what this device gives

#include "Blocks.h"
#include "Session.h"

#include <cstring>
#include <fstream>
#include <functional>
#include <iomanip>
#include <iostream>
#include <sstream>

namespace
{

using namespace chainmail;

/// FNV-1a over the bits of all displacements; -0 counts as 0.
std::string checksum(const Simulation& simulation)
{
  std::vector<float> u(3 * simulation.model().grid().voxels());
  simulation.displacements(u.data());
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const float value : u)
  {
    std::uint32_t bits = 0;
    const float plain = value + 0.0f;
    std::memcpy(&bits, &plain, sizeof(bits));
    for (int n = 0; n < 4; ++n)
    {
      hash = (hash ^ (bits >> 8 * n & 0xff)) * 0x100000001b3u;
    }
  }
  std::ostringstream text;
  text << std::hex << std::setw(16) << std::setfill('0') << hash;
  return text.str();
}

struct Scene
{
  std::string name;
  std::function<void(bench::Session&, std::string&)> play; ///< gives the checksum
};

Surface blade(double x)
{
  return { { { x, -1.0, -1.0 }, { x, 25.0, -1.0 }, { x, 25.0, 60.0 }, { x, -1.0, 60.0 } },
    { { { 0, 1, 2 } }, { { 0, 2, 3 } } } };
}

std::vector<Scene> scenes()
{
  const Index3 size{ 50, 41, 37 };
  const Index3 middle{ 25, 20, 18 };
  const Vector3 far{ 6.0, -4.5, 3.25 };
  std::vector<Scene> list;
  list.push_back({ "homogeneous", [=](bench::Session& session, std::string& sum)
    {
      const bench::Block block(size);
      Simulation simulation = session.simulate(block.model());
      simulation.pull({ bench::probeAt(middle, far) });
      sum = checksum(simulation);
    } });
  for (const bool timestamps : { false, true })
  {
    list.push_back(
      { timestamps ? "heterogeneous-timestamps" : "heterogeneous", [=](bench::Session& session, std::string& sum)
        {
          bench::Block block = bench::heterogeneousBlock(size);
          bench::addRods(block);
          Simulation simulation = session.simulate(block.model());
          simulation.setPropagation(
            timestamps ? PropagationMethod::Timestamp : PropagationMethod::Envelope, ConflictPolicy::Limit);
          simulation.pull({ bench::probeAt(middle, far, 2.5) });
          sum = checksum(simulation);
        } });
  }
  list.push_back({ "three-probes-anchored-cut", [=](bench::Session& session, std::string& sum)
    {
      bench::Block block = bench::heterogeneousBlock(size, 2);
      block.anchors.faces[4] = true;
      Simulation simulation = session.simulate(block.model());
      simulation.cut(blade(20.3));
      simulation.pull({ bench::probeAt({ 10, 10, 30 }, { 1.5, 0.5, -0.25 }), bench::probeAt({ 40, 30, 20 }, far, 1.5),
        bench::probeAt({ 30, 8, 33 }, { -1.0, -2.0, 1.0 }, 2.0) });
      sum = checksum(simulation);
    } });
  return list;
}

}

int main(int argc, char** argv)
{
  const bool record = argc == 3 && std::string(argv[1]) == "--record";
  if (argc != 2 && !record)
  {
    std::cerr << "Checksums [--record] FILE\n";
    return 2;
  }
  const std::string path = argv[argc - 1];
  return bench::run(1, argv, "Checksums", "propagation, bit for bit",
    [&](bench::Session& session)
    {
      std::map<std::string, std::string> recorded;
      std::ifstream in(path);
      for (std::string name, sum; in >> name >> sum;)
      {
        recorded[name] = sum;
      }
      std::ostringstream out;
      bool same = true;
      for (const Scene& scene : scenes())
      {
        std::string sum;
        scene.play(session, sum);
        out << scene.name << ' ' << sum << '\n';
        const bool equal = recorded[scene.name] == sum;
        same = same && equal;
        std::cout << "  " << scene.name << ' ' << sum << (record || equal ? "" : ", not " + recorded[scene.name])
                  << std::endl;
      }
      if (record)
      {
        std::ofstream(path) << out.str();
      }
      else if (!same)
      {
        throw std::runtime_error("propagation gives other bits on this device than those of " + path);
      }
    });
}
