// One colour pass of a relaxation sweep, a projected successive over-relaxation: every free element moves to the
// over-relaxed weighted mean of the target places of its links, clamped to their boxes (element.clh). It works in
// place, because all neighbours have the other colour.
//
// `limited`: whether the limits of links apply. It is an argument and no macro, because each variant of the kernel
// takes long to compile.
//
// With WAVES only the free elements that wavefronts.clh allows relax. With SOFT soft links count (softlinks.clh).
//
// The host guarantees: a work-group for each slot except 0; a feasible state; all 26 neighbours of a brick that is
// ready have a slot (brick.clh, sweep.clh).

#include "brick.clh"
#include "element.clh"
#include "softlinks.clh"
#include "sweep.clh"
#include "turning.clh"
#include "wavefronts.clh"

#include "cluster.clh"
#include "halo.clh"

// Relaxes one lane group and updates the largest moves and the faces.
CHAINMAIL_INLINE void relaxPiece(const Stencil* s, const Beside* beside, float omega, float still, float slack,
  int limited, uint pitch, uint tissuePitch, global const int* place, global float* displacement,
  global const float* constraint,
  global const uchar* cut, real* most, int* faces WAVES_ARGUMENTS SOFT_ARGUMENTS)
{
  real c[AXES], u[3];
  mask relaxes[AXES], free = (mask)(0);
  UNROLL
  for (int axis = 0; axis < AXES; ++axis)
  {
    c[axis] = LOAD_WHOLE(constraint + axis * tissuePitch + s->self);
    relaxes[axis] = (c[axis] > 0.0f) & IS_STILL(axis, s);
    free |= relaxes[axis];
  }
  if (!SOME(free))
  {
    return;
  }
  Neighbours neighbours[3];
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    u[axis] = LOAD_WHOLE(displacement + axis * pitch + s->self);
    neighbours[axis] = noNeighbours();
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
        relaxes[axis] &= IS_OF_SAME_FRONT(axis, s, d, s->odd, limit);
      }
      neighboursAdd(&neighbours[axis], u[axis], displacementBeside(beside, axis, d), limit, weight, slack);
    }
  }
#ifdef SOFT
  addSoftLinks(s, u, place SOFT_PASSED_ON, neighbours);
#endif
  real next[3], move = (real)(0.0f);
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    Neighbours* const n = &neighbours[axis];
    n->lower = limited ? n->lower : (real)(-INFINITY);
    n->upper = limited ? n->upper : (real)(INFINITY);
    next[axis] = select(u[axis], relaxedPlace(*n, u[axis], omega, still), relaxes[min(axis, AXES - 1)]);
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
NOINLINE float relaxShare(int lid, int items, uint slot, uint last, int colour, float omega, float still, float slack,
  int limited, LAYOUT_ARGUMENTS, global float* displacement, global const float* constraint, global const uchar* cut,
  int* faces WAVES_ARGUMENTS SOFT_ARGUMENTS)
{
  HALO(halo);
  real most = (real)(0.0f);
  for (int work = lid; work < VECTORS; work += items)
  {
    const Stencil s = stencilOf(slot, colour, work, pitch, table, place, strideY, strideZ);
    const Beside beside = besideOf(
      halo, &s, slot, last, colour, pitch, tissuePitch, table, place, strideY, strideZ, displacement, constraint);
    relaxPiece(&s, &beside, omega, still, slack, limited, pitch, tissuePitch, place, displacement, constraint, cut,
      &most, faces WAVES_PASSED_ON SOFT_PASSED_ON);
  }
  return largestOf(most);
}

kernel void relax(SWEEP_ARGUMENTS, int colour, float omega, float still, float slack, int limited, LAYOUT_ARGUMENTS,
  global float* displacement, global const float* constraint, global const uchar* cut WAVES_ARGUMENTS SOFT_ARGUMENTS)
{
  local Turn mine;
  const uint slot = get_group_id(0) + 1;
  beginSweepTurn(&mine, slot, colour, turn.z - 1, activity, log, turn, enough, table, place, strideY, strideZ);
  int touched = 0;
  float move = 0.0f;
  if (mine.has == TURN_HAS)
  {
    move = relaxShare(get_local_id(0), get_local_size(0), slot, get_num_groups(0), colour, omega, still, slack, limited,
      pitch, tissuePitch, table, place, strideY, strideZ, displacement, constraint, cut,
      &touched WAVES_PASSED_ON SOFT_PASSED_ON);
  }
  endSweepTurn(&mine, touched, move, slot, colour, SWEEP_EVER, activity, log, turn, enough);
}

#if WIDTH > 1 && !defined(WAVES)

// The colour pass of all rigid clusters.
inline void relaxClusters(int4 chunkClusterMemberCounts, int4 turn, float omega, float still, float slack, int limited,
  global int* activity, global int* log, uint pitch, uint tissuePitch, global float* displacement,
  global const float* constraint, CLUSTER_LISTS SOFT_CLUSTERS SOFT_ARGUMENTS)
{
  if (isCalledOff(log, turn, -1.0f))
  {
    log[SWEEP_LOG * turn.x + SWEEP_CALLED_OFF] = 1;
    return;
  }
  for (int n = 0; n < 3 * chunkClusterMemberCounts.x; ++n)
  {
    gatherChunk(n / 3, n % 3, chunks, links, ways, places, slack, pitch, tissuePitch, displacement, constraint,
      partial);
  }
  for (int id = 0; id < chunkClusterMemberCounts.y; ++id)
  {
    const int4 cluster = clusters[id];
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
        neighboursJoin(&n, laneOfCluster(cluster, lane, axis, partial));
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
  for (int n = 0; n < chunkClusterMemberCounts.z; ++n)
  {
    scatterMember(n, turn.z, activity, members, clusters, places, moves, pitch, displacement);
  }
}

// Several colour passes, one after the other, over all bricks and rigid clusters of a grid, by a single work-item. It
// serves grids so small that a launch for each pass would take longer than the pass. The results are the same to the
// bit.
kernel void relaxBatch(global int* activity, global int* log, global const int* batch, int turns, int slots,
  float still, float slack, int limited, LAYOUT_ARGUMENTS, global float* displacement,
  global const float* constraint, global const uchar* cut, int4 chunkClusterMemberCounts,
  CLUSTER_LISTS SOFT_CLUSTERS SOFT_ARGUMENTS)
{
  for (int n = 0; n < turns; ++n)
  {
    global const int* row = batch + BATCH_ROW * n;
    const int4 turn = vload4(0, row);
    const int kind = row[BATCH_KIND];
    const float enough = as_float(row[BATCH_ENOUGH]), omega = as_float(row[BATCH_OMEGA]);
    if (kind == SWEEP_OF_BODIES)
    {
      relaxClusters(chunkClusterMemberCounts, turn, omega, still, slack, limited, activity, log, pitch, tissuePitch,
        displacement, constraint, chunks, links, ways, clusters, members, partial, places,
        moves SOFT_CLUSTERS_PASSED_ON SOFT_PASSED_ON);
    }
    for (int slot = 1; kind != SWEEP_OF_BODIES && slot <= slots; ++slot)
    {
      int has = 0, touched = 0;
      for (int d = -1; d < 6; ++d)
      {
        has |= turnByRow(d, slot, kind, turn.z - 1, activity, log, turn, enough, table, place, strideY, strideZ);
      }
      float move = 0.0f;
      if (has == TURN_HAS)
      {
        move = relaxShare(0, 1, slot, slots, kind, omega, still, slack, limited, pitch, tissuePitch, table, place,
          strideY, strideZ, displacement, constraint, cut, &touched SOFT_PASSED_ON);
      }
      noteTurn(has, touched, move, slot, kind, SWEEP_EVER, activity, log, turn, enough);
    }
    if (log[SWEEP_LOG * turn.x + SWEEP_CALLED_OFF])
    {
      return;
    }
  }
}

#endif
