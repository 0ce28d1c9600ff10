// Propagation times of an envelope wave: for each element the length of the shortest path of links from the probe
// through elements that the wave moved. Times only decrease, so elements are updated in place, in any order.
//
// The host guarantees:
// - In the slots below `states`, `displacement` is the state after the wave and `before` the state before it.
// - Bricks in other slots got a state after the wave, so none of their elements moved. `before` is undefined there.
// - `arrival` starts as 0 at the probes' elements and as +infinity elsewhere.
// - All 26 neighbours of an updatable brick have a slot (brick.clh).
//
// |arrival| is the time. Its sign bit marks an element that did not move and so does not pass the wave on.

#include "brick.clh"
#include "state.clh"
#include "element.clh"
#include "fixedpoint.clh"

// What a wave reads and writes besides the state.
typedef struct
{
  global const float* before; // [axis][address]
  int states;
  global float* arrival; // [axis][address]
} Wave;

#define WAVE_ARGUMENTS global const float *before, int states, global float *arrival
#define WAVE                                                                                                           \
  {                                                                                                                    \
    before, states, arrival                                                                                            \
  }

CHAINMAIL_INLINE int arriveAt(const State* state, const Stencil* s, const Wave* wave, int mayHaveMoved)
{
  const uint pitch = state->layout.pitch;
  int touched = 0;
  UNROLL
  for (int axis = 0; axis < AXES; ++axis)
  {
    global float* const arrival = wave->arrival + axis * pitch;
    const real c = LOAD(constraintAlong(state, axis) + s->self);
    real next = (real)(INFINITY);
    UNROLL
    for (int d = 0; d < 6; ++d)
    {
      const Link link = linkOf(c, neighbourConstraint(state, axis, s, d, s->odd), d, axis);
      const real time = neighbour(arrival, s, d, s->odd);
      next = min(next, select(time + link.limit, (real)(INFINITY), AS_MASK(time) < 0));
    }
    const real time = LOAD(arrival + s->self);
    // Held elements keep their initial times: 0 for the wave's own probes, +infinity for others.
    const mask earlier = (next < fabs(time)) & ~isHeld(c);
    if (SOME(earlier))
    {
      mask moved = (mask)(0);
      for (int a = AXES == 1 ? 0 : axis; mayHaveMoved && a <= (AXES == 1 ? 2 : axis); ++a)
      {
        moved |= LOAD(displacementAlong(state, a) + s->self) != LOAD(wave->before + a * pitch + s->self);
      }
      STORE(select(time, select(-next, next, moved), earlier), arrival + s->self);
      // Elements that did not move pass nothing on. Bricks beyond them may be unallocated.
      touched |= changedAround(s, earlier & moved);
    }
  }
  return touched;
}

NOINLINE void arriveIn(const State* given, Wave wave, Launch launch, Visit visit)
{
  const State state = *given;
  const int mayHaveMoved = visit.slot < (uint)wave.states;
  FIXED_POINT(&state.layout, arriveAt(&state, &s, &wave, mayHaveMoved))
  passOn(&launch, &state.layout, &visit, faces, 0);
}

kernel void arrive(FIXED_POINT_ARGUMENTS, STATE_ARGUMENTS, WAVE_ARGUMENTS)
{
  const State state = STATE;
  const Wave wave = WAVE;
  FIXED_POINT_BEGIN(&state.layout)
  arriveIn(&state, wave, launch, visit);
}

// Writes the propagation times and the wave id `wave` of the elements that the wave reached.
kernel void record(
  global const int* list, uint pitch, global const float* arrival, int wave, global float* time, global int* front)
{
  const uint slot = list[get_group_id(0)];
  for (int axis = 0; axis < AXES; ++axis)
  {
    for (int n = get_local_id(0); n < ELEMENTS; n += get_local_size(0))
    {
      const uint at = axis * pitch + slot * ELEMENTS + n;
      const float t = fabs(arrival[at]);
      if (!isinf(t))
      {
        time[at] = t;
        front[at] = wave;
      }
    }
  }
}
