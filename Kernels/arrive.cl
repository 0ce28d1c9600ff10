// When an envelope wave came to each element: the length of the shortest path of links from the probe through elements
// that the wave moved. In place, in any order: times only fall.
//
// The host guarantees: bricks of one launch do not touch each other, `before` is the state in front of the wave and
// `displacement` the one behind it, `arrival` is 0 at the probes and else +infinity at first, brick.clh's promise.
//
// arrival: the time; its sign bit is set where the element did not move and so does not pass the wave on.

#include "brick.clh"
#include "element.clh"

kernel void arrive(global const int* list, int rounds, uint pitch, global const int* table, global const int* place,
  int strideY, int strideZ, global const float* displacement, global const float* before,
  global const float* constraint, global const uchar* cut, global float* arrival, global int* result)
{
  local int changed;
  local int faces;
  local int movedIn[2 * VECTORS];
  const int lid = get_local_id(0);
  const uint slot = list[get_group_id(0)];
  if (lid == 0)
  {
    faces = 0;
  }
  for (int work = lid; work < 2 * VECTORS; work += get_local_size(0))
  {
    movedIn[work] = -1;
  }
  int more = 1;
  for (int round = 0; more && round < rounds; ++round)
  {
    barrier(CLK_LOCAL_MEM_FENCE);
    if (lid == 0)
    {
      changed = 0;
    }
    for (int colour = 0; colour < 2; ++colour)
    {
      barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
      for (int work = lid; work < VECTORS; work += get_local_size(0))
      {
        const int pass = 2 * round + colour;
        if (round > 0 && !besideMoved(movedIn + (1 - colour) * VECTORS, work, pass - 1))
        {
          continue;
        }
        const Site s = siteOf(slot, colour, work, table, place, strideY, strideZ);
        int touched = 0;
        for (int axis = 0; axis < AXES; ++axis)
        {
          real cs[6], times[6];
          const real c = LOAD(constraint + axis * pitch + s.self);
          loadConstraints(constraint + axis * pitch, cut, &s, cs);
          loadNeighbours(arrival + axis * pitch, &s, times);
          real next = (real)(INFINITY);
          for (int d = 0; d < 6; ++d)
          {
            next = min(next, select(times[d] + linkLimit(c, cs[d]), (real)(INFINITY), signbit(times[d])));
          }
          const real time = LOAD(arrival + axis * pitch + s.self);
          // Held elements keep theirs: 0 for the wave's own probes, none for others.
          const mask earlier = (next < fabs(time)) & ~signbit(c);
          if (SOME(earlier))
          {
            mask moved = (mask)(0);
            for (int a = AXES == 1 ? 0 : axis; a <= (AXES == 1 ? 2 : axis); ++a)
            {
              moved |= LOAD(displacement + a * pitch + s.self) != LOAD(before + a * pitch + s.self);
            }
            STORE(select(time, select(-next, next, moved), earlier), arrival + axis * pitch + s.self);
            // Who did not move has nothing to pass on; beyond there may be no brick yet.
            touched |= movedFaces(&s, earlier & moved);
          }
        }
        if (touched)
        {
          atomic_or(&faces, touched);
          atomic_or(&changed, 1);
          movedIn[colour * VECTORS + work] = pass;
        }
      }
    }
    barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
    more = changed;
  }
  if (lid == 0)
  {
    result[get_group_id(0)] = faces | (more ? 128 : 0);
  }
}

// Writes the times and the wave's number where it came.
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
