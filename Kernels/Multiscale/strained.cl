// Which bricks have a strained link.
//
// The host guarantees that all 26 neighbours of a brick that is ready have a slot (brick.clh).

#include "brick.clh"
#include "state.clh"
#include "element.clh"

// Elements with a strained link.
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

// found[group]: whether an element of the brick has a strained link.
kernel void strained(global const int* list, STATE_ARGUMENTS, global int* found)
{
  const State state = STATE;
  local int any;
  if (get_local_id(0) == 0)
  {
    any = 0;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (anyStrained(&state, get_local_id(0), get_local_size(0), list[get_group_id(0)]))
  {
    atomic_or(&any, 1);
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (get_local_id(0) == 0)
  {
    found[get_group_id(0)] = any;
  }
}
