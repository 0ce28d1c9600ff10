// Finds the pieces of tissue that coarser grids may move. A piece is a connected component of elements and links; it
// may be moved where an element in it is held and a link in it is strained. Other pieces are at rest as they are, or
// follow nothing, but coarser grids cannot tell them from tissue close by.
//
// marks: HELD where an element in the piece is held, STRAINED where a link in it is strained. Bits of integers.
//
// The host guarantees that all 26 neighbours of a brick that is ready have a slot (brick.clh).

#include "brick.clh"
#include "element.clh"
#include "fixedpoint.clh"

#define HELD 1
#define STRAINED 2

// Marks elements for themselves and their own links, from their displacements before the coarser grids.
RULE mask markOf(const int odd, const Site* s, uint pitch, uint tissuePitch, global const float* displacement,
  global const float* constraint, global const uchar* cut)
{
  mask held = (mask)(0), strained = (mask)(0);
  UNROLL
  for (int axis = 0; axis < AXES; ++axis)
  {
    held |= isHeld(LOAD(constraint + axis * tissuePitch + s->self));
  }
  const real c = LOAD(constraint + s->self);
  UNROLL
  for (int d = 0; d < 6; ++d)
  {
    const mask linked = linkLimit(c, neighbourConstraint(constraint, cut, s, d, odd)) < INFINITY;
    ROLLED
    for (int axis = 0; axis < 3; ++axis)
    {
      global const float* u = displacement + axis * pitch;
      strained |= linked & (neighbour(u, s, d, odd) != LOAD(u + s->self));
    }
  }
  return select((mask)(0), (mask)(HELD), held) | select((mask)(0), (mask)(STRAINED), strained);
}

APART void markShare(int lid, int items, uint slot, LAYOUT_ARGUMENTS, global const float* displacement,
  global const float* constraint, global const uchar* cut, global int* marks)
{
  for (int work = lid; work < 2 * VECTORS; work += items)
  {
    const Site s = siteOf(slot, work / VECTORS, work % VECTORS, pitch, table, place, strideY, strideZ);
    const mask mark = markOf(s.odd, &s, pitch, tissuePitch, displacement, constraint, cut);
    STORE(mark, marks + s.self);
  }
}

kernel void mark(global const int* list, LAYOUT_ARGUMENTS, global const float* displacement,
  global const float* constraint, global const uchar* cut, global int* marks)
{
  markShare(get_local_id(0), get_local_size(0), list[get_group_id(0)], pitch, tissuePitch, table, place, strideY,
    strideZ, displacement, constraint, cut, marks);
}

RULE int joinAt(
  const int odd, const Site* s, global const float* constraint, global const uchar* cut, global int* marks)
{
  const real c = LOAD(constraint + s->self);
  const mask mark = LOAD(marks + s->self);
  mask next = mark;
  UNROLL
  for (int d = 0; d < 6; ++d)
  {
    const mask linked = linkLimit(c, neighbourConstraint(constraint, cut, s, d, odd)) < INFINITY;
    next |= select((mask)(0), AS_MASK(neighbour((global const float*)marks, s, d, odd)), linked);
  }
  const mask changed = next != mark;
  if (SOME(changed))
  {
    STORE(next, marks + s->self);
  }
  return changedAround(s, changed);
}

APART void joinIn(IN_BRICK_ARGUMENTS, FIXED_POINT_ARGUMENTS, LAYOUT_ARGUMENTS, global const float* constraint,
  global const uchar* cut, global int* marks)
{
  FIXED_POINT(joinAt(s.odd, &s, constraint, cut, marks))
  if (lid == 0 && from != 0)
  {
    passOn(faces, slot, visits, log, turn, enough, table, place, strideY, strideZ);
  }
}

// Spreads marks from link to link.
kernel void join(
  FIXED_POINT_ARGUMENTS, LAYOUT_ARGUMENTS, global const float* constraint, global const uchar* cut, global int* marks)
{
  FIXED_POINT_BEGIN
  joinIn(
    IN_BRICK, visits, log, turn, enough, pitch, tissuePitch, table, place, strideY, strideZ, constraint, cut, marks);
}

// Puts elements of all other pieces back to where they were.
kernel void putBack(
  global const int* list, uint pitch, global const int* marks, global const float* before, global float* displacement)
{
  const uint slot = list[get_group_id(0)];
  for (int n = get_local_id(0); n < ELEMENTS; n += get_local_size(0))
  {
    const uint at = slot * ELEMENTS + n;
    if (marks[at] != (HELD | STRAINED))
    {
      for (int axis = 0; axis < 3; ++axis)
      {
        displacement[axis * pitch + at] = before[axis * pitch + at];
      }
    }
  }
}
