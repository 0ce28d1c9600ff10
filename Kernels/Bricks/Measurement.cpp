#include "Measurement.h"

namespace chainmail
{

std::vector<BrickFigures> measureBricks(Bricks& bricks, const Elasticity& elasticity)
{
  static_assert(sizeof(BrickFigures) == 15 * sizeof(float), "measure.cl writes 15 floats a brick");
  std::vector<BrickFigures> figures(bricks.slots() - 1);
  // Elsewhere nothing is strained; behind a face there may be a link that is.
  const std::vector<int> list = bricks.slotsAround(bricks.touchedSlots());
  if (list.empty())
  {
    return figures;
  }
  Context& context = bricks.context();
  const cl::Buffer listBuffer = context.upload(list, "the list of bricks");
  const cl::Buffer result = context.allocate(sizeof(BrickFigures) * list.size(), "the figures of the state");
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
  std::vector<BrickFigures> measured(list.size());
  context.read(result, measured);
  for (std::size_t n = 0; n < list.size(); ++n)
  {
    figures[list[n] - 1] = measured[n];
  }
  return figures;
}

}
