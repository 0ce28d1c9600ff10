// Finds elements whose link to the next one along x, y or z is at its limit on some axis. Both ends have to be
// displaced and not held. Such a link may be a blocking one (ActiveConstraints.h).
//
// The host decides. The tolerance for rounding is twice that of the host, so no device misses a link.
//
// The host guarantees that all 26 neighbours of a listed brick have a slot (brick.clh).
//
// result[group * ELEMENTS + n] is not 0 where the element of local address n has such a link.

#include "brick.clh"
#include "state.clh"
#include "element.clh"
#include "rotations.clh"

#include "halo.clh"

kernel void activeConstraints(global const int* list, STATE_ARGUMENTS, global uchar* result)
{
  const State state = STATE;
  const uint slot = list[get_group_id(0)];
  for (int work = get_local_id(0); work < 2 * VECTORS; work += get_local_size(0))
  {
    const Stencil s = stencilOf(&state.layout, slot, work / VECTORS, work % VECTORS);
    if (work < VECTORS) // this prefetches both colours
    {
      prefetchAhead(&state, &s, slot, list[get_num_groups(0) - 1], 0);
    }
    mask found = (mask)(0);
#ifdef ROTATIONS
    real restOffsets[6][3];
    loadRestOffsets(s.odd, &state, &s, restOffsets);
#endif
    NO_UNROLL
    for (int d = 1; d < 6; d += 2)
    {
      Link link;
      mask free;
      UNROLL
      for (int axis = 0; axis < 3; ++axis)
      {
        if (axis < AXES)
        {
          const real c = LOAD(constraintAlong(&state, axis) + s.self);
          const real other = neighbourConstraint(&state, axis, &s, d, s.odd);
          link = linkOf(c, other, d, axis);
          free = (AS_MASK(c) >= 0) & (AS_MASK(other) >= 0) & !link.rigid;
        }
        const real u = LOAD(displacementAlong(&state, axis) + s.self);
        const real other = neighbour(displacementAlong(&state, axis), &s, d, s.odd);
        const real rounding = 2e-6f * max((real)(1.0f), fabs(u));
#ifdef ROTATIONS
        const real strain = other - u - restOffsets[d][axis];
#else
        const real strain = u - other;
#endif
        found |= free & (u != 0.0f) & (other != 0.0f) & (fabs(strain) >= link.limit - rounding);
      }
    }
    STORE_BYTES(found, result + get_group_id(0) * ELEMENTS + (s.self - slot * ELEMENTS));
  }
}
