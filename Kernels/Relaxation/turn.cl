// One colour pass of a relaxation sweep in which elements turn. Each element first takes the rotation that its links
// have about it, then goes to the over-relaxed weighted mean of the places that its neighbours ask for, which are those
// at which the spins of both ends have the link on average (turning.clh). Both steps lower
//
//   E = 1/2 sum over links of W ( |u(j) - u(i) - (R(i) - I) h e|^2 + |u(j) - u(i) - (R(j) - I) h e|^2 ),
//
// the energy of as-rigid-as-possible surfaces (O. Sorkine and M. Alexa, Symposium on Geometry Processing 2007) on the
// links of a grid, with W = V / (h^2 D), V the volume of an element and h the length of the link. It costs nothing to
// turn tissue as a whole. Where nothing turns and elements are cubes it is the energy of relax.cl.
//
// The limits of links hold for the strain, |u(j) - u(i) - wanted| <= D, on every axis of the grid.
//
// The host guarantees what it does for relax.cl.

#include "brick.clh"
#include "element.clh"
#include "sweep.clh"
#include "turning.clh"

typedef struct
{
  real apart[3];    // u(j) - u(i)
  real theirs[3];   // what the neighbour's spin wants that to be
  real limit[AXES]; // of the link
} TurningLink;

// What a spin adds to each of the three axes.
RULE void axesTurned(const real* spin, real out[3][3])
{
  UNROLL
  for (int a = 0; a < 3; ++a)
  {
    turnedAxis(spin, a, out[a]);
  }
}

// The rotation, about the element's own turned axes, that brings it nearer to that of its links: a step of Jacobi and
// Newton. Rotations about two axes are coupled by shear only, and adding the most that this can come to makes sure that
// the energy falls. `mine` is what its spin adds to the three axes.
RULE void torqueOf(const TurningLink* links, real mine[3][3], float4 proportions, real* rotation)
{
  real torque[3], stiffness[3][3], strain[3];
  torque[0] = torque[1] = torque[2] = (real)(0.0f);
  real coupling = (real)(0.0f);
  UNROLL
  for (int a = 0; a < 3; ++a)
  {
    const float length = proportion(proportions, a);
    real pull[3], arm[3];
    UNROLL
    for (int b = 0; b < 3; ++b)
    {
      const float width = proportion(proportions, b);
      const real on = linkWeight(links[2 * a + 1].limit[min(b, AXES - 1)]);
      const real back = linkWeight(links[2 * a].limit[min(b, AXES - 1)]);
      arm[b] = a == b ? mine[a][b] + 1.0f : mine[a][b];
      pull[b] = on * (links[2 * a + 1].apart[b] * (width / length) - mine[a][b]) -
                back * (links[2 * a].apart[b] * (width / length) + mine[a][b]);
      stiffness[a][b] = on + back;
      coupling += 0.75f * fabs(pull[b]);
    }
    strain[a] = arm[0] * pull[0] + arm[1] * pull[1] + arm[2] * pull[2];
    torque[0] += arm[1] * pull[2] - arm[2] * pull[1];
    torque[1] += arm[2] * pull[0] - arm[0] * pull[2];
    torque[2] += arm[0] * pull[1] - arm[1] * pull[0];
  }
  UNROLL
  for (int c = 0; c < 3; ++c)
  {
    const int a = (c + 1) % 3, b = (c + 2) % 3;
    const real inertia = stiffness[a][b] + stiffness[b][a] + strain[a] + strain[b] + coupling;
    const real moment = mine[c][0] * torque[0] + mine[c][1] * torque[1] + mine[c][2] * torque[2] + torque[c];
    rotation[c] = select((real)(0.0f), moment / inertia, inertia > 0.0f);
  }
}

// How far a link's strain lies beyond its limit where the element's own spin has it as `mine` says.
RULE real beyondLimit(const TurningLink* link, int d, int axis, real mine, float ratio)
{
  const real strain = link->apart[axis] - 0.5f * (link->theirs[axis] + (d & 1 ? mine : -mine) * ratio);
  return fabs(strain) - link->limit[min(axis, AXES - 1)];
}

// Whether a spin, which adds `next` to the axes in place of `mine`, takes a link beyond its limit, or further beyond it
// than it is. Nearly all spins leave all links within their limits, which is found out first.
RULE mask goesBeyond(const TurningLink* links, real mine[3][3], real next[3][3], float4 proportions)
{
  mask beyond = (mask)(0);
  UNROLL
  for (int m = 0; m < 18; ++m)
  {
    const float ratio = proportion(proportions, m / 6) / proportion(proportions, m % 3);
    beyond |= beyondLimit(&links[m / 3], m / 3, m % 3, next[m / 6][m % 3], ratio) > 0.0f;
  }
  if (!SOME(beyond))
  {
    return beyond;
  }
  beyond = (mask)(0);
  UNROLL
  for (int m = 0; m < 18; ++m)
  {
    const float ratio = proportion(proportions, m / 6) / proportion(proportions, m % 3);
    const real now = beyondLimit(&links[m / 3], m / 3, m % 3, mine[m / 6][m % 3], ratio);
    const real then = beyondLimit(&links[m / 3], m / 3, m % 3, next[m / 6][m % 3], ratio);
    beyond |= (then > 0.0f) & (then > now);
  }
  return beyond;
}

// The share of the way from one spin to the next that all links allow, by linear estimate. It stops a little short of
// what they allow, for what the estimate leaves out.
RULE real shareWithin(const TurningLink* links, real mine[3][3], real next[3][3], float4 proportions)
{
  real share = (real)(1.0f);
  UNROLL
  for (int d = 0; d < 6; ++d)
  {
    UNROLL
    for (int axis = 0; axis < 3; ++axis)
    {
      const float ratio = proportion(proportions, d / 2) / proportion(proportions, axis);
      const real now = beyondLimit(&links[d], d, axis, mine[d / 2][axis], ratio);
      const real then = beyondLimit(&links[d], d, axis, next[d / 2][axis], ratio);
      const real allowed = 0.95f * min(now, (real)(0.0f)) / (now - then);
      share = select(share, min(share, allowed), (then > 0.0f) & (then > now));
    }
  }
  return share;
}

// Relaxes one piece of work and returns the largest move. `odd`: see BY_PARITY.
RULE float turnPiece(const int odd, const Site* s, float omega, float still, uint pitch, uint tissuePitch,
  global float* displacement, global const float* constraint, global const uchar* cut, int* faces SPIN_ARGUMENTS)
{
  real c[AXES], u[3], own[3], mine[3][3];
  mask relaxes[AXES];
  mask turns = (mask)(-1);
  TurningLink links[6];
  UNROLL
  for (int axis = 0; axis < AXES; ++axis)
  {
    c[axis] = LOAD(constraint + axis * tissuePitch + s->self);
    relaxes[axis] = c[axis] > 0.0f;
    turns &= c[axis] != 0.0f; // rigid elements turn with their clusters
  }
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    u[axis] = LOAD(displacement + axis * pitch + s->self);
    own[axis] = LOAD(spin + axis * pitch + s->self);
  }
  UNROLL
  for (int d = 0; d < 6; ++d)
  {
    real other[3];
    UNROLL
    for (int axis = 0; axis < AXES; ++axis)
    {
      links[d].limit[axis] = linkLimit(c[axis], neighbourConstraint(constraint + axis * tissuePitch, cut, s, d, odd));
    }
    UNROLL
    for (int axis = 0; axis < 3; ++axis)
    {
      links[d].apart[axis] = neighbour(displacement + axis * pitch, s, d, odd) - u[axis];
      other[axis] = neighbour(spin + axis * pitch, s, d, odd);
    }
    wantedApart(other, d, proportions, links[d].theirs);
  }
  axesTurned(own, mine);

  real rotation[3], next[3], turnedTo[3][3];
  torqueOf(links, mine, proportions, rotation);
  mask turning = (mask)(0);
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    turning |= turns & (fabs(rotation[axis]) > still);
    rotation[axis] *= omega;
  }
  spinAfter(own, rotation, next);
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    next[axis] = select(own[axis], next[axis], turning);
  }
  axesTurned(next, turnedTo);
#ifndef UNLIMITED
  const mask beyond = goesBeyond(links, mine, turnedTo, proportions);
  if (SOME(beyond))
  {
    const real share = shareWithin(links, mine, turnedTo, proportions);
    UNROLL
    for (int axis = 0; axis < 3; ++axis)
    {
      next[axis] = select(next[axis], own[axis] + share * (next[axis] - own[axis]), beyond);
    }
    axesTurned(next, turnedTo);
    const mask stays = goesBeyond(links, mine, turnedTo, proportions);
    UNROLL
    for (int axis = 0; axis < 3; ++axis)
    {
      next[axis] = select(next[axis], own[axis], stays);
    }
    axesTurned(next, turnedTo);
  }
#endif

  Neighbours sums[3];
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    sums[axis] = noNeighbours();
    UNROLL
    for (int d = 0; d < 6; ++d)
    {
      const float length = proportion(proportions, d / 2);
      const real limit = links[d].limit[min(axis, AXES - 1)];
      const real wanted = turnedTo[d / 2][axis] * (length / proportion(proportions, axis));
      const real place = u[axis] + (links[d].apart[axis] - 0.5f * (links[d].theirs[axis] + (d & 1 ? wanted : -wanted)));
      neighboursAdd(&sums[axis], u[axis], place, limit, linkWeight(limit) / (length * length), 0.0f);
    }
  }
  real move = (real)(0.0f);
  real nextPlace[3];
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    nextPlace[axis] = select(u[axis], relaxedPlace(sums[axis], u[axis], omega, still), relaxes[min(axis, AXES - 1)]);
    move = max(move, max(fabs(nextPlace[axis] - u[axis]), fabs(next[axis] - own[axis])));
  }
  const float largest = largestOf(move);
  if (largest > 0.0f)
  {
    UNROLL
    for (int axis = 0; axis < 3; ++axis)
    {
      STORE(nextPlace[axis], displacement + axis * pitch + s->self);
      STORE(next[axis], spin + axis * pitch + s->self);
    }
    *faces |= movedFaces(s, move > 0.0f);
  }
  return largest;
}

kernel void relaxTurning(SWEEP_ARGUMENTS, int colour, float omega, float still, LAYOUT_ARGUMENTS,
  global float* displacement, global const float* constraint, global const uchar* cut SPIN_ARGUMENTS)
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
  turnPiece(odd, &s, omega, still, pitch, tissuePitch, displacement, constraint, cut, &touched SPIN_PASSED_ON)
      move = max(move, BY_PARITY(PIECE, s));
#undef PIECE
    }
  }
  endSweepTurn(&mine, touched, move, slot, colour, activity, log, turn, enough);
}
