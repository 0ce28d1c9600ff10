// One colour pass of a relaxation sweep in which elements rotate. Each element i first rotates towards the rotation
// that its links have about it. Then it moves to the over-relaxed weighted mean of the target places of its links. The
// target of a link is the mean of the rest offsets of its two ends (turning.clh):
//
//   u(j) - u(i) = rest offset = 1/2 ( (R(i) - I) h e + (R(j) - I) h e ).
//
// Both steps lower
//
//   E = 1/2 sum over links of W ( |u(j) - u(i) - (R(i) - I) h e|^2 + |u(j) - u(i) - (R(j) - I) h e|^2 ),
//
// the energy of as-rigid-as-possible surfaces (O. Sorkine and M. Alexa, Symposium on Geometry Processing 2007) on the
// links of a grid. h e is the link from i to j at rest, h its length, D its limit, W = V / (h^2 D), V the volume of an
// element. Rotating tissue as a whole costs nothing. Where nothing rotates and elements are cubes, E is the energy of
// relax.cl. In the code lengths are in mean spacings, so V = 1, and displacements are fractions of the spacing.
//
// With VOLUMETRIC_STRAIN, E also contains a volumetric energy (volumetricstrain.clh). d(i) is the volumetric strain, k
// a link of i:
//
//   sum over i of 1/2 bulk(i) d(i)^2,   d(i) = sum over k of y(k),   y(k) = share(k) (strain of k along R(i) e(k)).
//
// A move of an element changes d of its six neighbours. Each of these has five further neighbours of the element's
// colour, which move in the same pass. So d^2 is replaced by a separable majorant with auxiliary variables z(k)
// (majorise-minimise):
//
//   d^2 = min over z of 6 sum over k of (y(k) - z(k))^2,   sum over k of z(k) = 0;   minimiser z*(k) = y(k) - d / 6;
//
//   F(u, R, z) = E of the links + sum over i of 1/2 bulk(i) 6 sum over k of (y(k) - z(k))^2.
//
// With z fixed, elements of one colour do not interact, and each lowers F by itself: block coordinate descent in u, R
// and z. Element i updates its own z on its visits, over-relaxed like u: z = z* + (1 - omega) (z_old - z*). Of that
// deviation from z* only the antisymmetric part along each axis a is kept: q(a) = z(a+) - z(a-), with the minimiser
// m(a) = y(a+) - y(a-). The pressure on the neighbours along a is then:
//
//   lower: p + carried(a),   upper: p - carried(a),   p = bulk d,
//   carried(a) = 3 bulk (q(a) - m(a)),   q(a) = m(a) + (1 - omega) lag(a).
//
// lag(a) = q_old(a) - m(a), with m(a) before the element moves in this visit. In the two formulas above m(a) is that
// after its move.
//
// Without over-relaxing z, over-relaxing u gains nothing, because z resists moves that have the same direction
// everywhere. Sweeps per digit at Poisson's ratio 0.3: 200 instead of 20. A relaxation starts at z = z*, where F = E. F
// falls in every pass and is never below E, so E falls from the start of a relaxation to its end.
//
// Variables of the code, with s the rotation step (rotationOf):
//   bulk           2 kappa / D(i), Lame's first parameter for the shear modulus 1 / D(i)
//   share          D(i) / (D(i) + D(j)), the part of a link's strain that is in the element's half of the link
//   pressure       p, stored in component 3 of `spin`
//   carried        carried(a), stored in component 4 + a of `spin`
//   late, on       lag(a), and (1 - omega) times it
//   middleOf()     m(a) up to a term of R(i) alone; component 7 + a of `spin` stores q(a) up to that term
//   stretch[b][a]  strain of the element's halves of its links along a, along R(i) b; its trace is d
//   reach, middle  share (u(j) - u(i)) of the two links along an axis: upper minus lower link, and their sum
//   tug, load      half the force of the neighbours' pressure, half its diagonal; `pull` and `weight` are halves, too
//   lopsided()     the asymmetry -dd/du(i)
//   twist          the rotation gradient dd/ds
//
// A sweep with rotations takes 1.6 times as long as one in which elements only move. So elements rotate in some sweeps
// only, and keep their rotation in the others. After equally many sweeps the energy is at most 1 or 2 % higher.
//
// With SOFT, E also contains soft links (softlinks.clh). Their energy does not depend on the rotation of an element.
//
// The limits of links apply to the strain, |u(j) - u(i) - rest offset| <= D, on every axis of the grid.
//
// The host guarantees the same as for relax.cl.

#include "brick.clh"

// Sums of products use fused multiply-add where the device has it. The compiler decides where from the source alone, so
// results are the same in every brick.
#pragma OPENCL FP_CONTRACT ON

#include "element.clh"
#include "softlinks.clh"
#include "sweep.clh"
#include "turning.clh"

#include "halo.clh"
#include "volumetricstrain.clh"

typedef struct
{
  real limit[6][AXES];
  real weight[6][AXES]; // W of the links, without soft links and volumetric energy
  real gap[6][3];       // u(j) - u(i), minus half the rest offset (R(j) - I) h e of the neighbour
  real pull[3][3];      // for each axis, weight * (u(j) - u(i)) of its upper link minus that of its lower one
#ifdef VOLUMETRIC_STRAIN
  real bulk;         // 2 kappa / D(i)
  real share[6];     // D(i) / (D(i) + D(j))
  real reach[3][3];  // as pull, of share * (u(j) - u(i))
  real tug[3];       // half the force of the neighbours' pressure [mean spacings]
  real load[3];      // half the diagonal of the neighbours' volumetric energy
  real middle[3][3]; // for each axis, the sum of share * (u(j) - u(i)) of its two links
#endif
} TurningLinks;

#ifdef VOLUMETRIC_STRAIN
// Adds the volumetric terms of the neighbour j in direction d. apart: u(j) - u(i). theirs: (R(j) - I) a, with a the
// unit vector along the axis of the link.
CHAINMAIL_INLINE void loadVolumetricStrain(const int odd, const Stencil* s, real soft, int d, const real* apart,
  const real* theirs, uint pitch, uint tissuePitch, global const float* constraint, global const uchar* cut,
  TurningLinks* links SPIN_ARGUMENTS)
{
  const int a = d / 2;
  const real other = meanBeside(odd, s, tissuePitch, constraint, cut, d);
  const real each = shareByConstraint(soft, other);
  const float way = (d & 1 ? 1.0f : -1.0f) * (1.0f / proportion(proportions, a));
  const real carried = neighbour(spin + (4 + a) * pitch, s, d, odd);
  const real pressure = neighbour(spin + 3 * pitch, s, d, odd) + (d & 1 ? carried : -carried);
  const real theirShare = select((real)(0.0f), other * each, isSoft(other));
  const real pull = 0.5f * way * theirShare * pressure;
  const real load = 3.0f * proportions.w * way * way * theirShare * each; // 3 bulk(j) share(j)^2 / h^2
  real arm[3], size[3];
  UNROLL
  for (int b = 0; b < 3; ++b)
  {
    arm[b] = a == b ? theirs[b] + 1.0f : theirs[b];
    size[b] = fabs(arm[b]);
  }
  links->share[d] = select((real)(0.0f), soft * each, isSoft(soft));
  UNROLL
  for (int b = 0; b < 3; ++b)
  {
    const real reach = links->share[d] * apart[b];
    const real more = load * size[b] * (size[0] + size[1] + size[2]);
    links->reach[a][b] = d & 1 ? reach + links->reach[a][b] : -reach;
    links->middle[a][b] = d & 1 ? reach + links->middle[a][b] : reach;
    links->tug[b] = d == 0 ? pull * arm[b] : pull * arm[b] + links->tug[b];
    links->load[b] = d == 0 ? more : more + links->load[b];
  }
}

// The strain of an element's halves of its links along each axis a, along each of its rotated axes b: out[b][a], with
// the trace d. mine[a]: (R(i) - I) times the unit vector along axis a.
CHAINMAIL_INLINE void stretchOf(const TurningLinks* links, real mine[3][3], float4 proportions, real out[3][3])
{
  UNROLL
  for (int a = 0; a < 3; ++a)
  {
    real along[3];
    UNROLL
    for (int b = 0; b < 3; ++b)
    {
      const float ratio = proportion(proportions, b) / proportion(proportions, a);
      along[b] = ratio * links->reach[a][b] - (links->share[2 * a] + links->share[2 * a + 1]) * mine[a][b];
    }
    UNROLL
    for (int b = 0; b < 3; ++b)
    {
      out[b][a] = along[b] + (mine[b][0] * along[0] + mine[b][1] * along[1] + mine[b][2] * along[2]);
    }
  }
}

// The pressure of an element, bulk d.
CHAINMAIL_INLINE real pressureOf(const TurningLinks* links, real mine[3][3], float4 proportions)
{
  real stretch[3][3];
  stretchOf(links, mine, proportions, stretch);
  return links->bulk * (stretch[0][0] + stretch[1][1] + stretch[2][2]);
}

// The asymmetry -dd/du(i) along each axis of the grid [1 / mean spacing]: how fast d falls where the element itself
// moves. It is 0 where the links of both sides have the same share.
CHAINMAIL_INLINE void lopsided(const TurningLinks* links, real mine[3][3], float4 proportions, real* out)
{
  UNROLL
  for (int b = 0; b < 3; ++b)
  {
    out[b] = (links->share[2 * b + 1] - links->share[2 * b]) * (1.0f / proportion(proportions, b));
    UNROLL
    for (int a = 0; a < 3; ++a)
    {
      const real more = (links->share[2 * a + 1] - links->share[2 * a]) * (1.0f / proportion(proportions, a));
      out[b] += more * mine[a][b];
    }
  }
}

// Adds the term `pressure x` of the volumetric energy (rotationOf) to the torque and stiffness of the links. Returns
// the rotation gradient in `twist` and a bound for the row sums of |Q| in `arms`.
CHAINMAIL_INLINE void torqueOfPressure(const TurningLinks* links, real mine[3][3], float4 proportions, real* stiffness,
  real torque[3][3], real* twist, real* arms)
{
  real stretch[3][3];
  stretchOf(links, mine, proportions, stretch);
  const real pressure = links->bulk * (stretch[0][0] + stretch[1][1] + stretch[2][2]);
  *arms = (real)(0.0f);
  UNROLL
  for (int a = 0; a < 3; ++a)
  {
    const real both = links->share[2 * a] + links->share[2 * a + 1];
    stiffness[a] -= pressure * both;
    UNROLL
    for (int b = 0; b < 3; ++b)
    {
      torque[b][a] -= pressure * stretch[b][a];
      *arms += a == b ? both + fabs(stretch[b][a]) : fabs(stretch[b][a]);
    }
  }
  UNROLL
  for (int c = 0; c < 3; ++c)
  {
    const int a = (c + 1) % 3, b = (c + 2) % 3;
    twist[c] = stretch[b][a] - stretch[a][b];
  }
}
#endif

CHAINMAIL_INLINE void loadTurningLinks(const Stencil* s, const Beside* beside, const real* c, const real* u, uint pitch,
  uint tissuePitch, global const float* constraint, global const uchar* cut, TurningLinks* links SPIN_ARGUMENTS)
{
#ifdef VOLUMETRIC_STRAIN
  const real soft = meanConstraint(c);
  links->bulk = bulkOf(soft, proportions);
#endif
  UNROLL
  for (int d = 0; d < 6; ++d)
  {
    const int a = d / 2;
    const float length = proportion(proportions, a);
    real other[3], theirs[3];
    UNROLL
    for (int axis = 0; axis < AXES; ++axis)
    {
      links->limit[d][axis] = linkLimit(c[axis], linkedConstraint(beside, cut, s, axis, d));
      links->weight[d][axis] = 1.0f / (length * length) / (links->limit[d][axis] + WEIGHT_EPSILON);
    }
    UNROLL
    for (int axis = 0; axis < 3; ++axis)
    {
      other[axis] = spinBeside(beside, axis, d);
    }
    turnedAxis(other, a, theirs);
#ifdef VOLUMETRIC_STRAIN
    real aparts[3];
#endif
    UNROLL
    for (int b = 0; b < 3; ++b)
    {
      const float ratio = proportion(proportions, a) / proportion(proportions, b);
      const real apart = displacementBeside(beside, b, d) - u[b];
      const real weight = links->weight[d][min(b, AXES - 1)];
      links->gap[d][b] = apart - (d & 1 ? 0.5f : -0.5f) * ratio * theirs[b];
      links->pull[a][b] = d & 1 ? weight * apart + links->pull[a][b] : -weight * apart;
#ifdef VOLUMETRIC_STRAIN
      aparts[b] = apart;
#endif
    }
#ifdef VOLUMETRIC_STRAIN
    loadVolumetricStrain(s->odd, s, soft, d, aparts, theirs, pitch, tissuePitch, constraint, cut, links SPIN_PASSED_ON);
#endif
  }
}

// The rotation step s of an element about its own rotated axes (Rodrigues vector, spin.clh), towards the rotation of
// its links. It is one Newton step with a diagonal majorant (Jacobi). mine[a]: (R(i) - I) times the unit vector along
// axis a. Where constraints are the same for all axes, s changes the energy by (s H s / 2 - moment s) / (1 + s^2 / 4).
// Where they differ by axis, H is an upper bound. Adding the magnitudes of the rest of its row to each diagonal entry
// of H makes sure that the energy falls.
//
// With VOLUMETRIC_STRAIN, s changes d by x = (twist s - s Q s / 2) / (1 + s^2 / 4), and the energy by pressure x + bulk
// x^2 / 2. The first term has the same form as that of the links. The second is at most bulk ((twist s)^2 + (s Q s)^2 /
// 4). There the row sums of |Q| are at most `reachOfAxes`, and s is no longer than the step found without this term.
CHAINMAIL_INLINE void rotationOf(const TurningLinks* links, real mine[3][3], float4 proportions, real* rotation)
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
    const float length = proportion(proportions, a);
    real pull[3];
    UNROLL
    for (int b = 0; b < 3; ++b)
    {
      const int axis = min(b, AXES - 1);
      const float area = proportion(proportions, b) * length;
      const real both = length * length * (links->weight[2 * a][axis] + links->weight[2 * a + 1][axis]);
      pull[b] = area * links->pull[a][b] - both * mine[a][b];
      stiffness[a] = b == 0 ? both : b < AXES ? max(stiffness[a], both) : stiffness[a];
    }
    UNROLL
    for (int b = 0; b < 3; ++b)
    {
      torque[b][a] = arms[b][0] * pull[0] + arms[b][1] * pull[1] + arms[b][2] * pull[2];
    }
  }
#ifdef VOLUMETRIC_STRAIN
  real twist[3], reachOfAxes, moments[3], inertias[3];
  torqueOfPressure(links, mine, proportions, stiffness, torque, twist, &reachOfAxes);
#endif
  UNROLL
  for (int c = 0; c < 3; ++c)
  {
    const int a = (c + 1) % 3, b = (c + 2) % 3;
    const real moment = torque[b][a] - torque[a][b];
    const real coupling = fabs(torque[a][c] + torque[c][a]) + fabs(torque[b][c] + torque[c][b]);
    const real inertia = stiffness[a] + stiffness[b] + torque[a][a] + torque[b][b] + 0.5f * coupling;
    const real size = max(inertia, fabs(moment)); // |rotation[c]| <= 1, about a radian
    rotation[c] = select((real)(0.0f), moment / size, size > 0.0f);
#ifdef VOLUMETRIC_STRAIN
    moments[c] = moment;
    inertias[c] = inertia;
#endif
  }
#ifdef VOLUMETRIC_STRAIN
  const real square = rotation[0] * rotation[0] + rotation[1] * rotation[1] + rotation[2] * rotation[2];
  const real twists = fabs(twist[0]) + fabs(twist[1]) + fabs(twist[2]);
  UNROLL
  for (int c = 0; c < 3; ++c)
  {
    const real more = links->bulk * (2.0f * fabs(twist[c]) * twists + 0.5f * reachOfAxes * reachOfAxes * square);
    const real size = max(inertias[c] + more, fabs(moments[c]));
    rotation[c] = select((real)(0.0f), moments[c] / size, size > 0.0f);
  }
#endif
}

// The strain u(j) - u(i) - rest offset of a link on an axis, for the rotation of the element that `mine` describes. It
// is also the move of the element that makes the strain 0.
CHAINMAIL_INLINE real strainOf(const TurningLinks* links, real mine[3][3], int d, int axis, float4 proportions)
{
  const float ratio = 0.5f * (proportion(proportions, d / 2) / proportion(proportions, axis));
  return links->gap[d][axis] - (d & 1 ? ratio : -ratio) * mine[d / 2][axis];
}

typedef struct
{
  real weight[AXES]; // sum of W
#ifdef VOLUMETRIC_STRAIN
  real load[3]; // the volumetric energy's addition to the sum of W
#endif
  real pull[3]; // sum of W * strain
  real room;    // least limit - |strain|: no smaller move breaks a limit; negative where a link is beyond its limit
} TurningNeighbours;

CHAINMAIL_INLINE TurningNeighbours askNeighbours(const TurningLinks* links, real mine[3][3], float4 proportions)
{
  TurningNeighbours all;
  all.room = (real)(INFINITY);
  UNROLL
  for (int d = 0; d < 6; ++d)
  {
    real most[AXES];
    UNROLL
    for (int b = 0; b < 3; ++b)
    {
      const int axis = min(b, AXES - 1);
      const real strain = strainOf(links, mine, d, b, proportions);
      const real weight = links->weight[d][axis];
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
#ifdef VOLUMETRIC_STRAIN
  real own[3];
  lopsided(links, mine, proportions, own);
  const real pressure = pressureOf(links, mine, proportions);
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    const real size = fabs(own[0]) + fabs(own[1]) + fabs(own[2]);
    all.pull[axis] += (links->tug[axis] + 0.5f * pressure * own[axis]) * (1.0f / proportion(proportions, axis));
    all.load[axis] = links->load[axis] + 0.5f * links->bulk * fabs(own[axis]) * size;
  }
#endif
  return all;
}

#ifndef UNLIMITED
// The largest fraction of the step from one rotation to the next at which no link exceeds its limit. The strain is
// interpolated linearly. The factor 0.95 allows for the error of the interpolation.
CHAINMAIL_INLINE real shareWithin(const TurningLinks* links, real mine[3][3], real next[3][3], float4 proportions)
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

// Shortens rotation steps that would take a link beyond its limit, or further beyond it than before. Where the
// shortened step still does, the element keeps its rotation. Other elements are unchanged. `beyond`: elements whose
// whole step leaves a negative room.
CHAINMAIL_INLINE void turnWithin(const TurningLinks* links, const real* own, real mine[3][3], float4 proportions,
  mask beyond, real* next, real turnedTo[3][3], TurningNeighbours* all)
{
  const real least = min(askNeighbours(links, mine, proportions).room, (real)(0.0f));
  beyond &= all->room < least;
  if (!SOME(beyond))
  {
    return;
  }
  // Not computed in the loop: PoCL 6.0 with LLVM 18 cannot compile that in many work-items (see changedBeyond).
  real share = shareWithin(links, mine, turnedTo, proportions);
  for (int attempt = 0; attempt < 2 && SOME(beyond); ++attempt)
  {
    UNROLL
    for (int axis = 0; axis < 3; ++axis)
    {
      next[axis] = select(next[axis], own[axis] + share * (next[axis] - own[axis]), beyond);
    }
    turnedAxes(next, turnedTo);
    *all = askNeighbours(links, turnedTo, proportions);
    beyond &= all->room < least;
    share = (real)(0.0f);
  }
}

// Clamps the move of an element to the intersection of the boxes of its links. Where rounding leaves that empty, the
// element stays.
CHAINMAIL_INLINE void moveWithin(const TurningLinks* links, real mine[3][3], float4 proportions, real* move)
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

#ifdef VOLUMETRIC_STRAIN
// m(a) without its constant term: the sum of share * (u(j) - u(i)) of the links along axis a, along the rotated axis
// and divided by h.
CHAINMAIL_INLINE real middleOf(const TurningLinks* links, real mine[3][3], int a, float4 proportions)
{
  real sum = (real)(0.0f);
  UNROLL
  for (int b = 0; b < 3; ++b)
  {
    const float ratio = proportion(proportions, b) / proportion(proportions, a);
    sum += ratio * (a == b ? mine[a][b] + 1.0f : mine[a][b]) * links->middle[a][b];
  }
  return sum;
}

// lag(a) = q_old(a) - m(a) of each axis.
CHAINMAIL_INLINE void lateBy(const Stencil* s, const TurningLinks* links, real mine[3][3], uint pitch,
  real* out SPIN_ARGUMENTS)
{
  UNROLL
  for (int a = 0; a < 3; ++a)
  {
    out[a] = LOAD(spin + (7 + a) * pitch + s->self) - middleOf(links, mine, a, proportions);
  }
}

// Stores the pressure, carried(a) and q(a) of elements after a move. Where the pressure changes or carried(a) is or was
// not 0, neighbours have to be visited: returns the faces of the brick that such elements touch.
CHAINMAIL_INLINE int storePressure(const Stencil* s, TurningLinks* links, real mine[3][3], const real* move,
  const real* late, float omega, float still, uint pitch SPIN_ARGUMENTS)
{
  UNROLL
  for (int m = 0; m < 9; ++m)
  {
    const int a = m / 3;
    links->reach[a][m % 3] -= (links->share[2 * a + 1] - links->share[2 * a]) * move[m % 3];
    links->middle[a][m % 3] -= (links->share[2 * a + 1] + links->share[2 * a]) * move[m % 3];
  }
  const real next = pressureOf(links, mine, proportions);
  global float* own = spin + 3 * pitch + s->self;
  mask changed = next != LOAD(own);
  UNROLL
  for (int a = 0; a < 3; ++a)
  {
    const mask goesOn =
      (links->share[2 * a] > 0.0f) & (links->share[2 * a + 1] > 0.0f) & (fabs(late[a]) > max(still, 1e-7f));
    const real on = select((real)(0.0f), (1.0f - omega) * late[a], goesOn);
    const real carried = 3.0f * links->bulk * on;
    changed |= (carried != 0.0f) | (carried != LOAD(own + (1 + a) * pitch));
    STORE(carried, own + (1 + a) * pitch);
    STORE(middleOf(links, mine, a, proportions) + on, own + (4 + a) * pitch);
  }
  if (SOME(changed))
  {
    STORE(next, own);
  }
  return movedFaces(s, changed);
}
#endif

#ifdef SOFT
// Adds the soft links of a lane group (softlinks.clh).
CHAINMAIL_INLINE void askSoftLinks(const Stencil* s, const real* u, global const int* place SOFT_ARGUMENTS,
  TurningNeighbours* all)
{
  real weight, places[3];
  if (loadSoftLinks(s, place SOFT_PASSED_ON, &weight, places))
  {
    UNROLL
    for (int axis = 0; axis < 3; ++axis)
    {
      all->pull[axis] += weight * (places[axis] - u[axis]);
    }
    UNROLL
    for (int axis = 0; axis < AXES; ++axis)
    {
      all->weight[axis] += weight;
    }
  }
}
#endif

// Relaxes one lane group, with rotations if `mayTurn`, and updates the largest moves and the faces. `mayTurn` is a
// compile-time constant, so it takes no register.
CHAINMAIL_INLINE void turnPiece(const Stencil* s, const Beside* beside, bool mayTurn, float omega, float still,
  uint pitch, uint tissuePitch, global const int* place, global float* displacement, global const float* constraint,
  global const uchar* cut, real* most, int* faces SPIN_ARGUMENTS SOFT_ARGUMENTS)
{
  real c[AXES], u[3], own[3], mine[3][3];
  mask relaxes[AXES];
  mask does = (mask)(0), turns = (mask)(-1);
  TurningLinks links;
  UNROLL
  for (int axis = 0; axis < AXES; ++axis)
  {
    c[axis] = LOAD_WHOLE(constraint + axis * tissuePitch + s->self);
    relaxes[axis] = c[axis] > 0.0f;
    turns &= (c[axis] != 0.0f) & (c[axis] != -INFINITY); // rigid elements rotate with their clusters
    does |= relaxes[axis];
  }
  if (!SOME(does | turns))
  {
    return;
  }
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    u[axis] = LOAD_WHOLE(displacement + axis * pitch + s->self);
    own[axis] = LOAD_WHOLE(spin + axis * pitch + s->self);
  }
  loadTurningLinks(s, beside, c, u, pitch, tissuePitch, constraint, cut, &links SPIN_PASSED_ON);
  turnedAxes(own, mine);
#ifdef VOLUMETRIC_STRAIN
  real late[3];
  lateBy(s, &links, mine, pitch, late SPIN_PASSED_ON);
#endif

  real next[3], turnedTo[3][3];
  mask turning = (mask)(0);
  UNROLL
  for (int m = 0; m < 9; ++m)
  {
    next[m / 3] = own[m / 3];
    turnedTo[m / 3][m % 3] = mine[m / 3][m % 3];
  }
  if (mayTurn)
  {
    real rotation[3];
    rotationOf(&links, mine, proportions, rotation);
    UNROLL
    for (int axis = 0; axis < 3; ++axis)
    {
      turning |= turns & (fabs(rotation[axis]) > still);
    }
    steppedSpin(own, rotation, -1.0f, next);
    UNROLL
    for (int axis = 0; axis < 3; ++axis)
    {
      next[axis] = select(own[axis], next[axis], turning);
    }
    turnedAxes(next, turnedTo);
  }

  TurningNeighbours all = askNeighbours(&links, turnedTo, proportions);
#ifndef UNLIMITED
  const mask beyond = turning & (all.room < 0.0f);
  if (SOME(beyond))
  {
    turnWithin(&links, own, mine, proportions, beyond, next, turnedTo, &all);
  }
#endif
#ifdef SOFT
  askSoftLinks(s, u, place SOFT_PASSED_ON, &all);
#endif
  real move[3];
  mask far = (mask)(0);
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    const int which = min(axis, AXES - 1);
#ifdef VOLUMETRIC_STRAIN
    const real residual = all.pull[axis] * (1.0f / (all.weight[which] + all.load[axis]));
#else
    const real residual = all.pull[axis] * (1.0f / all.weight[which]);
#endif
    // An element without links does not move, because its residual is not a number and compares false.
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
    moved = max(moved, fabs(nextPlace[axis] - u[axis]));
    moved = mayTurn ? max(moved, fabs(next[axis] - own[axis])) : moved;
  }
#ifdef VOLUMETRIC_STRAIN
  *faces |= storePressure(s, &links, turnedTo, move, late, omega, still, pitch SPIN_PASSED_ON);
#endif
  if (SOME(moved > 0.0f))
  {
    if (mayTurn)
    {
      shortestSpin(next);
    }
    UNROLL
    for (int axis = 0; axis < 3; ++axis)
    {
      STORE_WHOLE(nextPlace[axis], displacement + axis * pitch + s->self);
      if (mayTurn)
      {
        STORE_WHOLE(next[axis], spin + axis * pitch + s->self);
      }
    }
    *faces |= movedFaces(s, moved > 0.0f);
    *most = max(*most, moved);
  }
}

// Relaxes the share of one of `items` work-items in a brick and returns the largest move. `last` is the last slot.
NOINLINE float turnShare(int lid, int items, uint slot, uint last, int colour, bool mayTurn, float omega, float still,
  LAYOUT_ARGUMENTS, global float* displacement, global const float* constraint, global const uchar* cut,
  int* faces SPIN_ARGUMENTS SOFT_ARGUMENTS)
{
  HALO(halo);
  real most = (real)(0.0f);
  for (int work = lid; work < VECTORS; work += items)
  {
    const Stencil s = stencilOf(slot, colour, work, pitch, table, place, strideY, strideZ);
    const Beside beside = besideOf(halo, &s, slot, last, colour, pitch, tissuePitch, table, place, strideY, strideZ,
      displacement, constraint SPIN_PASSED_ON);
    if (mayTurn)
    {
      turnPiece(&s, &beside, true, omega, still, pitch, tissuePitch, place, displacement, constraint, cut, &most,
        faces SPIN_PASSED_ON SOFT_PASSED_ON);
    }
    else
    {
      turnPiece(&s, &beside, false, omega, still, pitch, tissuePitch, place, displacement, constraint, cut, &most,
        faces SPIN_PASSED_ON SOFT_PASSED_ON);
    }
  }
  return largestOf(most);
}

// turning: in a sweep with rotations, the most sweeps since the previous one with rotations; else 0.
kernel void relaxTurning(SWEEP_ARGUMENTS, int colour, int turning, float omega, float still, LAYOUT_ARGUMENTS,
  global float* displacement, global const float* constraint, global const uchar* cut SPIN_ARGUMENTS SOFT_ARGUMENTS)
{
  local Turn mine;
  const uint slot = get_group_id(0) + 1;
  beginSweepTurn(
    &mine, slot, colour, turn.z - max(turning, 1), activity, log, turn, enough, table, place, strideY, strideZ);
  int touched = 0;
  float move = 0.0f;
  if (mine.has == TURN_HAS)
  {
    move = turnShare(get_local_id(0), get_local_size(0), slot, get_num_groups(0), colour, turning != 0, omega, still,
      pitch, tissuePitch, table, place, strideY, strideZ, displacement, constraint, cut,
      &touched SPIN_PASSED_ON SOFT_PASSED_ON);
  }
  endSweepTurn(
    &mine, touched, move, slot, colour, turning ? SWEEP_EVER : SWEEP_EVER | SWEEP_FACES, activity, log, turn, enough);
}
