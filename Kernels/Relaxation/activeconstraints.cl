// Finds elements whose link to the next one along x, y or z is at its limit on some axis. Both ends have to be
// displaced and not held. Such a link may be a blocking one (ActiveConstraints.h).
//
// The host decides. The tolerance for rounding is twice that of the host, so no device misses a link.
//
// The host guarantees that all 26 neighbours of a listed brick have a slot (brick.clh).
//
// result[group * ELEMENTS + n] is not 0 where the element of local address n has such a link.

#include "brick.clh"
#include "element.clh"
#include "turning.clh"

kernel void activeConstraints(global const int* list, LAYOUT_ARGUMENTS, global const float* displacement,
  global const float* constraint, global const uchar* cut SPIN_ARGUMENTS, global uchar* result)
{
  const uint slot = list[get_group_id(0)];
  for (int work = get_local_id(0); work < 2 * VECTORS; work += get_local_size(0))
  {
    const Stencil s = stencilOf(slot, work / VECTORS, work % VECTORS, pitch, table, place, strideY, strideZ);
    mask found = (mask)(0);
#ifdef TURNING
    real wanted[6][3];
    loadApart(s.odd, &s, pitch, spin, proportions, wanted);
#endif
    NO_UNROLL
    for (int d = 1; d < 6; d += 2)
    {
      real limit;
      mask free;
      UNROLL
      for (int axis = 0; axis < 3; ++axis)
      {
        if (axis < AXES)
        {
          const real c = LOAD(constraint + axis * tissuePitch + s.self);
          const real other = neighbourConstraint(constraint + axis * tissuePitch, cut, &s, d, s.odd);
          limit = linkLimit(c, other);
          free = (AS_MASK(c) >= 0) & (AS_MASK(other) >= 0) & (limit > 0.0f);
        }
        const real u = LOAD(displacement + axis * pitch + s.self);
        const real other = neighbour(displacement + axis * pitch, &s, d, s.odd);
        const real rounding = 2e-6f * max((real)(1.0f), fabs(u));
#ifdef TURNING
        const real apart = other - u - wanted[d][axis];
#else
        const real apart = u - other;
#endif
        found |= free & (u != 0.0f) & (other != 0.0f) & (fabs(apart) >= limit - rounding);
      }
    }
    STORE_BYTES(found, result + get_group_id(0) * ELEMENTS + (s.self - slot * ELEMENTS));
  }
}
