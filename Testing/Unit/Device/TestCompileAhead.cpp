#include "ChildProcess.h"
#include "CompileAhead.h"
#include "Scene.h"

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <map>
#include <stdexcept>
#include <stdlib.h>
#include <string>
#include <thread>

namespace
{

using namespace chainmail;

struct TemporaryFolder
{
  std::string path = (std::filesystem::temp_directory_path() / "chainmail-test-XXXXXX").string();

  TemporaryFolder()
  {
    if (!mkdtemp(this->path.data()))
    {
      throw std::runtime_error(this->path + " could not be made");
    }
  }
  ~TemporaryFolder()
  {
    std::error_code ignored;
    std::filesystem::remove_all(this->path, ignored);
  }

  /// For a process to which no kernel is compiled yet.
  std::map<std::string, std::string> environment() const
  {
    return { { "CHAINMAIL_CACHE_DIR", this->path + "/own" }, { "POCL_CACHE_DIR", this->path },
      { "CUDA_CACHE_PATH", this->path } };
  }
};

void compile()
{
  Settings settings;
  settings.device = testDevice();
  compileAhead(settings);
}

/// Ends, as the environment says, so many milliseconds after the compiler was put to work.
const ChildPart endingPart("endWhileCompiling",
  []
  {
    compile();
    std::this_thread::sleep_for(std::chrono::milliseconds(std::atoi(std::getenv("CHAINMAIL_TEST_DELAY"))));
    std::cout << "ended" << std::endl;
    return 0;
  });

TEST(CompileAhead, AProcessMayEndMeanwhile)
{
  for (const char* delay : { "0", "30", "300", "900", "2000" })
  {
    const TemporaryFolder caches;
    std::map<std::string, std::string> environment = caches.environment();
    environment["CHAINMAIL_TEST_DELAY"] = delay;
    const ChildResult child = runChild(environment, "endWhileCompiling");
    EXPECT_EQ(child.status, 0) << delay << ": " << child.output;
    EXPECT_EQ(child.output, "ended\n") << delay;
  }
}

/// A simulation beside, which may find kernels compiled, under way, or not begun.
const ChildPart besidePart("deformWhileCompiling",
  []
  {
    if (std::getenv("CHAINMAIL_TEST_AHEAD"))
    {
      compile();
    }
    Scene scene({ 12, 12, 12 }, 0.2f);
    scene.anchors.faces[0] = true;
    Simulation simulation = simulate(scene);
    simulation.setCoarseToFine(true);
    int reports = 0;
    simulation.setCompiling([&] { return ++reports > 0; });
    Probe probe;
    probe.position = scene.place(8, 6, 6);
    probe.displacement = { 1.5, 0.5, 0.0 };
    probe.radius = 2.0;
    simulation.pull({ probe });
    simulation.relax(5, 0.0);
    std::vector<float> displacement(3 * scene.grid.voxels());
    simulation.displacements(displacement.data());
    std::cout << (reports > 0 ? "waited\n" : "did not wait\n") << std::hexfloat;
    for (const float value : displacement)
    {
      std::cout << value << ' ';
    }
    return 0;
  });

TEST(CompileAhead, ASimulationBesideComputesTheSame)
{
  const TemporaryFolder caches;
  std::map<std::string, std::string> ahead = caches.environment();
  ahead["CHAINMAIL_TEST_AHEAD"] = "1";
  const ChildResult cold = runChild(ahead, "deformWhileCompiling");
  const ChildResult warm = runChild(caches.environment(), "deformWhileCompiling");
  EXPECT_EQ(cold.status, 0) << cold.output;
  EXPECT_EQ(warm.status, 0) << warm.output;
  EXPECT_EQ(cold.output.substr(0, 7), "waited\n");
  EXPECT_EQ(cold.output.substr(cold.output.find('\n')), warm.output.substr(warm.output.find('\n')));
}

TEST(CompileAhead, AWaitCanBeStopped)
{
  Scene scene({ 12, 12, 12 }, 0.2f);
  Simulation simulation = simulate(scene, { 4, 2, 16 }); // no other test has these bricks, and no cache at first
  Probe probe;
  probe.position = scene.place(6, 6, 6);
  probe.displacement = { 0.5, 0.0, 0.0 };
  bool stops = false;
  simulation.setCompiling(
    [&]
    {
      stops = true;
      return false;
    });
  try
  {
    simulation.pull({ probe });
    EXPECT_FALSE(stops) << "the wait went on";
  }
  catch (const Aborted&)
  {
    EXPECT_TRUE(stops);
  }
  simulation.setCompiling(nullptr);
  simulation.pull({ probe });
  EXPECT_GT(simulation.measure().displaced, 0u);
}

TEST(CompileAhead, WhereThereIsNoDeviceNothingHappens)
{
  Settings settings;
  settings.device = "no such machine";
  EXPECT_NO_THROW(compileAhead(settings));
}

}
