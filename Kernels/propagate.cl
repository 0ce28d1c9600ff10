// A wave through the tissue: every element into the bounds that the moved ones around it set (element.clh), until
// nothing in the brick changes. In place, in any order: raised values only grow and lowered ones only fall.
//
// After the first pass over the brick only pieces of work beside ones that moved in the pass before are looked at again:
// a wave front is thin.
//
// The host guarantees: bricks of one launch do not touch each other (one parity of the brick grid), `before` is a
// feasible state, moved tissue differs from it or is held, brick.clh's promise.
//
// result[group * 7]: faces that moved elements touch (movedFaces; 128 more where the rounds did not suffice), then for
// each axis how much too high and too low the moved tissue is for what is held, as the bits of floats.

#include "brick.clh"
#include "element.clh"

kernel void propagate(global const int* list, int rounds, uint pitch, global const int* table, global const int* place,
  int strideY, int strideZ, global float* displacement, global const float* before, global const float* constraint,
  global const uchar* cut, global int* result)
{
  local int changed;
  local int faces;
  local int conflict[6];
  local int movedIn[2 * VECTORS]; // the pass in which a piece of work last moved
  const int lid = get_local_id(0);
  const uint slot = list[get_group_id(0)];
  if (lid == 0)
  {
    faces = 0;
    for (int n = 0; n < 6; ++n)
    {
      conflict[n] = 0;
    }
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
        real c, cs[6], us[6], u0s[6];
        for (int axis = 0; axis < 3; ++axis)
        {
          if (axis < AXES)
          {
            c = LOAD(constraint + axis * pitch + s.self);
            loadConstraints(constraint + axis * pitch, cut, &s, cs);
          }
          loadNeighbours(displacement + axis * pitch, &s, us);
          loadNeighbours(before + axis * pitch, &s, u0s);
          Envelope e = { (real)(-INFINITY), (real)(INFINITY), (real)(-INFINITY), (real)(INFINITY) };
          for (int d = 0; d < 6; ++d)
          {
            envelopeAdd(&e, us[d], u0s[d], signbit(cs[d]), linkLimit(c, cs[d]));
          }
          const real u = LOAD(displacement + axis * pitch + s.self);
          const real u0 = LOAD(before + axis * pitch + s.self);
          const mask held = signbit(c);
          const real next = select(envelopeClamp(e, u0), u, held);
          const float tooHigh = largestOf(envelopeTooHigh(e, u, held));
          const float tooLow = largestOf(envelopeTooLow(e, u, held));
          if (tooHigh > 0.0f)
          {
            atomic_max(&conflict[2 * axis], as_int(tooHigh));
          }
          if (tooLow > 0.0f)
          {
            atomic_max(&conflict[2 * axis + 1], as_int(tooLow));
          }
          const mask moved = next != u;
          if (SOME(moved))
          {
            STORE(next, displacement + axis * pitch + s.self);
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
    global int* row = result + get_group_id(0) * 7;
    row[0] = faces | (more ? 128 : 0);
    for (int n = 0; n < 6; ++n)
    {
      row[1 + n] = conflict[n];
    }
  }
}
