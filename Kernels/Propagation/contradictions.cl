// Finds rotations with which no state is feasible. Around a loop of links the differences u(j) - u(i) cancel out. So
// |sum of rest offsets| <= sum of limits has to hold there on every axis. Otherwise the bounds of feasibility.cl
// diverge. Only the smallest loops are tested, squares of four elements: in scans the contradictions show in them.
//
// The host guarantees: ROTATIONS; WIDTH is 1; all 26 neighbours of the listed bricks have a slot (brick.clh).

#include "brick.clh"
#include "state.clh"
#include "element.clh"
#include "rotations.clh"

// Sums over the links of a loop, for each axis.
typedef struct
{
  float strain[3];
  float limits[3];
} Loop;

CHAINMAIL_INLINE Loop noLinks(void)
{
  const Loop none = { { 0.0f, 0.0f, 0.0f }, { 0.0f, 0.0f, 0.0f } };
  return none;
}

// For a link between two neighbours along axis a: adds its limit, and `sign` (1 or -1) times its strain from the first
// to the second.
CHAINMAIL_INLINE void addLink(const State* state, uint first, uint second, int a, float sign, Loop* loop)
{
  const uint atRest = state->layout.pitch - SKEW; // see brick.clh
  const uint at[2] = { min(first, atRest), min(second, atRest) };
  float restOffsets[2][3];
  UNROLL
  for (int end = 0; end < 2; ++end)
  {
    const float own[3] = { spinAlong(state, 0)[at[end]], spinAlong(state, 1)[at[end]], spinAlong(state, 2)[at[end]] };
    restOffset(own, 2 * a + 1, state->proportions, restOffsets[end]);
  }
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    global const float* c = constraintAlong(state, min(axis, AXES - 1));
    global const float* u = displacementAlong(state, axis);
    const Link link = linkOf(c[first], c[second], 2 * a + 1, axis);
    const float difference = u[at[1]] - u[at[0]];
    loop->limits[axis] += link.limit;
    loop->strain[axis] +=
      link.rigid ? 0.0f : sign * (difference - 0.5f * (restOffsets[0][axis] + restOffsets[1][axis]));
  }
}

// Whether the four links of a square along axes a and b contradict each other; false where one is missing. `x`: the
// lowest corner.
CHAINMAIL_INLINE bool isContradicted(const State* state, int3 x, int a, int b)
{
  const Layout* const layout = &state->layout;
  const int3 alongA = (int3)(a == 0, a == 1, a == 2), alongB = (int3)(b == 0, b == 1, b == 2);
  const uint at[4] = { addressOf(layout, x), addressOf(layout, x + alongA), addressOf(layout, x + alongB),
    addressOf(layout, x + alongA + alongB) };
  for (int n = 0; n < 4; ++n)
  {
    if (isinf(state->constraint[at[n]]))
    {
      return false;
    }
  }
#ifdef CUTS
  const uchar upA = CUT_UP_BIT(a), upB = CUT_UP_BIT(b);
  if ((state->cut[at[0]] & (upA | upB)) || (state->cut[at[1]] & upB) || (state->cut[at[2]] & upA))
  {
    return false;
  }
#endif
  Loop loop = noLinks();
  addLink(state, at[0], at[1], a, 1.0f, &loop);
  addLink(state, at[1], at[3], b, 1.0f, &loop);
  addLink(state, at[2], at[3], a, -1.0f, &loop);
  addLink(state, at[0], at[2], b, -1.0f, &loop);
  bool is = false;
  for (int axis = 0; axis < 3; ++axis)
  {
    is |= fabs(loop.strain[axis]) > 1.0001f * loop.limits[axis] + 1e-5f; // more than rounding
  }
  return is;
}

// Whether an element's link along axis a exceeds its limit and belongs to a contradicted square. A square whose links
// are all within their limits cannot be contradicted.
CHAINMAIL_INLINE bool isInContradiction(const State* state, int3 x, int a)
{
  const int3 along = (int3)(a == 0, a == 1, a == 2);
  const uint first = addressOf(&state->layout, x), second = addressOf(&state->layout, x + along);
  if (isinf(state->constraint[first]) || isinf(state->constraint[second]))
  {
    return false;
  }
  Loop loop = noLinks(); // of this link alone
  addLink(state, first, second, a, 1.0f, &loop);
  if (fabs(loop.strain[0]) <= loop.limits[0] && fabs(loop.strain[1]) <= loop.limits[1] &&
      fabs(loop.strain[2]) <= loop.limits[2])
  {
    return false;
  }
  for (int b = 0; b < 3; ++b)
  {
    const int3 below = x - (int3)(b == 0, b == 1, b == 2);
    if (b != a && (isContradicted(state, x, a, b) || isContradicted(state, below, a, b)))
    {
      return true;
    }
  }
  return false;
}

// `found` is set to 1 for bricks with such links.
kernel void contradicted(global const int* list, STATE_ARGUMENTS, global int* found)
{
  const State state = STATE;
  const int3 origin = brickOf(&state.layout, list[get_group_id(0)]) * (int3)(BX, BY, BZ);
  for (int n = get_local_id(0); n < BX * BY * BZ; n += get_local_size(0))
  {
    const int3 x = origin + (int3)(n % BX, n / BX % BY, n / (BX * BY));
    for (int a = 0; a < 3; ++a)
    {
      if (isInContradiction(&state, x, a))
      {
        found[get_group_id(0)] = 1;
        return;
      }
    }
  }
}
