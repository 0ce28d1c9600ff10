#include "Measurement.h"

namespace chainmail
{

std::vector<BrickFigures> measureBricks(Bricks& bricks, const Elasticity& elasticity)
{
  static_assert(sizeof(BrickFigures) == 15 * sizeof(float), "measure.cl writes 15 floats a brick");
  std::vector<BrickFigures> figures(bricks.slots() - 1);
  // Only links of touched bricks can be strained. Some of these links lead to bricks behind their faces, so the bricks
  // there are measured, too.
  const std::vector<int> list = bricks.slotsAround(bricks.dirtySlots());
  if (list.empty())
  {
    return figures;
  }
  Context& context = bricks.context();
  const cl::Buffer listBuffer = context.upload(list, "the list of bricks");
  const cl::Buffer result = context.allocate(sizeof(BrickFigures) * list.size(), "the figures of the state");
  const std::size_t items = bricks.workItems(true);
  context.launch(
    context.kernel("measure.cl",
      bricks.definesOfRows() + elasticity.ofLinks() + bricks.ofVolumetricStrain() + bricks.ofSoftLinks(), "measure"),
    list.size(), items, listBuffer, bricks.state(bricks.rotations(), bricks.softLinks()), elasticity.slack,
    cl::Local(sizeof(BrickFigures) * items), result);
  std::vector<BrickFigures> measured(list.size());
  context.read(result, measured);
  for (std::size_t n = 0; n < list.size(); ++n)
  {
    figures[list[n] - 1] = measured[n];
  }
  return figures;
}

double energyOf(const Bricks& bricks, const std::vector<BrickFigures>& figures)
{
  double energy = 0.0;
  // A sum depends slightly on its order, and the order of slots depends on which bricks got a state first. So bricks
  // are added in the order in which their tissue was loaded.
  bricks.forKnown(
    [&](int slot)
    {
      for (int a = 0; a < 3; ++a)
      {
        energy += figures[slot - 1].energy[a] * bricks.model().grid().spacing[a];
      }
    });
  return energy;
}

}
