// The kernels of resampling; resample.clh explains the terms. In `cover` the moved cells enter candidates for the
// output voxels that they cover. `settle` resolves write conflicts between them. `leave` fills the voxels that no cell
// covers.
//
// Output voxels come in bricks, too. A box of these bricks starts at voxel `boxFirst`, a multiple of the brick size
// away from voxel 0. For each of them `places` gives its number in the list of bricks that tissue may reach, or -1. A
// list is processed in batches.
//
// FINER is the number of output voxels along each axis per voxel of the grid: voxel FINER * i lies at grid point i.
// Output bricks have FINER times as many voxels along each axis, so bricks of the output and the grid have the same
// numbers. Positions, displacements and offsets stay in voxels of the grid.

#include "tile.clh"

#ifndef SHARES // groups that take turns with the tiles of a brick
#define SHARES 1
#endif

// Output voxels along the axes of a brick, and in a whole brick.
#define OUT_X (FINER * BX)
#define OUT_Y (FINER * BY)
#define OUT_Z (FINER * BZ)
#define OUTPUTS (OUT_X * OUT_Y * OUT_Z)

typedef struct
{
  int4 boxFirst, boxBricks; // `boxFirst` is a point of the grid
  int4 cellsFirst, cellsSize; // the box in which cells are counted
  global const int* places;
  volatile global uint* claims; // the lowest candidates; these three have one entry for each voxel of the listed bricks
  global uchar* disputed;       // 1 where a conflict was
  global float* offsets;
  volatile global uint* disputes; // the number of conflicts, then the first `mostDisputes` of them (DISPUTE)
  uint mostDisputes;
  bool alone; // the group is a single work-item
  int3 brick; // the first cell of the group
#ifdef SMOOTH_CUTS
  volatile global uint* covered; // these two have one word for each voxel of the listed bricks, see SAMPLES
  volatile global uint* behind;
  float3 sampling; // the width of the box of samples [voxels], 0 along a flat axis
#endif
} Output;

// Words of a conflict: a candidate that was the lowest so far for a voxel with an earlier candidate. They are the
// voxel's number, the candidate and its offset. Conflicts follow the first word of `disputes`.
#define DISPUTE 5

// The number of a voxel, given by brick and offset in it, in the arrays of the output; -1 where it has none.
CHAINMAIL_INLINE int numberIn(const Output* o, int brick, int offset)
{
  const int place = o->places[brick];
  return place >= 0 ? place * OUTPUTS + offset : -1;
}

CHAINMAIL_INLINE int numberAt(const Output* o, int3 at)
{
  const uint3 from = convert_uint3(at - FINER * o->boxFirst.xyz); // huge where negative
  const uint3 brick = from / (uint3)(OUT_X, OUT_Y, OUT_Z), offset = from % (uint3)(OUT_X, OUT_Y, OUT_Z);
  if (brick.x >= (uint)o->boxBricks.x || brick.y >= (uint)o->boxBricks.y || brick.z >= (uint)o->boxBricks.z)
  {
    return -1;
  }
  return numberIn(o, brick.x + o->boxBricks.x * (brick.y + o->boxBricks.y * brick.z),
    offset.x + OUT_X * (offset.y + OUT_Y * offset.z));
}

// Whether this work-item entered a candidate. Then offsets that it stores later overwrite that candidate's.
CHAINMAIL_INLINE bool isOurs(const Output* o, uint claim)
{
  if (!o->alone)
  {
    return false;
  }
  const uint cell = (claim & ~BORDER) / 8, row = cell / o->cellsSize.x;
  const int3 at = o->cellsFirst.xyz + (int3)(cell % o->cellsSize.x, row % o->cellsSize.y, row / o->cellsSize.y);
  return all(at >= o->brick) && all(at < o->brick + (int3)(BX, BY, BZ));
}

// Enters a cell's candidate for a voxel, with the offset to its material point. Returns whether it is the lowest so
// far: then the caller stores the offset. If a different work-item entered the previous candidate, it may store its own
// offset even later. Such a conflict is logged, and `settle` resolves it when all candidates are entered. Once a voxel
// has a conflict, all its later winners are logged, too.
inline bool isTaken(const Output* o, int voxel, uint claim, float3 offset)
{
  const uint before = atomic_min(o->claims + voxel, claim);
  if (claim > before)
  {
    return false;
  }
  if (before < RESTS && (!isOurs(o, before) || o->disputed[voxel]))
  {
    o->disputed[voxel] = 1;
    const uint n = atomic_inc(o->disputes);
    if (n < o->mostDisputes)
    {
      volatile global uint* dispute = o->disputes + 1 + DISPUTE * (size_t)n;
      dispute[0] = voxel;
      dispute[1] = claim;
      dispute[2] = as_uint(offset.x);
      dispute[3] = as_uint(offset.y);
      dispute[4] = as_uint(offset.z);
    }
  }
  return true;
}

// Enters border candidates for the voxels of the air at some corners of a cell, unless the cell itself covers them. Air
// displaced by less than a voxel on each axis takes its scalars along (offset -u), so no seam opens there. Air
// displaced further leaves its voxel VACATED, and air at rest enters RESTS. Voxels that elements leave are filled by
// `leave`.
inline void takeCorners(const Tissue* t, const Output* o, int3 base, uint corners, const float3* u, uint key)
{
  // The number of output voxels before a grid point that are nearest to it.
  const int3 before = select((int3)(FINER / 2), (int3)(0), t->flat.xyz != 0);
  for (int n = 0; n < 8 * FINER * FINER * FINER; ++n)
  {
    const int corner = n % 8, step = n / 8;
    const int3 steps = (int3)(step % FINER, step / FINER % FINER, step / (FINER * FINER));
    const int3 at = FINER * cornerAt(t, base, corner) - before + steps;
    const int voxel = corners >> corner & 1 ? numberAt(o, at) : -1;
    const float3 way = u[corner];
    const bool rests = all(way == 0.0f);
    if (voxel >= 0 && !rests && all(fabs(way) < 1.0f))
    {
      if (o->claims[voxel] != BORDER + key && isTaken(o, voxel, BORDER + key, -way))
      {
        vstore3(-way, voxel, o->offsets);
      }
    }
    else if (voxel >= 0)
    {
      atomic_min(o->claims + voxel, rests ? RESTS : VACATED);
    }
  }
}

#ifdef SMOOTH_CUTS

// A voxel is sampled at SAMPLES points, each with a bit in two words. In `covered` it is set where tissue near a cut
// surface covers the point. In `behind` it is set where the point lies behind the surface of such tissue and the
// voxel's middle before it. AT_SURFACE is set in `behind` where any point lies behind a surface.
//
// The points are a Kronecker sequence (M. Roberts' R3: powers of the root of g^4 = g + 1), symmetric about the middle.
// No plane holds many of them, so coverage grows in small steps at any angle. They fill a box of 1.25 voxels. A larger
// box improves the gradients by which images are lit, but worsens the colours at a cut.
#define MIDDLE_SAMPLE 15
#define AT_SURFACE 0x80000000u
#define SAMPLED (1.25f / FINER) // [voxels]

// In local coordinates of a cell. BEHIND: how far from the cell its map still decides which samples are behind its
// surface. SAMPLE_SLACK: the overlap of cells, because each cell places its samples with a linear map of its own.
#define BEHIND 1.3f
#define SAMPLE_SLACK 0.03f

// The bitwise OR over all lanes.
CHAINMAIL_INLINE uint bitsOfAll(mask bits)
{
  int lanes[WIDTH], all = 0;
  STORE(bits, lanes);
  UNROLL
  for (int lane = 0; lane < WIDTH; ++lane)
  {
    all |= lanes[lane];
  }
  return (uint)all;
}

// The offsets of WIDTH samples, from number `first` on, from the middle of their voxel in local coordinates of a cell:
// J^-1 step, or `step` itself in cells that are not gentle. `map` holds the same cell in all lanes.
CHAINMAIL_INLINE void wayToSamples(const Output* o, const CellMap* map, int first, real* way)
{
  const float powers[3] = { 0.81917251f, 0.67104361f, 0.54970048f }; // powers of 1 / g
  const float sampling[3] = { o->sampling.x, o->sampling.y, o->sampling.z };
  real step[3];
  UNROLL
  for (int a = 0; a < 3; ++a)
  {
    const real along = TO_FLOAT(laneNumbers() + (first - MIDDLE_SAMPLE)) * powers[a];
    step[a] = (along - floor(along + 0.5f)) * sampling[a];
  }
  UNROLL
  for (int a = 0; a < 3; ++a)
  {
    way[a] = step[a] + DOT(map->back[a], step);
  }
}

// Samples a voxel with its middle at x, in local coordinates of a cell; `map` holds that cell in all lanes. Returns
// whether the middle lies behind the cell's surface while the cell covers some samples.
inline bool sampleVoxel(const Output* o, const Cell* cell, int component, const CellMap* map, float3 x, int voxel)
{
  const float middle[3] = { x.x, x.y, x.z };
  const float least[3] = { cell->least.x, cell->least.y, cell->least.z };
  const float most[3] = { cell->most.x, cell->most.y, cell->most.z };
  mask coveredBits = (mask)(0), behindBits = (mask)(0);
  for (int first = 0; first < SAMPLES; first += WIDTH)
  {
    const mask number = laneNumbers() + first, bit = (mask)(1) << number;
    real at[3], beyond = (real)(-INFINITY); // largest distance beyond the cell's faces
#if WIDTH > 1
    const real* way = map->way[first / WIDTH];
#else
    real way[3];
    wayToSamples(o, map, first, way);
#endif
    UNROLL
    for (int a = 0; a < 3; ++a)
    {
      at[a] = middle[a] + way[a];
      at[a] = min(max(at[a], (real)(least[a])), (real)(most[a]));
      beyond = max(beyond, fabs(at[a] - 0.5f) - 0.5f);
    }
    mask within = (beyond <= SAMPLE_SLACK) & (number < SAMPLES);
    if (cell->isDivided)
    {
      const mask isBehind = distanceOf(cell, component, at) < 0.0f;
      behindBits |= select((mask)(0), bit, isBehind & (beyond <= BEHIND) & (number < SAMPLES));
      within &= isBehind == 0;
    }
    else if (!cell->whole)
    {
      within &= isShareOf(cell, component, at);
    }
    coveredBits |= select((mask)(0), bit, within);
  }
  const uint covered = bitsOfAll(coveredBits), behind = cell->isDivided ? bitsOfAll(behindBits) : 0;
  if (covered)
  {
    atomic_or(o->covered + voxel, covered);
  }
  const bool isMiddleBehind = cell->isDivided && behind >> MIDDLE_SAMPLE & 1;
  if (behind)
  {
    atomic_or(o->behind + voxel, AT_SURFACE | (isMiddleBehind ? 0 : behind));
  }
  return covered && isMiddleBehind;
}

#endif

// WIDTH inversions. Each lane has one voxel and one cell; the target is relative to the cell's lowest corner.
typedef struct
{
  float target[3][WIDTH];
  int voxel[WIDTH];    // its number; -1 where the lane has nothing to do
  int key[WIDTH];      // of the cell
  int elements[WIDTH]; // of the cell
} Lanes;

// Enters candidates for those voxels that lie in their cells. `cell` is null, or the cell of all lanes of which only
// the share of one component counts. A cell at rest (`rests`) enters candidates only in two cases. Either the voxel's
// middle lies behind the cell's surface, and a part of the voxel lies in the cell. Or the voxel lies between grid
// points (FINER > 1) in a cell that a surface divides: `leave` reads only grid points and cannot tell on which side
// such a voxel lies.
CHAINMAIL_INLINE void takeInside(
  const Output* o, const CellMap* map, const Lanes* lanes, const Cell* cell, int component, bool rests)
{
  const real target[3] = { LOAD(lanes->target[0]), LOAD(lanes->target[1]), LOAD(lanes->target[2]) };
  real x[3];
  const mask inside = inverted(map, target, LOAD(lanes->voxel) >= 0, x);
#ifdef SMOOTH_CUTS
  const bool samples = cell && cell->isNearCut;
#else
  const bool samples = false;
#endif
  if (!samples && !SOME(inside))
  {
    return;
  }
  float found[3][WIDTH], offset[3][WIDTH];
  int hits[WIDTH];
  STORE(inside, hits);
  UNROLL
  for (int a = 0; a < 3; ++a)
  {
    STORE(x[a], found[a]);
    STORE(x[a] - target[a], offset[a]);
  }
  for (int lane = 0; lane < WIDTH; ++lane)
  {
    const float3 place = (float3)(found[0][lane], found[1][lane], found[2][lane]);
    const float3 way = (float3)(offset[0][lane], offset[1][lane], offset[2][lane]);
#ifdef SMOOTH_CUTS
    if (samples && lanes->voxel[lane] >= 0 && all(fabs(place) < 2.0f))
    {
      if (sampleVoxel(o, cell, component, map, place, lanes->voxel[lane]))
      {
        // The voxel's middle lies behind the surface, so it is a border candidate: any other tissue has priority.
        hits[lane] = isTaken(o, lanes->voxel[lane], BORDER + lanes->key[lane], way);
        continue;
      }
    }
    const bool isDivided = FINER > 1 && samples && cell->isDivided;
    const bool leaves = isDivided && hits[lane] && rests; // if it lies behind the surface
    hits[lane] = hits[lane] && (!rests || isDivided);
#else
    const bool leaves = false;
#endif
    const real at[3] = { (real)(place.x), (real)(place.y), (real)(place.z) };
    if (hits[lane] && (!cell || SOME(isShareOf(cell, component, at))))
    {
      const int nearest = (place.x > 0.5f) | (place.y > 0.5f) << 1 | (place.z > 0.5f) << 2;
      const uint border = lanes->elements[lane] >> nearest & 1 ? 0 : BORDER;
      hits[lane] = isTaken(o, lanes->voxel[lane], border + lanes->key[lane], way);
    }
    else
    {
      hits[lane] = 0;
      if (leaves)
      {
        atomic_min(o->claims + lanes->voxel[lane], VACATED);
      }
    }
  }
  // A loop of its own: otherwise the atomic of each candidate would wait for the stores of offsets before it.
  for (int lane = 0; lane < WIDTH; ++lane)
  {
    if (hits[lane])
    {
      vstore3((float3)(offset[0][lane], offset[1][lane], offset[2][lane]), lanes->voxel[lane], o->offsets);
    }
  }
}

// The key of component 0 of a cell.
CHAINMAIL_INLINE uint keyOf(const Output* o, int3 base)
{
  const int3 cell = base - o->cellsFirst.xyz;
  return (uint)(cell.x + o->cellsSize.x * (cell.y + o->cellsSize.y * cell.z)) * 8;
}

// The bits in `rows` of the eight corners of the cell at `at` in the tile.
CHAINMAIL_INLINE uint cornerBits(const Tissue* t, local const ulong* rows, int3 at)
{
  uint bits = 0;
  UNROLL
  for (int n = 0; n < 4; ++n)
  {
    const ulong row = rows[ROW(at.y + (t->flat.y ? 0 : n & 1), at.z + (t->flat.z ? 0 : n >> 1))] >> at.x;
    bits |= (uint)(t->flat.x ? (row & 1) * 3 : row & 3) << 2 * n;
  }
  return bits;
}

// Marks the air at the corners of a cell as visited (taken), except ambiguous air, whose displacement differs by cell.
CHAINMAIL_INLINE void noteTaken(local Tile* tile, int3 at)
{
  UNROLL
  for (int n = 0; n < 4; ++n)
  {
    const int row = ROW(at.y + (n & 1), at.z + (n >> 1));
    tile->taken[row] |= (ulong)3 << at.x & ~(tile->elements[row] | tile->ambiguous[row]);
  }
}

// The displacement of corner n of the virtual cell of the corners `own`: the mean over those elements around the corner
// that links join to `own`. Cells that share a corner and the tissue around it compute the same value, so their virtual
// cells fit together.
inline float3 virtualCorner(const Tissue* t, local const Tile* tile, int3 at, int n, uint own)
{
  const int3 corner = cornerAt(t, at, n);
  uint seeds = 0;
  for (int m = 0; m < 8; ++m)
  {
    const int3 from = cornerAt(t, at, m) - corner + 1;
    seeds |= (own >> m & 1) << (from.x + 3 * from.y + 9 * from.z);
  }
  const uint joined = joinedTo(seeds, tile, corner);
  // The corner itself may be connected to them around the end of a cut.
  return joined >> 13 & 1 ? displacementIn(tile, corner) : meanAround(tile, corner, joined);
}

// --- One cell

// Enters candidates for the voxels that a component of a cell covers.
inline void coverComponent(
  const Tissue* t, const Output* o, local const Tile* tile, int3 at, const Cell* cell, int component, bool smooth)
{
  float3 u[8], low = (float3)(INFINITY), high = (float3)(-INFINITY);
  bool rests = true;
  uint own = 0, air = 0;
  for (int n = 0; n < 8; ++n)
  {
    own |= isOwn(cell, component, n) ? 1u << n : 0;
  }
  // Air that is not ambiguous already has its displacement in the tile.
  const uint known = own | ~(cell->elements | cornerBits(t, tile->ambiguous, at));
  for (int n = 0; n < 8; ++n)
  {
    u[n] = known >> n & 1 ? displacementIn(tile, cornerAt(t, at, n)) : virtualCorner(t, tile, at, n, own);
    const float3 corner = u[n] + (float3)(n & 1, n >> 1 & 1, n >> 2);
    low = min(low, corner);
    high = max(high, corner);
    rests = rests && all(u[n] == 0.0f);
    air |= cell->component[n] == component && !(cell->elements >> n & 1) ? 1u << n : 0;
  }
#ifdef SMOOTH_CUTS
  const bool samples = cell->isNearCut;
  const uint tissue = cell->isDivided ? cell->elements | cell->carved : cell->elements;
  const float around = samples ? 0.5f * SAMPLED + SLACK : SLACK;
#else
  const bool samples = false;
  const uint tissue = cell->elements;
  const float around = SLACK;
#endif
  if (rests && !samples)
  {
    return;
  }
  Lanes lanes;
  for (int lane = 0; lane < WIDTH; ++lane)
  {
    lanes.key[lane] = keyOf(o, cell->base) + component;
    lanes.elements[lane] = tissue;
  }
  real corners[3][8];
  for (int n = 0; n < 8; ++n)
  {
    corners[0][n] = (real)(u[n].x);
    corners[1][n] = (real)(u[n].y);
    corners[2][n] = (real)(u[n].z);
  }
  CellMap map;
  mapOf(corners, (mask)(smooth ? -1 : 0), &map);
#if defined(SMOOTH_CUTS) && WIDTH > 1
  for (int first = 0; samples && first < SAMPLES; first += WIDTH)
  {
    wayToSamples(o, &map, first, map.way[first / WIDTH]);
  }
#endif
  const int3 base = FINER * cell->base, begin = FINER * o->boxFirst.xyz;
  const int3 end = begin + o->boxBricks.xyz * (int3)(OUT_X, OUT_Y, OUT_Z) - 1;
  const int3 flat = t->flat.xyz;
  const int3 first = select(max(convert_int3(ceil(FINER * (low - around))) + base, begin), base, flat != 0);
  const int3 last = select(min(convert_int3(floor(FINER * (high + around))) + base, end), base, flat != 0);
  int used = 0;
  for (int3 voxel = first; all(voxel <= last);)
  {
    const int number = numberAt(o, voxel);
    if (number >= 0)
    {
      const float3 target = convert_float3(voxel - base) * (1.0f / FINER);
      lanes.target[0][used] = target.x;
      lanes.target[1][used] = target.y;
      lanes.target[2][used] = target.z;
      lanes.voxel[used++] = number;
    }
    const bool endsRow = voxel.x == last.x, endsLayer = endsRow && voxel.y == last.y;
    voxel = (int3)(endsRow ? first.x : voxel.x + 1, endsLayer ? first.y : voxel.y + endsRow, voxel.z + endsLayer);
    if (used == WIDTH || (used > 0 && voxel.z > last.z))
    {
      for (int lane = used; lane < WIDTH; ++lane)
      {
        lanes.voxel[lane] = -1;
      }
      takeInside(o, &map, &lanes, cell, component, rests);
      used = 0;
    }
  }
  if (rests)
  {
    return;
  }
  takeCorners(t, o, cell->base, air, u, lanes.key[0]);
}

NOINLINE void coverCell(const Tissue* t, const Output* o, local const Tile* tile, int3 at, int3 base, bool smooth)
{
  Cell cell = cellOf(t, base, cornerBits(t, tile->elements, at));
  findComponents(t, &cell);
#ifdef SMOOTH_CUTS
  findSurface(t, &cell);
#endif
  for (int component = 0; component < 8; ++component)
  {
    if (isOwn(&cell, component, component))
    {
      coverComponent(t, o, tile, at, &cell, component, smooth);
    }
  }
}

// --- WIDTH cells with a single component each

// The elements among the corners of WIDTH cells along x, one bit each. The first cell is at `at` in the tile.
CHAINMAIL_INLINE mask elementsOfRow(local const Tile* tile, int3 at)
{
  const mask number = laneNumbers();
  mask elements = (mask)(0);
  UNROLL
  for (int n = 0; n < 4; ++n)
  {
    const ulong row = tile->elements[ROW(at.y + (n & 1), at.z + (n >> 1))] >> at.x;
    elements |= ((mask)((int)row) >> number & 3) << 2 * n;
  }
  return elements;
}

// Whether some corners of each cell are connected along its edges, if no link is cut.
CHAINMAIL_INLINE mask areOnePiece(mask corners)
{
  mask joined = corners & -corners, before;
  do
  {
    before = joined;
    const mask x = (joined & 0x55) << 1 | (joined >> 1 & 0x55);
    const mask y = (joined & 0x33) << 2 | (joined >> 2 & 0x33);
    const mask z = joined << 4 | joined >> 4;
    joined |= (x | y | z) & corners;
  } while (SOME(before != joined));
  return joined == corners;
}

// Cells that may cover more voxels than this are handled one by one.
#define LONG (4 * WIDTH)
#define LATTICES (FINER * FINER * FINER)

// The displacements at the corners of WIDTH cells along x.
typedef struct
{
  float u[3][8][WIDTH];
} Corners;

// `at` is the first cell in the tile. `ambiguous` has a bit for each cell with an ambiguous corner.
inline void cornersOfRow(local const Tile* tile, int3 at, uint ambiguous, mask elements, Corners* corners)
{
  UNROLL
  for (int n = 0; n < 8; ++n)
  {
    UNROLL
    for (int a = 0; a < 3; ++a)
    {
      local const float* from = tile->displacement[a] + POINT(at.x + (n & 1), at.y + (n >> 1 & 1), at.z + (n >> 2));
      STORE(LOAD(from), corners->u[a][n]);
    }
  }
  for (int n = 0; ambiguous && n < 8; ++n)
  {
    const int3 corner = at + (int3)(n & 1, n >> 1 & 1, n >> 2);
    const uint air = (uint)(tile->ambiguous[ROW(corner.y, corner.z)] >> corner.x) & ambiguous;
    if (!air)
    {
      continue;
    }
    // Computed as in virtualCorner().
    const mask counts = lanesOf(air);
    mask seeds = (mask)(0);
    for (int m = 0; m < 8; ++m)
    {
      const int3 from = at + (int3)(m & 1, m >> 1 & 1, m >> 2) - corner + 1;
      seeds |= (elements >> m & 1) << (from.x + 3 * from.y + 9 * from.z);
    }
    const mask around = bitsAroundEach(tile->elements, corner);
    real mean[3];
    meanAroundEach(tile, corner, joinedToEach(seeds & counts, around, tile, corner), mean);
    UNROLL
    for (int a = 0; a < 3; ++a)
    {
      STORE(select(LOAD(corners->u[a][n]), mean[a], counts), corners->u[a][n]);
    }
  }
}

// A lattice: the output voxels at one common offset after their grid points. There are FINER lattices along each axis
// that is not flat, and each has as many voxels as the grid.
typedef struct
{
  int after[3]; // the offset [output voxels]
} Lattice;

CHAINMAIL_INLINE Lattice latticeOf(int number)
{
  const Lattice lattice = { { number % FINER, number / FINER % FINER, number / (FINER * FINER) } };
  return lattice;
}

CHAINMAIL_INLINE float behindGrid(const Lattice* lattice, int axis)
{
  return lattice->after[axis] * (1.0f / FINER);
}

CHAINMAIL_INLINE bool hasVoxels(const Lattice* lattice, int4 flat)
{
  return !(flat.x && lattice->after[0]) && !(flat.y && lattice->after[1]) && !(flat.z && lattice->after[2]);
}

// Enters candidates for the voxels of a lattice that WIDTH cells along x cover. Lane n has the n-th of these cells, if
// `moves` is set there. It tries the grid points `first` to `last`, counted from the cell's lowest corner. A cell
// covers about one voxel, but a different one in each lane. So the voxels that may lie inside are first collected and
// then inverted together.
CHAINMAIL_INLINE void takeReached(const Output* o, const CellMap* map, const Lattice* lattice, const real* first,
  const real* last, mask moves, const mask* start, Lanes* lanes)
{
  int most[3], voxels[LONG][WIDTH], count[WIDTH], rounds = 0;
  float targets[LONG][3][WIDTH];
  UNROLL
  for (int a = 0; a < 3; ++a)
  {
    most[a] = (int)largestOf(select((real)(-1.0f), last[a] - first[a], moves));
  }
  for (int lane = 0; lane < WIDTH; ++lane)
  {
    count[lane] = 0;
  }
  int3 step = (int3)(0, 0, 0);
  while (step.x <= most[0] && step.y <= most[1] && step.z <= most[2])
  {
    const real point[3] = { first[0] + (float)step.x, first[1] + (float)step.y, first[2] + (float)step.z };
    const mask may = moves & (point[0] <= last[0]) & (point[1] <= last[1]) & (point[2] <= last[2]);
    const real target[3] = { point[0] + behindGrid(lattice, 0), point[1] + behindGrid(lattice, 1),
      point[2] + behindGrid(lattice, 2) };
    const mask within = may & mayBeInside(map, target);
    if (SOME(within))
    {
      float places[3][WIDTH];
      int wanted[WIDTH], brick[WIDTH], offset[WIDTH];
      STORE(within, wanted);
      const mask x = start[0] + TO_INT(point[0]), y = start[1] + TO_INT(point[1]), z = start[2] + TO_INT(point[2]);
      STORE(x / BX + o->boxBricks.x * (y / BY + o->boxBricks.y * (z / BZ)), brick);
      const mask inX = FINER * (x & (BX - 1)) + lattice->after[0], inY = FINER * (y & (BY - 1)) + lattice->after[1];
      const mask inZ = FINER * (z & (BZ - 1)) + lattice->after[2];
      STORE(inX + OUT_X * (inY + OUT_Y * inZ), offset);
      UNROLL
      for (int a = 0; a < 3; ++a)
      {
        STORE(target[a], places[a]);
      }
      for (int lane = 0; lane < WIDTH; ++lane)
      {
        const int voxel = wanted[lane] ? numberIn(o, brick[lane], offset[lane]) : -1;
        if (voxel < 0)
        {
          continue;
        }
        PREFETCH((global const uint*)o->claims + voxel);
        PREFETCH(o->offsets + 3 * (size_t)voxel);
        const int n = count[lane]++;
        if (n == rounds)
        {
          STORE((mask)(-1), voxels[n]);
          rounds = n + 1;
        }
        voxels[n][lane] = voxel;
        for (int a = 0; a < 3; ++a)
        {
          targets[n][a][lane] = places[a][lane];
        }
      }
    }
    const bool endsRow = step.x == most[0], endsLayer = endsRow && step.y == most[1];
    step = (int3)(endsRow ? 0 : step.x + 1, endsLayer ? 0 : step.y + endsRow, step.z + endsLayer);
  }
  for (int round = 0; round < rounds; ++round)
  {
    STORE(LOAD(voxels[round]), lanes->voxel);
    UNROLL
    for (int a = 0; a < 3; ++a)
    {
      STORE(LOAD(targets[round][a]), lanes->target[a]);
    }
    takeInside(o, map, lanes, 0, 0, false);
  }
}

// Finds the voxels of a lattice between `low` and `high` in the box of the output, for WIDTH cells. `first` and `last`
// are their grid points, counted from the lowest corner of each cell. `start` is where the cells begin in the box, and
// `end` the box's last point.
CHAINMAIL_INLINE void boundsOf(
  const Lattice* lattice, const real* low, const real* high, const mask* start, int3 end, real* first, real* last)
{
  UNROLL
  for (int a = 0; a < 3; ++a)
  {
    first[a] = max(ceil(low[a] - behindGrid(lattice, a)), TO_FLOAT(-start[a]));
    const int most = a == 0 ? end.x : a == 1 ? end.y : end.z;
    last[a] = min(floor(high[a] - behindGrid(lattice, a)), TO_FLOAT(most - start[a]));
  }
}

// WIDTH cells along x, one lane each.
typedef struct
{
  int3 at;       // place of the first cell in the tile
  int3 base;     // grid point of its lowest corner
  mask elements; // see cellOf()
  uint wanted;   // bit n: cell n is to be handled. The next two likewise.
  uint ambiguous, smooth;
} CellRow;

// Handles the cells of a row that are wanted.
CHAINMAIL_INLINE void coverRow(const Tissue* t, const Output* o, local Tile* tile, const CellRow* row)
{
  const int3 at = row->at, base = row->base;
  const mask elements = row->elements;
  const uint wanted = row->wanted, ambiguous = row->ambiguous, smooth = row->smooth;
  const int4 flat = t->flat;
  Lanes lanes;
  Corners corners;
  const mask number = laneNumbers(), isSmooth = lanesOf(smooth);
  STORE(elements, lanes.elements);
  STORE((mask)(keyOf(o, base)) + 8 * number + popcount((elements & -elements) - 1), lanes.key);
  cornersOfRow(tile, at, ambiguous, elements, &corners);
  // Voxels are counted from the lowest corner of each cell, and cells from the first point of the output box.
  const int3 from = base - o->boxFirst.xyz, end = o->boxBricks.xyz * (int3)(BX, BY, BZ) - 1;
  const mask start[3] = { number + from.x, (mask)(from.y), (mask)(from.z) };
  real u[3][8], first[3], last[3], low[3], high[3];
  mask moves = (mask)(0);
  UNROLL
  for (int a = 0; a < 3; ++a)
  {
    low[a] = (real)(INFINITY);
    high[a] = (real)(-INFINITY);
    UNROLL
    for (int n = 0; n < 8; ++n)
    {
      u[a][n] = LOAD(corners.u[a][n]);
      moves |= u[a][n] != 0.0f;
      low[a] = min(low[a], u[a][n] + (float)(n >> a & 1));
      high[a] = max(high[a], u[a][n] + (float)(n >> a & 1));
    }
    low[a] -= SLACK;
    // The strip left to the next cell (HANDED_ON) is at least half as wide after deformation.
    high[a] += select((real)(SLACK), (real)(-0.5f * HANDED_ON), isSmooth);
  }
  moves &= lanesOf(wanted);
  // A cell that a wave has just stretched far would keep the other lanes waiting.
  mask isLong = (mask)(0);
  for (int n = 0; n < LATTICES; ++n)
  {
    const Lattice lattice = latticeOf(n);
    boundsOf(&lattice, low, high, start, end, first, last);
    const real reach = (last[0] - first[0] + 1.0f) * (last[1] - first[1] + 1.0f) * (last[2] - first[2] + 1.0f);
    isLong |= moves & (reach > (float)LONG);
  }
  moves &= isLong == 0;
  const mask hasAir = moves & (elements != 255);
  int tooLong[WIDTH], airy[WIDTH];
  STORE(isLong, tooLong);
  STORE(hasAir, airy);
  for (int lane = 0; lane < WIDTH && SOME(isLong); ++lane)
  {
    if (tooLong[lane])
    {
      coverCell(t, o, tile, at + (int3)(lane, 0, 0), base + (int3)(lane, 0, 0), smooth >> lane & 1);
    }
  }
  CellMap map;
  mapOf(u, isSmooth, &map);
  for (int n = 0; n < LATTICES; ++n)
  {
    const Lattice lattice = latticeOf(n);
    if (hasVoxels(&lattice, flat))
    {
      boundsOf(&lattice, low, high, start, end, first, last);
      takeReached(o, &map, &lattice, first, last, moves, start, &lanes);
    }
  }
  for (int lane = 0; lane < WIDTH && SOME(hasAir); ++lane)
  {
    if (airy[lane])
    {
      const int3 place = at + (int3)(lane, 0, 0);
      const uint air = ~lanes.elements[lane] & 255 & ~cornerBits(t, tile->taken, place);
      float3 u[8];
      for (int n = 0; n < 8; ++n)
      {
        u[n] = (float3)(corners.u[0][n][lane], corners.u[1][n][lane], corners.u[2][n][lane]);
      }
      takeCorners(t, o, base + (int3)(lane, 0, 0), air, u, lanes.key[lane]);
      if (o->alone)
      {
        noteTaken(tile, place);
      }
    }
  }
}

// --- Kernels

// Handles those of WIDTH cells along x that have tissue and move.
NOINLINE void coverCells(const Tissue* t, const Output* o, local Tile* tile, int3 at, int3 base)
{
  const ulong near = tile->near[at.y - 1 + TILE_Y * (at.z - 1)];
  if (!((uint)(near >> at.x) & ((1u << WIDTH) - 1)))
  {
    return;
  }
  ulong full = ~(ulong)0, some = 0, moved = 0, ambiguous = 0, cut = any(t->flat.xyz != 0) ? ~(ulong)0 : 0, nearCut = 0;
  UNROLL
  for (int n = 0; n < 4; ++n)
  {
    const int row = ROW(at.y + (n & 1), at.z + (n >> 1));
    full &= tile->elements[row] & tile->elements[row] >> 1;
    some |= tile->elements[row] | tile->elements[row] >> 1;
    moved |= tile->moved[row] | tile->moved[row] >> 1;
    ambiguous |= tile->ambiguous[row] | tile->ambiguous[row] >> 1;
#ifdef CUTS
    cut |= tile->cut[row] | tile->cut[row] >> 1;
#endif
#ifdef SMOOTH_CUTS
    nearCut |= tile->nearCut[row] | tile->nearCut[row] >> 1;
#endif
  }
  cut |= nearCut; // these cells are sampled one by one
  uint wanted = (uint)((near & some & (moved | ~full | nearCut)) >> at.x) & ((1u << WIDTH) - 1);
  const uint whole = (uint)((full & ~cut) >> at.x);
  const mask elements = elementsOfRow(tile, at);
  int onePiece[WIDTH];
  STORE(areOnePiece(elements), onePiece);
  for (int lane = 0; (wanted & ~whole) >> lane; ++lane)
  {
    const int3 place = at + (int3)(lane, 0, 0), corner = base + (int3)(lane, 0, 0);
    if ((wanted & ~whole) >> lane & 1)
    {
      const bool hasCell = all(corner < max(t->size.xyz - 1, 1));
      const bool alone = (cut >> place.x & 1) || !onePiece[lane];
      wanted &= hasCell && !alone ? ~0u : ~(1u << lane);
      if (hasCell && alone)
      {
        coverCell(t, o, tile, place, corner, false);
      }
    }
  }
  if (wanted)
  {
    // Local copies: otherwise the members would be read again after each store.
    const Tissue tissue = *t;
    const Output output = *o;
    const CellRow row = { at, base, elements, wanted, (uint)(ambiguous >> at.x) & wanted,
      (uint)(smoothCells(tile, at.y, at.z) >> at.x) };
    coverRow(&tissue, &output, tile, &row);
  }
}

// The arguments of `cover` that make its Output: the box of output voxels, the cells, and what is written for each
// voxel.
#define BOXES_ARGUMENTS int4 boxFirst, int4 boxBricks, int4 cellsFirst, int4 cellsSize, global const int *places
#define CANDIDATES_ARGUMENTS                                                                                           \
  volatile global uint *claims, global uchar *disputed, global float *offsets, volatile global uint *disputes,         \
    uint mostDisputes
#ifdef SMOOTH_CUTS
#define DISTANCES_ARGUMENTS , global const int *distanceRows, global const ushort *distances
#define DISTANCES , distanceRows, distances
#define COVERAGE_ARGUMENTS , volatile global uint *covered, volatile global uint *behind
#define COVERAGE , covered, behind, select((float3)(SAMPLED), (float3)(0.0f), flat.xyz != 0)
#else
#define DISTANCES_ARGUMENTS
#define DISTANCES
#define COVERAGE_ARGUMENTS
#define COVERAGE
#endif

// Handles the cells whose lowest corner lies in a brick. `list` holds bricks as places in the table.
kernel void cover(global const int* list, STATE_ARGUMENTS, int4 size, int4 flat, BOXES_ARGUMENTS,
  CANDIDATES_ARGUMENTS DISTANCES_ARGUMENTS COVERAGE_ARGUMENTS)
{
  const Tissue tissue = { LAYOUT(state), displacement, constraint, cut, size, flat DISTANCES };
  const int3 origin = brickAtPlace(&tissue.layout, list[get_group_id(0) / SHARES]) * (int3)(BX, BY, BZ);
  const Output output = { boxFirst, boxBricks, cellsFirst, cellsSize, places, claims, disputed, offsets, disputes,
    mostDisputes, get_local_size(0) == 1, origin COVERAGE };
  local Tile tile;
  for (int n = get_group_id(0) % SHARES; n < TILES; n += SHARES)
  {
    const int3 first = (int3)(n % (BX / TILE_X), n / (BX / TILE_X) % (BY / TILE_Y), n / (BX / TILE_X * (BY / TILE_Y))) *
                       (int3)(TILE_X, TILE_Y, TILE_Z);
    if (loadTile(&tissue, origin + first - 1, &tile))
    {
      for (int work = get_local_id(0); work < TILE_WORK; work += get_local_size(0))
      {
        const int3 at = tileAt(work);
        coverCells(&tissue, &output, &tile, at + 1, origin + first + at);
      }
    }
    TILE_BARRIER
  }
}

// Stores, for voxels with conflicts, the offsets of the candidates that have won.
kernel void settle(global const uint* claims, global const uint* disputes, global float* offsets, uint count)
{
  const uint n = get_global_id(0);
  global const uint* dispute = disputes + 1 + DISPUTE * (size_t)n;
  if (n < count && claims[dispute[0]] == dispute[1])
  {
    vstore3((float3)(as_float(dispute[2]), as_float(dispute[3]), as_float(dispute[4])), dispute[0], offsets);
  }
}

// Fills a voxel without a candidate of tissue: the offset is NaN where material went away, else 0. A voxel between grid
// points is filled as the nearest grid point.
inline void leaveVoxel(const Tissue* t, int3 voxel, uint claim, global float* offset)
{
  const bool inside = all(voxel >= 0) && all(voxel <= FINER * (t->size.xyz - 1));
  const uint address = inside ? addressOf(&t->layout, (voxel + FINER / 2) / FINER) : 0;
  const bool element = inside && isElement(t, address);
  const bool rests = element && all(displacementAt(t, address) == 0.0f);
  // Border candidates do not hide tissue at rest.
  if (claim >= RESTS || rests)
  {
    const bool left = claim == VACATED || (element && !rests) || (inside && isCarved(t, address));
    vstore3((float3)(left ? NAN : 0.0f), 0, offset);
  }
}

#ifdef SMOOTH_CUTS

// The coverage of a voxel: 1 - open samples / SAMPLES. The open samples depend on the voxel's middle. In tissue near a
// cut surface they are those behind this surface that no other tissue covers. Behind a surface or in air (a border
// candidate, with AT_SURFACE) they are those that no tissue near a surface covers. Otherwise there are none.
CHAINMAIL_INLINE float coverageOf(uint covered, uint behind, uint claim)
{
  const bool isBeside = claim >= BORDER && claim < RESTS;
  const uint open = covered >> MIDDLE_SAMPLE & 1 ? behind : isBeside && behind & AT_SURFACE ? ~0u : 0;
  return 1.0f - popcount(open & ~covered & ~AT_SURFACE) / (float)SAMPLES;
}

#endif

#if WIDTH > 1

// Fills 2 * WIDTH voxels along x at once, in two cases: all have candidates of tissue; or all lie in the grid, without
// candidates and at rest. Returns whether it was one of these.
CHAINMAIL_INLINE bool leaveAlike(const Tissue* t, int3 voxel, bool inGrid, global const uint* claims,
  global float* offsets)
{
  const mask low = LOAD((global const int*)claims), high = LOAD((global const int*)claims + WIDTH);
  if (!SOME(low < 0) && !SOME(high < 0)) // BORDER is the sign
  {
    return true;
  }
  if (FINER > 1 || !inGrid || SOME(low != (int)NOTHING) || SOME(high != (int)NOTHING))
  {
    return false;
  }
  const uint addresses[2] = { addressOf(&t->layout, voxel),
    addressOf(&t->layout, voxel + (int3)(1, 0, 0)) };
  mask changed = (mask)(0);
  UNROLL
  for (int n = 0; n < 2; ++n)
  {
    real u[3];
    changed |= readColour(t, addresses[n], elementsAt(t, addresses[n]), u);
#ifdef CUTS
    changed |= (LOAD_BYTES(t->cut + addresses[n]) & CARVED_BIT) != 0;
#endif
  }
  if (SOME(changed))
  {
    return false;
  }
  UNROLL
  for (int n = 0; n < 6; ++n)
  {
    STORE((real)(0.0f), offsets + n * WIDTH);
  }
  return true;
}

#endif

#define LEFT_AT_ONCE (WIDTH > 1 ? 2 * WIDTH : 1)

// Fills the voxels of the listed output bricks. `firsts` holds the lowest voxel of each brick. `covered` is replaced by
// the coverage, as the bits of a float.
kernel void leave(STATE_ARGUMENTS, int4 size, int4 flat, global const int4* firsts, global const uint* claims,
  global float* offsets
#ifdef SMOOTH_CUTS
  ,
  global uint* covered, global const uint* behind
#endif
)
{
  const Tissue tissue = { LAYOUT(state), displacement, constraint, cut, size, flat };
  const int3 first = firsts[get_group_id(0)].xyz, begin = FINER * first;
  claims += get_group_id(0) * (size_t)OUTPUTS;
  offsets += 3 * get_group_id(0) * (size_t)OUTPUTS;
#ifdef SMOOTH_CUTS
  for (int n = get_local_id(0); n < OUTPUTS; n += get_local_size(0))
  {
    global uint* const at = covered + get_group_id(0) * (size_t)OUTPUTS + n;
    *at = as_uint(coverageOf(*at, behind[get_group_id(0) * (size_t)OUTPUTS + n], claims[n]));
  }
#endif
#if WIDTH > 1
  const bool inGrid = all(first >= 0) && all(first < size.xyz);
#endif
  for (int n = get_local_id(0) * LEFT_AT_ONCE; n < OUTPUTS; n += get_local_size(0) * LEFT_AT_ONCE)
  {
#if WIDTH > 1
    // Nearly all voxels are of the same case as those beside them.
    const int3 voxel = begin + (int3)(n % OUT_X, n / OUT_X % OUT_Y, n / (OUT_X * OUT_Y));
    if (leaveAlike(&tissue, voxel, inGrid, claims + n, offsets + 3 * n))
    {
      continue;
    }
#endif
    for (int m = n; m < n + LEFT_AT_ONCE; ++m)
    {
      if (claims[m] >= BORDER)
      {
        const int3 at = begin + (int3)(m % OUT_X, m / OUT_X % OUT_Y, m / (OUT_X * OUT_Y));
        leaveVoxel(&tissue, at, claims[m], offsets + 3 * m);
      }
    }
  }
}
