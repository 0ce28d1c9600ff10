// One colour pass of a relaxation sweep in which elements rotate. Each element i first rotates towards the rotation
// that its links have about it. Then it moves to the over-relaxed weighted mean of the target places of its links. The
// target of a link is the mean of the rest offsets of its two ends (rotations.clh):
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
//   sum over i of 1/2 lambda(i) d(i)^2,   d(i) = sum over k of y(k),   y(k) = share(k) (strain of k along R(i) e(k)).
//
// A move of an element changes d of its six neighbours. Each of these has five further neighbours of the element's
// colour, which move in the same pass. So d^2 is replaced by a separable majorant with auxiliary variables z(k)
// (majorise-minimise):
//
//   d^2 = min over z of 6 sum over k of (y(k) - z(k))^2,   sum over k of z(k) = 0;   minimiser z*(k) = y(k) - d / 6;
//
//   F(u, R, z) = E of the links + sum over i of 1/2 lambda(i) 6 sum over k of (y(k) - z(k))^2.
//
// With z fixed, elements of one colour do not interact, and each lowers F by itself: block coordinate descent in u, R
// and z. Element i updates its own z on its visits, over-relaxed like u: z = z* + (1 - omega) (z_old - z*). Of that
// deviation from z* only the antisymmetric part along each axis a is kept: q(a) = z(a+) - z(a-), with the minimiser
// m(a) = y(a+) - y(a-). The pressure on the neighbours along a is then:
//
//   lower: p + carry(a),   upper: p - carry(a),   p = lambda d,
//   carry(a) = 3 lambda (q(a) - m(a)),   q(a) = m(a) + (1 - omega) lag(a).
//
// lag(a) = q_old(a) - m(a), with m(a) before the element moves in this visit. In the two formulas above m(a) is that
// after its move.
//
// Without over-relaxing z, over-relaxing u gains nothing, because z resists moves that have the same direction
// everywhere. At Poisson's ratio 0.3 a tenfold smaller error would take 200 sweeps instead of 20. A relaxation starts
// at z = z*, where F = E. F falls in every pass and is never below E, so E falls from the start of a relaxation to its
// end.
//
// Variables of the code, with s the rotation step (rotationOf):
//   lambda         2 kappa / D(i), Lame's first parameter for the shear modulus 1 / D(i)
//   share          D(i) / (D(i) + D(j)), the part of a link's strain that is in the element's half of the link
//   pressure       p, a field of the state
//   carry          carry(a), a field of the state
//   lag, keptLag   lag(a), and (1 - omega) times it
//   middleOf()     m(a) up to a term of R(i) alone; the field `auxiliary` stores q(a) up to that term
//   stretch[b][a]  strain of the element's halves of its links along a, along R(i) b; its trace is d
//   reach, middle  share (u(j) - u(i)) of the two links along an axis: upper minus lower link, and their sum
//   force          half the force of the neighbours' pressure. In RotatingNeighbours `pull` is half of minus the
//                  derivative of E by u(i), and `weight` half of the second derivative
//   diagonal       half the row sums of magnitudes of the Hessian of the neighbours' volumetric energy. They replace
//                  its diagonal, so a step that treats the axes one by one lowers the energy
//   asymmetryOf()  the asymmetry -dd/du(i)
//   gradient       the rotation gradient dd/ds
//
// A sweep with rotations takes 1.6 times as long as one in which elements only move. So elements rotate in some sweeps
// only (SweepPlan), and keep their rotation in the others. Data/Method.md says what this costs.
//
// With SOFT, E also contains soft links (softlinks.clh). Their energy does not depend on the rotation of an element.
//
// The limits of links apply to the strain, |u(j) - u(i) - rest offset| <= D, on every axis of the grid.
//
// The host guarantees the same as for relax.cl.

#include "brick.clh"
#include "state.clh"

// Sums of products use fused multiply-add where the device has it. The compiler decides where from the source alone, so
// results are the same in every brick.
#pragma OPENCL FP_CONTRACT ON

#include "element.clh"
#include "method.clh"
#include "softlinks.clh"
#include "sweep.clh"
#include "rotations.clh"

#include "halo.clh"
#include "volumetricstrain.clh"

typedef struct
{
  real limit[6][AXES];
  real weight[6][AXES]; // W of the links, without soft links and volumetric energy
  real gap[6][3];       // u(j) - u(i), minus half the rest offset (R(j) - I) h e of the neighbour
  real pull[3][3];      // for each axis, weight * (u(j) - u(i)) of its upper link minus that of its lower one
#ifdef VOLUMETRIC_STRAIN
  real lambda;       // 2 kappa / D(i)
  real share[6];     // D(i) / (D(i) + D(j))
  real reach[3][3];  // as pull, of share * (u(j) - u(i))
  real force[3];     // half the force of the neighbours' pressure [mean spacings]
  real diagonal[3];  // half the row sums of magnitudes of the Hessian of the neighbours' volumetric energy
  real middle[3][3]; // for each axis, the sum of share * (u(j) - u(i)) of its two links
#endif
} RotatingLinks;

#ifdef VOLUMETRIC_STRAIN
// Adds the volumetric terms of the neighbour j in direction d. difference: u(j) - u(i). otherAxis: (R(j) - I) a, with a
// the unit vector along the axis of the link.
CHAINMAIL_INLINE void loadVolumetricStrain(const int odd, const State* state, const Stencil* s, real soft, int d,
  const real* difference, const real* otherAxis, RotatingLinks* links)
{
  const float4 proportions = state->proportions;
  const int a = d / 2;
  const real other = neighbourMeanConstraint(odd, state, s, d);
  const real each = shareByConstraint(soft, other);
  const float perSpacing = (d & 1 ? 1.0f : -1.0f) * (1.0f / alongAxis(proportions, a));
  const real carry = neighbour(carryAlong(state, a), s, d, odd);
  const real pressure = neighbour(state->pressure, s, d, odd) + (d & 1 ? carry : -carry);
  const real otherShare = select((real)(0.0f), other * each, isSoft(other));
  const real pull = 0.5f * perSpacing * otherShare * pressure;
  // 3 lambda(j) share(j)^2 / h^2
  const real diagonal = 3.0f * proportions.w * perSpacing * perSpacing * otherShare * each;
  real arm[3], size[3];
  UNROLL
  for (int b = 0; b < 3; ++b)
  {
    arm[b] = a == b ? otherAxis[b] + 1.0f : otherAxis[b];
    size[b] = fabs(arm[b]);
  }
  links->share[d] = select((real)(0.0f), soft * each, isSoft(soft));
  UNROLL
  for (int b = 0; b < 3; ++b)
  {
    const real reach = links->share[d] * difference[b];
    const real more = diagonal * size[b] * (size[0] + size[1] + size[2]);
    links->reach[a][b] = d & 1 ? reach + links->reach[a][b] : -reach;
    links->middle[a][b] = d & 1 ? reach + links->middle[a][b] : reach;
    links->force[b] = d == 0 ? pull * arm[b] : pull * arm[b] + links->force[b];
    links->diagonal[b] = d == 0 ? more : more + links->diagonal[b];
  }
}

// The strain of an element's halves of its links along each axis a, along each of its rotated axes b: out[b][a], with
// the trace d. axes[a]: (R(i) - I) times the unit vector along axis a.
CHAINMAIL_INLINE void stretchOf(const RotatingLinks* links, real axes[3][3], float4 proportions, real out[3][3])
{
  UNROLL
  for (int a = 0; a < 3; ++a)
  {
    real along[3];
    UNROLL
    for (int b = 0; b < 3; ++b)
    {
      const float ratio = alongAxis(proportions, b) / alongAxis(proportions, a);
      along[b] = ratio * links->reach[a][b] - (links->share[2 * a] + links->share[2 * a + 1]) * axes[a][b];
    }
    UNROLL
    for (int b = 0; b < 3; ++b)
    {
      out[b][a] = along[b] + (axes[b][0] * along[0] + axes[b][1] * along[1] + axes[b][2] * along[2]);
    }
  }
}

// The pressure of an element, lambda d.
CHAINMAIL_INLINE real pressureOf(const RotatingLinks* links, real axes[3][3], float4 proportions)
{
  real stretch[3][3];
  stretchOf(links, axes, proportions, stretch);
  return links->lambda * (stretch[0][0] + stretch[1][1] + stretch[2][2]);
}

// The asymmetry -dd/du(i) along each axis of the grid [1 / mean spacing]: how fast d falls where the element itself
// moves. It is 0 where the links of both sides have the same share.
CHAINMAIL_INLINE void asymmetryOf(const RotatingLinks* links, real axes[3][3], float4 proportions, real* out)
{
  UNROLL
  for (int b = 0; b < 3; ++b)
  {
    out[b] = (links->share[2 * b + 1] - links->share[2 * b]) * (1.0f / alongAxis(proportions, b));
    UNROLL
    for (int a = 0; a < 3; ++a)
    {
      const real more = (links->share[2 * a + 1] - links->share[2 * a]) * (1.0f / alongAxis(proportions, a));
      out[b] += more * axes[a][b];
    }
  }
}

// Subtracts the term pressure x of the volumetric energy (rotationOf) from the torque and stiffness of the links.
// Returns the rotation gradient in `gradient` and a bound for the row sums of |Q| in `reachOfAxes`.
CHAINMAIL_INLINE void torqueOfPressure(const RotatingLinks* links, real axes[3][3], float4 proportions, real* stiffness,
  real torque[3][3], real* gradient, real* reachOfAxes)
{
  real stretch[3][3];
  stretchOf(links, axes, proportions, stretch);
  const real pressure = links->lambda * (stretch[0][0] + stretch[1][1] + stretch[2][2]);
  *reachOfAxes = (real)(0.0f);
  UNROLL
  for (int a = 0; a < 3; ++a)
  {
    const real both = links->share[2 * a] + links->share[2 * a + 1];
    stiffness[a] -= pressure * both;
    UNROLL
    for (int b = 0; b < 3; ++b)
    {
      torque[b][a] -= pressure * stretch[b][a];
      *reachOfAxes += a == b ? both + fabs(stretch[b][a]) : fabs(stretch[b][a]);
    }
  }
  UNROLL
  for (int c = 0; c < 3; ++c)
  {
    const int a = (c + 1) % 3, b = (c + 2) % 3;
    gradient[c] = stretch[b][a] - stretch[a][b];
  }
}
#endif

CHAINMAIL_INLINE void loadRotatingLinks(
  const State* state, const Stencil* s, const Halo* halo, const real* c, const real* u, RotatingLinks* links)
{
  const float4 proportions = state->proportions;
#ifdef VOLUMETRIC_STRAIN
  const real soft = meanConstraint(c);
  links->lambda = lambdaOf(soft, proportions);
#endif
  UNROLL
  for (int d = 0; d < 6; ++d)
  {
    const int a = d / 2;
    const float length = alongAxis(proportions, a);
    real other[3], otherAxis[3];
    UNROLL
    for (int axis = 0; axis < AXES; ++axis)
    {
      links->limit[d][axis] = linkOf(c[axis], linkedConstraint(halo, state, s, axis, d), d, axis).limit;
      links->weight[d][axis] = 1.0f / (length * length) / (links->limit[d][axis] + WEIGHT_EPSILON);
    }
    UNROLL
    for (int axis = 0; axis < 3; ++axis)
    {
      other[axis] = spinIn(halo, axis, d);
    }
    rotationOffsetOfAxis(other, a, otherAxis);
#ifdef VOLUMETRIC_STRAIN
    real differences[3];
#endif
    UNROLL
    for (int b = 0; b < 3; ++b)
    {
      const float ratio = alongAxis(proportions, a) / alongAxis(proportions, b);
      const real difference = displacementIn(halo, b, d) - u[b];
      const real weight = links->weight[d][min(b, AXES - 1)];
      links->gap[d][b] = difference - (d & 1 ? 0.5f : -0.5f) * ratio * otherAxis[b];
      links->pull[a][b] = d & 1 ? weight * difference + links->pull[a][b] : -weight * difference;
#ifdef VOLUMETRIC_STRAIN
      differences[b] = difference;
#endif
    }
#ifdef VOLUMETRIC_STRAIN
    loadVolumetricStrain(s->odd, state, s, soft, d, differences, otherAxis, links);
#endif
  }
}

// The rotation step s of an element about its own rotated axes (Rodrigues vector, spin.clh), towards the rotation of
// its links. axes[a]: (R(i) - I) times the unit vector along axis a. Where constraints are the same for all axes, s
// changes the energy by (s H s / 2 - moment s) / (1 + s^2 / 4). With T = `torque`, and c, a, b in cyclic order:
//
//   moment[c] = T[b][a] - T[a][b],
//   H = S + trace(T) I - (T + T^T) / 2,   S diagonal with S[c] = stiffness[a] + stiffness[b].
//
// Where constraints differ by axis, H is an upper bound. s is one Newton step with a diagonal matrix in place of H
// (Jacobi): `inertia`, the diagonal of H plus the magnitudes of the rest of each row. This is an upper bound of H, so
// the energy falls.
//
// With VOLUMETRIC_STRAIN, s changes d by x = (gradient s - s Q s / 2) / (1 + s^2 / 4), and the energy by
// pressure x + lambda x^2 / 2. Here Q = trace(G) I - (G + G^T) / 2. G is `stretch` plus, on the diagonal, the sum of
// the shares of the two links along the axis. The first term has the same form as that of the links. The second is at
// most lambda ((gradient s)^2 + (s Q s)^2 / 4). In its bound `reachOfAxes` stands for the row sums of |Q|, which are no
// larger. One factor s^2 is that of the step without this term, which is no shorter.
CHAINMAIL_INLINE void rotationOf(const RotatingLinks* links, real axes[3][3], float4 proportions, real* rotation)
{
  real stiffness[3], arms[3][3];
  real torque[3][3]; // [b][a]: of the links along a, along the rotated axis b
  UNROLL
  for (int m = 0; m < 9; ++m)
  {
    arms[m / 3][m % 3] = m / 3 == m % 3 ? axes[m / 3][m % 3] + 1.0f : axes[m / 3][m % 3];
  }
  UNROLL
  for (int a = 0; a < 3; ++a)
  {
    const float length = alongAxis(proportions, a);
    real pull[3];
    UNROLL
    for (int b = 0; b < 3; ++b)
    {
      const int axis = min(b, AXES - 1);
      const float area = alongAxis(proportions, b) * length;
      const real both = length * length * (links->weight[2 * a][axis] + links->weight[2 * a + 1][axis]);
      pull[b] = area * links->pull[a][b] - both * axes[a][b];
      stiffness[a] = b == 0 ? both : b < AXES ? max(stiffness[a], both) : stiffness[a];
    }
    UNROLL
    for (int b = 0; b < 3; ++b)
    {
      torque[b][a] = arms[b][0] * pull[0] + arms[b][1] * pull[1] + arms[b][2] * pull[2];
    }
  }
#ifdef VOLUMETRIC_STRAIN
  real gradient[3], reachOfAxes, moments[3], inertias[3];
  torqueOfPressure(links, axes, proportions, stiffness, torque, gradient, &reachOfAxes);
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
  const real gradients = fabs(gradient[0]) + fabs(gradient[1]) + fabs(gradient[2]);
  UNROLL
  for (int c = 0; c < 3; ++c)
  {
    const real more =
      links->lambda * (2.0f * fabs(gradient[c]) * gradients + 0.5f * reachOfAxes * reachOfAxes * square);
    const real size = max(inertias[c] + more, fabs(moments[c]));
    rotation[c] = select((real)(0.0f), moments[c] / size, size > 0.0f);
  }
#endif
}

// The strain u(j) - u(i) - rest offset of a link on an axis, for the rotation of the element that `axes` describes. It
// is also the move of the element that makes the strain 0.
CHAINMAIL_INLINE real strainOf(const RotatingLinks* links, real axes[3][3], int d, int axis, float4 proportions)
{
  const float ratio = 0.5f * (alongAxis(proportions, d / 2) / alongAxis(proportions, axis));
  return links->gap[d][axis] - (d & 1 ? ratio : -ratio) * axes[d / 2][axis];
}

typedef struct
{
  real weight[AXES]; // sum of W
#ifdef VOLUMETRIC_STRAIN
  real diagonal[3]; // the volumetric energy's addition to the sum of W
#endif
  real pull[3]; // sum of W * strain
  real room;    // least limit - |strain|: no smaller move breaks a limit; negative where a link is beyond its limit
} RotatingNeighbours;

CHAINMAIL_INLINE RotatingNeighbours sumOverLinks(const RotatingLinks* links, real axes[3][3], float4 proportions)
{
  RotatingNeighbours all;
  all.room = (real)(INFINITY);
  UNROLL
  for (int d = 0; d < 6; ++d)
  {
    real most[AXES];
    UNROLL
    for (int b = 0; b < 3; ++b)
    {
      const int axis = min(b, AXES - 1);
      const real strain = strainOf(links, axes, d, b, proportions);
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
  asymmetryOf(links, axes, proportions, own);
  const real pressure = pressureOf(links, axes, proportions);
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    const real size = fabs(own[0]) + fabs(own[1]) + fabs(own[2]);
    all.pull[axis] += (links->force[axis] + 0.5f * pressure * own[axis]) * (1.0f / alongAxis(proportions, axis));
    all.diagonal[axis] = links->diagonal[axis] + 0.5f * links->lambda * fabs(own[axis]) * size;
  }
#endif
  return all;
}

#ifndef UNLIMITED
// The largest fraction of the step from one rotation to the next at which no link exceeds its limit. The strain is
// interpolated linearly. The factor 0.95 allows for the error of the interpolation.
CHAINMAIL_INLINE real shareWithin(const RotatingLinks* links, real axes[3][3], real next[3][3], float4 proportions)
{
  real share = (real)(1.0f);
  UNROLL
  for (int m = 0; m < 18; ++m)
  {
    const int d = m / 3, axis = m % 3;
    const real limit = links->limit[d][min(axis, AXES - 1)];
    const real now = fabs(strainOf(links, axes, d, axis, proportions)) - limit;
    const real then = fabs(strainOf(links, next, d, axis, proportions)) - limit;
    const real allowed = 0.95f * min(now, (real)(0.0f)) / (now - then);
    share = select(share, min(share, allowed), (then > 0.0f) & (then > now));
  }
  return share;
}

// Shortens rotation steps that would take a link beyond its limit, or further beyond it than before. Where the
// shortened step still does, the element keeps its rotation. Other elements are unchanged. `beyond`: elements whose
// whole step leaves a negative room.
CHAINMAIL_INLINE void shortenRotation(const RotatingLinks* links, const real* own, real axes[3][3], float4 proportions,
  mask beyond, real* next, real nextAxes[3][3], RotatingNeighbours* all)
{
  const real least = min(sumOverLinks(links, axes, proportions).room, (real)(0.0f));
  beyond &= all->room < least;
  if (!SOME(beyond))
  {
    return;
  }
  // Not computed in the loop: PoCL 6.0 with LLVM 18 cannot compile that in many work-items (see changedBeyond).
  real share = shareWithin(links, axes, nextAxes, proportions);
  for (int attempt = 0; attempt < 2 && SOME(beyond); ++attempt)
  {
    UNROLL
    for (int axis = 0; axis < 3; ++axis)
    {
      next[axis] = select(next[axis], own[axis] + share * (next[axis] - own[axis]), beyond);
    }
    rotationOffsetsOfAxes(next, nextAxes);
    *all = sumOverLinks(links, nextAxes, proportions);
    beyond &= all->room < least;
    share = (real)(0.0f);
  }
}

// Clamps the move of an element to the intersection of the boxes of its links. Where rounding leaves that empty, the
// element stays.
CHAINMAIL_INLINE void moveWithin(const RotatingLinks* links, real axes[3][3], float4 proportions, real* move)
{
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    real lower = (real)(-INFINITY), upper = (real)(INFINITY);
    UNROLL
    for (int d = 0; d < 6; ++d)
    {
      const real limit = links->limit[d][min(axis, AXES - 1)];
      const real strain = strainOf(links, axes, d, axis, proportions);
      lower = max(lower, strain - limit);
      upper = min(upper, strain + limit);
    }
    const real within = min(max(move[axis], lower), upper);
    move[axis] = select((real)(STAY), within, (move[axis] != 0.0f) & (lower <= upper));
  }
}
#endif

#ifdef VOLUMETRIC_STRAIN
// m(a) up to its term of R(i) alone: the sum of share * (u(j) - u(i)) of the links along axis a, along the rotated axis
// and divided by h.
CHAINMAIL_INLINE real middleOf(const RotatingLinks* links, real axes[3][3], int a, float4 proportions)
{
  real sum = (real)(0.0f);
  UNROLL
  for (int b = 0; b < 3; ++b)
  {
    const float ratio = alongAxis(proportions, b) / alongAxis(proportions, a);
    sum += ratio * (a == b ? axes[a][b] + 1.0f : axes[a][b]) * links->middle[a][b];
  }
  return sum;
}

// lag(a) = q_old(a) - m(a) of each axis.
CHAINMAIL_INLINE void lagOf(
  const State* state, const Stencil* s, const RotatingLinks* links, real axes[3][3], real* out)
{
  UNROLL
  for (int a = 0; a < 3; ++a)
  {
    out[a] = LOAD(auxiliaryAlong(state, a) + s->self) - middleOf(links, axes, a, state->proportions);
  }
}

// Stores the pressure, carry(a) and q(a) of elements after a move. Where the pressure changes or carry(a) is or was
// not 0, neighbours have to be visited: returns the faces of the brick that such elements touch.
CHAINMAIL_INLINE int storePressure(const State* state, const Stencil* s, const Method* method, RotatingLinks* links,
  real axes[3][3], const real* move, const real* lag)
{
  const float4 proportions = state->proportions;
  UNROLL
  for (int m = 0; m < 9; ++m)
  {
    const int a = m / 3;
    links->reach[a][m % 3] -= (links->share[2 * a + 1] - links->share[2 * a]) * move[m % 3];
    links->middle[a][m % 3] -= (links->share[2 * a + 1] + links->share[2 * a]) * move[m % 3];
  }
  const real next = pressureOf(links, axes, proportions);
  global float* own = state->pressure + s->self;
  mask changed = next != LOAD(own);
  UNROLL
  for (int a = 0; a < 3; ++a)
  {
    // A lag up to the residual tolerance is dropped, so tissue comes to rest. Along an axis with a free half nothing is
    // carried, because there is no second half to balance it.
    const mask goesOn =
      (links->share[2 * a] > 0.0f) & (links->share[2 * a + 1] > 0.0f) & (fabs(lag[a]) > max(method->still, 1e-7f));
    const real keptLag = select((real)(0.0f), (1.0f - method->omega) * lag[a], goesOn);
    const real carry = 3.0f * links->lambda * keptLag;
    changed |= (carry != 0.0f) | (carry != LOAD(carryAlong(state, a) + s->self));
    STORE(carry, carryAlong(state, a) + s->self);
    STORE(middleOf(links, axes, a, proportions) + keptLag, auxiliaryAlong(state, a) + s->self);
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
CHAINMAIL_INLINE void addSoftLinksTo(
  RotatingNeighbours* all, const State* state, const Stencil* s, const real* u)
{
  real weight, places[3];
  if (loadSoftLinks(state, s, &weight, places))
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

// Rotates elements by their rotation step, unless it is at most `still`: from `own`, with the offsets `axes` of the
// unit vectors, to `next` and `nextAxes`. Returns which elements rotate.
CHAINMAIL_INLINE mask rotateElements(const RotatingLinks* links, float4 proportions, mask mayRotate, float still,
  const real* own, real axes[3][3], real* next, real nextAxes[3][3])
{
  real rotation[3];
  rotationOf(links, axes, proportions, rotation);
  mask rotating = (mask)(0);
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    rotating |= mayRotate & (fabs(rotation[axis]) > still);
  }
  steppedSpin(own, rotation, -1.0f, next);
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    next[axis] = select(own[axis], next[axis], rotating);
  }
  rotationOffsetsOfAxes(next, nextAxes);
  return rotating;
}

// The over-relaxed move of elements to where their energy is least, without limits. Returns which elements may exceed a
// limit by it. An element without links does not move, because its residual is not a number and compares false.
CHAINMAIL_INLINE mask unlimitedMove(
  const RotatingNeighbours* all, const mask* relaxes, const Method* method, real* move)
{
  mask far = (mask)(0);
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    const int which = min(axis, AXES - 1);
#ifdef VOLUMETRIC_STRAIN
    const real residual = all->pull[axis] * (1.0f / (all->weight[which] + all->diagonal[axis]));
#else
    const real residual = all->pull[axis] * (1.0f / all->weight[which]);
#endif
    move[axis] =
      select((real)(STAY), method->omega * residual, relaxes[which] & (fabs(residual) > method->still));
    far |= fabs(move[axis]) > all->room;
  }
  return far;
}

// Stores the places of elements after a move from u and, where they may rotate, the rotations `next` in place of `own`.
// Returns how far the elements went, on any axis of either.
CHAINMAIL_INLINE real storeMove(const State* state, const Stencil* s, const real* u, const real* move, bool rotations,
  const real* own, real* next)
{
  real moved = (real)(0.0f), place[3];
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    place[axis] = u[axis] + move[axis];
    moved = max(moved, fabs(place[axis] - u[axis]));
    moved = rotations ? max(moved, fabs(next[axis] - own[axis])) : moved;
  }
  if (SOME(moved > 0.0f))
  {
    if (rotations)
    {
      shortestSpin(next);
    }
    UNROLL
    for (int axis = 0; axis < 3; ++axis)
    {
      STORE_WHOLE(place[axis], displacementAlong(state, axis) + s->self);
      if (rotations)
      {
        STORE_WHOLE(next[axis], spinAlong(state, axis) + s->self);
      }
    }
  }
  return moved;
}

// Relaxes one lane group and updates the largest moves and the faces. `rotations`: whether elements may rotate; it is a
// compile-time constant, so it takes no register.
CHAINMAIL_INLINE void relaxGroup(const State* state, const Stencil* s, const Halo* halo, const Method* method,
  bool rotations, real* most, int* faces)
{
  const float4 proportions = state->proportions;
  real c[AXES], u[3], own[3], axes[3][3];
  mask relaxes[AXES];
  mask mayMove = (mask)(0), mayRotate = (mask)(-1);
  RotatingLinks links;
  UNROLL
  for (int axis = 0; axis < AXES; ++axis)
  {
    c[axis] = LOAD_WHOLE(constraintAlong(state, axis) + s->self);
    relaxes[axis] = c[axis] > 0.0f;
    // Held elements rotate, too; only their places are held. Rigid elements rotate with their clusters.
    mayRotate &= (c[axis] != 0.0f) & (c[axis] != -INFINITY);
    mayMove |= relaxes[axis];
  }
  if (!SOME(mayMove | mayRotate))
  {
    return;
  }
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    u[axis] = LOAD_WHOLE(displacementAlong(state, axis) + s->self);
    own[axis] = LOAD_WHOLE(spinAlong(state, axis) + s->self);
  }
  loadRotatingLinks(state, s, halo, c, u, &links);
  rotationOffsetsOfAxes(own, axes);
#ifdef VOLUMETRIC_STRAIN
  real lag[3];
  lagOf(state, s, &links, axes, lag);
#endif

  real next[3], nextAxes[3][3];
  mask rotating = (mask)(0);
  UNROLL
  for (int m = 0; m < 9; ++m)
  {
    next[m / 3] = own[m / 3];
    nextAxes[m / 3][m % 3] = axes[m / 3][m % 3];
  }
  if (rotations)
  {
    rotating = rotateElements(&links, proportions, mayRotate, method->still, own, axes, next, nextAxes);
  }

  RotatingNeighbours all = sumOverLinks(&links, nextAxes, proportions);
#ifndef UNLIMITED
  const mask beyond = rotating & (all.room < 0.0f);
  if (SOME(beyond))
  {
    shortenRotation(&links, own, axes, proportions, beyond, next, nextAxes, &all);
  }
#endif
#ifdef SOFT
  addSoftLinksTo(&all, state, s, u);
#endif
  real move[3];
  const mask far = unlimitedMove(&all, relaxes, method, move);
#ifndef UNLIMITED
  if (SOME(far))
  {
    moveWithin(&links, nextAxes, proportions, move);
  }
#endif
#ifdef VOLUMETRIC_STRAIN
  *faces |= storePressure(state, s, method, &links, nextAxes, move, lag);
#endif
  const real moved = storeMove(state, s, u, move, rotations, own, next);
  if (SOME(moved > 0.0f))
  {
    *faces |= movedFaces(s, moved > 0.0f);
    *most = max(*most, moved);
  }
}

// Relaxes a share of a brick and returns the largest move.
NOINLINE float relaxShare(const State* given, Method method, bool rotations, Share share, int* faces)
{
  const State state = *given;
  HALO_MEMORY(memory);
  real most = (real)(0.0f);
  for (int work = share.lid; work < VECTORS; work += share.items)
  {
    const Stencil s = stencilOf(&state.layout, share.slot, share.colour, work);
    const Halo halo = haloOf(memory, &state, &s, share.slot, share.last, share.colour);
    if (rotations)
    {
      relaxGroup(&state, &s, &halo, &method, true, &most, faces);
    }
    else
    {
      relaxGroup(&state, &s, &halo, &method, false, &most, faces);
    }
  }
  return largestOf(most);
}

// sweepsPerRotation: in a sweep with rotations, the most sweeps since the previous one with rotations; else 0.
kernel void relaxRotating(PASS_ARGUMENTS, STATE_ARGUMENTS, int colour, int sweepsPerRotation, float omega, float still)
{
  const Pass pass = PASS;
  const State state = STATE;
  const Method method = { omega, still, 0.0f, true }; // the last two are not read: there is no slack; see UNLIMITED
  local Visit visit;
  const uint slot = get_group_id(0) + 1;
  beginVisit(&visit, &pass, &state.layout, slot, colour, pass.sweep - max(sweepsPerRotation, 1));
  int faces = 0;
  float move = 0.0f;
  if (visit.due == DUE_AND_READY)
  {
    const Share share = { get_local_id(0), get_local_size(0), slot, get_num_groups(0), colour };
    move = relaxShare(&state, method, sweepsPerRotation != 0, share, &faces);
  }
  endVisit(&visit, &pass, slot, colour, faces, move, sweepsPerRotation ? SWEEP_EVER : SWEEP_EVER | SWEEP_FACES);
}
