// The kernels of a correction (CoarseToFine::correct): what the sweeps on a grid have left is found on coarser grids,
// as in a multigrid method. The residual of an element is the sum of weight * pull over its links, as far as their
// limits let it follow, for each axis. It acts as a force on the coarser grid, whose elements start at rest and move
// until their links balance it. That is the correction.
//
// Some elements are fixed in a correction: they keep their place. On the finest grid these are held ones and those that
// the limit of a link keeps from following. A correction would pull them out of their limits (truncated nonsmooth Newton
// multigrid; C. Graeser and R. Kornhuber, Journal of Computational Mathematics 27, 2009). Their residual along x is
// INFINITY. The host also fixes the members of rigid clusters that cannot move (RigidClusters::beginCorrection). The
// residuals of the members of any other cluster add up to a force on it. Where constraints differ by axis, all rigid
// elements are fixed: there are no corrections if one of them could move.
//
// Prolongation is that of coarsen.cl, with a Correction.
//
// The host guarantees: both grids have bricks of the same size; all 26 neighbours of a brick have a slot (brick.clh).

#include "brick.clh"
#include "state.clh"
#include "element.clh"
#include "finer.clh"
#include "halo.clh"

// An element that moves by less than this share of what its links ask for is kept by their limits.
#define KEPT_SHARE 0.1f

// Stores the residuals of a lane group of the finest grid.
CHAINMAIL_INLINE void storeResiduals(const State* state, const Stencil* s, const Halo* halo, global float* residual)
{
  real c[AXES], u[3];
  Neighbours neighbours[3];
  mask fixed = (mask)(0), rigid = (mask)(0);
  UNROLL
  for (int axis = 0; axis < AXES; ++axis)
  {
    c[axis] = LOAD(constraintAlong(state, axis) + s->self);
    fixed |= AXES == 1 ? isHeld(c[axis]) : (c[axis] > 0.0f) == 0;
    rigid |= c[axis] == 0.0f;
  }
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    u[axis] = LOAD(displacementAlong(state, axis) + s->self);
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
      }
      neighboursAdd(&neighbours[axis], u[axis], displacementIn(halo, axis, d), link, 0.0f);
    }
  }
  real each[3];
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    const Neighbours n = neighbours[axis];
    const real step = n.pull / n.weight;
    // Where no limit is in the way, rounding of the place must not change the residual. A rigid element moves with its
    // cluster, whatever its own links ask for.
    const mask limited = (rigid == 0) & ((n.lower > u[axis] + step) | (n.upper < u[axis] + step));
    const real way = relaxedPlace(n, u[axis], 1.0f, 0.0f) - u[axis];
    fixed |= limited & (fabs(way) < KEPT_SHARE * fabs(step));
    each[axis] = select(n.pull, n.weight * way, limited);
  }
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    STORE(axis == 0 ? select(each[axis], (real)(INFINITY), fixed) : each[axis],
      residual + axis * state->layout.pitch + s->self);
  }
}

// Stores those of one colour of a brick. `last`: the last slot of the list.
NOINLINE void residualsOf(const State* given, uint slot, uint last, int colour, global float* residual)
{
  const State state = *given;
  HALO_MEMORY(memory);
  for (int work = get_local_id(0); work < VECTORS; work += get_local_size(0))
  {
    const Stencil s = stencilOf(&state.layout, slot, colour, work);
    const Halo halo = haloOf(memory, &state, &s, slot, last, colour);
    storeResiduals(&state, &s, &halo, residual);
  }
}

// residual: [axis][address], like a displacement.
kernel void residuals(global const int* list, STATE_ARGUMENTS, global float* residual)
{
  const State state = STATE;
  for (int colour = 0; colour < 2; ++colour)
  {
    residualsOf(&state, list[get_group_id(0)], list[get_num_groups(0) - 1], colour, residual);
  }
}

// The weights of the soft links by which residuals act as forces (softlinks.clh). That of a free element is so small
// that only weight * place counts; that of a fixed one is so large that nothing else counts. Next to a cut it is in
// between: a coarser grid may separate a piece there from all that holds it, and nothing else would balance its force.
#define FORCE_WEIGHT 5e-5f
#define CUT_WEIGHT 5e-2f
#define FIXED_WEIGHT 1e12f

// Restriction: the residual of a coarser element is the sum of its children's, times `share`. It is fixed if one of
// them is (`any`), or if all are. A rigid one, which moves with its cluster, is fixed only if all are. The State is that
// of the coarser grid; in place of the displacement of the finer grid the host passes its residual. Group n writes the
// soft links of row n, with no displacement to begin with.
kernel void restrictResiduals(global const int* list, STATE_ARGUMENTS, FINER_ARGUMENTS, float share, int any,
  global float* residual, global float* softLinks, float4 proportions)
{
  const State state = STATE;
  const Finer finer = FINER;
  const uint slot = list[get_group_id(0)];
  const int3 brick = brickOf(&state.layout, slot);
  for (int work = get_local_id(0); work < 2 * VECTORS; work += get_local_size(0))
  {
    const int3 at = (int3)(work % (BX / WIDTH) * WIDTH, work / (BX / WIDTH) % BY, work / (BX / WIDTH) / BY);
    real sum[3], tissue = (real)(0.0f), fixed = (real)(0.0f);
    for (int axis = 0; axis < 3; ++axis)
    {
      sum[axis] = (real)(0.0f);
    }
    for (int child = 0; child < 8; ++child)
    {
      const uint address = childAddress(&finer.layout, brick, at, child);
      const mask isTissue = isinf(LOAD(finer.constraint + address)) == 0;
      const uint inState = min(address, finer.layout.pitch - SKEW);
      const mask isFixed = isTissue & (isinf(LOAD(finer.displacement + inState)) != 0);
      tissue += select((real)(0.0f), (real)(1.0f), isTissue);
      fixed += select((real)(0.0f), (real)(1.0f), isFixed);
      UNROLL
      for (int axis = 0; axis < 3; ++axis)
      {
        const real part = LOAD(finer.displacement + axis * finer.layout.pitch + inState);
        sum[axis] += select((real)(0.0f), part, isTissue & (isFixed == 0));
      }
    }
    mask rigid = (mask)(0), held = (mask)(0);
    UNROLL
    for (int axis = 0; axis < AXES; ++axis)
    {
      const real c = loadRow(constraintAlong(&state, axis) + slot * ELEMENTS, at);
      rigid |= c == 0.0f;
      held |= AXES > 1 ? (c > 0.0f) == 0 : AS_MASK(c) < 0;
    }
    const mask needed = (mask)(any ? -1 : 0) & (rigid == 0); // one fixed child is enough to fix these
    const mask free = (held == 0) & (fixed < select(tissue, (real)(1.0f), needed));
    real weight = (real)(FORCE_WEIGHT);
#ifdef CUTS
    weight = select(weight, (real)(CUT_WEIGHT), loadRowOfBytes(state.cut + slot * ELEMENTS, at) != 0);
#endif
    global float* const soft = softLinks + 4 * ELEMENTS * (uint)get_group_id(0);
    storeRow(select((real)(FIXED_WEIGHT), weight, free), soft, at);
    UNROLL
    for (int axis = 0; axis < 3; ++axis)
    {
      const real each = share * sum[axis];
      const real none = (real)(0.0f);
      storeRow(select(axis == 0 ? (real)(INFINITY) : none, each, free),
        residual + axis * state.layout.pitch + slot * ELEMENTS, at);
      storeRow(select(none, each / (weight * alongAxis(proportions, axis)), free), soft + (1 + axis) * ELEMENTS, at);
    }
  }
}
