// One colour pass of a relaxation sweep: every free element goes to the over-relaxed weighted mean of the places that
// its neighbours ask for, within their boxes (element.clh). It works in place, since all neighbours have the other
// colour.
//
// `limited`: whether boxes count. It is no macro, as both kinds take long to compile.
//
// With WAVES only the free elements that wavefronts.clh allows relax.
//
// The host guarantees: a work-group for each slot but 0; a feasible state; all 26 neighbours of a brick that is ready
// have a slot (brick.clh, sweep.clh).

#include "brick.clh"
#include "element.clh"
#include "sweep.clh"
#include "turning.clh"
#include "wavefronts.clh"

#include "halo.clh"

// A little less than a link's limit. The rounding of differences is far below what is left out.
#define ALMOST 0.999999f

// Keeps the steps that go far within the boxes of all links, where neighboursAdd() and relaxedPlace() of element.clh
// have them. Loops that stay loops leave the registers to the sums, with which most pieces end.
RULE void stepWithin(const Site* s, const Beside* beside, const real* c, global const uchar* cut, const real* u,
  const mask* far, real* next)
{
  real cs[AXES], us[3], places[3];
  mask fars[3];
  const Beside lying = *beside; // only loops need it in memory
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    cs[min(axis, AXES - 1)] = c[min(axis, AXES - 1)];
    us[axis] = u[axis];
    fars[axis] = far[axis];
    places[axis] = next[axis];
  }
  ROLLED
  for (int axis = 0; axis < 3; ++axis)
  {
    if (!SOME(fars[axis]))
    {
      continue;
    }
    const int which = min(axis, AXES - 1);
    real lower = (real)(-INFINITY), upper = (real)(INFINITY);
    ROLLED
    for (int d = 0; d < 6; ++d)
    {
      const real limit = linkLimit(cs[which], linkedConstraint(&lying, cut, s, which, d));
      const real place = displacementBeside(&lying, axis, d);
      lower = max(lower, place - limit);
      upper = min(upper, place + limit);
    }
    const real within = min(max(places[axis], lower), upper);
    places[axis] = select(places[axis], select(us[axis], within, lower <= upper), fars[axis]);
  }
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    next[axis] = places[axis];
  }
}

// Relaxes one piece of work and notes the largest moves: as neighboursAdd() and relaxedPlace() of element.clh say, but
// only where an element would come near the limit of a link along an axis its box is looked at.
RULE void relaxPiece(const Site* s, const Beside* beside, float omega, float still, float slack, int limited,
  uint pitch, uint tissuePitch, global float* displacement, global const float* constraint, global const uchar* cut,
  real* most, int* faces WAVES_ARGUMENTS)
{
  real c[AXES], weights[AXES], room[3], u[3], pull[3];
  mask relaxes[AXES], free = (mask)(0);
  UNROLL
  for (int axis = 0; axis < AXES; ++axis)
  {
    c[axis] = LOAD(constraint + axis * tissuePitch + s->self);
    relaxes[axis] = (c[axis] > 0.0f) & IS_STILL(axis, s);
    free |= relaxes[axis];
    weights[axis] = (real)(0.0f);
  }
  if (!SOME(free))
  {
    return;
  }
  const float almost = limited ? ALMOST : INFINITY;
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    u[axis] = LOAD(displacement + axis * pitch + s->self);
    pull[axis] = (real)(0.0f);
    room[axis] = (real)(INFINITY);
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
        limit = linkLimit(c[axis], linkedConstraint(beside, cut, s, axis, d));
        weight = linkWeight(limit);
        weights[axis] += weight;
        relaxes[axis] &= IS_OF_SAME_FRONT(axis, s, d, s->odd, limit);
      }
      const real other = displacementBeside(beside, axis, d);
      const real apart = fabs(other - u[axis]);
      pull[axis] += weight * linkPull(u[axis], other, limit, slack);
      room[axis] = min(room[axis], almost * limit - apart);
    }
  }
  real next[3];
  mask far[3], anyFar = (mask)(0);
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    const int which = min(axis, AXES - 1);
    const real residual = pull[axis] / weights[which];
    const real step = select((real)(STAY), omega * residual, relaxes[which] & (fabs(residual) > still));
    next[axis] = u[axis] + step;
    far[axis] = fabs(step) > max(room[axis], 0.0f);
    anyFar |= far[axis];
  }
  if (SOME(anyFar))
  {
    stepWithin(s, beside, c, cut, u, far, next);
  }
  real move = (real)(0.0f);
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    move = max(move, fabs(next[axis] - u[axis]));
  }
  if (SOME(move > 0.0f))
  {
    UNROLL
    for (int axis = 0; axis < 3; ++axis)
    {
      STORE_WHOLE(next[axis], displacement + axis * pitch + s->self);
    }
    *faces |= movedFaces(s, move > 0.0f);
    *most = max(*most, move);
  }
}

// Relaxes the share of one of `items` work-items in a brick and returns the largest move. `last` is the last slot.
APART float relaxShare(int lid, int items, uint slot, uint last, int colour, float omega, float still, float slack,
  int limited, LAYOUT_ARGUMENTS, global float* displacement, global const float* constraint, global const uchar* cut,
  int* faces WAVES_ARGUMENTS)
{
  HALO(halo);
  real most = (real)(0.0f);
  for (int work = lid; work < VECTORS; work += items)
  {
    const Site s = siteOf(slot, colour, work, pitch, table, place, strideY, strideZ);
    const Beside beside = besideOf(
      halo, &s, slot, last, colour, pitch, tissuePitch, table, place, strideY, strideZ, displacement, constraint);
    relaxPiece(&s, &beside, omega, still, slack, limited, pitch, tissuePitch, displacement, constraint, cut, &most,
      faces WAVES_PASSED_ON);
  }
  return largestOf(most);
}

kernel void relax(SWEEP_ARGUMENTS, int colour, float omega, float still, float slack, int limited, LAYOUT_ARGUMENTS,
  global float* displacement, global const float* constraint, global const uchar* cut WAVES_ARGUMENTS)
{
  local Turn mine;
  const uint slot = get_group_id(0) + 1;
  beginSweepTurn(&mine, slot, colour, turn.z - 1, activity, log, turn, enough, table, place, strideY, strideZ);
  int touched = 0;
  float move = 0.0f;
  if (mine.has == TURN_HAS)
  {
    move = relaxShare(get_local_id(0), get_local_size(0), slot, get_num_groups(0), colour, omega, still, slack, limited,
      pitch, tissuePitch, table, place, strideY, strideZ, displacement, constraint, cut, &touched WAVES_PASSED_ON);
  }
  endSweepTurn(&mine, touched, move, slot, colour, SWEEP_EVER, activity, log, turn, enough);
}
