// Projects a state to a feasible one. `bound` (bounds.clh) computes min_j(u(j) + d(i, j)) and max_j(u(j) - d(i, j))
// over all elements j. `settle` sets elements to the mean of these bounds. The bounds spread from the bricks that
// `violated` finds, which are few in most cases.
//
// Both bounds start as the displacement. With ROTATIONS they are bounds of shifts and start as 0.
//
// The host guarantees: both bounds are set in the bricks that `violated` found; all 26 neighbours of an updatable brick
// have a slot (brick.clh).

#ifdef ROTATIONS
#define BOUNDS_OF_SHIFTS
#define SHIFTED_ARGUMENTS , global const float* lower
#else
#define SHIFTED_ARGUMENTS
#endif

#include "bounds.clh"

#include "halo.clh"

// Whether a link of any element of a lane group exceeds its limit, in which case `bound` would change its bounds.
CHAINMAIL_INLINE int isViolated(const int odd, const State* state, const Stencil* s)
{
  const Stencil moving = stateStencil(s);
  mask beyond = (mask)(0);
#ifdef ROTATIONS
  real restOffsets[6][3];
  loadRestOffsets(odd, state, s, restOffsets);
#endif
  Link links[6];
  NO_UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    if (axis < AXES)
    {
      loadLinks(odd, state, axis, s, links);
    }
    global const float* displacement = displacementAlong(state, axis);
    const real u = LOAD(displacement + moving.self);
    UNROLL
    for (int d = 0; d < 6; ++d)
    {
#ifdef ROTATIONS
      // Rounding between two elements of a rotated rigid cluster is no violation.
      const real other =
        select(neighbour(displacement, &moving, d, odd) - restOffsets[d][axis], u, links[d].rigid);
#else
      const real other = neighbour(displacement, &moving, d, odd);
#endif
      // In exact arithmetic two tests suffice. With rounding the neighbour's own two differ from them.
      const real limit = links[d].limit;
      beyond |= (other - limit > u) | (other + limit < u) | (u - limit > other) | (u + limit < other);
    }
  }
  return SOME(beyond);
}

// Whether a work-item's part of a brick has such elements. Every link joins elements of different colours. So one
// colour covers all links if the bricks around those that moved are listed, too. With ROTATIONS these are not listed,
// since bricks with links beyond their limits are tested again one by one (contradictions.cl). Then both colours are
// tested. `last`: the last slot.
#ifdef ROTATIONS
#define COLOURS_SEEN 2
#else
#define COLOURS_SEEN 1
#endif
NOINLINE int anyViolated(const State* given, int lid, int items, uint slot, uint last)
{
  const State state = *given;
  int any = 0;
  for (int work = lid; !any && work < COLOURS_SEEN * VECTORS; work += items)
  {
    const Stencil s = stencilOf(&state.layout, slot, work / VECTORS, work % VECTORS);
    if (work < VECTORS) // this prefetches both colours
    {
      prefetchAhead(&state, &s, slot, last, 0);
    }
    any = isViolated(s.odd, &state, &s);
  }
  return any;
}

// `found` is set to 1 for bricks with such elements.
kernel void violated(global const int* list, STATE_ARGUMENTS, global int* found)
{
  const State state = STATE;
  if (anyViolated(&state, get_local_id(0), get_local_size(0), list[get_group_id(0)], list[get_num_groups(0) - 1]))
  {
    atomic_or(&found[get_group_id(0)], 1);
  }
}

// Writes the mean to `before` and, except for held elements, to `displacement`. For an envelope wave that starts from
// this state, held elements are moved from the mean back to where they are held. `found` is set to 1 for bricks in which
// there are such elements.
kernel void settle(global const int* list, uint pitch, uint tissuePitch, global const float* constraint,
  global const float* upper SHIFTED_ARGUMENTS, global float* before, global float* displacement, global int* found)
{
  int any = 0;
  const uint slot = list[get_group_id(0)];
  for (int axis = 0; axis < 3; ++axis)
  {
    for (int n = get_local_id(0); n < ELEMENTS; n += get_local_size(0))
    {
      const uint at = axis * pitch + slot * ELEMENTS + n;
#ifdef ROTATIONS
      const float mean = before[at] + 0.5f * (lower[at] + upper[at]);
#else
      const float mean = 0.5f * (before[at] + upper[at]);
#endif
      before[at] = mean;
      if (!signbit(constraint[min(axis, AXES - 1) * tissuePitch + slot * ELEMENTS + n]))
      {
        displacement[at] = mean;
      }
      any |= displacement[at] != mean;
    }
  }
  if (any)
  {
    atomic_or(&found[get_group_id(0)], 1);
  }
}
