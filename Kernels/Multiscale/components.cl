// Finds the tissue that coarser grids may move. A piece is a connected component of elements and links. Coarser grids
// may move it if an element in it is held and a link in it is strained. Other pieces are at rest as they are, or
// nothing holds them. But coarser grids cannot distinguish them from tissue close by.
//
// marks, bits of integers: PIECE_HELD, an element in the piece is held; PIECE_STRAINED, a link in it is strained. Many
// bricks are whole. For these the host determines which are in one piece.
//
// The host guarantees that all 26 neighbours of a brick that is ready have a slot (brick.clh).

#include "brick.clh"
#include "state.clh"
#include "element.clh"
#include "fixedpoint.clh"
#include "pieces.clh"

// Elements with a strained link in the state before the coarser grids.
CHAINMAIL_INLINE mask strainedOf(const int odd, const State* state, const Stencil* s)
{
  mask strained = (mask)(0);
  const real c = LOAD(state->constraint + s->self);
  UNROLL
  for (int d = 0; d < 6; ++d)
  {
    const mask linked = linkOf(c, neighbourConstraint(state, 0, s, d, odd), d, 0).exists;
    NO_UNROLL
    for (int axis = 0; axis < 3; ++axis)
    {
      global const float* u = displacementAlong(state, axis);
      strained |= linked & (neighbour(u, s, d, odd) != LOAD(u + s->self));
    }
  }
  return strained;
}

// Whether a work-item's share of a brick has a strained link.
NOINLINE bool anyStrained(const State* given, int lid, int items, uint slot)
{
  const State state = *given;
  bool any = false;
  for (int work = lid; !any && work < 2 * VECTORS; work += items)
  {
    const Stencil s = stencilOf(&state.layout, slot, work / VECTORS, work % VECTORS);
    mask displaced = (mask)(0);
    UNROLL
    for (int axis = 0; axis < 3; ++axis)
    {
      displaced |= LOAD(displacementAlong(&state, axis) + s.self) != 0.0f;
    }
    any = SOME(displaced) && SOME(strainedOf(s.odd, &state, &s));
  }
  return any;
}

// Finds whole bricks, without air or cuts. Such a brick is in one piece with all whole bricks that share a face with
// it. found[group] is PIECE_WHOLE with the combined marks of all elements of the brick, or 0 for other bricks.
kernel void wholes(global const int* list, STATE_ARGUMENTS, global int* found)
{
  const State state = STATE;
  local int divided, marks;
  const uint slot = list[get_group_id(0)];
  if (get_local_id(0) == 0)
  {
    divided = marks = 0;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  mask held = (mask)(0), some = (mask)(0);
  for (uint at = slot * ELEMENTS + get_local_id(0) * WIDTH; at < (slot + 1) * ELEMENTS; at += get_local_size(0) * WIDTH)
  {
    some |= LOAD(state.constraint + at) == -INFINITY;
#ifdef CUTS
    some |= LOAD_BYTES(state.cut + at) != 0;
#endif
    UNROLL
    for (int axis = 0; axis < AXES; ++axis)
    {
      held |= isHeld(LOAD(constraintAlong(&state, axis) + at));
    }
  }
  if (SOME(some))
  {
    atomic_or(&divided, 1);
  }
  else if (anyStrained(&state, get_local_id(0), get_local_size(0), slot))
  {
    atomic_or(&marks, PIECE_STRAINED);
  }
  if (SOME(held))
  {
    atomic_or(&marks, PIECE_HELD);
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (get_local_id(0) == 0)
  {
    found[get_group_id(0)] = divided ? 0 : PIECE_WHOLE | marks;
  }
}

// Marks all elements of bricks that coarser grids may move.
kernel void markAll(global const int* list, global int* marks)
{
  for (int n = get_local_id(0); n < ELEMENTS; n += get_local_size(0))
  {
    marks[list[get_group_id(0)] * ELEMENTS + n] = PIECE_HELD | PIECE_STRAINED;
  }
}

// Sets the initial marks of each element, from itself and its own links in the state before the coarser grids.
NOINLINE void markShare(const State* given, int lid, int items, uint slot, global int* marks)
{
  const State state = *given;
  for (int work = lid; work < 2 * VECTORS; work += items)
  {
    const Stencil s = stencilOf(&state.layout, slot, work / VECTORS, work % VECTORS);
    mask held = (mask)(0);
    UNROLL
    for (int axis = 0; axis < AXES; ++axis)
    {
      held |= isHeld(LOAD(constraintAlong(&state, axis) + s.self));
    }
    const mask strained = strainedOf(s.odd, &state, &s);
    const mask bits = select((mask)(0), (mask)(PIECE_HELD), held);
    STORE(bits | select((mask)(0), (mask)(PIECE_STRAINED), strained), marks + s.self);
  }
}

kernel void mark(global const int* list, STATE_ARGUMENTS, global int* marks)
{
  const State state = STATE;
  markShare(&state, get_local_id(0), get_local_size(0), list[get_group_id(0)], marks);
}

CHAINMAIL_INLINE int joinAt(const int odd, const State* state, const Stencil* s, global int* marks)
{
  const real c = LOAD(state->constraint + s->self);
  const mask mark = LOAD(marks + s->self);
  if (!SOME((mark != (PIECE_HELD | PIECE_STRAINED)) & (c != -INFINITY)))
  {
    return 0; // no mark is missing
  }
  mask next = mark;
  UNROLL
  for (int d = 0; d < 6; ++d)
  {
    const mask linked = linkOf(c, neighbourConstraint(state, 0, s, d, odd), d, 0).exists;
    next |= select((mask)(0), AS_MASK(neighbour((global const float*)marks, s, d, odd)), linked);
  }
  const mask changed = next != mark;
  if (SOME(changed))
  {
    STORE(next, marks + s->self);
  }
  return changedAround(s, changed);
}

NOINLINE void joinIn(const State* given, global int* marks, Launch launch, Visit visit)
{
  const State state = *given;
  FIXED_POINT(&state.layout, joinAt(s.odd, &state, &s, marks))
  passOn(&launch, &state.layout, &visit, faces);
}

// Spreads marks along links.
kernel void join(FIXED_POINT_ARGUMENTS, STATE_ARGUMENTS, global int* marks)
{
  const State state = STATE;
  FIXED_POINT_BEGIN(&state.layout)
  joinIn(&state, marks, launch, visit);
}

// Restores the state `before` of elements in pieces that coarser grids may not move.
kernel void putBack(
  global const int* list, uint pitch, global const int* marks, global const float* before, global float* displacement)
{
  const uint slot = list[get_group_id(0)];
  for (int n = get_local_id(0); n < ELEMENTS; n += get_local_size(0))
  {
    const uint at = slot * ELEMENTS + n;
    if (marks[at] != (PIECE_HELD | PIECE_STRAINED))
    {
      for (int axis = 0; axis < 3; ++axis)
      {
        displacement[axis * pitch + at] = before[axis * pitch + at];
      }
    }
  }
}
