// The third colour pass of a relaxation sweep: rigid clusters, each one unknown per axis (cluster.clh).
//
// The host guarantees: all members of a cluster have the same displacement and none is held; the other ends of its
// links are not rigid; the bricks of members and other ends have a state; WIDTH is 1.
//
// All kernels have the same arguments, except for numbers at the end.

#include "brick.clh"
#include "state.clh"
#include "element.clh"
#include "method.clh"
#include "softlinks.clh"
#include "sweep.clh"
#include "rotations.clh"

#include "cluster.clh"

// Sums over the links of clusters, one work-item for each chunk.
kernel void clusterGather(PASS_ARGUMENTS, STATE_ARGUMENTS, CLUSTERS_ARGUMENTS, METHOD_ARGUMENTS, uint count)
{
  const Pass pass = PASS;
  const State state = STATE;
  const Clusters clusters = CLUSTERS;
  if (get_global_id(0) >= count || isCalledOff(&pass))
  {
    return;
  }
  for (int axis = 0; axis < 3; ++axis)
  {
    gatherChunk(&state, &clusters, slack, get_global_id(0), axis);
  }
}

// Moves the clusters, one work-group each.
kernel void clusterMove(PASS_ARGUMENTS, STATE_ARGUMENTS, CLUSTERS_ARGUMENTS, METHOD_ARGUMENTS)
{
  const Pass pass = PASS;
  const State state = STATE;
  const Clusters clusters = CLUSTERS;
  const Method method = METHOD;
  local Neighbours lanes[3 * LANES];
  const uint id = get_group_id(0);
  const int lid = get_local_id(0);
  const int4 head = heads[id];
  for (int lane = lid; lane < 3 * LANES; lane += get_local_size(0))
  {
    lanes[lane] = laneOfCluster(&clusters, id, lane / 3, lane % 3);
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (lid > 0)
  {
    return;
  }
  if (isCalledOff(&pass))
  {
    moves[id] = 0.0f;
    if (id == 0)
    {
      callOff(&pass);
    }
    return;
  }
  float move = 0.0f;
  for (int axis = 0; axis < 3; ++axis)
  {
    if (head.z >= 0 && head.z != axis)
    {
      continue;
    }
    Neighbours sum = noNeighbours();
    for (int lane = 0; lane < min(LANES, head.y); ++lane)
    {
      neighboursJoin(&sum, lanes[3 * lane + axis]);
    }
    move = max(move, moveAlong(&state, &clusters, &method, id, axis, sum));
  }
  moves[id] = move;
  recordMove(&pass, move);
}

// Gives the members the new displacement of their cluster, one work-item each.
kernel void clusterScatter(PASS_ARGUMENTS, STATE_ARGUMENTS, CLUSTERS_ARGUMENTS, METHOD_ARGUMENTS, uint count)
{
  const Pass pass = PASS;
  const State state = STATE;
  const Clusters clusters = CLUSTERS;
  if (get_global_id(0) < count)
  {
    scatterMember(&state, &clusters, &pass, get_global_id(0));
  }
}

// Does all three steps by a single work-item. It serves clusters so few that three launches would take longer than the
// steps. The results are the same to the bit.
kernel void clusterPass(PASS_ARGUMENTS, STATE_ARGUMENTS, CLUSTERS_ARGUMENTS, METHOD_ARGUMENTS, int4 counts)
{
  const Pass pass = PASS;
  const State state = STATE;
  const Clusters clusters = CLUSTERS;
  const Method method = METHOD;
  relaxClusters(&state, &clusters, &method, &pass, counts);
}
