// How far a step has moved the elements, and the way back.

#include "StepStart.h"

#include "Elements.h"
#include "Scene.h"

#include <cmath>

namespace
{

using namespace chainmail;

/// Elements with random displacements, of which a step changes some.
class Step
{
public:
  explicit Step(const Index3& brick)
    : bricks(Context::of(testDevice()), scene.model(), brick)
    , start(bricks)
  {
    Random random(4700);
    const Grid& grid = this->bricks.model().grid();
    std::vector<int> touched;
    for (std::size_t voxel = 0; voxel < grid.voxels(); ++voxel)
    {
      const Index3 at = grid.indexOf(voxel);
      touched.push_back(this->bricks.brickAt(at[0], at[1], at[2]));
      this->voxels.push_back(voxel);
      const bool moves = at[0] > 5; // the others are at rest, and do not count
      for (int a = 0; a < 3; ++a)
      {
        this->before.push_back(moves ? static_cast<float>(random(-4.0, 4.0)) : 0.0f);
        this->after.push_back(
          moves && at[1] > 3 ? this->before.back() + static_cast<float>(random(-0.05, 0.05)) : this->before.back());
      }
    }
    this->bricks.makeUpdatable(touched);
    this->bricks.markDirty(this->bricks.slotsOf(touched));
    Elements(this->bricks, this->voxels).setDisplacements(this->before);
    this->start.save();
    Elements(this->bricks, this->voxels).setDisplacements(this->after);
  }

  std::vector<float> displacements() { return Elements(this->bricks, this->voxels).displacements(); }

  Scene scene = []
  {
    Scene anisotropic({ 21, 13, 9 }, 0.3f);
    anisotropic.grid.spacing = { 0.5, 1.25, 3.0 };
    return anisotropic;
  }();
  Bricks bricks;
  StepStart start;
  std::vector<std::size_t> voxels;
  std::vector<float> before;
  std::vector<float> after;
};

}

TEST(StepStart, MeasuresTheChange)
{
  Step first({ 8, 4, 8 });
  const Vector3& spacing = first.bricks.model().grid().spacing;
  const auto square = [&](const std::vector<float>& a, const std::vector<float>* b, std::size_t n)
  {
    double sum = 0.0;
    for (int axis = 0; axis < 3; ++axis)
    {
      const double u = static_cast<double>(a[3 * n + axis]) - (b ? static_cast<double>((*b)[3 * n + axis]) : 0.0);
      sum += std::pow(u * spacing[axis], 2);
    }
    return sum;
  };
  double largest = 0.0;
  for (std::size_t n = 0; n < first.voxels.size(); ++n)
  {
    largest = std::max(largest, square(first.after, nullptr, n));
  }
  double squares = 0.0;
  int displaced = 0;
  for (std::size_t n = 0; n < first.voxels.size(); ++n)
  {
    squares += square(first.after, &first.before, n);
    displaced += square(first.after, nullptr, n) > 1e-6 * largest ? 1 : 0;
  }
  const double change = first.start.change();
  // Float32 rounding of displacements of 4, relative to changes of 0.05, is 1e-5.
  EXPECT_NEAR(change, std::sqrt(squares / displaced / largest), 1e-5 * change);
  EXPECT_GT(change, 1e-3);
  for (const Index3& brick : brickSizes())
  {
    EXPECT_EQ(Step(brick).start.change(), change) << brick[0];
  }
}

TEST(StepStart, NothingChangesAtRest)
{
  Step step({ 8, 4, 8 });
  step.start.save();
  EXPECT_EQ(step.start.change(), 0.0);
  Elements(step.bricks, step.voxels).setDisplacements(std::vector<float>(3 * step.voxels.size(), 0.0f));
  EXPECT_EQ(step.start.change(), 0.0); // nothing is displaced any more
}

TEST(StepStart, GoesBack)
{
  Step step({ 4, 2, 2 });
  step.start.goBack(0.5f);
  const std::vector<float> u = step.displacements();
  for (std::size_t n = 0; n < u.size(); ++n)
  {
    EXPECT_NEAR(u[n], 0.5 * (step.before[n] + step.after[n]), 1e-6) << n; // float32 rounding
  }
  step.start.restore();
  EXPECT_EQ(step.displacements(), step.before);
}
