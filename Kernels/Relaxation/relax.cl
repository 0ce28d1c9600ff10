// One colour pass of a relaxation sweep, a projected successive over-relaxation: every free element moves to the
// over-relaxed weighted mean of the target places of its links, clamped to their boxes (element.clh). It works in
// place, because all neighbours have the other colour.
//
// With WAVES only the free elements that wavefronts.clh allows relax. With SOFT soft links count (softlinks.clh).
//
// The host guarantees: a work-group for each slot except 0; a feasible state; all 26 neighbours of a brick that is
// ready have a slot (brick.clh, sweep.clh).

#include "brick.clh"
#include "state.clh"
#include "element.clh"
#include "method.clh"
#include "softlinks.clh"
#include "sweep.clh"
#include "rotations.clh"
#include "wavefronts.clh"

#include "cluster.clh"
#include "halo.clh"

// Relaxes one lane group and updates the largest moves and the faces.
CHAINMAIL_INLINE void relaxGroup(const State* state, const Stencil* s, const Halo* halo, const Method* method,
  const WavesUnderWay* waves, real* most, int* faces)
{
  real c[AXES], u[3];
  mask relaxes[AXES], free = (mask)(0);
  UNROLL
  for (int axis = 0; axis < AXES; ++axis)
  {
    c[axis] = LOAD_WHOLE(constraintAlong(state, axis) + s->self);
    relaxes[axis] = (c[axis] > 0.0f) & isUnmoved(waves, &state->layout, axis, s);
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
    u[axis] = LOAD_WHOLE(displacementAlong(state, axis) + s->self);
    neighbours[axis] = noNeighbours();
  }
  UNROLL
  for (int d = 0; d < 6; ++d)
  {
    Link link;
    UNROLL
    for (int axis = 0; axis < 3; ++axis)
    {
      if (axis < AXES)
      {
        link = linkOf(c[axis], linkedConstraint(halo, state, s, axis, d), d, axis);
        relaxes[axis] &= isOfSameWave(waves, &state->layout, axis, s, d, !link.exists);
      }
      neighboursAdd(&neighbours[axis], u[axis], displacementIn(halo, axis, d), link, method->slack);
    }
  }
#ifdef SOFT
  addSoftLinks(state, s, u, neighbours);
#endif
  real next[3], move = (real)(0.0f);
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    Neighbours* const n = &neighbours[axis];
    n->lower = method->limited ? n->lower : (real)(-INFINITY);
    n->upper = method->limited ? n->upper : (real)(INFINITY);
    next[axis] =
      select(u[axis], relaxedPlace(*n, u[axis], method->omega, method->still), relaxes[min(axis, AXES - 1)]);
    move = max(move, fabs(next[axis] - u[axis]));
  }
  if (SOME(move > 0.0f))
  {
    UNROLL
    for (int axis = 0; axis < 3; ++axis)
    {
      STORE_WHOLE(next[axis], displacementAlong(state, axis) + s->self);
    }
    *faces |= movedFaces(s, move > 0.0f);
    *most = max(*most, move);
  }
}

// Relaxes a share of a brick and returns the largest move.
NOINLINE float relaxShare(const State* given, Method method, WavesUnderWay waves, Share share, int* faces)
{
  const State state = *given;
  HALO_MEMORY(memory);
  real most = (real)(0.0f);
  for (int work = share.lid; work < VECTORS; work += share.items)
  {
    const Stencil s = stencilOf(&state.layout, share.slot, share.colour, work);
    const Halo halo = haloOf(memory, &state, &s, share.slot, share.last, share.colour);
    relaxGroup(&state, &s, &halo, &method, &waves, &most, faces);
  }
  return largestOf(most);
}

kernel void relax(PASS_ARGUMENTS, STATE_ARGUMENTS, int colour, METHOD_ARGUMENTS WAVES_ARGUMENTS)
{
  const Pass pass = PASS;
  const State state = STATE;
  const Method method = METHOD;
  const WavesUnderWay waves = WAVES_UNDER_WAY;
  local Visit visit;
  const uint slot = get_group_id(0) + 1;
  beginVisit(&visit, &pass, &state.layout, slot, colour, pass.sweep - 1);
  int faces = 0;
  float move = 0.0f;
  if (visit.due == DUE_AND_READY)
  {
    const Share share = { get_local_id(0), get_local_size(0), slot, get_num_groups(0), colour };
    move = relaxShare(&state, method, waves, share, &faces);
  }
  endVisit(&visit, &pass, slot, colour, faces, move, SWEEP_EVER);
}

#if WIDTH > 1 && !defined(WAVES)

// The colour pass of all bricks.
inline void relaxBricks(const State* state, const Method* method, const Pass* pass, int kind, int slots)
{
  const WavesUnderWay waves = WAVES_UNDER_WAY;
  for (int slot = 1; slot <= slots; ++slot)
  {
    int due = 0, faces = 0;
    for (int d = -1; d < 6; ++d)
    {
      due |= dueByRow(pass, &state->layout, slot, kind, pass->sweep - 1, d);
    }
    const Share share = { 0, 1, slot, slots, kind };
    const float move = due == DUE_AND_READY ? relaxShare(state, *method, waves, share, &faces) : 0.0f;
    recordVisit(pass, slot, kind, due, faces, move, SWEEP_EVER);
  }
}

// Several passes, one after the other, over all bricks and rigid clusters of a grid, by a single work-item. It serves
// grids so small that a launch for each pass would take longer than the pass. The results are the same to the bit.
//
// batch: see sweepaccount.clh; `passes` is the number of its rows. counts: see relaxClusters() in cluster.clh.
kernel void relaxBatch(global int* activity, global int* log, global const int* batch, int passes, int slots,
  STATE_ARGUMENTS, CLUSTERS_ARGUMENTS, int4 counts, float still, float slack, int limited)
{
  const State state = STATE;
  const Clusters clusters = CLUSTERS;
  for (int n = 0; n < passes; ++n)
  {
    global const int* row = batch + BATCH_ROW * n;
    const int4 numbers = vload4(0, row);
    const int kind = row[BATCH_KIND];
    const float stopThreshold = as_float(row[BATCH_STOP_THRESHOLD]), omega = as_float(row[BATCH_OMEGA]);
    const Pass pass = PASS;
    const Method method = METHOD;
    if (kind == SWEEP_OF_BODIES)
    {
      relaxClusters(&state, &clusters, &method, &pass, counts);
    }
    else
    {
      relaxBricks(&state, &method, &pass, kind, slots);
    }
    if (log[SWEEP_LOG * pass.number + SWEEP_CALLED_OFF])
    {
      return;
    }
  }
}

#endif
