#include "VolumetricStrain.h"

#include "Pass.h"

namespace chainmail
{

void updatePressureAround(Bricks& bricks, const std::vector<int>& slots, const cl::Buffer* activity, int sweep)
{
  if (bricks.ofVolumetricStrain().empty() || slots.empty())
  {
    return;
  }
  const std::vector<int> around = bricks.bricksOf(bricks.slotsAround(slots));
  bricks.makeUpdatable(around);
  const std::vector<int> ready = bricks.slotsOf(around); // may differ from before
  Context& context = bricks.context();
  const cl::Buffer list = context.upload(ready, "the list of bricks");
  const std::string defines = bricks.defines(true) + bricks.ofVolumetricStrain();
  const std::size_t items = bricks.workItems(true);
  if (activity)
  {
    launchPass(bricks, context.kernel("volumetricstrain.cl", defines + " -DNOTED", "volumetricStrains"), ready.size(),
      items, list, bricks.state(bricks.rotations()), *activity, static_cast<cl_int>(sweep));
  }
  else
  {
    launchPass(bricks, context.kernel("volumetricstrain.cl", defines, "volumetricStrains"), ready.size(), items, list,
      bricks.state(bricks.rotations()));
  }
  context.queue().finish();
}

}
