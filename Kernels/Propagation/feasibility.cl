// Projects a state to a feasible one: `bound` (bounds.clh) finds min_j(u(j) + d(i, j)) and max_j(u(j) - d(i, j)) over
// all elements j, and `settle` takes their mean. They begin at the bricks that `violated` finds, most often few.
//
// At first both bounds are the displacement or, where elements turn and bounds are those of shifts, 0.
//
// The host guarantees: bricks that `violated` found have both bounds; all 26 neighbours of a brick that is ready have a
// slot (brick.clh).

#ifdef TURNING
#define BOUNDS_OF_SHIFTS
#define SHIFTED_ARGUMENTS , global const float* lower
#else
#define SHIFTED_ARGUMENTS
#endif

#include "bounds.clh"

// Whether any element of a piece of work has a link beyond its limit, so that `bound` would move its bounds.
RULE int isViolated(const int odd, const Site* s, uint pitch, uint tissuePitch, global const float* constraint,
  global const uchar* cut, global const float* displacement SPIN_ARGUMENTS)
{
  mask beyond = (mask)(0);
#ifdef TURNING
  real wanted[6][3];
  loadApart(odd, s, pitch, spin, proportions, wanted);
#endif
  real limits[6];
  ROLLED
  for (int axis = 0; axis < 3; ++axis)
  {
    if (axis < AXES)
    {
      loadLimits(odd, s, constraint + axis * tissuePitch, cut, limits);
    }
    const real u = LOAD(displacement + axis * pitch + stateAddress(s, s->self));
    UNROLL
    for (int d = 0; d < 6; ++d)
    {
#ifdef TURNING
      // What rounding has between two elements of a bone that has turned is no violation.
      const real other =
        select(neighbour(displacement + axis * pitch, s, d, odd) - wanted[d][axis], u, limits[d] == 0.0f);
#else
      const real other = neighbour(displacement + axis * pitch, s, d, odd);
#endif
      // With rounding these are four tests: two are the neighbour's own.
      beyond |= (other - limits[d] > u) | (other + limits[d] < u) | (u - limits[d] > other) | (u + limits[d] < other);
    }
  }
  return SOME(beyond);
}

// Whether a work-item's share of a brick has such elements. Every link joins elements of different colours, so one
// colour sees them all, if the bricks around those that were moved are listed, too. Where elements turn they are not,
// as bricks with links beyond their limits are looked at again one by one (contradictions.cl).
#ifdef TURNING
#define COLOURS_SEEN 2
#else
#define COLOURS_SEEN 1
#endif
APART int anyViolated(int lid, int items, uint slot, LAYOUT_ARGUMENTS, global const float* displacement,
  global const float* constraint, global const uchar* cut SPIN_ARGUMENTS)
{
  int any = 0;
  for (int work = lid; !any && work < COLOURS_SEEN * VECTORS; work += items)
  {
    const Site s = siteOf(slot, work / VECTORS, work % VECTORS, pitch, table, place, strideY, strideZ);
    any = isViolated(s.odd, &s, pitch, tissuePitch, constraint, cut, displacement SPIN_PASSED_ON);
  }
  return any;
}

// `found` is set to 1 for bricks with such elements.
kernel void violated(global const int* list, LAYOUT_ARGUMENTS, global const float* displacement,
  global const float* constraint, global const uchar* cut SPIN_ARGUMENTS, global int* found)
{
  if (anyViolated(get_local_id(0), get_local_size(0), list[get_group_id(0)], pitch, tissuePitch, table, place, strideY,
        strideZ, displacement, constraint, cut SPIN_PASSED_ON))
  {
    atomic_or(&found[get_group_id(0)], 1);
  }
}

// Leaves the mean in `before` and, except for held elements, in `displacement`. This is the state from which an
// envelope wave that starts at the held elements can bring them back.
kernel void settle(global const int* list, uint pitch, uint tissuePitch, global const float* constraint,
  global const float* upper SHIFTED_ARGUMENTS, global float* before, global float* displacement)
{
  const uint slot = list[get_group_id(0)];
  for (int axis = 0; axis < 3; ++axis)
  {
    for (int n = get_local_id(0); n < ELEMENTS; n += get_local_size(0))
    {
      const uint at = axis * pitch + slot * ELEMENTS + n;
#ifdef TURNING
      const float mean = before[at] + 0.5f * (lower[at] + upper[at]);
#else
      const float mean = 0.5f * (before[at] + upper[at]);
#endif
      before[at] = mean;
      if (!signbit(constraint[min(axis, AXES - 1) * tissuePitch + slot * ELEMENTS + n]))
      {
        displacement[at] = mean;
      }
    }
  }
}
