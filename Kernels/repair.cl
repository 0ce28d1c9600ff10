// Makes a state feasible: `bound` finds min_j(u(j) + d(i, j)) and max_j(u(j) - d(i, j)) over all elements j, in place
// and in any order, `settle` takes their mean.
//
// The host guarantees: both bounds are the displacement at first, brick.clh's promise of bricks that are ready.

#include "brick.clh"
#include "element.clh"
#include "spread.clh"

RULE int boundAt(const Site* s, uint pitch, global const float* constraint, global const uchar* cut,
  global float* lower, global float* upper)
{
  int touched = 0;
  real limits[6];
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    if (axis < AXES)
    {
      const real c = LOAD(constraint + axis * pitch + s->self);
      UNROLL
      for (int d = 0; d < 6; ++d)
      {
        limits[d] = linkLimit(c, neighbourConstraint(constraint + axis * pitch, cut, s, d, s->odd));
      }
    }
    const real l = LOAD(lower + axis * pitch + s->self);
    const real u = LOAD(upper + axis * pitch + s->self);
    real nextLower = l, nextUpper = u;
    UNROLL
    for (int d = 0; d < 6; ++d)
    {
      nextLower = max(nextLower, neighbour(lower + axis * pitch, s, d, s->odd) - limits[d]);
      nextUpper = min(nextUpper, neighbour(upper + axis * pitch, s, d, s->odd) + limits[d]);
    }
    const mask moved = (nextLower != l) | (nextUpper != u);
    if (SOME(moved))
    {
      STORE(nextLower, lower + axis * pitch + s->self);
      STORE(nextUpper, upper + axis * pitch + s->self);
      touched |= movedFaces(s, moved);
    }
  }
  return touched;
}

kernel void bound(SPREAD_ARGUMENTS, uint pitch, global const int* table, global const int* place, int strideY,
  int strideZ, global const float* constraint, global const uchar* cut, global float* lower, global float* upper)
{
  SPREAD_TO
  SPREAD(boundAt(&s, pitch, constraint, cut, lower, upper))
  if (lid == 0 && from != 0)
  {
    passOn(faces, slot, visits, log, turn, enough, table, place, strideY, strideZ);
  }
}

// Leaves the mean in `before`, and in `displacement` but for held elements: as a wave finds it that starts at these.
kernel void settle(global const int* list, uint pitch, global const float* constraint, global const float* upper,
  global float* before, global float* displacement)
{
  const uint slot = list[get_group_id(0)];
  for (int axis = 0; axis < 3; ++axis)
  {
    for (int n = get_local_id(0); n < ELEMENTS; n += get_local_size(0))
    {
      const uint at = axis * pitch + slot * ELEMENTS + n;
      const float mean = 0.5f * (before[at] + upper[at]);
      before[at] = mean;
      if (!signbit(constraint[min(axis, AXES - 1) * pitch + slot * ELEMENTS + n]))
      {
        displacement[at] = mean;
      }
    }
  }
}
