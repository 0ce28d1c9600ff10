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

// Products that are added are not rounded in between, where the device has an instruction for that. The compiler sees
// which from the text, so that results are the same in every brick.
#pragma OPENCL FP_CONTRACT ON

#include "element.clh"
#include "sweep.clh"
#include "turning.clh"

typedef struct
{
  real limit[6][AXES];
  real weight[6][AXES]; // by limit alone
  real gap[6][3];       // u(j) - u(i), less half of what the neighbour's spin wants that to be
  real pull[3][3];      // for each axis, the difference of weight * (u(j) - u(i)) of its two links
} TurningLinks;

// What a spin adds to each of the three axes.
RULE void axesTurned(const real* spin, real out[3][3])
{
  UNROLL
  for (int a = 0; a < 3; ++a)
  {
    turnedAxis(spin, a, out[a]);
  }
}

RULE void loadTurningLinks(const int odd, const Site* s, const real* c, const real* u, uint pitch, uint tissuePitch,
  global const float* displacement, global const float* constraint, global const uchar* cut,
  TurningLinks* links SPIN_ARGUMENTS)
{
  UNROLL
  for (int d = 0; d < 6; ++d)
  {
    const int a = d / 2;
    real other[3], theirs[3];
    UNROLL
    for (int axis = 0; axis < AXES; ++axis)
    {
      links->limit[d][axis] = linkLimit(c[axis], neighbourConstraint(constraint + axis * tissuePitch, cut, s, d, odd));
      links->weight[d][axis] = linkWeight(links->limit[d][axis]);
    }
    UNROLL
    for (int axis = 0; axis < 3; ++axis)
    {
      other[axis] = neighbour(spin + axis * pitch, s, d, odd);
    }
    turnedAxis(other, a, theirs);
    UNROLL
    for (int b = 0; b < 3; ++b)
    {
      const float ratio = proportion(proportions, a) / proportion(proportions, b);
      const real apart = neighbour(displacement + b * pitch, s, d, odd) - u[b];
      const real weight = links->weight[d][min(b, AXES - 1)];
      links->gap[d][b] = apart - (d & 1 ? 0.5f : -0.5f) * ratio * theirs[b];
      links->pull[a][b] = d & 1 ? weight * apart + links->pull[a][b] : -weight * apart;
    }
  }
}

// The rotation, about the element's own turned axes, that brings it nearer to that of its links: a step of Jacobi and
// Newton. `mine` is what its spin adds to the three axes. Where constraints are the same for all axes, a rotation s
// changes the energy by (s H s / 2 - moment s) / (1 + s^2 / 4), and adding what its rows have beside its diagonal to
// that of H makes sure that the energy falls; else H is an upper bound.
RULE void rotationOf(const TurningLinks* links, real mine[3][3], float4 proportions, real* rotation)
{
  real stiffness[3], arms[3][3];
  real torque[3][3]; // [b][a]: of the links along a, along the turned axis b
  UNROLL
  for (int m = 0; m < 9; ++m)
  {
    arms[m / 3][m % 3] = m / 3 == m % 3 ? mine[m / 3][m % 3] + 1.0f : mine[m / 3][m % 3];
  }
  UNROLL
  for (int a = 0; a < 3; ++a)
  {
    real pull[3];
    UNROLL
    for (int b = 0; b < 3; ++b)
    {
      const int axis = min(b, AXES - 1);
      const float ratio = proportion(proportions, b) / proportion(proportions, a);
      const real both = links->weight[2 * a][axis] + links->weight[2 * a + 1][axis];
      pull[b] = ratio * links->pull[a][b] - both * mine[a][b];
      stiffness[a] = b == 0 ? both : b < AXES ? max(stiffness[a], both) : stiffness[a];
    }
    UNROLL
    for (int b = 0; b < 3; ++b)
    {
      torque[b][a] = arms[b][0] * pull[0] + arms[b][1] * pull[1] + arms[b][2] * pull[2];
    }
  }
  UNROLL
  for (int c = 0; c < 3; ++c)
  {
    const int a = (c + 1) % 3, b = (c + 2) % 3;
    const real moment = torque[b][a] - torque[a][b];
    const real coupling = fabs(torque[a][c] + torque[c][a]) + fabs(torque[b][c] + torque[c][b]);
    const real inertia = stiffness[a] + stiffness[b] + torque[a][a] + torque[b][b] + 0.5f * coupling;
    const real size = max(inertia, fabs(moment)); // at most about a radian
    rotation[c] = select((real)(0.0f), moment / size, size > 0.0f);
  }
}

// By how much a link would be strained on an axis if the element's spin added `mine` to the axes of the grid. That is
// how far the link would have the element move.
RULE real strainOf(const TurningLinks* links, real mine[3][3], int d, int axis, float4 proportions)
{
  const float ratio = 0.5f * (proportion(proportions, d / 2) / proportion(proportions, axis));
  return links->gap[d][axis] - (d & 1 ? ratio : -ratio) * mine[d / 2][axis];
}

typedef struct
{
  real weight[AXES]; // sum of W
  real pull[3];      // sum of W * strain
  real room;         // how far the element may move at least, whichever way; negative where a link is beyond its limit
} TurningNeighbours;

RULE TurningNeighbours askNeighbours(const TurningLinks* links, real mine[3][3], float4 proportions)
{
  TurningNeighbours all;
  all.room = (real)(INFINITY);
  UNROLL
  for (int d = 0; d < 6; ++d)
  {
    const float length = proportion(proportions, d / 2);
    real most[AXES];
    UNROLL
    for (int b = 0; b < 3; ++b)
    {
      const int axis = min(b, AXES - 1);
      const real strain = strainOf(links, mine, d, b, proportions);
      const real weight = links->weight[d][axis] * (1.0f / (length * length));
      all.pull[b] = d == 0 ? weight * strain : weight * strain + all.pull[b];
      all.weight[axis] = d == 0 ? weight : b < AXES ? all.weight[axis] + weight : all.weight[axis];
      most[axis] = b < AXES ? fabs(strain) : max(most[axis], fabs(strain));
    }
    UNROLL
    for (int axis = 0; axis < AXES; ++axis)
    {
      all.room = min(all.room, links->limit[d][axis] - most[axis]);
    }
  }
  return all;
}

#define STAY -0.0f // added to any number it leaves all bits as they are

#ifndef UNLIMITED
// The share of the way from one spin to the next that all links allow, by linear estimate. It stops a little short of
// what they allow, for what the estimate leaves out.
RULE real shareWithin(const TurningLinks* links, real mine[3][3], real next[3][3], float4 proportions)
{
  real share = (real)(1.0f);
  UNROLL
  for (int m = 0; m < 18; ++m)
  {
    const int d = m / 3, axis = m % 3;
    const real limit = links->limit[d][min(axis, AXES - 1)];
    const real now = fabs(strainOf(links, mine, d, axis, proportions)) - limit;
    const real then = fabs(strainOf(links, next, d, axis, proportions)) - limit;
    const real allowed = 0.95f * min(now, (real)(0.0f)) / (now - then);
    share = select(share, min(share, allowed), (then > 0.0f) & (then > now));
  }
  return share;
}

// Shortens a turn that would take links beyond their limits, or further beyond them than they are. For all other
// elements nothing changes. `beyond`: where the turn as it is leaves no room.
RULE void turnWithin(const TurningLinks* links, const real* own, real mine[3][3], float4 proportions, mask beyond,
  real* next, real turnedTo[3][3], TurningNeighbours* all)
{
  const real least = min(askNeighbours(links, mine, proportions).room, (real)(0.0f));
  beyond &= all->room < least;
  for (int attempt = 0; attempt < 2 && SOME(beyond); ++attempt)
  {
    const real share = attempt == 0 ? shareWithin(links, mine, turnedTo, proportions) : (real)(0.0f);
    UNROLL
    for (int axis = 0; axis < 3; ++axis)
    {
      next[axis] = select(next[axis], own[axis] + share * (next[axis] - own[axis]), beyond);
    }
    axesTurned(next, turnedTo);
    *all = askNeighbours(links, turnedTo, proportions);
    beyond &= all->room < least;
  }
}

// Keeps moves within the boxes of all links. Where rounding leaves these no common point the element stays.
RULE void moveWithin(const TurningLinks* links, real mine[3][3], float4 proportions, real* move)
{
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    real lower = (real)(-INFINITY), upper = (real)(INFINITY);
    UNROLL
    for (int d = 0; d < 6; ++d)
    {
      const real limit = links->limit[d][min(axis, AXES - 1)];
      const real strain = strainOf(links, mine, d, axis, proportions);
      lower = max(lower, strain - limit);
      upper = min(upper, strain + limit);
    }
    const real within = min(max(move[axis], lower), upper);
    move[axis] = select((real)(STAY), within, (move[axis] != 0.0f) & (lower <= upper));
  }
}
#endif

// Relaxes one piece of work and returns the largest move. `odd`: see BY_PARITY.
RULE float turnPiece(const int odd, const Site* s, float omega, float still, uint pitch, uint tissuePitch,
  global float* displacement, global const float* constraint, global const uchar* cut, int* faces SPIN_ARGUMENTS)
{
  real c[AXES], u[3], own[3], mine[3][3];
  mask relaxes[AXES];
  mask does = (mask)(0), turns = (mask)(-1);
  TurningLinks links;
  UNROLL
  for (int axis = 0; axis < AXES; ++axis)
  {
    c[axis] = LOAD(constraint + axis * tissuePitch + s->self);
    relaxes[axis] = c[axis] > 0.0f;
    turns &= (c[axis] != 0.0f) & (c[axis] != -INFINITY); // rigid elements turn with their clusters
    does |= relaxes[axis];
  }
  if (!SOME(does | turns))
  {
    return 0.0f;
  }
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    u[axis] = LOAD(displacement + axis * pitch + s->self);
    own[axis] = LOAD(spin + axis * pitch + s->self);
  }
  loadTurningLinks(odd, s, c, u, pitch, tissuePitch, displacement, constraint, cut, &links SPIN_PASSED_ON);
  axesTurned(own, mine);

  real rotation[3], next[3], turnedTo[3][3];
  rotationOf(&links, mine, proportions, rotation);
  mask turning = (mask)(0);
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    turning |= turns & (fabs(rotation[axis]) > still);
  }
  spinAfter(own, rotation, next);
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    next[axis] = select(own[axis], next[axis], turning);
  }
  axesTurned(next, turnedTo);

  TurningNeighbours all = askNeighbours(&links, turnedTo, proportions);
#ifndef UNLIMITED
  const mask beyond = turning & (all.room < 0.0f);
  if (SOME(beyond))
  {
    turnWithin(&links, own, mine, proportions, beyond, next, turnedTo, &all);
  }
#endif
  real move[3];
  mask far = (mask)(0);
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    const int which = min(axis, AXES - 1);
    const real residual = all.pull[axis] * (1.0f / all.weight[which]);
    // An element without links does not move, as its residual compares false.
    move[axis] = select((real)(STAY), omega * residual, relaxes[which] & (fabs(residual) > still));
    far |= fabs(move[axis]) > all.room;
  }
#ifndef UNLIMITED
  if (SOME(far))
  {
    moveWithin(&links, turnedTo, proportions, move);
  }
#endif
  real moved = (real)(0.0f);
  real nextPlace[3];
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    nextPlace[axis] = u[axis] + move[axis];
    moved = max(moved, max(fabs(nextPlace[axis] - u[axis]), fabs(next[axis] - own[axis])));
  }
  const float largest = largestOf(moved);
  if (largest > 0.0f)
  {
    UNROLL
    for (int axis = 0; axis < 3; ++axis)
    {
      STORE(nextPlace[axis], displacement + axis * pitch + s->self);
      STORE(next[axis], spin + axis * pitch + s->self);
    }
    *faces |= movedFaces(s, moved > 0.0f);
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
