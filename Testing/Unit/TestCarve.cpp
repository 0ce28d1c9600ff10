// Carves: which elements go, against implicit functions; what is left behaves as if they had never been.

#include "Blades.h"
#include "Picture.h"

namespace
{

using namespace chainmail;

TEST(Carve, ABoxBetweenVoxels)
{
  Scene scene({ 20, 16, 12 });
  Simulation simulation = simulate(scene);
  EXPECT_EQ(simulation.carve(box({ 3.5, 4.5, 5.5 }, { 9.5, 8.5, 7.5 })), 6u * 4u * 2u);
}

}
