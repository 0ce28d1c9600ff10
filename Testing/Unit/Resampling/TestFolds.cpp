// In folded tissue several cells cover a voxel, and the voxel shows the lowest of them, for any number and order of
// work-items.

#include "ChildProcess.h"
#include "Picture.h"

#include <iostream>

namespace
{

using namespace chainmail;

/// Resamples folded tissue and prints a number for each scene. Returns the number of scenes with another result the
/// second time.
int playFolds()
{
  int unlike = 0;
  std::cout << "outcome" << std::hex;
  for (int n = 0; n < 3; ++n)
  {
    const Scene scene = randomScene({ 30, 18, 14 }, 1, 40 + n, 0.2, 0.05);
    Simulation simulation = simulate(scene, brickSizes().back());
    Random random(100 + n);
    std::vector<Probe> probes(3);
    for (Probe& probe : probes)
    {
      const Index3 place = randomElement(scene, random);
      const Vector3 displacement{ random(-9, 9), random(-9, 9), random(-9, 9) };
      probe = probeAt(scene, place, displacement, random(0.0, 2.0));
    }
    simulation.pull(probes);
    const Picture picture = resample(simulation);
    std::cout << ' ' << hashOfBits(picture.offset);
    for (int again = 0; again < 3; ++again)
    {
      resample(simulation, { 0, 1, 0 }); // another padding, so the next resampling starts anew
      if (!sameBits(resample(simulation).offset, picture.offset))
      {
        ++unlike;
        break;
      }
    }
  }
  std::cout << '\n';
  return unlike;
}

const ChildPart foldsPart("folds", playFolds);

}

TEST(Folds, AreResampledAlikeByFewWorkItemsAndByMany)
{
  // Device/TestWidths.cpp tests that the variable makes the device a GPU.
  const ChildResult many = runChild({ { "CHAINMAIL_TEST_AS_GPU", "1" } }, "folds");
  const ChildResult few = runChild({}, "folds");
  EXPECT_EQ(many.status, 0) << many.output;
  EXPECT_EQ(few.status, 0) << few.output;
  const auto outcome = [](const ChildResult& child) { return child.output.substr(child.output.rfind("outcome")); };
  ASSERT_NE(many.output.rfind("outcome"), std::string::npos);
  ASSERT_NE(few.output.rfind("outcome"), std::string::npos);
  EXPECT_EQ(outcome(many), outcome(few));
}
