// The third colour pass of a relaxation sweep: rigid clusters, each one unknown per axis (cluster.clh).
//
// The host guarantees: all members of a cluster have the same displacement and none is held; the other ends of its
// links are not rigid; the bricks of members and other ends have a state; WIDTH is 1.
//
// activity, log, turn: see sweep.clh.

#include "brick.clh"
#include "element.clh"
#include "softlinks.clh"
#include "sweep.clh"
#include "turning.clh"

#include "cluster.clh"

// Sums over the links of clusters, one work-item for each chunk.
kernel void clusterGather(global const int* log, int4 turn, global const int4* chunks, global const uint* links,
  global const uchar* ways, global const float* places, float slack, uint pitch, uint tissuePitch,
  global const float* displacement, global const float* constraint SPIN_ARGUMENTS, global float* partial, uint count)
{
  if (get_global_id(0) >= count || isCalledOff(log, turn, -1.0f))
  {
    return;
  }
  for (int axis = 0; axis < 3; ++axis)
  {
    gatherChunk(get_global_id(0), axis, chunks, links, ways, places, slack, pitch, tissuePitch, displacement,
      constraint SPIN_PASSED_ON, partial);
  }
}

// Moves the clusters, one work-group each. limited: whether the limits of links apply.
kernel void clusterMove(global int* log, int4 turn, global const int4* clusters, int limited, float omega, float still,
  global const float* partial, global float* places, global float* moves SOFT_CLUSTERS SOFT_ARGUMENTS)
{
  local Neighbours lanes[3 * LANES];
  const uint id = get_group_id(0);
  const int lid = get_local_id(0);
  const int4 cluster = clusters[id];
  for (int lane = lid; lane < 3 * LANES; lane += get_local_size(0))
  {
    lanes[lane] = laneOfCluster(cluster, lane / 3, lane % 3, partial);
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
      neighboursJoin(&n, lanes[3 * lane + axis]);
    }
#ifdef SOFT
    addSoftOfCluster(&n, id, axis, places, softClusters, softProportions);
#endif
    move = max(move, moveAlong(n, limited, omega, still, places + id * 3 + axis));
  }
  moves[id] = move;
  if (move > 0.0f)
  {
    atomic_max(&log[SWEEP_LOG * turn.x + SWEEP_LARGEST], as_int(move));
  }
}

// Gives the members the new displacement of their cluster, one work-item each.
kernel void clusterScatter(global int* activity, int4 turn, global const uint2* members, global const int4* clusters,
  global const float* places, global const float* moves, uint pitch, global float* displacement, uint count)
{
  if (get_global_id(0) < count)
  {
    scatterMember(get_global_id(0), turn.z, activity, members, clusters, places, moves, pitch, displacement);
  }
}
