// One colour pass of a relaxation sweep: every free element goes to the over-relaxed weighted mean of the places that
// its neighbours ask for, within their boxes (element.clh). It works in place, since all neighbours have the other
// colour.
//
// With WAVES only the free elements that wavefronts.clh allows relax.
//
// The host guarantees: a work-group for each slot but 0; a feasible state; all 26 neighbours of a brick that is ready
// have a slot (brick.clh, sweep.clh).

#include "brick.clh"
#include "element.clh"
#include "sweep.clh"
#include "wavefronts.clh"

// Relaxes one piece of work and returns the largest move. `odd`: see BY_PARITY. Summing up neighbour by neighbour, for
// all axes at once, keeps the sums in registers.
RULE float relaxPiece(const int odd, const Site* s, float omega, float still, float slack, uint pitch, uint tissuePitch,
  global float* displacement, global const float* constraint, global const uchar* cut, int* faces WAVES_ARGUMENTS)
{
  real c[AXES], u[3];
  mask relaxes[AXES];
  Neighbours sums[3];
  UNROLL
  for (int axis = 0; axis < AXES; ++axis)
  {
    c[axis] = LOAD(constraint + axis * tissuePitch + s->self);
    relaxes[axis] = (c[axis] > 0.0f) & IS_STILL(axis, s);
  }
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    u[axis] = LOAD(displacement + axis * pitch + s->self);
    sums[axis] = noNeighbours();
  }
  UNROLL
  for (int d = 0; d < 6; ++d)
  {
    real limit, weight;
    UNROLL
    for (int axis = 0; axis < 3; ++axis)
    {
      if (axis < AXES)
      {
        limit = linkLimit(c[axis], neighbourConstraint(constraint + axis * tissuePitch, cut, s, d, odd));
        weight = linkWeight(limit);
        relaxes[axis] &= IS_OF_SAME_FRONT(axis, s, d, odd, limit);
      }
      neighboursAdd(&sums[axis], u[axis], neighbour(displacement + axis * pitch, s, d, odd), limit, weight, slack);
    }
  }
  real next[3];
  real move = (real)(0.0f);
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    next[axis] = select(u[axis], relaxedPlace(sums[axis], u[axis], omega, still), relaxes[min(axis, AXES - 1)]);
    move = max(move, fabs(next[axis] - u[axis]));
  }
  const float largest = largestOf(move);
  if (largest > 0.0f)
  {
    UNROLL
    for (int axis = 0; axis < 3; ++axis)
    {
      STORE(next[axis], displacement + axis * pitch + s->self);
    }
    *faces |= movedFaces(s, move > 0.0f);
  }
  return largest;
}

kernel void relax(SWEEP_ARGUMENTS, int colour, float omega, float still, float slack, LAYOUT_ARGUMENTS,
  global float* displacement, global const float* constraint, global const uchar* cut WAVES_ARGUMENTS)
{
  local Turn mine;
  const uint slot = get_group_id(0) + 1;
  beginSweepTurn(&mine, slot, colour, activity, log, turn, enough, table, place, strideY, strideZ);
  int touched = 0;
  float move = 0.0f;
  if (mine.has == TURN_HAS)
  {
    for (int work = get_local_id(0); work < VECTORS; work += get_local_size(0))
    {
      const Site s = siteOf(slot, colour, work, pitch, table, place, strideY, strideZ);
#define PIECE(odd)                                                                                                     \
  relaxPiece(odd, &s, omega, still, slack, pitch, tissuePitch, displacement, constraint, cut, &touched WAVES_PASSED_ON)
#ifdef UNLIMITED
      move = max(move, PIECE(s.odd)); // only few sweeps, which smooth what interpolation bent
#else
      move = max(move, BY_PARITY(PIECE, s));
#endif
#undef PIECE
    }
  }
  endSweepTurn(&mine, touched, move, slot, colour, activity, log, turn, enough);
}
