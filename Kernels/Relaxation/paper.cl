// One iteration of the published relaxation (PaperRelaxation.h): a Jacobi iteration without limits. Every element that
// is not held moves to the weighted mean of the target places of its links (element.clh). The kernel reads one copy of
// the displacements and writes the other.
//
// With WAVES only the elements that wavefronts.clh allows relax. With SOFT soft links count (softlinks.clh).
//
// The host guarantees: a work-group for each slot except 0; all 26 neighbours of a brick that is ready have a slot
// (brick.clh, sweep.clh); both copies are equal at first. Later both copies are equal in every brick that is not
// visited: after the last visit in which elements of it moved, a brick is visited once more.

#include "brick.clh"
#include "element.clh"
#include "softlinks.clh"
#include "sweep.clh"
#include "wavefronts.clh"

kernel void relaxAll(SWEEP_ARGUMENTS, int kind, float still, float slack, LAYOUT_ARGUMENTS,
  global const float* displacement, global float* after, global const float* constraint,
  global const uchar* cut WAVES_ARGUMENTS SOFT_ARGUMENTS)
{
  local Turn mine;
  const uint slot = get_group_id(0) + 1;
  beginSweepTurn(&mine, slot, kind, turn.z - 1, activity, log, turn, enough, table, place, strideY, strideZ);
  int touched = 0;
  float move = 0.0f;
  for (int colour = 0; mine.has == TURN_HAS && colour < 2; ++colour)
  {
    for (int work = get_local_id(0); work < VECTORS; work += get_local_size(0))
    {
      const Stencil s = stencilOf(slot, colour, work, pitch, table, place, strideY, strideZ);
      real limit[6], weight[6], us[6];
#ifdef SOFT
      real softWeight, softPlaces[3];
      const bool soft = loadSoftLinks(&s, place SOFT_PASSED_ON, &softWeight, softPlaces);
#endif
      mask relaxes;
      for (int axis = 0; axis < 3; ++axis)
      {
        if (axis < AXES)
        {
          const real c = LOAD(constraint + axis * tissuePitch + s.self);
          loadConstraints(constraint + axis * tissuePitch, cut, &s, limit);
          relaxes = (!signbit(c)) & IS_STILL(axis, &s);
          for (int d = 0; d < 6; ++d)
          {
            limit[d] = linkLimit(c, limit[d]);
            weight[d] = linkWeight(limit[d]);
            relaxes &= IS_OF_SAME_FRONT(axis, &s, d, s.odd, limit[d]);
          }
        }
        const real u = LOAD(displacement + axis * pitch + s.self);
        loadNeighbours(displacement + axis * pitch, &s, us);
        Neighbours n = noNeighbours();
        for (int d = 0; d < 6; ++d)
        {
          neighboursAdd(&n, u, us[d], limit[d], weight[d], slack);
        }
#ifdef SOFT
        if (soft)
        {
          neighboursAddSoft(&n, u, softPlaces[axis], SOFT_FACTOR(axis) * softWeight);
        }
#endif
        // Limits do not apply.
        n.lower = (real)(-INFINITY);
        n.upper = (real)(INFINITY);
        const real next = select(u, relaxedPlace(n, u, 1.0f, still), relaxes);
        STORE(next, after + axis * pitch + s.self);
        const mask moved = next != u;
        if (SOME(moved))
        {
          touched |= movedFaces(&s, moved);
          move = max(move, largestOf(fabs(next - u)));
        }
      }
    }
  }
  endSweepTurn(&mine, touched, move, slot, kind, SWEEP_EVER, activity, log, turn, enough);
}
