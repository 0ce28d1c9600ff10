// The third colour pass of a sweep with rotations: rigid clusters, each with six unknowns, a displacement and a
// rotation. A cluster takes an over-relaxed Gauss-Newton step towards the minimum of the energy E (relaxrotations.cl)
// of the links that leave it. The step is shortened to what the limits of these links allow. Where that is little, as
// at links near their limits, a move without a rotation may lower the energy more. Then this move is taken instead. A
// step that would break a limit or raise the energy is rejected.
//
// The links are listed in chunks (cluster.clh). With SOFT the soft links of members count as well.
//
// The host guarantees: members are where the pose puts them; the other ends of links are not rigid; the bricks of
// members and other ends have a state; constraints are the same for all axes.
//
// All energy differences in this file are twice those of E. Only their sign and order count.
//
// All kernels have the same arguments, except for the number of work-items at the end.

#include "brick.clh"
#include "state.clh"
#include "element.clh"
#include "method.clh"
#include "sweep.clh"
#include "rotations.clh"

#define FREE 0  // moves and rotates
#define BALL 1  // rotates about the reference element, which is held
#define HINGE 2 // rotates about an axis on which elements are held

#define BODY_RADIUS 3
#define BODY_AXIS 4
#define BODY_FREEDOM 7
#define ROW 8 // floats of a pose and of a body

#define SYSTEM 16 // floats of the sums of a chunk, and of a step
#define STEP_WHOLE 12
#define STEP_RISE 13
#define BOUNDS 8
#define LANES 16

#ifdef SOFT
// Sums over the soft links of the members of a cluster, lengths in mean spacings. w: weight of a link. r: place of its
// member at rest, relative to the reference element. t: displacement that the link pulls the member to. r_m and t_m are
// the means of r and t, weighted by w.
//
//   [0]            sum 2 w
//   SOFT_REST      r_m (3)
//   SOFT_PLACE     t_m (3)
//   SOFT_SECOND    sum 2 w (r - r_m) (r - r_m)^T (6: xx, xy, xz, yy, yz, zz)
//   SOFT_MIXED     sum 2 w (t - t_m) (r - r_m)^T (9, by rows, one for each component of t)
//
// Weights count twice, because the weight of a link between elements counts for both of its ends.
#define SOFT_ROW 24
#define SOFT_REST 1
#define SOFT_PLACE 4
#define SOFT_SECOND 7
#define SOFT_MIXED 13
#define SOFT_CLUSTERS_ARGUMENT , global const float *softClusters
#define SOFT_CLUSTERS_PASSED_ON , softClusters
#else
#define SOFT_CLUSTERS_ARGUMENT
#define SOFT_CLUSTERS_PASSED_ON
#endif

// The clusters of a grid. A kernel makes this of its arguments: `const Clusters clusters = CLUSTERS;`. The host is
// RotatingClusters::relax().
typedef struct
{
  global const int4* chunks;      // as in cluster.clh, like the next four
  global const uint* links;
  global const uchar* directions;
  global const int4* heads;
  global const uint2* members;
  uint memberCount;
  // ROW floats per cluster: the index of the reference element in the grid (3), the radius of a ball about it that
  // contains the cluster (1) [mean spacings], the axis of a hinge at rest (3), the freedom (1).
  global const float* bodies;
  // ROW floats per cluster: the displacement of its reference element (3) [fractions of the spacing], its rotation
  // (spin) (3), two unused.
  global float* poses;
  global float* ends;    // the pose after the step, laid out as poses
  global float* steps;   // SYSTEM floats per cluster, see solveCluster()
  global float* moves;   // of each cluster: how far it moved in this pass, 0 where it stayed
  global float* sums;    // SYSTEM floats per chunk, see gatherSystem()
  global float* bounds;  // BOUNDS floats per chunk, see boundChunk()
  global float2* checks; // of each chunk, see checkChunk()
#ifdef SOFT
  global const float* soft; // SOFT_ROW floats per cluster
#endif
} Clusters;

#define CLUSTERS_ARGUMENTS                                                                                             \
  global const int4 *chunks, global const uint *links, global const uchar *directions, global const int4 *heads,       \
    global const uint2 *members, uint memberCount, global const float *bodies, global float *poses,                    \
    global float *ends, global float *steps, global float *moves, global float *sums, global float *bounds,            \
    global float2 *checks SOFT_CLUSTERS_ARGUMENT
#define CLUSTERS                                                                                                       \
  {                                                                                                                    \
    chunks, links, directions, heads, members, memberCount, bodies, poses, ends, steps, moves, sums, bounds,           \
      checks SOFT_CLUSTERS_PASSED_ON                                                                                   \
  }

// A link that leaves a cluster: what does not depend on the pose. Lengths are in mean spacings, except displacements.
// The fourth component of all vectors is 0. i: the member at its one end. j: the element at its other end.
typedef struct
{
  float4 rest;        // r: from the reference element to i at rest
  float4 place;       // u(j) [fractions of the spacing]
  float4 axis;        // h e: from i to j at rest
  float4 otherOffset; // (R(j) - I) h e: the rest offset by the rotation of j
  float4 limit;
  float weight; // W, see relaxrotations.cl
} OutgoingLink;

typedef struct
{
  float4 arm;         // R r: the lever arm, from the reference element to i
  float4 axis;        // R h e: the link as the cluster's rotation R puts it
  float4 strain;      // u(j) - u(i) - (R - I) h e
  float4 otherStrain; // u(j) - u(i) - (R(j) - I) h e
} PosedLink;

// The cross product. builtins.clh, which PoCL reads in place of the header of built-in functions, has no cross().
CHAINMAIL_INLINE float4 across(float4 a, float4 b)
{
  return a.yzxw * b.zxyw - a.zxyw * b.yzxw;
}

CHAINMAIL_INLINE float4 three(global const float* values, uint pitch)
{
  return (float4)(values[0], values[pitch], values[2 * pitch], 0.0f);
}

CHAINMAIL_INLINE float4 lengths(float4 proportions)
{
  return (float4)(proportions.x, proportions.y, proportions.z, 0.0f);
}

// (R - I) v, as rotationOffset() of spin.clh, for vectors of OpenCL.
CHAINMAIL_INLINE float4 rotationOffsetOf(float4 spin, float4 v)
{
  const float part = 0.0625f * (spin.x * spin.x + spin.y * spin.y + spin.z * spin.z);
  const float scale = 1.0f / (1.0f + part);
  const float4 q = 0.5f * scale * spin;
  const float scalar = 2.0f * scale * (1.0f - part);
  const float square = 2.0f * (q.x * q.x + q.y * q.y + q.z * q.z);
  const float along = 2.0f * (q.x * v.x + q.y * v.y + q.z * v.z);
  return scalar * across(q, v) + (along * q - square * v);
}

// Link number n of the lists.
CHAINMAIL_INLINE OutgoingLink outgoingLink(
  const State* state, const Clusters* clusters, int n, global const float* body)
{
  OutgoingLink link;
  const uint other = clusters->links[n];
  const int d = clusters->directions[n];
  const float4 unit = lengths(state->proportions);
  const float sign = d & 1 ? 1.0f : -1.0f;
  const float4 step = (float4)(d / 2 == 0 ? sign : 0.0f, d / 2 == 1 ? sign : 0.0f, d / 2 == 2 ? sign : 0.0f, 0.0f);
  const int3 at = brickOf(&state->layout, other / ELEMENTS) * (int3)(BX, BY, BZ) + elementAt(other % ELEMENTS);
  const float4 end = (float4)(at.x, at.y, at.z, 0.0f) - step;
  link.axis = step * unit;
  link.rest = (end - three(body, 1)) * unit;
  link.place = three(state->displacement + other, state->layout.pitch);
  link.otherOffset = rotationOffsetOf(three(state->spin + other, state->layout.pitch), link.axis);
  // Constraints are the same for all axes here.
  const Link along = linkOf(0.0f, state->constraint[other], d, d / 2);
  const float length = alongAxis(state->proportions, d / 2);
  link.limit = along.limit * unit;
  link.weight = along.weight / (length * length);
  return link;
}

// A pose: the displacement of the reference element, and (R - I) times the unit vectors along the three axes.
typedef struct
{
  float4 place;
  float4 x, y, z;
} Pose;

CHAINMAIL_INLINE Pose loadPose(global const float* pose)
{
  const float4 spin = three(pose + 3, 1);
  Pose loaded;
  loaded.place = three(pose, 1);
  loaded.x = rotationOffsetOf(spin, (float4)(1.0f, 0.0f, 0.0f, 0.0f));
  loaded.y = rotationOffsetOf(spin, (float4)(0.0f, 1.0f, 0.0f, 0.0f));
  loaded.z = rotationOffsetOf(spin, (float4)(0.0f, 0.0f, 1.0f, 0.0f));
  return loaded;
}

// (R - I) v.
CHAINMAIL_INLINE float4 addedTo(const Pose* pose, float4 v)
{
  return v.x * pose->x + v.y * pose->y + v.z * pose->z;
}

CHAINMAIL_INLINE PosedLink posed(const OutgoingLink* link, const Pose* pose, float4 proportions)
{
  PosedLink as;
  const float4 more = addedTo(pose, link->rest);
  const float4 ownOffset = addedTo(pose, link->axis);
  const float4 difference = (link->place - pose->place) * lengths(proportions) - more;
  as.arm = link->rest + more;
  as.axis = link->axis + ownOffset;
  as.strain = difference - ownOffset;
  as.otherStrain = difference - link->otherOffset;
  return as;
}

#ifdef SOFT
// The rows of a symmetric matrix of 6 values.
CHAINMAIL_INLINE void symmetric(global const float* values, float4* rows)
{
  rows[0] = (float4)(values[0], values[1], values[2], 0.0f);
  rows[1] = (float4)(values[1], values[3], values[4], 0.0f);
  rows[2] = (float4)(values[2], values[4], values[5], 0.0f);
}

// The rows of the matrix R - I of a pose, or of the sum or difference of two such matrices.
CHAINMAIL_INLINE void rowsOf(float4 x, float4 y, float4 z, float4* rows)
{
  rows[0] = (float4)(x.x, y.x, z.x, 0.0f);
  rows[1] = (float4)(x.y, y.y, z.y, 0.0f);
  rows[2] = (float4)(x.z, y.z, z.z, 0.0f);
}

// The product of a matrix and a symmetric one, both by rows.
CHAINMAIL_INLINE void timesSymmetric(const float4* matrix, const float4* second, float4* product)
{
  for (int a = 0; a < 3; ++a)
  {
    product[a] = matrix[a].x * second[0] + matrix[a].y * second[1] + matrix[a].z * second[2];
  }
}

CHAINMAIL_INLINE float inner(float4 a, float4 b)
{
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

// Adds the soft links of a cluster to the sums of gatherSystem() over its links.
inline void addSoftLinksOf(const State* state, const Clusters* clusters, uint id, float* sum)
{
  const float4 proportions = state->proportions;
  global const float* soft = clusters->soft + SOFT_ROW * id;
  const Pose pose = loadPose(clusters->poses + ROW * id);
  const float weight = soft[0];
  const float4 rest = three(soft + SOFT_REST, 1);
  const float4 more = addedTo(&pose, rest);
  const float4 arm = rest + more;
  const float4 pull = weight * (three(soft + SOFT_PLACE, 1) - pose.place * lengths(proportions) - more);
  float4 second[3], added[3], rotated[3], moment[3], rotatedSecond[3];
  symmetric(soft + SOFT_SECOND, second);
  rowsOf(pose.x, pose.y, pose.z, added);
  timesSymmetric(added, second, moment);
  for (int a = 0; a < 3; ++a)
  {
    rotated[a] = added[a] + (float4)(a == 0 ? 1.0f : 0.0f, a == 1 ? 1.0f : 0.0f, a == 2 ? 1.0f : 0.0f, 0.0f);
    moment[a] = three(soft + SOFT_MIXED + 3 * a, 1) - moment[a]; // sum 2 w e r^T, e: see riseOfSoftLinks()
  }
  timesSymmetric(rotated, second, rotatedSecond);
  const float4 torque = across(arm, pull) + (float4)(inner(moment[2], rotated[1]) - inner(moment[1], rotated[2]),
                                              inner(moment[0], rotated[2]) - inner(moment[2], rotated[0]),
                                              inner(moment[1], rotated[0]) - inner(moment[0], rotated[1]), 0.0f);
  const float moments[15] = { weight * arm.x, weight * arm.y, weight * arm.z,
    weight * arm.x * arm.x + inner(rotatedSecond[0], rotated[0]),
    weight * arm.x * arm.y + inner(rotatedSecond[0], rotated[1]),
    weight * arm.x * arm.z + inner(rotatedSecond[0], rotated[2]),
    weight * arm.y * arm.y + inner(rotatedSecond[1], rotated[1]),
    weight * arm.y * arm.z + inner(rotatedSecond[1], rotated[2]),
    weight * arm.z * arm.z + inner(rotatedSecond[2], rotated[2]), pull.x, pull.y, pull.z, torque.x, torque.y,
    torque.z };
  sum[0] += weight;
  for (int m = 0; m < 15; ++m)
  {
    sum[1 + m] += moments[m];
  }
}

// By how much the energy of a cluster's soft links rises from its pose to that at the end of the step. With the
// residual e = t - p - A r of a link, A = R - I and p the displacement of a pose, that is sum 2 w (e' - e) (e' + e).
// Like riseOf() it is computed from differences, so little is lost by rounding where both poses are nearly the same.
inline float riseOfSoftLinks(const State* state, const Clusters* clusters, uint id)
{
  const float4 proportions = state->proportions;
  global const float* soft = clusters->soft + SOFT_ROW * id;
  const Pose now = loadPose(clusters->poses + ROW * id);
  const Pose then = loadPose(clusters->ends + ROW * id);
  const float4 rest = three(soft + SOFT_REST, 1);
  const float4 both[2] = { three(soft + SOFT_PLACE, 1) - now.place * lengths(proportions) - addedTo(&now, rest),
    three(soft + SOFT_PLACE, 1) - then.place * lengths(proportions) - addedTo(&then, rest) };
  float rise = soft[0] * inner(both[1] - both[0], both[1] + both[0]);
  float4 second[3], sums[3], differences[3], product[3];
  symmetric(soft + SOFT_SECOND, second);
  rowsOf(then.x + now.x, then.y + now.y, then.z + now.z, sums);
  rowsOf(then.x - now.x, then.y - now.y, then.z - now.z, differences);
  timesSymmetric(sums, second, product);
  for (int a = 0; a < 3; ++a)
  {
    rise += inner(differences[a], product[a] - 2.0f * three(soft + SOFT_MIXED + 3 * a, 1));
  }
  return rise;
}
#endif

// Prefetches the state that a chunk reads, which other threads have just written.
inline void prefetchChunk(const State* state, const Clusters* clusters, uint number)
{
  const int4 chunk = clusters->chunks[number];
  for (int n = chunk.y; n < chunk.y + chunk.z; ++n)
  {
    UNROLL
    for (int axis = 0; axis < 3; ++axis)
    {
      PREFETCH(displacementAlong(state, axis) + clusters->links[n]);
      PREFETCH(spinAlong(state, axis) + clusters->links[n]);
    }
  }
}

// Sums over the links of one chunk and both of the terms of a link in E: the weights W (1), their first and second
// moments, W x and W x x^T (3, 6), the force (3) and the torque (3). The lever arm x is R r for the term with R(j), and
// R (r + h e) for the term with R.
inline void gatherSystem(const State* state, const Clusters* clusters, uint number)
{
  const int4 chunk = clusters->chunks[number];
  const Pose pose = loadPose(clusters->poses + ROW * chunk.x);
  float weight = 0.0f;
  float4 first = (float4)(0.0f), ofX = first, ofYZ = first, force = first, torque = first;
  for (int n = chunk.y; n < chunk.y + chunk.z; ++n)
  {
    const OutgoingLink link = outgoingLink(state, clusters, n, clusters->bodies + ROW * chunk.x);
    const PosedLink now = posed(&link, &pose, state->proportions);
    const float4 arms[2] = { now.arm, now.arm + now.axis };
    const float4 pulls[2] = { now.otherStrain, now.strain };
    weight += 2.0f * link.weight;
    UNROLL
    for (int which = 0; which < 2; ++which)
    {
      const float4 arm = arms[which], moment = link.weight * arm, pull = link.weight * pulls[which];
      first += moment;
      ofX += moment.x * arm;
      ofYZ += moment.yyzw * arm.yzzw;
      force += pull;
      torque += across(arm, pull);
    }
  }
  global float* out = clusters->sums + SYSTEM * number;
  out[0] = weight;
  vstore3(first.xyz, 0, out + 1);
  vstore3(ofX.xyz, 0, out + 4);
  vstore3(ofYZ.xyz, 0, out + 7);
  vstore3(force.xyz, 0, out + 10);
  vstore3(torque.xyz, 0, out + 13);
}

kernel void rotatingGather(PASS_ARGUMENTS, STATE_ARGUMENTS, CLUSTERS_ARGUMENTS, METHOD_ARGUMENTS, uint count)
{
  const Pass pass = PASS;
  const State state = STATE;
  const Clusters clusters = CLUSTERS;
  if (get_global_id(0) < count && !isCalledOff(&pass))
  {
    gatherSystem(&state, &clusters, get_global_id(0));
  }
}

// Solves a symmetric positive definite system of six unknowns in place.
inline void solve(float matrix[6][6], float* x)
{
  for (int n = 0; n < 6; ++n)
  {
    const float pivot = 1.0f / matrix[n][n];
    for (int m = n + 1; m < 6; ++m)
    {
      const float factor = matrix[m][n] * pivot;
      for (int k = n; k < 6; ++k)
      {
        matrix[m][k] -= factor * matrix[n][k];
      }
      x[m] -= factor * x[n];
    }
  }
  for (int n = 5; n >= 0; --n)
  {
    for (int k = n + 1; k < 6; ++k)
    {
      x[n] -= matrix[n][k] * x[k];
    }
    x[n] /= matrix[n][n];
  }
}

// The pose after the given share of a step: a move [mean spacings] and a rotation (Rodrigues vector, spin.clh).
inline void stepFrom(global const float* pose, const float* step, float share, float4 proportions, float* out)
{
  const float own[3] = { pose[3], pose[4], pose[5] };
  const float rotation[3] = { share * step[3], share * step[4], share * step[5] };
  for (int axis = 0; axis < 3; ++axis)
  {
    out[axis] = pose[axis] + share * step[axis] / alongAxis(proportions, axis);
  }
  steppedSpin(own, rotation, 1.0f, out + 3);
  shortestSpin(out + 3);
}

inline void storePose(const float* pose, global float* out)
{
  for (int m = 0; m < 6; ++m)
  {
    out[m] = pose[m];
  }
}

// Entry m of the sums over those chunks of a cluster that belong to one of LANES lanes.
inline float laneOfSystem(const Clusters* clusters, uint id, int lane, int m)
{
  const int4 head = clusters->heads[id];
  float sum = 0.0f;
  for (int chunk = lane; chunk < head.y; chunk += LANES)
  {
    sum += clusters->sums[SYSTEM * (head.x + chunk) + m];
  }
  return sum;
}

// Computes the step of a cluster from the sums over all of its links, and the pose at its end. Entries of a step:
//
//   [0] to [5]     move and rotation, times `factor`
//   [6]            by how much the quadratic model of the energy falls for factor 1
//   [7]            factor
//   [8] to [10]    the best move without a rotation, for factor 1
//   [11]           sum of 2 W
//   STEP_WHOLE, STEP_RISE: see chooseStep()
inline void solveCluster(const State* state, const Clusters* clusters, float omega, uint id, const float* sum)
{
  global const float* body = clusters->bodies + ROW * id;
  global const float* pose = clusters->poses + ROW * id;
  global float* out = clusters->steps + SYSTEM * id;
  const int freedom = (int)body[BODY_FREEDOM];
  const float radius = body[BODY_RADIUS];
  float step[6], right[6], matrix[6][6];
  // Rotations are multiplied by the radius, so all six unknowns are lengths of the same order.
  const float scale = 1.0f / radius;
  const float second[3][3] = { { sum[4], sum[5], sum[6] }, { sum[5], sum[7], sum[8] }, { sum[6], sum[8], sum[9] } };
  const float trace = sum[4] + sum[7] + sum[9];
  for (int a = 0; a < 3; ++a)
  {
    const int b = (a + 1) % 3, c = (a + 2) % 3;
    for (int e = 0; e < 3; ++e)
    {
      matrix[a][e] = a == e ? sum[0] : 0.0f;
      matrix[3 + a][3 + e] = scale * scale * ((a == e ? trace : 0.0f) - second[a][e]);
    }
    // the cross product with the first moment
    matrix[3 + a][a] = matrix[a][3 + a] = 0.0f;
    matrix[3 + a][b] = matrix[b][3 + a] = -scale * sum[1 + c];
    matrix[3 + a][c] = matrix[c][3 + a] = scale * sum[1 + b];
    right[a] = sum[10 + a];
    right[3 + a] = scale * sum[13 + a];
  }
  if (freedom == HINGE)
  {
    const float own[3] = { pose[3], pose[4], pose[5] };
    const float rest[3] = { body[BODY_AXIS], body[BODY_AXIS + 1], body[BODY_AXIS + 2] };
    float axis[3];
    rotationOffset(own, rest, axis);
    float inertia = 0.0f, moment = 0.0f;
    for (int a = 0; a < 3; ++a)
    {
      axis[a] += rest[a];
    }
    for (int a = 0; a < 3; ++a)
    {
      moment += axis[a] * right[3 + a];
      for (int e = 0; e < 3; ++e)
      {
        inertia += axis[a] * matrix[3 + a][3 + e] * axis[e];
      }
    }
    for (int a = 0; a < 3; ++a)
    {
      step[a] = 0.0f;
      step[3 + a] = inertia > 0.0f ? axis[a] * moment / inertia : 0.0f;
    }
  }
  else
  {
    for (int a = 0; a < 3; ++a)
    {
      for (int e = 0; freedom == BALL && e < 6; ++e)
      {
        matrix[a][e] = matrix[e][a] = a == e ? 1.0f : 0.0f;
      }
      right[a] = freedom == BALL ? 0.0f : right[a];
    }
    for (int m = 0; m < 6; ++m)
    {
      step[m] = right[m];
      matrix[m][m] = matrix[m][m] * (1.0f + 1e-6f) + 1e-20f;
    }
    solve(matrix, step);
  }
  float gain = 0.0f;
  for (int m = 0; m < 6; ++m)
  {
    gain += right[m] * step[m];
  }
  float angle = 0.0f;
  for (int a = 0; a < 3; ++a)
  {
    step[3 + a] *= scale;
    angle = max(angle, fabs(step[3 + a]));
  }
  // The step is linear in the angle. To keep the error small, no component of the rotation exceeds 0.2 rad.
  const float factor = min(omega, 0.2f / max(angle, 1e-20f));
  for (int m = 0; m < 6; ++m)
  {
    step[m] *= factor;
    out[m] = step[m];
  }
  out[6] = gain;
  out[7] = factor;
  for (int a = 0; a < 3; ++a)
  {
    out[8 + a] = freedom == FREE ? sum[10 + a] / sum[0] : 0.0f;
  }
  out[11] = sum[0];
  float end[6];
  stepFrom(pose, step, 1.0f, state->proportions, end);
  storePose(end, clusters->ends + ROW * id);
}

// solveCluster() for each cluster, one work-group each.
kernel void rotatingSolve(PASS_ARGUMENTS, STATE_ARGUMENTS, CLUSTERS_ARGUMENTS, METHOD_ARGUMENTS)
{
  const Pass pass = PASS;
  const State state = STATE;
  const Clusters clusters = CLUSTERS;
  local float lanes[SYSTEM * LANES];
  const uint id = get_group_id(0);
  for (int lane = get_local_id(0); lane < SYSTEM * LANES; lane += get_local_size(0))
  {
    lanes[lane] = laneOfSystem(&clusters, id, lane / SYSTEM, lane % SYSTEM);
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (get_local_id(0) > 0 || isCalledOff(&pass))
  {
    return;
  }
  float sum[SYSTEM];
  for (int m = 0; m < SYSTEM; ++m)
  {
    sum[m] = 0.0f;
    for (int lane = 0; lane < min(LANES, heads[id].y); ++lane)
    {
      sum[m] += lanes[SYSTEM * lane + m];
    }
  }
#ifdef SOFT
  addSoftLinksOf(&state, &clusters, id, sum);
#endif
  solveCluster(&state, &clusters, omega, id, sum);
}

// By how much the energy of a link rises from one pose to another, by axes.
CHAINMAIL_INLINE float4 riseOf(float weight, const PosedLink* now, const PosedLink* then)
{
  return weight * ((then->strain - now->strain) * (then->strain + now->strain) +
                    (then->otherStrain - now->otherStrain) * (then->otherStrain + now->otherStrain));
}

// u(j) - u(i) - rest offset, with the mean of the rest offsets of both ends.
CHAINMAIL_INLINE float4 meanStrain(const PosedLink* link)
{
  return 0.5f * (link->strain + link->otherStrain);
}

// Bounds from the links of a chunk: the share of the step that their limits allow, by linear interpolation (1); lower
// and upper bounds of a move without a rotation (3, 3); by how much the energy would rise in the whole step (1).
inline void boundChunk(const State* state, const Clusters* clusters, uint number)
{
  const int4 chunk = clusters->chunks[number];
  const Pose pose = loadPose(clusters->poses + ROW * chunk.x);
  const Pose end = loadPose(clusters->ends + ROW * chunk.x);
  float4 share = (float4)(1.0f), rise = (float4)(0.0f);
  float4 lower = (float4)(-INFINITY), upper = (float4)(INFINITY);
  for (int n = chunk.y; n < chunk.y + chunk.z; ++n)
  {
    const OutgoingLink link = outgoingLink(state, clusters, n, clusters->bodies + ROW * chunk.x);
    const PosedLink now = posed(&link, &pose, state->proportions);
    const PosedLink then = posed(&link, &end, state->proportions);
    const float4 from = meanStrain(&now), to = meanStrain(&then);
    const float4 room = select(link.limit + from, link.limit - from, to > 0.0f);
    const float4 allowed = max(room, 0.0f) / fabs(to - from);
    rise += riseOf(link.weight, &now, &then);
    lower = max(lower, from - link.limit);
    upper = min(upper, from + link.limit);
    share = select(share, min(share, allowed), (fabs(to) > link.limit) & (fabs(to) > fabs(from)));
  }
  global float* out = clusters->bounds + BOUNDS * number;
  out[0] = min(min(share.x, share.y), share.z);
  vstore3(lower.xyz, 0, out + 1);
  vstore3(upper.xyz, 0, out + 4);
  out[7] = rise.x + rise.y + rise.z;
}

kernel void rotatingBound(PASS_ARGUMENTS, STATE_ARGUMENTS, CLUSTERS_ARGUMENTS, METHOD_ARGUMENTS, uint count)
{
  const Pass pass = PASS;
  const State state = STATE;
  const Clusters clusters = CLUSTERS;
  if (get_global_id(0) < count && !isCalledOff(&pass))
  {
    boundChunk(&state, &clusters, get_global_id(0));
  }
}

// Combines entry m of the bounds of a chunk with that of others: sum of rises, least share, tightest bounds of a move.
inline float boundOf(int m, float all, float part)
{
  return m == 7 ? all + part : m == 0 || m >= 4 ? min(all, part) : max(all, part);
}

// Entry m of the bounds over those chunks of a cluster that belong to one of LANES lanes.
inline float laneOfBounds(const Clusters* clusters, uint id, int lane, int m)
{
  const int4 head = clusters->heads[id];
  float value = m == 0 ? 1.0f : m == 7 ? 0.0f : m < 4 ? -INFINITY : INFINITY;
  for (int chunk = lane; chunk < head.y; chunk += LANES)
  {
    value = boundOf(m, value, clusters->bounds[BOUNDS * (head.x + chunk) + m]);
  }
  return value;
}

// Chooses the allowed part of the step or a move without a rotation, whichever lowers the energy more. STEP_WHOLE
// stores whether the whole step is chosen, STEP_RISE by how much the energy rises in the whole step.
inline void chooseStep(
  const State* state, const Clusters* clusters, const Method* method, uint id, const float* bound)
{
  const float omega = method->omega;
  const int limited = method->limited;
  global float* const solved = clusters->steps + SYSTEM * id;
  // The share is a linear estimate, so a shortened step stops a little before the limits.
  const float share = !limited || bound[0] >= 1.0f ? 1.0f : 0.95f * bound[0];
  float step[6], move[6];
  const float part = share * solved[7];
  const float gain = part * (2.0f - part) * solved[6];
  float gainOfMove = 0.0f;
  for (int axis = 0; axis < 3; ++axis)
  {
    const float best = solved[8 + axis];
    float to = omega * best;
    to = limited ? min(max(to, bound[1 + axis]), bound[4 + axis]) : to;
    to = limited && bound[1 + axis] > bound[4 + axis] ? 0.0f : to;
    gainOfMove += solved[11] * to * (2.0f * best - to);
    move[axis] = to;
    move[3 + axis] = 0.0f;
  }
  for (int m = 0; m < 6; ++m)
  {
    step[m] = gainOfMove > gain ? move[m] : share * solved[m];
    solved[m] = step[m];
  }
  solved[STEP_WHOLE] = share == 1.0f && !(gainOfMove > gain) ? 1.0f : 0.0f;
  solved[STEP_RISE] = bound[7];
  float end[6];
  stepFrom(clusters->poses + ROW * id, step, 1.0f, state->proportions, end);
  storePose(end, clusters->ends + ROW * id);
}

kernel void rotatingChoose(PASS_ARGUMENTS, STATE_ARGUMENTS, CLUSTERS_ARGUMENTS, METHOD_ARGUMENTS)
{
  const Pass pass = PASS;
  const State state = STATE;
  const Clusters clusters = CLUSTERS;
  const Method method = METHOD;
  local float lanes[BOUNDS * LANES];
  const uint id = get_group_id(0);
  for (int lane = get_local_id(0); lane < BOUNDS * LANES; lane += get_local_size(0))
  {
    lanes[lane] = laneOfBounds(&clusters, id, lane / BOUNDS, lane % BOUNDS);
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (get_local_id(0) > 0 || isCalledOff(&pass))
  {
    return;
  }
  float bound[BOUNDS];
  for (int m = 0; m < BOUNDS; ++m)
  {
    bound[m] = lanes[m];
    for (int lane = 1; lane < min(LANES, heads[id].y); ++lane)
    {
      bound[m] = boundOf(m, bound[m], lanes[BOUNDS * lane + m]);
    }
  }
#ifdef SOFT
  bound[7] += riseOfSoftLinks(&state, &clusters, id);
#endif
  chooseStep(&state, &clusters, &method, id, bound);
}

// For steps that are not whole: by how much links of a chunk would exceed their limits, and by how much the energy
// would rise. Links whose strain does not grow do not count as beyond their limits.
inline void checkChunk(const State* state, const Clusters* clusters, uint number)
{
  const int4 chunk = clusters->chunks[number];
  if (clusters->steps[SYSTEM * chunk.x + STEP_WHOLE] != 0.0f)
  {
    return;
  }
  const Pose pose = loadPose(clusters->poses + ROW * chunk.x);
  const Pose end = loadPose(clusters->ends + ROW * chunk.x);
  float4 beyond = (float4)(0.0f), rise = (float4)(0.0f);
  for (int n = chunk.y; n < chunk.y + chunk.z; ++n)
  {
    const OutgoingLink link = outgoingLink(state, clusters, n, clusters->bodies + ROW * chunk.x);
    const PosedLink now = posed(&link, &pose, state->proportions);
    const PosedLink then = posed(&link, &end, state->proportions);
    const float4 from = fabs(meanStrain(&now)), to = fabs(meanStrain(&then));
    rise += riseOf(link.weight, &now, &then);
    beyond = select(beyond, max(beyond, to - link.limit), (to > from) & (to > link.limit));
  }
  clusters->checks[number] = (float2)(max(max(beyond.x, beyond.y), beyond.z), rise.x + rise.y + rise.z);
}

kernel void rotatingCheck(PASS_ARGUMENTS, STATE_ARGUMENTS, CLUSTERS_ARGUMENTS, METHOD_ARGUMENTS, uint count)
{
  const Pass pass = PASS;
  const State state = STATE;
  const Clusters clusters = CLUSTERS;
  if (get_global_id(0) < count && !isCalledOff(&pass))
  {
    checkChunk(&state, &clusters, get_global_id(0));
  }
}

// By how much rounding may put a link beyond its limit [mean spacings].
#define ROUNDING 2e-6f

// The checks over those chunks of a cluster that belong to one of LANES lanes: by how much a link is beyond its limit
// at most, and by how much the energy rises.
inline float2 laneOfChecks(const Clusters* clusters, uint id, int lane)
{
  const int4 head = clusters->heads[id];
  float2 sum = (float2)(0.0f, 0.0f);
  for (int chunk = lane; chunk < head.y; chunk += LANES)
  {
    const float2 part = clusters->checks[head.x + chunk];
    sum = (float2)(max(sum.x, part.x), sum.y + part.y);
  }
  return sum;
}

// Takes the step of a cluster if it passed the check. Stores how far the cluster moved, 0 where it stayed.
inline void acceptStep(const State* state, const Clusters* clusters, const Method* method, const Pass* pass, uint id,
  float beyond, float rise)
{
  global const float* step = clusters->steps + SYSTEM * id;
  float move = 0.0f;
  clusters->moves[id] = 0.0f;
  for (int axis = 0; axis < 3; ++axis)
  {
    const float length = alongAxis(state->proportions, axis);
    move = max(move, fabs(step[axis]) / length);
    move = max(move, fabs(step[3 + axis]) * clusters->bodies[ROW * id + BODY_RADIUS] / length);
  }
  if ((method->limited && beyond > ROUNDING) || !(rise <= 0.0f) || !(move > method->still))
  {
    return;
  }
  for (int m = 0; m < 6; ++m)
  {
    clusters->poses[ROW * id + m] = clusters->ends[ROW * id + m];
  }
  clusters->moves[id] = move;
  recordMove(pass, move);
}

// Records that the launch was called off for a cluster.
inline void leaveOut(const Clusters* clusters, const Pass* pass, uint id)
{
  clusters->moves[id] = 0.0f;
  if (id == 0)
  {
    callOff(pass);
  }
}

kernel void rotatingAccept(PASS_ARGUMENTS, STATE_ARGUMENTS, CLUSTERS_ARGUMENTS, METHOD_ARGUMENTS)
{
  const Pass pass = PASS;
  const State state = STATE;
  const Clusters clusters = CLUSTERS;
  const Method method = METHOD;
  local float2 lanes[LANES];
  const uint id = get_group_id(0);
  const bool whole = steps[SYSTEM * id + STEP_WHOLE] != 0.0f;
  for (int lane = get_local_id(0); lane < LANES; lane += get_local_size(0))
  {
    lanes[lane] = whole ? (float2)(0.0f, 0.0f) : laneOfChecks(&clusters, id, lane);
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (get_local_id(0) > 0)
  {
    return;
  }
  if (isCalledOff(&pass))
  {
    leaveOut(&clusters, &pass, id);
    return;
  }
  float beyond = 0.0f, rise = whole ? steps[SYSTEM * id + STEP_RISE] : 0.0f;
  for (int lane = 0; lane < min(LANES, heads[id].y); ++lane)
  {
    beyond = max(beyond, lanes[lane].x);
    rise += lanes[lane].y;
  }
#ifdef SOFT
  rise += whole ? 0.0f : riseOfSoftLinks(&state, &clusters, id);
#endif
  acceptStep(&state, &clusters, &method, &pass, id, beyond, rise);
}

// Gives a member the displacement and rotation of its cluster's pose. Held elements keep their displacement and take
// the rotation.
inline void scatterMember(const State* state, const Clusters* clusters, const Pass* pass, uint number)
{
  const uint2 member = clusters->members[number]; // address, cluster
  atomic_max(&pass->activity[SWEEP_ROW * (member.x / ELEMENTS) + SWEEP_NOTED], pass->sweep);
  const int3 size = (int3)(BX, BY, BZ);
  const int3 at = brickOf(&state->layout, member.x / ELEMENTS) * size + elementAt(member.x % ELEMENTS);
  const float4 proportions = state->proportions;
  global const float* body = clusters->bodies + ROW * member.y;
  global const float* pose = clusters->poses + ROW * member.y;
  const float own[3] = { pose[3], pose[4], pose[5] };
  const float rest[3] = { ((float)at.x - body[0]) * proportions.x, ((float)at.y - body[1]) * proportions.y,
    ((float)at.z - body[2]) * proportions.z };
  float more[3];
  rotationOffset(own, rest, more);
  const int held = signbit(state->constraint[member.x]);
  for (int axis = 0; axis < 3; ++axis)
  {
    spinAlong(state, axis)[member.x] = own[axis];
    if (!held)
    {
      displacementAlong(state, axis)[member.x] = pose[axis] + more[axis] / alongAxis(proportions, axis);
    }
  }
}

kernel void rotatingScatter(PASS_ARGUMENTS, STATE_ARGUMENTS, CLUSTERS_ARGUMENTS, METHOD_ARGUMENTS, uint count)
{
  const Pass pass = PASS;
  const State state = STATE;
  const Clusters clusters = CLUSTERS;
  if (get_global_id(0) < count && moves[members[get_global_id(0)].y] > 0.0f)
  {
    scatterMember(&state, &clusters, &pass, get_global_id(0));
  }
}

// All steps above for each cluster in one launch, one work-item each. It serves clusters with so few links that
// separate launches would take longer than their work. The results are the same to the bit.
kernel void rotatingAtOnce(PASS_ARGUMENTS, STATE_ARGUMENTS, CLUSTERS_ARGUMENTS, METHOD_ARGUMENTS)
{
  const Pass pass = PASS;
  const State state = STATE;
  const Clusters clusters = CLUSTERS;
  const Method method = METHOD;
  const uint id = get_group_id(0);
  const int4 head = heads[id];
  if (isCalledOff(&pass))
  {
    leaveOut(&clusters, &pass, id);
    return;
  }
  for (int n = head.x; n < head.x + head.y; ++n)
  {
    prefetchChunk(&state, &clusters, min(n + 1, head.x + head.y - 1));
    gatherSystem(&state, &clusters, n);
  }
  float sum[SYSTEM];
  for (int m = 0; m < SYSTEM; ++m)
  {
    sum[m] = 0.0f;
    for (int lane = 0; lane < min(LANES, head.y); ++lane)
    {
      sum[m] += laneOfSystem(&clusters, id, lane, m);
    }
  }
#ifdef SOFT
  addSoftLinksOf(&state, &clusters, id, sum);
#endif
  solveCluster(&state, &clusters, omega, id, sum);

  for (int n = head.x; n < head.x + head.y; ++n)
  {
    boundChunk(&state, &clusters, n);
  }
  float bound[BOUNDS];
  for (int m = 0; m < BOUNDS; ++m)
  {
    bound[m] = laneOfBounds(&clusters, id, 0, m);
    for (int lane = 1; lane < min(LANES, head.y); ++lane)
    {
      bound[m] = boundOf(m, bound[m], laneOfBounds(&clusters, id, lane, m));
    }
  }
#ifdef SOFT
  bound[7] += riseOfSoftLinks(&state, &clusters, id);
#endif
  chooseStep(&state, &clusters, &method, id, bound);

  const bool whole = steps[SYSTEM * id + STEP_WHOLE] != 0.0f;
  float beyond = 0.0f, rise = whole ? steps[SYSTEM * id + STEP_RISE] : 0.0f;
  for (int n = head.x; n < head.x + head.y && !whole; ++n)
  {
    checkChunk(&state, &clusters, n);
  }
  for (int lane = 0; lane < min(LANES, head.y) && !whole; ++lane)
  {
    const float2 part = laneOfChecks(&clusters, id, lane);
    beyond = max(beyond, part.x);
    rise += part.y;
  }
#ifdef SOFT
  rise += whole ? 0.0f : riseOfSoftLinks(&state, &clusters, id);
#endif
  acceptStep(&state, &clusters, &method, &pass, id, beyond, rise);

  for (uint n = head.w; n < memberCount && members[n].y == id && moves[id] > 0.0f; ++n)
  {
    scatterMember(&state, &clusters, &pass, n);
  }
}
