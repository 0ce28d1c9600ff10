// Transfers displacements between a grid and one of half its resolution, each of whose elements stands for 2 x 2 x 2
// finer ones (its children): restriction (`coarsen`) and prolongation (`refine`) of a multigrid method. Displacements
// are fractions of each grid's own spacing.
//
// With `rotations` both kernels transfer rotations. The host then passes the rotations of both grids in place of their
// displacements.
//
// The host guarantees: both grids have bricks of the same size; the State is that of the coarser grid; tables are as
// brick.clh says.

#include "brick.clh"
#include "state.clh"
#include "element.clh"
#include "finer.clh"
#ifdef ROTATIONS
#include "spin.clh"
#endif

// Restriction: an element of the coarser grid gets the mean displacement of its children. If some of them are held,
// only these count. With `rotations`, the same for rotations. Two vectors describe each rotation (spin.clh), of which
// the mean takes the one nearest to the first child's. `scale`: 1/2 for displacements, because they are fractions of
// the spacing, and 1 for rotations.
kernel void coarsen(global const int* list, STATE_ARGUMENTS, FINER_ARGUMENTS, float scale, int rotations)
{
  const State state = STATE;
  const Finer finer = FINER;
  const uint slot = list[get_group_id(0)];
  const int3 brick = brickOf(&state.layout, slot);
  for (int work = get_local_id(0); work < 2 * VECTORS; work += get_local_size(0))
  {
    const int3 at = (int3)(work % (BX / WIDTH) * WIDTH, work / (BX / WIDTH) % BY, work / (BX / WIDTH) / BY);
    real free[3], held[3], first[3], numberFree = (real)(0.0f), numberHeld = (real)(0.0f);
    for (int axis = 0; axis < 3; ++axis)
    {
      free[axis] = held[axis] = first[axis] = (real)(0.0f);
    }
    for (int d = 0; d < 8; ++d)
    {
      const uint child = childAddress(&finer.layout, brick, at, d);
      const real c = LOAD(finer.constraint + child);
      const mask isOfHeld = isHeld(c), isFree = AS_MASK(c) >= 0;
      real u[3];
      UNROLL
      for (int axis = 0; axis < 3; ++axis)
      {
        u[axis] = LOAD(finer.displacement + axis * finer.layout.pitch + min(child, finer.layout.pitch - SKEW));
      }
#ifdef ROTATIONS
      if (rotations)
      {
        const mask isFirst = (isFree | isOfHeld) & (numberFree + numberHeld == 0.0f);
        UNROLL
        for (int axis = 0; axis < 3; ++axis)
        {
          first[axis] = select(first[axis], u[axis], isFirst);
        }
        const real nearest = nearestSpinTo(first, u);
        UNROLL
        for (int axis = 0; axis < 3; ++axis)
        {
          u[axis] *= nearest;
        }
      }
#endif
      numberFree += select((real)(0.0f), (real)(1.0f), isFree);
      numberHeld += select((real)(0.0f), (real)(1.0f), isOfHeld);
      UNROLL
      for (int axis = 0; axis < 3; ++axis)
      {
        free[axis] += select((real)(0.0f), u[axis], isFree);
        held[axis] += select((real)(0.0f), u[axis], isOfHeld);
      }
    }
    real mean[3];
    UNROLL
    for (int axis = 0; axis < 3; ++axis)
    {
      const mask anyHeld = numberHeld > 0.0f;
      const real sum = select(free[axis], held[axis], anyHeld);
      const real number = max(select(numberFree, numberHeld, anyHeld), (real)(1.0f));
      mean[axis] = scale * (sum / number);
    }
#ifdef ROTATIONS
    if (rotations)
    {
      shortestSpin(mean);
    }
#endif
    UNROLL
    for (int axis = 0; axis < 3; ++axis)
    {
      storeRow(mean[axis], displacementAlong(&state, axis) + slot * ELEMENTS, at);
    }
  }
}

// --- Refine: one layer of coarser elements at a time

// A layer in local memory: the coarser elements that cover a brick of the finer grid, with a halo of one element. It
// has rows for each of FIELDS: displacements (0 in air), constraints and, as the bits of a float, cuts.
#define SPAN_X (HALF + 2)
#define SPAN_Y (BY / 2 + 2)
#ifdef CUTS
#define FIELDS (4 + AXES)
#else
#define FIELDS (3 + AXES)
#endif
#define LAYER (FIELDS * SPAN_Y * SPAN_X)

// Loads element number n of a layer, whose address is `at`.
CHAINMAIL_INLINE void loadElement(const State* state, uint at, local float* layer, int n)
{
  const uint atRest = state->layout.pitch - SKEW; // see brick.clh
  const bool air = isinf(state->constraint[at]);
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    layer[axis * SPAN_Y * SPAN_X + n] = air ? 0.0f : displacementAlong(state, axis)[min(at, atRest)];
  }
  UNROLL
  for (int axis = 0; axis < AXES; ++axis)
  {
    layer[(3 + axis) * SPAN_Y * SPAN_X + n] = constraintAlong(state, axis)[at];
  }
#ifdef CUTS
  layer[(3 + AXES) * SPAN_Y * SPAN_X + n] = as_float((int)state->cut[at]);
#endif
}

// Loads a layer whose first element is at `corner`. All items of the group have to call it.
inline void loadLayer(const State* state, int3 corner, local float* layer)
{
#if WIDTH == 1
  for (int n = get_local_id(0); n < SPAN_Y * SPAN_X; n += get_local_size(0))
  {
    loadElement(state, addressOf(&state->layout, corner + (int3)(n % SPAN_X, n / SPAN_X, 0)), layer, n);
  }
#else
  // The elements of a row, except the first and the last, are in one brick, where they have two colours in turn.
  for (int y = get_local_id(0); y < SPAN_Y; y += get_local_size(0))
  {
    const int3 first = corner + (int3)(0, y, 0);
    const int row = y * SPAN_X;
    const uint even = addressOf(&state->layout, first + (int3)(1, 0, 0));
    const uint odd = even % ELEMENTS < COLOUR ? even + COLOUR : even - COLOUR;
    loadElement(state, addressOf(&state->layout, first), layer, row);
    for (int n = 0; n < HALF / 2; ++n)
    {
      loadElement(state, even + n, layer, row + 1 + 2 * n);
      loadElement(state, odd + n, layer, row + 2 + 2 * n);
    }
    loadElement(state, addressOf(&state->layout, first + (int3)(SPAN_X - 1, 0, 0)), layer, row + SPAN_X - 1);
  }
#endif
}

// WIDTH consecutive coarser elements in a row, the first at (x, y) of layer number `middle`. That layer and the two
// next to it are in `layers`, each at its number modulo 3.
typedef struct
{
  local const float* layers;
  int middle;
  int x, y;
} Window;

// One field of the 3 x 3 x 3 coarser elements around each element of a window, at index x + 3 y + 9 z. The element
// itself is at 13.
CHAINMAIL_INLINE void loadAround(const Window* window, int field, real* around)
{
  UNROLL
  for (int m = 0; m < 27; ++m)
  {
    local const float* layer = window->layers + (window->middle + 2 + m / 9) % 3 * LAYER + field * SPAN_Y * SPAN_X;
    around[m] = LOAD(layer + (window->y + m / 3 % 3) * SPAN_X + window->x + m % 3);
  }
}

// share[axis][side]: the interpolation weight of the neighbour on the lower (0) or upper (1) side, for the children on
// that side.
typedef struct
{
  real share[3][2];
} Towards;

// Interpolates the values of the eight children, at index x + 2 y + 4 z. Mirrored values give mirrored results, to the
// bit.
CHAINMAIL_INLINE void interpolate(const real* around, const Towards* towards, real* child)
{
  real alongX[2][9], alongY[4][3];
  UNROLL
  for (int m = 0; m < 18; ++m)
  {
    const real share = towards->share[0][m / 9];
    alongX[m / 9][m % 9] = (1.0f - share) * around[m % 9 * 3 + 1] + share * around[m % 9 * 3 + m / 9 * 2];
  }
  UNROLL
  for (int m = 0; m < 12; ++m)
  {
    const int side = m / 6;
    const real share = towards->share[1][side];
    alongY[m / 3][m % 3] =
      (1.0f - share) * alongX[m / 3 % 2][m % 3 * 3 + 1] + share * alongX[m / 3 % 2][m % 3 * 3 + 2 * side];
  }
  UNROLL
  for (int m = 0; m < 8; ++m)
  {
    const real share = towards->share[2][m / 4];
    child[m] = (1.0f - share) * alongY[m % 4][1] + share * alongY[m % 4][m / 4 * 2];
  }
}

// The interpolation weights. The halves of a link are springs in series, so strain is proportional to the constraint:
// the part own / (own + other) of it lies between the centre of an element and its face. A child is half way there, so
//
//   share = 1/2 own / (own + other).
//
// So children in soft tissue partly follow hard tissue beside them, and hard ones do not bend. `c`: constraints, in the
// order of loadAround(). A neighbour behind a cut has no weight.
CHAINMAIL_INLINE void shareOut(const real* c, const mask cut, Towards* towards)
{
  UNROLL
  for (int d = 0; d < 6; ++d)
  {
    const int step = d < 2 ? 1 : d < 4 ? 3 : 9;
    const real own = fabs(c[13]) + WEIGHT_EPSILON;
    const real other = fabs(c[13 + (d & 1 ? step : -step)]) + WEIGHT_EPSILON;
    towards->share[d / 2][d % 2] = select(0.5f * own / (own + other), (real)(0.0f), (cut & CUT_BIT(d)) != 0);
  }
}

#ifdef ROTATIONS
// The factors of nearestSpinTo() (spin.clh) for the 27 elements. They select, of the two vectors of each rotation, the
// one nearest to that of the central element.
CHAINMAIL_INLINE void nearestAround(const Window* window, real* nearest)
{
  real around[3][27];
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    loadAround(window, axis, around[axis]);
  }
  const real own[3] = { around[0][13], around[1][13], around[2][13] };
  UNROLL
  for (int m = 0; m < 27; ++m)
  {
    const real spin[3] = { around[0][m], around[1][m], around[2][m] };
    nearest[m] = nearestSpinTo(own, spin);
  }
}

// Describes the rotations of the finer grid by the shortest vectors (spin.clh).
CHAINMAIL_INLINE void shorten(const Finer* finer, uint at)
{
  const uint pitch = finer->layout.pitch;
  global float* const spin = finer->displacement;
  real next[3];
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    next[axis] = LOAD(spin + axis * pitch + at);
  }
  shortestSpin(next);
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    STORE(next[axis], spin + axis * pitch + at);
  }
}
#endif

// What becomes of an interpolated displacement: the displacement of the finer element, or a correction to it
// (correction.cl), of which `share` is added. Elements whose `fixed` is infinite, the residual along x, get none.
typedef struct
{
  int adds;
  float share;
  global const float* fixed; // [address], read only if it `adds`
} Correction;

// Moves the children, except held ones, of the elements of a window. `children`: addresses of the children of its first
// element, at index x + 2 y + 4 z. Children of the same index, of consecutive elements, have consecutive addresses.
NOINLINE void refineAt(
  Finer finer, Window window, const uint* children, float scale, int rotations, Correction correction)
{
#ifdef ROTATIONS
  real nearest[27];
  if (rotations)
  {
    nearestAround(&window, nearest);
  }
#endif
#ifdef CUTS
  local const float* const cuts = window.layers + window.middle % 3 * LAYER;
  const mask bits = AS_MASK(LOAD(cuts + ((3 + AXES) * SPAN_Y + window.y + 1) * SPAN_X + window.x + 1));
#else
  const mask bits = (mask)(0);
#endif
  Towards towards;
  real c[27], u[27], part[27], weight[8], rigidWeight[8], sum[8], rigidSum[8];
  NO_UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    if (axis < AXES)
    {
      loadAround(&window, 3 + axis, c);
      shareOut(c, bits, &towards);
      UNROLL
      for (int m = 0; m < 27; ++m)
      {
        part[m] = select((real)(1.0f), (real)(0.0f), c[m] == -INFINITY);
      }
      interpolate(part, &towards, weight);
    }
    loadAround(&window, axis, u);
#ifdef ROTATIONS
    if (rotations)
    {
      UNROLL
      for (int m = 0; m < 27; ++m)
      {
        u[m] *= nearest[m];
      }
    }
#endif
    interpolate(u, &towards, sum);

    global const float* constraints = finer.constraint + min(axis, AXES - 1) * finer.layout.tissuePitch;
    mask anyRigid = (mask)(0);
    UNROLL
    for (int child = 0; child < 8; ++child)
    {
      anyRigid |= LOAD(constraints + children[child]) == 0.0f;
    }
    if (SOME(anyRigid))
    {
      UNROLL
      for (int m = 0; m < 27; ++m)
      {
        part[m] = select((real)(0.0f), (real)(1.0f), c[m] == 0.0f);
        u[m] = select((real)(0.0f), u[m], c[m] == 0.0f);
      }
      interpolate(part, &towards, rigidWeight);
      interpolate(u, &towards, rigidSum);
    }
    UNROLL
    for (int child = 0; child < 8; ++child)
    {
      real next = scale * sum[child] / weight[child];
      if (SOME(anyRigid))
      {
        const mask isRigid = (LOAD(constraints + children[child]) == 0.0f) & (rigidWeight[child] > 0.0f);
        next = select(next, scale * rigidSum[child] / rigidWeight[child], isRigid);
      }
      // false in air, too: its sign bit is set
      mask moves = AS_MASK(LOAD(finer.constraint + children[child])) >= 0;
      global float* to = finer.displacement + axis * finer.layout.pitch + children[child];
      const real last = LOAD(to);
      if (correction.adds)
      {
        next = fma(correction.share, next, last);
        moves &= isinf(LOAD(correction.fixed + children[child])) == 0;
      }
      STORE(select(last, next, moves), to);
    }
  }
#ifdef ROTATIONS
  for (int child = 0; rotations && child < 8; ++child)
  {
    shorten(&finer, children[child]);
  }
#endif
}

// Prolongation: displaces the elements of the finer grid that are not held. The displacement of a child is interpolated
// between the up to eight coarser elements around it. Those that a cut separates from its own coarser element do not
// count (shareOut). For rigid children only the rigid ones among these count, separately on each axis. So finer bone is
// where the coarser bone is. `scale`: 2 for displacements, 1 for rotations. `adds`, `share` and `fixed`: see Correction.
kernel void refine(global const int* list, STATE_ARGUMENTS, FINER_ARGUMENTS, float scale, int rotations, int adds,
  float share, global const float* fixed)
{
  const State state = STATE;
  const Finer finer = FINER;
  const Correction correction = { adds, share, fixed };
  local float layers[3 * LAYER];
  const uint finerSlot = list[get_group_id(0)];
  const int3 corner = brickOf(&finer.layout, finerSlot) * (int3)(HALF, BY / 2, BZ / 2) - 1;
  for (int z = 0; z < BZ / 2 + 2; ++z)
  {
    loadLayer(&state, corner + (int3)(0, 0, z), layers + z % 3 * LAYER);
    barrier(CLK_LOCAL_MEM_FENCE);
    for (int work = get_local_id(0); z >= 2 && work < HALF / WIDTH * (BY / 2); work += get_local_size(0))
    {
      const Window window = { layers, z - 1, work % (HALF / WIDTH) * WIDTH, work / (HALF / WIDTH) };
      uint children[8];
      UNROLL
      for (int child = 0; child < 8; ++child)
      {
        const int j = 2 * window.y + (child >> 1 & 1), k = 2 * (z - 2) + (child >> 2);
        children[child] = finerSlot * ELEMENTS + ((child ^ j ^ k) & 1) * COLOUR + (k * BY + j) * HALF + window.x;
      }
      refineAt(finer, window, children, scale, rotations, correction);
    }
    barrier(CLK_LOCAL_MEM_FENCE);
  }
}
