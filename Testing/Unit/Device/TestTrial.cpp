// Devices with unknown drivers: none is chosen by default before a trial.

#include "../../TemporaryFolder.h"
#include "ChildProcess.h"
#include "Environment.h"
#include "Notices.h"
#include "Scene.h"
#include "Trial.h"

#include <cstdlib>
#include <iostream>
#include <stdexcept>

namespace
{

using namespace chainmail;

class Trial : public testing::Test
{
protected:
  Trial()
  {
    std::filesystem::permissions(this->folder_.path, std::filesystem::perms::owner_all);
    this->device.name = "a card";
    this->device.platform = "a driver";
    this->device.driver = "1.0";
  }

  DeviceInfo device;

private:
  TemporaryFolder folder_;
  const Variable cache_{ "CHAINMAIL_CACHE_DIR", this->folder_.path.string().c_str() };
};

TEST_F(Trial, IsPassedByADeviceThatWorksAndMadeOnce)
{
  EXPECT_FALSE(hasPassedTrial(this->device));
  int uses = 0;
  for (int n = 0; n < 2; ++n)
  {
    tryDevice(this->device, [&] { ++uses; });
    EXPECT_TRUE(hasPassedTrial(this->device));
  }
  EXPECT_EQ(uses, 1);
  // Another version of the driver is another device.
  this->device.driver = "1.1";
  EXPECT_FALSE(hasPassedTrial(this->device));
  tryDevice(this->device, [&] { ++uses; });
  EXPECT_EQ(uses, 2);
}

TEST_F(Trial, ThatFailsIsNotMadeAgain)
{
  EXPECT_THROW(tryDevice(this->device, [] { throw std::runtime_error("wrong"); }), std::runtime_error);
  EXPECT_FALSE(hasPassedTrial(this->device));
  tryDevice(this->device, [] { ADD_FAILURE() << "it might end this process, too"; });
  EXPECT_FALSE(hasPassedTrial(this->device));
}

TEST_F(Trial, WithoutACacheIsNotMade)
{
  const Variable none("CHAINMAIL_CACHE_DIR", "");
  tryDevice(this->device, [] { ADD_FAILURE() << "it would be made at each start"; });
  EXPECT_FALSE(hasPassedTrial(this->device));
}

const ChildPart bestPart("bestDevice",
  []
  {
    const Scene scene({ 4, 4, 4 });
    const auto best = [&]
    {
      std::cout << "best: " << Simulation(scene.model(), Settings()).deviceName() << '\n';
      for (const std::string& notice : takeNotices())
      {
        std::cout << "notice: " << notice << '\n';
      }
    };
    best();
    const std::vector<DeviceInfo> devices = listDevices();
    for (const DeviceInfo& one : devices)
    {
      if (one.gpu && !one.proven)
      {
        std::cout << "unknown: " << one.name << '\n';
        tryDevice(one, [] {});
      }
    }
    best();
    return static_cast<int>(devices.size());
  });

// With rusticl (check `rusticl`), as a GPU in addition to PoCL.
TEST_F(Trial, DecidesWhetherAGpuOfAnUnknownDriverIsTheBest)
{
  const ChildResult child =
    runChild({ { "RUSTICL_ENABLE", "llvmpipe" }, { "RUSTICL_DEVICE_TYPE", "gpu" } }, "bestDevice");
  if (child.status == 1 || !contains(child.output, "unknown: llvmpipe") || std::getenv("CHAINMAIL_TEST_AS_GPU"))
  {
    GTEST_SKIP() << "rusticl and PoCL are not both there";
  }
  const std::size_t first = child.output.find("best: "), second = child.output.rfind("best: ");
  EXPECT_NE(child.output.compare(first, 14, "best: llvmpipe"), 0) << child.output;
  EXPECT_EQ(child.output.compare(second, 14, "best: llvmpipe"), 0) << child.output;
  const std::size_t notice = child.output.find("notice: ");
  ASSERT_NE(notice, std::string::npos) << child.output;
  EXPECT_TRUE(contains(child.output.substr(notice), "llvmpipe")) << child.output;
  EXPECT_TRUE(contains(child.output.substr(notice), "set Device to its name")) << child.output;
}

}
