// Resampling (resample.clh): `cover` goes over the moved cells, once to claim the output voxels that they cover and once
// more to find the material of those voxels whose claim won. In between, `leave` decides what becomes of the others.
//
// Output voxels come in bricks, too. For each brick of a box that starts at voxel `boxFirst` (a multiple of the brick
// size away from voxel 0), `places` gives its number in the list of bricks that tissue may reach, or -1. A list is
// handled in batches.

#include "part.clh"

typedef struct
{
  int4 boxFirst, boxBricks;
  int4 cellsFirst, cellsSize; // the box in which cells are counted
  global const int* places;
  volatile global uint* claims;
  global float* offsets;
  bool claiming; // in the first pass
} Output;

// The number of an output voxel among those of the listed bricks, or -1.
RULE int placeOf(const Output* o, int3 voxel)
{
  const uint3 at = convert_uint3(voxel - o->boxFirst.xyz); // huge where negative
  const uint3 brick = at / (uint3)(BX, BY, BZ);
  if (brick.x >= (uint)o->boxBricks.x || brick.y >= (uint)o->boxBricks.y || brick.z >= (uint)o->boxBricks.z)
  {
    return -1;
  }
  const int place = o->places[brick.x + o->boxBricks.x * (brick.y + o->boxBricks.y * brick.z)];
  const uint3 local3 = at % (uint3)(BX, BY, BZ);
  return place < 0 ? -1 : place * ELEMENTS + (int)(local3.x + BX * (local3.y + BY * local3.z));
}

// The same, and -1 for a voxel that is of no use to the cell with a key: in the second pass, one that another has won.
RULE int soughtPlace(const Output* o, int3 voxel, uint key)
{
  const int place = placeOf(o, voxel);
  return place >= 0 && (o->claiming || (o->claims[place] & ~BORDER) == key) ? place : -1;
}

// Tissue that does not move is not hidden by a border.
inline bool restsAt(const Tissue* t, int3 voxel)
{
  if (any(voxel < 0) || any(voxel >= t->size.xyz))
  {
    return false;
  }
  const uint address = addressOf(voxel, t->table, t->strideY, t->strideZ);
  return isElement(t, address) && all(displacementAt(t, address) == 0.0f);
}

// Claims a voxel, or, if that claim has won, says where its material came from.
inline void take(const Tissue* t, const Output* o, int place, int3 voxel, uint claim, float3 offset)
{
  if (o->claiming)
  {
    atomic_min(o->claims + place, claim);
  }
  else if (o->claims[place] == claim && !(claim >= BORDER && restsAt(t, voxel)))
  {
    vstore3(offset, place, o->offsets);
  }
}

// Takes the voxels in which the air at some corners of a cell lies. Air that moved by less than a voxel carries its
// surroundings along, so that no seam opens there; other air leaves. What elements leave behind is for `leave`.
inline void takeCorners(const Tissue* t, const Output* o, int3 base, uint corners, const float3* u, uint key)
{
  for (int n = 0; n < 8; ++n)
  {
    const int3 voxel = cornerAt(t, base, n);
    const int place = corners >> n & 1 ? placeOf(o, voxel) : -1;
    if (place < 0)
    {
      continue;
    }
    const bool rests = all(u[n] == 0.0f);
    if (!rests && all(fabs(u[n]) < 1.0f))
    {
      take(t, o, place, voxel, BORDER + key, -u[n]);
    }
    else if (o->claiming)
    {
      atomic_min(o->claims + place, rests ? RESTS : VACATED);
    }
  }
}

// WIDTH inversions. Each lane is about one voxel and one cell, from whose lowest corner the target is measured.
typedef struct
{
  int3 voxel[WIDTH];
  float target[3][WIDTH];
  int place[WIDTH];     // of the voxel; -1 where the lane has nothing to do
  uint key[WIDTH];      // of the cell
  uint elements[WIDTH]; // of the cell
} Lanes;

// Takes those voxels that lie in their cells, which have the coefficients `c`. `cell` is null, or a cell for all lanes
// of which only the share of one component counts.
RULE void takeInside(const Tissue* t, const Output* o, real (*c)[8], const Lanes* lanes, const Cell* cell, int component)
{
  const real target[3] = { LOAD(lanes->target[0]), LOAD(lanes->target[1]), LOAD(lanes->target[2]) };
  real x[3];
  const mask inside = inverted(c, target, x);
  if (!SOME(inside))
  {
    return;
  }
  float found[3][WIDTH];
  int hits[WIDTH];
  STORE(inside, hits);
  for (int a = 0; a < 3; ++a)
  {
    STORE(x[a], found[a]);
  }
  for (int lane = 0; lane < WIDTH; ++lane)
  {
    const float3 place = (float3)(found[0][lane], found[1][lane], found[2][lane]);
    if (lanes->place[lane] >= 0 && hits[lane] && (!cell || isShareOf(cell, component, place)))
    {
      const int nearest = (place.x > 0.5f) | (place.y > 0.5f) << 1 | (place.z > 0.5f) << 2;
      const uint border = lanes->elements[lane] >> nearest & 1 ? 0 : BORDER;
      const float3 target = (float3)(lanes->target[0][lane], lanes->target[1][lane], lanes->target[2][lane]);
      take(t, o, lanes->place[lane], lanes->voxel[lane], border + lanes->key[lane], place - target);
    }
  }
}

// The claim of the first component of a cell.
RULE uint keyOf(const Output* o, int3 base)
{
  const int3 cell = base - o->cellsFirst.xyz;
  return (uint)(cell.x + o->cellsSize.x * (cell.y + o->cellsSize.y * cell.z)) * 8;
}

// The corners, one bit each, of the cell at a place of a part that have their bit set in `rows`.
RULE uint cornerBits(const Tissue* t, local const ulong* rows, int3 at)
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

// --- Cells whose elements belong together: a row of them at once

// The lowest of some corners.
RULE uint lowest(uint corners)
{
  return popcount((corners & -corners) - 1);
}

// Whether the links between some corners of a cell join them all.
inline bool isOnePiece(uint corners)
{
  uint joined = corners & -corners;
  for (uint before = 0; before != joined;)
  {
    before = joined;
    const uint x = (joined & 0x55) << 1 | (joined >> 1 & 0x55);
    const uint y = (joined & 0x33) << 2 | (joined >> 2 & 0x33);
    const uint z = joined << 4 | joined >> 4;
    joined |= (x | y | z) & corners;
  }
  return joined == corners;
}

// Takes the voxels that WIDTH cells along x cover. Lane n is about the n-th cell after the one at `base`, and looks at
// the voxels `first` to `last` from that cell's lowest corner, where it `moves`.
inline void takeReached(const Tissue* t, const Output* o, real (*c)[8], const real* first, const real* last, mask moves,
  int3 base, Lanes* lanes)
{
  int most[3];
  for (int a = 0; a < 3; ++a)
  {
    most[a] = (int)largestOf(select((real)(-1.0f), last[a] - first[a], moves));
  }
  int3 step = (int3)(0, 0, 0);
  while (step.x <= most[0] && step.y <= most[1] && step.z <= most[2])
  {
    const real target[3] = { first[0] + (float)step.x, first[1] + (float)step.y, first[2] + (float)step.z };
    int within[WIDTH];
    STORE(moves & (target[0] <= last[0]) & (target[1] <= last[1]) & (target[2] <= last[2]), within);
    for (int a = 0; a < 3; ++a)
    {
      STORE(target[a], lanes->target[a]);
    }
    bool some = false;
    for (int lane = 0; lane < WIDTH; ++lane)
    {
      lanes->place[lane] = -1;
      if (within[lane])
      {
        const float3 reach = (float3)(lanes->target[0][lane], lanes->target[1][lane], lanes->target[2][lane]);
        lanes->voxel[lane] = base + (int3)(lane, 0, 0) + convert_int3(reach);
        lanes->place[lane] = soughtPlace(o, lanes->voxel[lane], lanes->key[lane]);
        some = some || lanes->place[lane] >= 0;
      }
    }
    if (some)
    {
      takeInside(t, o, c, lanes, 0, 0);
    }
    const bool endsRow = step.x == most[0], endsLayer = endsRow && step.y == most[1];
    step = (int3)(endsRow ? 0 : step.x + 1, endsLayer ? 0 : step.y + endsRow, step.z + endsLayer);
  }
}

// Handles those of WIDTH cells along x that have their bit set in `wanted`. The first is at a place `at` of the part
// and has its lowest corner at `base`.
inline void coverRow(const Tissue* t, const Output* o, local const Part* part, int3 at, int3 base, uint wanted)
{
  Lanes lanes;
  float numbers[WIDTH];
  int moving[WIDTH];
  for (int lane = 0; lane < WIDTH; ++lane)
  {
    lanes.elements[lane] = cornerBits(t, part->elements, at + (int3)(lane, 0, 0));
    lanes.key[lane] = keyOf(o, base + (int3)(lane, 0, 0)) + lowest(lanes.elements[lane]);
    numbers[lane] = lane;
    moving[lane] = wanted >> lane & 1 ? -1 : 0;
  }
  const int3 end = o->boxFirst.xyz + o->boxBricks.xyz * (int3)(BX, BY, BZ) - 1;
  const float3 least = convert_float3(o->boxFirst.xyz - base), greatest = convert_float3(end - base);
  real c[3][8], first[3], last[3];
  mask moves = (mask)(0);
  UNROLL
  for (int a = 0; a < 3; ++a)
  {
    real u[8], low = (real)(INFINITY), high = (real)(-INFINITY);
    UNROLL
    for (int n = 0; n < 8; ++n)
    {
      u[n] = LOAD(part->displacement[a] + POINT(at.x + (n & 1), at.y + (n >> 1 & 1), at.z + (n >> 2)));
      moves |= u[n] != 0.0f;
      low = min(low, u[n] + (float)(n >> a & 1));
      high = max(high, u[n] + (float)(n >> a & 1));
    }
    TRILINEAR(u, c[a])
    const real before = a == 0 ? LOAD(numbers) : (real)(0.0f);
    first[a] = max(ceil(low - SLACK), (a == 0 ? least.x : a == 1 ? least.y : least.z) - before);
    last[a] = min(floor(high + SLACK), (a == 0 ? greatest.x : a == 1 ? greatest.y : greatest.z) - before);
  }
  moves &= LOAD(moving);
  STORE(moves, moving);
  for (int lane = 0; lane < WIDTH; ++lane)
  {
    if (moving[lane] && lanes.elements[lane] != 255)
    {
      float3 u[8];
      for (int n = 0; n < 8; ++n)
      {
        u[n] = displacementIn(part, at + (int3)(lane + (n & 1), n >> 1 & 1, n >> 2));
      }
      takeCorners(t, o, base + (int3)(lane, 0, 0), ~lanes.elements[lane] & 255, u, lanes.key[lane]);
    }
  }
  takeReached(t, o, c, first, last, moves, base, &lanes);
}

// --- Cells that several pieces share, or in a grid of one layer: one by one

// The displacements of all corners of a component's virtual cell: its own, and for the others the mean over those
// elements around the corner that links join to the component. Cells that share a corner and the tissue around it get
// the same value, so their virtual cells fit together.
inline void cornersOf(
  const Tissue* t, local const Part* part, int3 at, const Cell* cell, int component, float3* corners)
{
  for (int n = 0; n < 8; ++n)
  {
    const int3 corner = cornerAt(t, at, n);
    corners[n] = displacementIn(part, corner);
    if (isOwn(cell, component, n))
    {
      continue;
    }
    uint seeds = 0;
    for (int m = 0; m < 8; ++m)
    {
      if (isOwn(cell, component, m))
      {
        const int3 from = cornerAt(t, at, m) - corner + 1;
        seeds |= 1u << (from.x + 3 * from.y + 9 * from.z);
      }
    }
    const uint joined = joinedTo(seeds, part, corner);
    // The corner may itself be joined to the component, around the end of a cut.
    if (!(joined >> 13 & 1))
    {
      corners[n] = meanAround(part, corner, joined);
    }
  }
}

// Takes the voxels that a component of a cell covers.
inline void coverComponent(
  const Tissue* t, const Output* o, local const Part* part, int3 at, const Cell* cell, int component)
{
  float3 u[8];
  cornersOf(t, part, at, cell, component, u);
  float3 low = (float3)(INFINITY), high = (float3)(-INFINITY);
  bool rests = true;
  uint air = 0;
  for (int n = 0; n < 8; ++n)
  {
    const float3 corner = u[n] + (float3)(n & 1, n >> 1 & 1, n >> 2);
    low = min(low, corner);
    high = max(high, corner);
    rests = rests && all(u[n] == 0.0f);
    air |= cell->component[n] == component && !(cell->elements >> n & 1) ? 1u << n : 0;
  }
  if (rests)
  {
    return;
  }
  Lanes lanes;
  for (int lane = 0; lane < WIDTH; ++lane)
  {
    lanes.key[lane] = keyOf(o, cell->base) + component;
    lanes.elements[lane] = cell->elements;
  }
  takeCorners(t, o, cell->base, air, u, lanes.key[0]);
  real c[3][8];
  for (int a = 0; a < 3; ++a)
  {
    float values[8], coefficients[8];
    for (int n = 0; n < 8; ++n)
    {
      values[n] = a == 0 ? u[n].x : a == 1 ? u[n].y : u[n].z;
    }
    TRILINEAR(values, coefficients)
    for (int n = 0; n < 8; ++n)
    {
      c[a][n] = (real)(coefficients[n]);
    }
  }
  const int3 base = cell->base, end = o->boxFirst.xyz + o->boxBricks.xyz * (int3)(BX, BY, BZ) - 1;
  const int3 flat = t->flat.xyz;
  const int3 first = select(max(convert_int3(ceil(low - SLACK)) + base, o->boxFirst.xyz), base, flat != 0);
  const int3 last = select(min(convert_int3(floor(high + SLACK)) + base, end), base, flat != 0);
  int used = 0;
  for (int3 voxel = first; all(voxel <= last);)
  {
    const int place = soughtPlace(o, voxel, lanes.key[0]);
    if (place >= 0)
    {
      const float3 target = convert_float3(voxel - base);
      lanes.voxel[used] = voxel;
      lanes.target[0][used] = target.x;
      lanes.target[1][used] = target.y;
      lanes.target[2][used] = target.z;
      lanes.place[used++] = place;
    }
    const bool endsRow = voxel.x == last.x, endsLayer = endsRow && voxel.y == last.y;
    voxel = (int3)(endsRow ? first.x : voxel.x + 1, endsLayer ? first.y : voxel.y + endsRow, voxel.z + endsLayer);
    if (used == WIDTH || (used > 0 && voxel.z > last.z))
    {
      for (int lane = used; lane < WIDTH; ++lane)
      {
        lanes.place[lane] = -1;
      }
      takeInside(t, o, c, &lanes, cell, component);
      used = 0;
    }
  }
}

inline void coverCell(const Tissue* t, const Output* o, local const Part* part, int3 at, int3 base)
{
  Cell cell = cellOf(t, base, cornerBits(t, part->elements, at));
  findComponents(t, &cell);
  for (int component = 0; component < 8; ++component)
  {
    if (isOwn(&cell, component, component))
    {
      coverComponent(t, o, part, at, &cell, component);
    }
  }
}

// --- Kernels

// Handles WIDTH cells along x: those that have tissue and move.
inline void coverCells(const Tissue* t, const Output* o, local const Part* part, int3 at, int3 base)
{
  ulong full = ~(ulong)0, some = 0, moved = 0, alone = any(t->flat.xyz != 0) ? ~(ulong)0 : 0;
  UNROLL
  for (int n = 0; n < 4; ++n)
  {
    const int row = ROW(at.y + (n & 1), at.z + (n >> 1));
    full &= part->elements[row] & part->elements[row] >> 1;
    some |= part->elements[row] | part->elements[row] >> 1;
    moved |= part->moved[row] | part->moved[row] >> 1;
    alone |= part->ambiguous[row] | part->ambiguous[row] >> 1;
#ifdef CUTS
    alone |= part->cut[row] | part->cut[row] >> 1;
#endif
  }
  const ulong near = part->near[at.y - 1 + PART_Y * (at.z - 1)];
  uint wanted = (uint)((near & some & (moved | ~full)) >> at.x) & ((1u << WIDTH) - 1);
  for (int lane = 0; wanted >> lane; ++lane)
  {
    const int3 place = at + (int3)(lane, 0, 0), corner = base + (int3)(lane, 0, 0);
    if ((wanted >> lane & 1) == 0)
    {
      continue;
    }
    const bool hasCell = all(corner < max(t->size.xyz - 1, 1));
    const bool isAlone = alone >> place.x & 1;
    if (!hasCell || isAlone || !(full >> place.x & 1 || isOnePiece(cornerBits(t, part->elements, place))))
    {
      wanted &= ~(1u << lane);
      if (hasCell)
      {
        coverCell(t, o, part, place, corner);
      }
    }
  }
  if (wanted)
  {
    coverRow(t, o, part, at, base, wanted);
  }
}

// Handles the cells whose lowest corner lies in a brick. `list` holds bricks as places in the table.
kernel void cover(global const int* list, global const int* table, int strideY, int strideZ, uint pitch,
  global const float* displacement, global const float* constraint, global const uchar* cut, int4 size, int4 flat,
  int4 boxFirst, int4 boxBricks, int4 cellsFirst, int4 cellsSize, global const int* places,
  volatile global uint* claims, global float* offsets, int claiming)
{
  const Tissue tissue = { table, strideY, strideZ, size, flat, pitch, displacement, constraint, cut };
  const Output output = { boxFirst, boxBricks, cellsFirst, cellsSize, places, claims, offsets, claiming };
  const int3 origin = brickAt(list[get_group_id(0)], strideY, strideZ) * (int3)(BX, BY, BZ);
  local Part part;
  for (int n = 0; n < PARTS; ++n)
  {
    const int3 begin = origin - 1 + (int3)(n % (BX / PART_X) * PART_X, n / (BX / PART_X) % (BY / PART_Y) * PART_Y,
                                      n / (BX / PART_X * (BY / PART_Y)) * PART_Z);
    if (lookAround(&tissue, begin, &part))
    {
      for (int work = get_local_id(0); work < PART_X * PART_Y * PART_Z / WIDTH; work += get_local_size(0))
      {
        const int x = work % (PART_X / WIDTH) * WIDTH, row = work / (PART_X / WIDTH);
        const int3 at = (int3)(x, row % PART_Y, row / PART_Y) + 1;
        coverCells(&tissue, &output, &part, at, begin + at);
      }
    }
    barrier(CLK_LOCAL_MEM_FENCE);
  }
}

// Gives every voxel of the listed output bricks an offset for the case that no cell takes it: NaN where material went
// away, else 0. `firsts` holds the lowest voxel of each brick.
kernel void leave(global const int* table, int strideY, int strideZ, uint pitch, global const float* displacement,
  global const float* constraint, global const uchar* cut, int4 size, int4 flat, global const int4* firsts,
  global const uint* claims, global float* offsets)
{
  const Tissue tissue = { table, strideY, strideZ, size, flat, pitch, displacement, constraint, cut };
  for (int n = get_local_id(0); n < ELEMENTS; n += get_local_size(0))
  {
    const size_t at = get_group_id(0) * (size_t)ELEMENTS + n;
    const int3 voxel = firsts[get_group_id(0)].xyz + (int3)(n % BX, n / BX % BY, n / (BX * BY));
    bool left = claims[at] == VACATED;
    if (all(voxel >= 0) && all(voxel < size.xyz))
    {
      const uint address = addressOf(voxel, table, strideY, strideZ);
      left = left || isCarved(&tissue, address) ||
             (isElement(&tissue, address) && any(displacementAt(&tissue, address) != 0.0f));
    }
    vstore3((float3)(left ? NAN : 0.0f), at, offsets);
  }
}
