// A child process that is forked after the use of OpenCL.
#ifndef _WIN32

#include "ChildProcess.h"
#include "Device.h"
#include "Scene.h"

#include <functional>
#include <iostream>
#include <optional>
#include <sys/wait.h>
#include <unistd.h>

namespace
{

using namespace chainmail;

Probe probe(const Scene& scene)
{
  Probe probe;
  probe.position = scene.place(4, 4, 4);
  probe.displacement = { 1.0, 0.0, 0.0 };
  return probe;
}

void report(const std::string& what, const std::function<void()>& call)
{
  try
  {
    call();
    std::cout << what << ": no error" << std::endl;
  }
  catch (const DeviceError& error)
  {
    std::cout << what << ": " << error.what() << std::endl;
  }
}

/// A forked process has a minute, and exits normally, with all destructors.
int inFork(const std::function<void()>& body)
{
  std::cout.flush();
  const pid_t child = fork();
  if (child == 0)
  {
    alarm(60);
    body();
    std::cout << "end" << std::endl;
    std::exit(0);
  }
  int status = -1;
  waitpid(child, &status, 0);
  return status;
}

const ChildPart usedPart("forkAfterUse",
  []
  {
    const Scene scene({ 8, 8, 8 });
    std::optional<Simulation> simulation = simulate(scene);
    simulation->pull({ probe(scene) });
    const int status = inFork(
      [&]
      {
        report("list", [] { listDevices(); });
        report("choose", [] { chooseDevice(""); });
        report("new", [&] { simulate(scene); });
        report("pull", [&] { simulation->pull({ probe(scene) }); });
        report("displacements", [&] { displacements(*simulation); });
        report("elements",
          [&]
          {
            std::vector<std::uint8_t> e(512);
            simulation->elements(e.data());
          });
        simulation.reset();
      });
    simulation->relax(3, 0.0);
    std::cout << "the first goes on" << std::endl;
    return status;
  });

const ChildPart unusedPart("forkBeforeUse",
  []
  {
    const Scene scene({ 8, 8, 8 });
    return inFork([&] { report("pull", [&] { simulate(scene).pull({ probe(scene) }); }); });
  });

}

TEST(Process, AForkOfOneThatUsedOpenClSaysSoAndComesToAnEnd)
{
  const ChildResult child = runChild({}, "forkAfterUse");
  EXPECT_EQ(child.status, 0) << child.output;
  for (const char* call : { "list", "choose", "new", "pull", "displacements" })
  {
    EXPECT_TRUE(contains(child.output, std::string(call) + ": This process was forked")) << call << '\n'
                                                                                         << child.output;
  }
  EXPECT_TRUE(contains(child.output, "\"spawn\"")) << "what to do is not said: " << child.output;
  EXPECT_TRUE(contains(child.output, "\nend\n")) << child.output;
  EXPECT_TRUE(contains(child.output, "the first goes on")) << child.output;
}

TEST(Process, AForkOfOneThatDidNotUseItWorks)
{
  const ChildResult child = runChild({}, "forkBeforeUse");
  EXPECT_EQ(child.status, 0) << child.output;
  EXPECT_TRUE(contains(child.output, "pull: no error")) << child.output;
}

#endif
