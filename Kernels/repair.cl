// Makes a state feasible: `bound` finds min_j(u(j) + d(i, j)) and max_j(u(j) - d(i, j)) over all elements j, in place and
// in any order, `settle` takes their mean.
//
// The host guarantees: bricks of one launch do not touch each other, both bounds are the displacement at first,
// brick.clh's promise.

#include "brick.clh"
#include "element.clh"

kernel void bound(global const int* list, int rounds, uint pitch, global const int* table, global const int* place,
  int strideY, int strideZ, global const float* constraint, global const uchar* cut, global float* lower,
  global float* upper, global int* result)
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
        real c, cs[6], lowers[6], uppers[6];
        for (int axis = 0; axis < 3; ++axis)
        {
          if (axis < AXES)
          {
            c = LOAD(constraint + axis * pitch + s.self);
            loadConstraints(constraint + axis * pitch, cut, &s, cs);
          }
          loadNeighbours(lower + axis * pitch, &s, lowers);
          loadNeighbours(upper + axis * pitch, &s, uppers);
          const real l = LOAD(lower + axis * pitch + s.self);
          const real u = LOAD(upper + axis * pitch + s.self);
          real nextLower = l, nextUpper = u;
          for (int d = 0; d < 6; ++d)
          {
            const real limit = linkLimit(c, cs[d]);
            nextLower = max(nextLower, lowers[d] - limit);
            nextUpper = min(nextUpper, uppers[d] + limit);
          }
          const mask moved = (nextLower != l) | (nextUpper != u);
          if (SOME(moved))
          {
            STORE(nextLower, lower + axis * pitch + s.self);
            STORE(nextUpper, upper + axis * pitch + s.self);
            touched |= movedFaces(&s, moved);
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
