// Compromise between many incompatible handles (Sharing.h): bounds of shifts (bounds.clh), whose means the host takes.
// Held elements get bounds of 0 (holdBounds). Around them, bounds spread from these zeros replace those that handles
// request beyond what held tissue allows.
//
// The host guarantees: all 26 neighbours of an updatable brick have a slot (brick.clh).

#define BOUNDS_OF_SHIFTS
#define MARGIN

#include "bounds.clh"

// Resets the bounds of held elements in the listed bricks to 0. `found` is set to 1 for bricks where one was not 0.
kernel void holdBounds(global const int* list, uint pitch, uint tissuePitch, global const float* constraint,
  global float* lower, global float* upper, global int* found)
{
  const uint first = list[get_group_id(0)] * ELEMENTS;
  for (int axis = 0; axis < 3; ++axis)
  {
    for (uint n = first + get_local_id(0); n < first + ELEMENTS; n += get_local_size(0))
    {
      const uint at = axis * pitch + n;
      if (signbit(constraint[min(axis, AXES - 1) * tissuePitch + n]) && (lower[at] != 0.0f || upper[at] != 0.0f))
      {
        lower[at] = 0.0f;
        upper[at] = 0.0f;
        found[get_group_id(0)] = 1;
      }
    }
  }
}
