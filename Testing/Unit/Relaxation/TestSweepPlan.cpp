// The plan of a relaxation's sweeps: factors, rotations, active-set steps at fixed intervals.

#include "SweepPlan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace
{

using namespace chainmail;

constexpr int iterations = 2000;

SweepPlan farPlan(double poissonRatio = 0.0)
{
  return SweepPlan(Range::Far, false, poissonRatio, 300, 0, iterations);
}

// The semi-iterative method's factors by Chebyshev polynomials: 2 T(s, 1 / rho) / (rho T(s + 1, 1 / rho)).
TEST(SweepPlan, FactorsFollowChebyshev)
{
  const double last = 2.0 / 1.9 - 1.0;
  const double rho = std::sqrt(1.0 - last * last);
  const double angle = std::acosh(1.0 / rho);
  EXPECT_EQ(farPlan().omega(0), 1.0f);
  for (int s = 1; s < 150; ++s)
  {
    const double expected = 2.0 * std::cosh(s * angle) / (rho * std::cosh((s + 1) * angle));
    EXPECT_NEAR(farPlan().omega(s), expected, 1e-6) << s; // a float's rounding
  }
  EXPECT_NEAR(farPlan().omega(1000), 1.9, 1e-6);
}

// A larger diagonal, where tissue resists changes of volume, brings the factor closer to 2.
TEST(SweepPlan, FactorsGrowWithPoissonsRatio)
{
  float before = farPlan(0.0).omega(500);
  for (const double ratio : { 0.1, 0.2, 0.3, 0.4 })
  {
    const float omega = farPlan(ratio).omega(500);
    EXPECT_GT(omega, before) << ratio;
    EXPECT_LT(omega, 2.0f) << ratio;
    before = omega;
  }
}

// After coarser grids: an opening of 20 sweeps from 4/3 on, then rounds of 16, 32, 64, ... that end at 1.93.
TEST(SweepPlan, RoundsAfterCoarserGrids)
{
  const SweepPlan plan(Range::Near, false, 0.0, 300, 0, iterations);
  EXPECT_NEAR(plan.omega(0), 4.0 / 3.0, 1e-6);
  for (int s = 1; s < 20; ++s)
  {
    EXPECT_GE(plan.omega(s), plan.omega(s - 1)) << s;
    EXPECT_LE(plan.omega(s), 1.93f) << s;
  }
  const double most = 2.0 / (1.0 + std::sin(std::acos(-1.0) / (6.0 * 300)));
  int begin = 20;
  for (int round = 16; begin + round < iterations; round *= 2)
  {
    EXPECT_EQ(SweepPlan::roundsEnd(begin), begin + round);
    EXPECT_EQ(SweepPlan::roundsEnd(begin - 1), begin);
    EXPECT_NEAR(plan.omega(begin), std::min(most, 2.0 / (1.0 + 0.1 / round)), 1e-6) << round;
    EXPECT_NEAR(plan.omega(begin + round - 1), 1.93, 1e-6) << round;
    for (int s = begin; s < begin + round; ++s)
    {
      EXPECT_GE(plan.omega(s), 1.93f) << s;
      EXPECT_LE(plan.omega(s), most + 1e-6) << s;
      EXPECT_TRUE(s == begin || plan.omega(s) <= plan.omega(s - 1)) << s;
    }
    begin += round;
  }
  EXPECT_NEAR(plan.omega(iterations - 1), 1.93, 1e-6); // whatever is left of the round
}

// A continued run has the factors of a single run.
TEST(SweepPlan, GoesOn)
{
  for (const Range range : { Range::Far, Range::Near })
  {
    for (const bool rotates : { false, true })
    {
      const SweepPlan whole(range, rotates, 0.3, 80, 0, 300);
      const SweepPlan rest(range, rotates, 0.3, 80, 100, 200);
      for (int s = 0; s < 200; ++s)
      {
        EXPECT_EQ(whole.omega(100 + s), rest.omega(s)) << s;
        EXPECT_EQ(whole.rotates(100 + s), rest.rotates(s)) << s;
        EXPECT_EQ(whole.isTimedStepAfter(100 + s), rest.isTimedStepAfter(s)) << s;
        EXPECT_EQ(whole.sweepsToTimedStep(100 + s), rest.sweepsToTimedStep(s)) << s;
      }
    }
  }
}

// Elements rotate in every third sweep, later in every sixth; only those sweeps show whether they are at rest.
TEST(SweepPlan, Rotations)
{
  for (const Range range : { Range::Far, Range::Near })
  {
    const SweepPlan plan(range, true, 0.0, 300, 0, iterations);
    int last = -3;
    for (int s = 0; s < 200; ++s)
    {
      EXPECT_EQ(plan.showsRest(s), plan.rotates(s)) << s;
      if (plan.rotates(s))
      {
        EXPECT_TRUE(last < 0 || s - last == 3 || s - last == SweepPlan::mostSweepsPerRotation) << s;
        EXPECT_TRUE(last < 0 || s - last == 3 || s > 12) << s;
        last = s;
      }
      EXPECT_LT(s - last, SweepPlan::mostSweepsPerRotation) << s;
    }
    EXPECT_EQ(plan.rotates(0), range == Range::Far); // after coarser grids displacements are rough at first
  }
  EXPECT_FALSE(farPlan().rotates(0));
  EXPECT_TRUE(farPlan().showsRest(1));
}

// After coarser grids and the opening there is an active-set step every 10 sweeps; elsewhere there is none.
TEST(SweepPlan, StepsAtFixedIntervals)
{
  const SweepPlan plan(Range::Near, false, 0.0, 300, 0, iterations);
  for (int s = 0; s < 200; ++s)
  {
    EXPECT_EQ(plan.isTimedStepAfter(s), s > 20 && s % 10 == 9) << s;
    EXPECT_EQ(plan.sweepsToTimedStep(s), s < 20 ? 30 - s : 10 - s % 10) << s;
  }
  for (const SweepPlan& none : { farPlan(), SweepPlan(Range::Near, true, 0.0, 300, 0, iterations),
         SweepPlan(Range::Near, false, 0.0, 0, 0, iterations) })
  {
    for (int s = 0; s < 200; ++s)
    {
      EXPECT_FALSE(none.isTimedStepAfter(s)) << s;
      EXPECT_GT(none.sweepsToTimedStep(s), iterations) << s;
    }
  }
}

}
