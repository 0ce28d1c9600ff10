// First pass of resampling: every moved cell claims the output voxels that it covers (resample.clh).
//
// Output voxels come in bricks, too. For each brick of a box that starts at voxel `boxFirst` (a multiple of the brick
// size away from voxel 0), `places` gives its number in the list of bricks that tissue may reach, or -1. A list is
// handled in batches.

#include "resample.clh"

typedef struct
{
  int4 boxFirst, boxBricks;
  global const int* places;
  volatile global uint* claims;
} Output;

// Claims an output voxel if its brick is on the list.
inline void claimVoxel(const Output* o, int3 voxel, uint key)
{
  const int3 at = voxel - o->boxFirst.xyz;
  const int3 brick = at / (int3)(BX, BY, BZ);
  if (any(at < 0) || any(brick >= o->boxBricks.xyz))
  {
    return;
  }
  const int place = o->places[brick.x + o->boxBricks.x * (brick.y + o->boxBricks.y * brick.z)];
  if (place >= 0)
  {
    const int3 local3 = at - brick * (int3)(BX, BY, BZ);
    atomic_min(o->claims + place * ELEMENTS + local3.x + BX * (local3.y + BY * local3.z), key);
  }
}

// The tissue in a part of a brick and up to two points around it, as one bit for each point, so that a cell knows at
// once whether there is something to do. Rows along x begin one point before the part.
#define PART_X (BX < 32 ? BX : 32)
#define PART_Z (BZ < 8 ? BZ : 8)
#define AROUND_Y (BY + 3)
#define AROUND_ROWS (AROUND_Y * (PART_Z + 3))
typedef struct
{
  ulong elements[AROUND_ROWS];
  ulong moved[AROUND_ROWS]; // elements that are displaced
  ulong near[BY * PART_Z];  // cells that have a displaced element among the 4 x 4 x 4 points around them
#ifdef CUTS
  ulong cutX[AROUND_ROWS], cutY[AROUND_ROWS], cutZ[AROUND_ROWS];
#endif
} Part;

// Fills `part`. Bit 0 of its first row stands for the point `begin`.
inline void lookAround(const Tissue* t, int3 begin, local Part* part)
{
  for (int row = get_local_id(0); row < AROUND_ROWS; row += get_local_size(0))
  {
    const int y = begin.y + row % AROUND_Y, z = begin.z + row / AROUND_Y;
    const bool outside = y < 0 || z < 0 || y >= t->size.y || z >= t->size.z;
    const int end = outside ? 0 : min(begin.x + PART_X + 3, t->size.x);
    ulong elements = 0, moved = 0, cutX = 0, cutY = 0, cutZ = 0;
    for (int x = max(begin.x, 0); x < end; ++x)
    {
      const uint address = addressOf((int3)(x, y, z), t->table, t->strideY, t->strideZ);
      if (isElement(t, address))
      {
        const ulong bit = (ulong)1 << (x - begin.x);
        const uint cuts = cutAt(t, address);
        elements |= bit;
        moved |= any(displacementAt(t, address) != 0.0f) ? bit : 0;
        cutX |= cuts >> 1 & 1 ? bit : 0;
        cutY |= cuts >> 3 & 1 ? bit : 0;
        cutZ |= cuts >> 5 & 1 ? bit : 0;
      }
    }
    part->elements[row] = elements;
    part->moved[row] = moved;
#ifdef CUTS
    part->cutX[row] = cutX;
    part->cutY[row] = cutY;
    part->cutZ[row] = cutZ;
#endif
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  for (int row = get_local_id(0); row < BY * PART_Z; row += get_local_size(0))
  {
    ulong moved = 0;
    UNROLL
    for (int n = 0; n < 16; ++n)
    {
      moved |= part->moved[row % BY + n % 4 + AROUND_Y * (row / BY + n / 4)];
    }
    part->near[row] = moved << 1 | moved | moved >> 1 | moved >> 2;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
}

// The corners, one bit each, of the cell at a place of a part that have their bit set in `rows`.
RULE uint cornerBits(const Tissue* t, local const ulong* rows, int3 at)
{
  uint bits = 0;
  UNROLL
  for (int n = 0; n < 4; ++n)
  {
    const ulong row = rows[at.y + (t->flat.y ? 0 : n & 1) + AROUND_Y * (at.z + (t->flat.z ? 0 : n >> 1))] >> at.x;
    bits |= (uint)(t->flat.x ? (row & 1) * 3 : row & 3) << 2 * n;
  }
  return bits;
}

// The same for the 3 x 3 x 3 points around a centre.
RULE uint bitsAround(local const ulong* rows, int3 centre)
{
  uint bits = 0;
  UNROLL
  for (int n = 0; n < 9; ++n)
  {
    bits |= (uint)(rows[centre.y + n % 3 - 1 + AROUND_Y * (centre.z + n / 3 - 1)] >> (centre.x - 1) & 7) << 3 * n;
  }
  return bits;
}

RULE Around aroundIn(local const Part* part, int3 centre)
{
  Around around = { bitsAround(part->elements, centre), 0, 0, 0 };
#ifdef CUTS
  around.cutX = bitsAround(part->cutX, centre);
  around.cutY = bitsAround(part->cutY, centre);
  around.cutZ = bitsAround(part->cutZ, centre);
#endif
  return around;
}

// Claims the voxels that a component of a cell covers, and marks those that its corners leave.
inline void claimComponent(const Tissue* t, const Output* o, const Cell* cell, int component, const Around* around)
{
  const int3 base = cell->base, cells = max(t->size.xyz - 1, 1);
  const int4 flat = t->flat;
  float3 u[8];
  cornersOf(t, cell, component, around, u);
  float3 low = (float3)(INFINITY), high = (float3)(-INFINITY);
  bool rests = true;
  UNROLL
  for (int n = 0; n < 8; ++n)
  {
    const float3 corner = u[n] + (float3)(n & 1, n >> 1 & 1, n >> 2);
    low = min(low, corner);
    high = max(high, corner);
    rests = rests && all(u[n] == 0.0f);
  }
  if (rests)
  {
    return;
  }
  const uint key = numberOf(t, base) * 8 + component;
  // Corners leave their voxels, unless they stay where they are.
  UNROLL
  for (int n = 0; n < 8; ++n)
  {
    // Each element marks once: in the cell where it is corner 0, or in the last layers.
    const bool again =
      (cell->elements >> n & 1) &&
      (((n & 1) && base.x < cells.x - 1) || ((n >> 1 & 1) && base.y < cells.y - 1) || (n >> 2 && base.z < cells.z - 1));
    if (cell->component[n] == component && !again)
    {
      // Air that moved by less than a voxel carries its surroundings along, so that no seam opens there.
      const bool follows = !(cell->elements >> n & 1) && all(fabs(u[n]) < 1.0f);
      claimVoxel(o, cornerAt(t, base, n), all(u[n] == 0.0f) ? RESTS : follows ? BORDER + key : VACATED);
    }
  }
  int3 first = max(convert_int3(ceil(low - SLACK)) + base, o->boxFirst.xyz);
  int3 last =
    min(convert_int3(floor(high + SLACK)) + base, o->boxFirst.xyz + o->boxBricks.xyz * (int3)(BX, BY, BZ) - 1);
  first = (int3)(flat.x ? base.x : first.x, flat.y ? base.y : first.y, flat.z ? base.z : first.z);
  last = (int3)(flat.x ? base.x : last.x, flat.y ? base.y : last.y, flat.z ? base.z : last.z);
  real c[3][8];
  UNROLL
  for (int a = 0; a < 3; ++a)
  {
    float values[8], coefficients[8];
    UNROLL
    for (int n = 0; n < 8; ++n)
    {
      values[n] = a == 0 ? u[n].x : a == 1 ? u[n].y : u[n].z;
    }
    TRILINEAR(values, coefficients)
    UNROLL
    for (int n = 0; n < 8; ++n)
    {
      c[a][n] = (real)(coefficients[n]);
    }
  }
  int3 voxel = first;
  for (bool more = all(first <= last); more;)
  {
    float lanes[3][WIDTH];
    int used = 0;
    UNROLL
    for (int lane = 0; lane < WIDTH; ++lane)
    {
      lanes[0][lane] = voxel.x - base.x;
      lanes[1][lane] = voxel.y - base.y;
      lanes[2][lane] = voxel.z - base.z;
      if (more)
      {
        ++used;
        const bool endsRow = voxel.x == last.x, endsLayer = endsRow && voxel.y == last.y;
        more = !endsLayer || voxel.z < last.z;
        if (more)
        {
          voxel = (int3)(endsRow ? first.x : voxel.x + 1, endsLayer ? first.y : voxel.y + endsRow, voxel.z + endsLayer);
        }
      }
    }
    const real target[3] = { LOAD(lanes[0]), LOAD(lanes[1]), LOAD(lanes[2]) };
    real x[3];
    const mask inside = inverted(c, target, x);
    if (!SOME(inside))
    {
      continue;
    }
    float found[3][WIDTH];
    int hits[WIDTH];
    STORE(inside, hits);
    for (int a = 0; a < 3; ++a)
    {
      STORE(x[a], found[a]);
    }
    for (int lane = 0; lane < used; ++lane)
    {
      const float3 place = (float3)(found[0][lane], found[1][lane], found[2][lane]);
      if (hits[lane] && isShareOf(cell, component, place))
      {
        const int3 covered = base + (int3)((int)lanes[0][lane], (int)lanes[1][lane], (int)lanes[2][lane]);
        const int nearest = (place.x > 0.5f) | (place.y > 0.5f) << 1 | (place.z > 0.5f) << 2;
        claimVoxel(o, covered, cell->elements >> nearest & 1 ? key : BORDER + key);
      }
    }
  }
}

// Claims what one cell covers. `at` is its place in the part.
inline void claimCell(const Tissue* t, const Output* o, local const Part* part, int3 at, int3 base)
{
  if (isCarved(t, addressOf(base, t->table, t->strideY, t->strideZ)))
  {
    claimVoxel(o, base, VACATED);
  }
  const uint elements = cornerBits(t, part->elements, at);
  const bool near = part->near[at.y - 1 + BY * (at.z - 1)] >> at.x & 1;
  if (any(base >= max(t->size.xyz - 1, 1)) || elements == 0 || !near ||
      (elements == 255 && cornerBits(t, part->moved, at) == 0))
  {
    return;
  }
  Cell cell = cellOf(t, base, elements);
  findComponents(t, &cell);
  Around around[8];
  for (int n = 0; n < 8 && !(cell.whole && elements == 255); ++n)
  {
    around[n] = aroundIn(part, cornerAt(t, at, n));
  }
  for (int component = 0; component < 8; ++component)
  {
    if (isOwn(&cell, component, component))
    {
      claimComponent(t, o, &cell, component, around);
    }
  }
}

// Handles the cells whose lowest corner lies in a brick. `list` holds bricks as places in the table.
kernel void claim(global const int* list, global const int* table, int strideY, int strideZ, uint pitch,
  global const float* displacement, global const float* constraint, global const uchar* cut, int4 size, int4 flat,
  int4 firstCell, int4 cellCounts, int4 boxFirst, int4 boxBricks, global const int* places,
  volatile global uint* claims)
{
  const Tissue tissue = { table, strideY, strideZ, size, flat, firstCell, cellCounts, pitch, displacement, constraint,
    cut };
  const Output output = { boxFirst, boxBricks, places, claims };
  const int3 origin = brickAt(list[get_group_id(0)], strideY, strideZ) * (int3)(BX, BY, BZ);
  local Part part;
  for (int n = 0; n < BX / PART_X * (BZ / PART_Z); ++n)
  {
    const int3 begin = origin + (int3)(n % (BX / PART_X) * PART_X, 0, n / (BX / PART_X) * PART_Z) - 1;
    lookAround(&tissue, begin, &part);
    for (int work = get_local_id(0); work < PART_X * BY * PART_Z; work += get_local_size(0))
    {
      const int3 at = (int3)(work % PART_X, work / PART_X % BY, work / (PART_X * BY)) + 1;
      claimCell(&tissue, &output, &part, at, begin + at);
    }
    barrier(CLK_LOCAL_MEM_FENCE);
  }
}
