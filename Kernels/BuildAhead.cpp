#include "BuildAhead.h"

namespace chainmail
{

void buildAhead(const Bricks& bricks, const Bricks& voxels, const Elasticity* projected, bool coarseToFine)
{
  Context& context = bricks.context();
  const std::string elements = bricks.defines(true);
  const std::string single = bricks.defines(false);
  const Elasticity elasticity = projected ? *projected : Elasticity();
  context.buildAhead("scatter.cl", "");
  context.buildAhead("envelope.cl", elements);
  context.buildAhead("measure.cl", elements + elasticity.ofLinks());
  if (projected && coarseToFine)
  {
    Elasticity unlimited = elasticity;
    unlimited.limited = false;
    context.buildAhead("coarsen.cl", single);
    context.buildAhead("feasibility.cl", elements);
    context.buildAhead("relax.cl", elements + elasticity.defines());
    context.buildAhead("coarsen.cl", elements);
    context.buildAhead("components.cl", elements);
    context.buildAhead("relax.cl", elements + unlimited.defines());
  }
  if (projected)
  {
    context.buildAhead("relax.cl", elements + elasticity.defines());
    context.buildAhead("clusters.cl", single + elasticity.ofLinks());
  }
  context.buildAhead("cover.cl", voxels.defines(true));
}

}
