// The third colour pass of a relaxation sweep: rigid clusters, each one unknown. The links that leave a cluster are
// listed in an order that no brick size changes, in chunks of fixed length, so that sums are the same for every layout.
//
// The host guarantees: all members of a cluster have the same displacement and none is held; the other ends of its
// links are not rigid; the bricks of both have memory.
//
// ways: the directions of links. activity, log, turn: see sweep.clh.

#include "brick.clh"
#include "element.clh"
#include "sweep.clh"
#include "turning.clh"

// Sums up one chunk of links. chunk: cluster, first link, number of links. partial[(chunk * 3 + axis) * 4] is the sum,
// as the fields of Neighbours.
kernel void clusterGather(global const int* log, int4 turn, global const int4* chunks, global const uint* links,
  global const uchar* ways, global const float* places, float slack, uint pitch, uint tissuePitch,
  global const float* displacement, global const float* constraint SPIN_ARGUMENTS, global float* partial, uint count)
{
  if (get_global_id(0) >= count || isCalledOff(log, turn, -1.0f))
  {
    return;
  }
  const int4 chunk = chunks[get_global_id(0)];
  for (int axis = 0; axis < 3; ++axis)
  {
    global const float* u = displacement + axis * pitch;
    global const float* c = constraint + min(axis, AXES - 1) * tissuePitch;
    const float ui = places[chunk.x * 3 + axis];
    Neighbours sum = noNeighbours();
    for (int n = chunk.y; n < chunk.y + chunk.z; ++n)
    {
      const float limit = linkLimit(0.0f, c[links[n]]);
      float place = u[links[n]];
      float weight = linkWeight(limit);
#ifdef TURNING
      // Rigid elements do not turn where constraints differ by axis.
      const float other[3] = { spin[links[n]], spin[pitch + links[n]], spin[2 * pitch + links[n]] };
      const float length = proportion(proportions, ways[n] / 2);
      float wanted[3];
      wantedApart(other, ways[n], proportions, wanted);
      place -= 0.5f * wanted[axis];
      weight /= length * length;
#endif
      neighboursAdd(&sum, ui, place, limit, weight, slack);
    }
    vstore4((float4)(sum.weight, sum.pull, sum.lower, sum.upper), get_global_id(0) * 3 + axis, partial);
  }
}

// Moves the clusters, one work-group each. The chunks are added up in LANES sums, whatever the number of work-items.
//
// cluster: first chunk, number of chunks, axis (-1 for all three). moves: how far the cluster went, 0 where it stayed.
// limited: whether links keep their limits.
#define LANES 16
kernel void clusterMove(global int* log, int4 turn, global const int4* clusters, int limited, float omega, float still,
  global const float* partial, global float* places, global float* moves)
{
  local Neighbours lanes[3 * LANES];
  const uint id = get_group_id(0);
  const int lid = get_local_id(0);
  const int4 cluster = clusters[id];
  for (int lane = lid; lane < 3 * LANES; lane += get_local_size(0))
  {
    Neighbours n = noNeighbours();
    for (int chunk = lane / 3; chunk < cluster.y; chunk += LANES)
    {
      const float4 part = vload4((cluster.x + chunk) * 3 + lane % 3, partial);
      n.weight += part.x;
      n.pull += part.y;
      n.lower = max(n.lower, part.z);
      n.upper = min(n.upper, part.w);
    }
    lanes[lane] = n;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (lid > 0)
  {
    return;
  }
  if (isCalledOff(log, turn, -1.0f))
  {
    moves[id] = 0.0f;
    if (id == 0)
    {
      log[SWEEP_LOG * turn.x + SWEEP_CALLED_OFF] = 1;
    }
    return;
  }
  float move = 0.0f;
  for (int axis = 0; axis < 3; ++axis)
  {
    if (cluster.z >= 0 && cluster.z != axis)
    {
      continue;
    }
    Neighbours n = noNeighbours();
    for (int lane = 0; lane < min(LANES, cluster.y); ++lane)
    {
      const Neighbours part = lanes[3 * lane + axis];
      n.weight += part.weight;
      n.pull += part.pull;
      n.lower = max(n.lower, part.lower);
      n.upper = min(n.upper, part.upper);
    }
    n.lower = limited ? n.lower : -INFINITY;
    n.upper = limited ? n.upper : INFINITY;
    const float u = places[id * 3 + axis];
    const float next = relaxedPlace(n, u, omega, still);
    places[id * 3 + axis] = next;
    move = max(move, fabs(next - u));
  }
  moves[id] = move;
  if (move > 0.0f)
  {
    atomic_max(&log[SWEEP_LOG * turn.x + SWEEP_LARGEST], as_int(move));
  }
}

// Moves the members to their cluster's new place. member: address, cluster.
kernel void clusterScatter(global int* activity, int4 turn, global const uint2* members, global const int4* clusters,
  global const float* places, global const float* moves, uint pitch, global float* displacement, uint count)
{
  if (get_global_id(0) >= count)
  {
    return;
  }
  const uint2 member = members[get_global_id(0)];
  if (moves[member.y] == 0.0f)
  {
    return;
  }
  atomic_max(&activity[SWEEP_ROW * (member.x / ELEMENTS) + SWEEP_NOTED], turn.z);
  for (int axis = 0; axis < 3; ++axis)
  {
    if (clusters[member.y].z < 0 || clusters[member.y].z == axis)
    {
      displacement[axis * pitch + member.x] = places[member.y * 3 + axis];
    }
  }
}
