// Which pieces of tissue, each all that links join, a relaxation from afar may move: those in which something is held
// and some link is strained. Any other is at rest as it is, or follows nothing; coarser grids do not know it from
// tissue close by.
//
// marks: [0] something in the piece is held, [1] something in it is strained; 1 or 0.
//
// The host guarantees: brick.clh's promise of bricks that are ready.

#include "brick.clh"
#include "element.clh"
#include "spread.clh"

// The elements themselves, as they were displaced.
kernel void mark(global const int* list, uint pitch, global const int* table, global const int* place, int strideY,
  int strideZ, global const float* displacement, global const float* constraint, global const uchar* cut,
  global float* marks)
{
  const uint slot = list[get_group_id(0)];
  for (int work = get_local_id(0); work < 2 * VECTORS; work += get_local_size(0))
  {
    const Site s = siteOf(slot, work / VECTORS, work % VECTORS, table, place, strideY, strideZ);
    mask held = (mask)(0), strained = (mask)(0);
    for (int axis = 0; axis < AXES; ++axis)
    {
      held |= isHeld(LOAD(constraint + axis * pitch + s.self));
    }
    const real c = LOAD(constraint + s.self);
    for (int d = 0; d < 6; ++d)
    {
      const mask linked = linkLimit(c, neighbourConstraint(constraint, cut, &s, d, s.odd)) < INFINITY;
      for (int axis = 0; axis < 3; ++axis)
      {
        global const float* u = displacement + axis * pitch;
        strained |= linked & (neighbour(u, &s, d, s.odd) != LOAD(u + s.self));
      }
    }
    STORE(select((real)(0.0f), (real)(1.0f), held), marks + s.self);
    STORE(select((real)(0.0f), (real)(1.0f), strained), marks + pitch + s.self);
  }
}

RULE int joinAt(const Site* s, uint pitch, global const float* constraint, global const uchar* cut, global float* marks)
{
  const real c = LOAD(constraint + s->self);
  const real held = LOAD(marks + s->self), strained = LOAD(marks + pitch + s->self);
  real nextHeld = held, nextStrained = strained;
  UNROLL
  for (int d = 0; d < 6; ++d)
  {
    const mask linked = linkLimit(c, neighbourConstraint(constraint, cut, s, d, s->odd)) < INFINITY;
    nextHeld = max(nextHeld, select((real)(0.0f), neighbour(marks, s, d, s->odd), linked));
    nextStrained = max(nextStrained, select((real)(0.0f), neighbour(marks + pitch, s, d, s->odd), linked));
  }
  const mask changed = (nextHeld != held) | (nextStrained != strained);
  if (SOME(changed))
  {
    STORE(nextHeld, marks + s->self);
    STORE(nextStrained, marks + pitch + s->self);
  }
  return movedFaces(s, changed);
}

// From link to link.
kernel void join(SPREAD_ARGUMENTS, uint pitch, global const int* table, global const int* place, int strideY,
  int strideZ, global const float* constraint, global const uchar* cut, global float* marks)
{
  SPREAD_TO
  SPREAD(joinAt(&s, pitch, constraint, cut, marks))
  if (lid == 0 && from != 0)
  {
    passOn(faces, slot, visits, log, turn, enough, table, place, strideY, strideZ);
  }
}

// Elements of other pieces back to where they were.
kernel void putBack(
  global const int* list, uint pitch, global const float* marks, global const float* before, global float* displacement)
{
  const uint slot = list[get_group_id(0)];
  for (int n = get_local_id(0); n < ELEMENTS; n += get_local_size(0))
  {
    const uint at = slot * ELEMENTS + n;
    if (marks[at] == 0.0f || marks[pitch + at] == 0.0f)
    {
      for (int axis = 0; axis < 3; ++axis)
      {
        displacement[axis * pitch + at] = before[axis * pitch + at];
      }
    }
  }
}
