#include "Measurement.h"

#include <numeric>

namespace chainmail
{

std::vector<BrickFigures> measureBricks(Bricks& bricks, const Elasticity& elasticity)
{
  static_assert(sizeof(BrickFigures) == 15 * sizeof(float), "measure.cl writes 15 floats a brick");
  std::vector<int> list(bricks.slots() - 1);
  std::iota(list.begin(), list.end(), 1);
  std::vector<BrickFigures> figures(list.size());
  if (list.empty())
  {
    return figures;
  }
  Context& context = bricks.context();
  const cl::Buffer listBuffer = context.upload(list, "the list of bricks");
  const cl::Buffer result = context.allocate(sizeof(BrickFigures) * figures.size(), "the figures of the state");
  const std::size_t items = bricks.workItems(true);
  cl::Kernel kernel = context.kernel("measure.cl", bricks.defines(true) + elasticity.defines(), "measure");
  int argument = 0;
  kernel.setArg(argument++, listBuffer);
  kernel.setArg(argument++, elasticity.slack);
  kernel.setArg(argument++, bricks.pitch());
  bricks.bindTable(kernel, argument);
  kernel.setArg(argument++, bricks.displacement);
  kernel.setArg(argument++, bricks.constraint);
  kernel.setArg(argument++, bricks.cutsOrNothing());
  kernel.setArg(argument++, cl::Local(sizeof(BrickFigures) * items));
  kernel.setArg(argument++, result);
  context.runGroups(kernel, list.size(), items);
  context.read(result, figures);
  return figures;
}

}
