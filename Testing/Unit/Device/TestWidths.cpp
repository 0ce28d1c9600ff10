// Kernels have two variants. On a processor one work-item with vectors updates a brick; on a GPU many work-items
// without vectors do. Both must give the same bits.

#include "ChildProcess.h"
#include "Inclusion.h"

#include <CL/cl.h>

#include <cstdlib>
#include <dlfcn.h>
#include <iostream>
#include <sstream>

// Replaces OpenCL's function, and calls it: with CHAINMAIL_TEST_AS_GPU in the environment every device is a GPU with a
// memory of its own. So all tests can be run with the kernels and copies of GPUs.
extern "C" cl_int clGetDeviceInfo(cl_device_id device, cl_device_info name, size_t size, void* value, size_t* sizeOut)
{
  static const auto ask = reinterpret_cast<decltype(&clGetDeviceInfo)>(dlsym(RTLD_NEXT, "clGetDeviceInfo"));
  const cl_int status = ask(device, name, size, value, sizeOut);
  if (status == CL_SUCCESS && value && name == CL_DEVICE_TYPE && std::getenv("CHAINMAIL_TEST_AS_GPU"))
  {
    *static_cast<cl_device_type*>(value) = CL_DEVICE_TYPE_GPU;
  }
  if (status == CL_SUCCESS && value && name == CL_DEVICE_HOST_UNIFIED_MEMORY && std::getenv("CHAINMAIL_TEST_AS_GPU"))
  {
    *static_cast<cl_bool*>(value) = CL_FALSE;
  }
  return status;
}

namespace
{

using namespace chainmail;

const Index3 brickOfGpus{ 16, 8, 8 };

/// A pull, relaxation, a cut, and a second wave with relaxation between its steps. Prints a number for each step.
void play(int axes, const Index3& brick, PropagationMethod propagation, RelaxationMethod relaxation, std::ostream& out)
{
  const Scene scene = inclusionScene(21, axes, 50 + axes);
  Simulation simulation = simulate(scene, brick);
  simulation.setPropagation(propagation, ConflictPolicy::Limit);
  simulation.setPropagationTimes(true);
  simulation.setRelaxation(relaxation, 0.8);
  out << axes << " axes, " << (propagation == PropagationMethod::Envelope ? "envelope" : "timestamp") << ", brick "
      << brick[0] << ' ' << brick[1] << ' ' << brick[2] << std::hex;
  const auto print = [&] { out << ' ' << hashOfBits(displacements(simulation)); };
  simulation.pull({ corner(scene, { 1.9, -2.3, 1.1 }) });
  print();
  simulation.relax(9, 0.0);
  print();
  Surface blade;
  blade.points = { { 10.4, -1.0, -1.0 }, { 10.4, 30.0, -1.0 }, { 10.4, -1.0, 12.3 }, { 10.4, 30.0, 12.3 } };
  blade.triangles = { { 0, 1, 2 }, { 1, 2, 3 } };
  simulation.cut(blade);
  simulation.hold({ corner(scene, { 2.4, -3.0, -0.7 }) });
  for (bool finished = false; !finished;)
  {
    finished = simulation.propagate(3).finished;
    simulation.relax(1, 0.0);
  }
  print();
  simulation.relax(9, 0.0);
  print();
  std::vector<float> times(simulation.model().grid().voxels() * axes);
  std::vector<int> fronts(times.size());
  simulation.propagationTimes(times.data());
  simulation.wavefronts(fronts.data());
  out << ' ' << hashOfBits(times) << ' ' << hashOfBits(fronts) << std::dec << '\n';
}

/// A relaxation that starts on coarser grids and is corrected there.
void playCoarse(const Index3& brick, std::ostream& out)
{
  Scene scene = randomScene({ 30, 26, 22 }, 1, 60, 0.1, 0.0);
  scene.anchors.faces[0] = true;
  Simulation simulation = simulate(scene, brick);
  simulation.setCoarseToFine(true);
  simulation.pull({ probeAt(scene, { 24, 12, 12 }, { 4.0, -3.0, 2.0 }, 2.0) });
  simulation.relax(24, 0.0);
  out << "coarse to fine " << std::hex << hashOfBits(displacements(simulation)) << std::dec << '\n';
}

int playAll()
{
  // Other brick sizes, and so other widths of vectors, are compared in the tests of their scenes.
  const Index3 brick{ 32, 16, 4 };
  std::ostringstream outcome;
  play(1, brick, PropagationMethod::Envelope, RelaxationMethod::Projected, outcome);
  play(3, brick, PropagationMethod::Envelope, RelaxationMethod::Projected, outcome);
  play(1, brick, PropagationMethod::Timestamp, RelaxationMethod::Paper, outcome);
  playCoarse(brick, outcome);
  std::cout << "outcome\n" << outcome.str(); // after possible messages of a device's compiler
  return simulate(Scene({ 3, 3, 3 })).brickSize() == brickOfGpus ? 1 : 0;
}

const ChildPart widthsPart("widths", playAll);

}

TEST(Widths, AGpuAndAProcessorGiveTheSameBits)
{
  if (simulate(Scene({ 3, 3, 3 })).brickSize() == brickOfGpus)
  {
    GTEST_SKIP() << "the device is a GPU, and the processor is not asked";
  }
  const ChildResult gpu = runChild({ { "CHAINMAIL_TEST_AS_GPU", "1" } }, "widths");
  const ChildResult processor = runChild({}, "widths");
  EXPECT_EQ(gpu.status, 1) << "the engine takes the device for a processor: " << gpu.output;
  EXPECT_EQ(processor.status, 0) << processor.output;
  const auto outcome = [](const ChildResult& child) { return child.output.substr(child.output.rfind("outcome")); };
  ASSERT_NE(gpu.output.rfind("outcome"), std::string::npos);
  ASSERT_NE(processor.output.rfind("outcome"), std::string::npos);
  EXPECT_EQ(outcome(gpu), outcome(processor));
}
