// Where the material of each output voxel comes from.
//
// The unit is the cell of eight neighbouring grid points with at least one element. The links left in a cell split its
// elements into components. Each component gets a whole virtual cell: its own corners as they are, the others (air at
// the border, elements behind a cut) at the mean of the elements around them that hang together with the component. A
// material point belongs to the component of its nearest corner, so components share a cell without gap or overlap. A
// carved corner belongs to none: its share of the cell is gone.
//
// Two passes over the same inversion: `claim` lets every moved cell claim the voxels it covers, the lowest claim wins;
// `locate` finds the winner's material point. Coordinates are relative to the cell, in voxels, so float32 suffices.
//
// Output voxels come in bricks, too; `output` maps the bricks of a box that starts at voxel `boxFirst` (a multiple of
// the brick size away from voxel 0) to their places in the list of those that tissue may reach, or -1.
//
// Nearly all time goes into inversions, so WIDTH of them are made at once: of the voxels that a cell may cover, and of
// a row of voxels.
//
// The host guarantees: brick.clh's promise for every brick with a displaced element; flat[axis] says that the grid has
// a single layer there, in which case the axis takes no part.

#include "brick.clh"

// Claims: cell * 8 + component, and above all of these, in falling rank:
#define BORDER 0x80000000u  // + claim: air at the border of that component, never before the tissue of another
#define RESTS 0xFFFFFFFDu   // material that is still at its rest place
#define VACATED 0xFFFFFFFEu // material was here and went away
#define NOTHING 0xFFFFFFFFu

// Local coordinates may be off by this much, so that rounding opens no gap between two cells.
#define SLACK 1e-4f

#define DOT(a, b) (a[0] * b[0] + a[1] * b[1] + a[2] * b[2])
#define CROSS(a, b, out)                                                                                               \
  out[0] = a[1] * b[2] - a[2] * b[1];                                                                                  \
  out[1] = a[2] * b[0] - a[0] * b[2];                                                                                  \
  out[2] = a[0] * b[1] - a[1] * b[0];

typedef struct
{
  global const int* table;
  int strideY, strideZ;
  int4 size; // of the grid, in voxels
  int4 flat;
  uint pitch;
  global const float* displacement;
  global const float* constraint;
  global const uchar* cut;
} Tissue;

inline bool isElement(const Tissue* t, uint address)
{
  return !isinf(t->constraint[address]);
}

inline float3 displacementAt(const Tissue* t, uint address)
{
  return (float3)(t->flat.x ? 0.0f : t->displacement[address], t->flat.y ? 0.0f : t->displacement[t->pitch + address],
    t->flat.z ? 0.0f : t->displacement[2 * t->pitch + address]);
}

inline uint cutAt(const Tissue* t, uint address)
{
#ifdef CUTS
  return t->cut[address];
#else
  return 0;
#endif
}

inline bool isCarved(const Tissue* t, uint address)
{
  return cutAt(t, address) >> 6 & 1;
}

// The point that corner n of a cell is.
RULE int3 cornerAt(const Tissue* t, int3 base, int n)
{
  return base + (int3)(t->flat.x ? 0 : n & 1, t->flat.y ? 0 : n >> 1 & 1, t->flat.z ? 0 : n >> 2);
}

#define NO_COMPONENT 8

// Corner n of a cell: bit 0 x, bit 1 y, bit 2 z.
typedef struct
{
  int3 base;
  uint elements;      // bit n: corner n is an element
  bool whole;         // all corners belong to one component
  uchar component[8]; // lowest corner of the component that corner n belongs to; air corners join the nearest one;
                      // NO_COMPONENT where it is carved
  uint address[8];
} Cell;

// `elements`: of the cell, bit n: corner n.
RULE Cell cellOf(const Tissue* t, int3 base, uint elements)
{
  Cell cell;
  cell.base = base;
  cell.elements = elements;
  UNROLL
  for (int n = 0; n < 8; ++n)
  {
    cell.address[n] = addressOf(cornerAt(t, base, n), t->table, t->strideY, t->strideZ);
    cell.component[n] = n;
  }
  return cell;
}

RULE Cell cellAt(const Tissue* t, int3 base)
{
  Cell cell = cellOf(t, base, 0);
  UNROLL
  for (int n = 0; n < 8; ++n)
  {
    cell.elements |= isElement(t, cell.address[n]) ? 1u << n : 0;
  }
  return cell;
}

// Splits the elements of a cell by the links between them.
inline void findComponents(const Tissue* t, Cell* cell)
{
  if (cell->elements == 255)
  {
    // Nearly all cells: nothing is missing.
    uint cuts = 0;
#ifdef CUTS
    UNROLL
    for (int n = 0; n < 7; ++n)
    {
      cuts |= cutAt(t, cell->address[n]);
    }
#endif
    if (cuts == 0)
    {
      UNROLL
      for (int n = 0; n < 8; ++n)
      {
        cell->component[n] = 0;
      }
      cell->whole = true;
      return;
    }
  }
  for (int pass = 0; pass < 4; ++pass)
  {
    for (int n = 0; n < 8; ++n)
    {
      for (int a = 0; a < 3; ++a)
      {
        const int m = n | 1 << a;
        if (m == n || !(cell->elements >> n & cell->elements >> m & 1))
        {
          continue;
        }
        const bool same = cell->address[m] == cell->address[n];
        if (same || !(cutAt(t, cell->address[n]) >> (2 * a + 1) & 1))
        {
          const uchar lowest = min(cell->component[n], cell->component[m]);
          cell->component[n] = lowest;
          cell->component[m] = lowest;
        }
      }
    }
  }
  for (int n = 0; n < 8; ++n)
  {
    if (cell->elements >> n & 1)
    {
      continue;
    }
    if (isCarved(t, cell->address[n]))
    {
      cell->component[n] = NO_COMPONENT;
      continue;
    }
    int best = 0, distance = 4;
    for (int m = 0; m < 8; ++m)
    {
      const int steps = popcount((uint)(n ^ m));
      if ((cell->elements >> m & 1) && steps < distance)
      {
        best = m;
        distance = steps;
      }
    }
    cell->component[n] = cell->component[best];
  }
  cell->whole = true;
  for (int n = 1; n < 8; ++n)
  {
    cell->whole = cell->whole && cell->component[n] == cell->component[0];
  }
}

// The 3 x 3 x 3 grid points around one: bit x + 3 y + 9 z. Which are elements, and which of these are cut from the next
// point along an axis.
typedef struct
{
  uint elements, cutX, cutY, cutZ;
} Around;

inline Around aroundPoint(const Tissue* t, int3 centre)
{
  Around around = { 0, 0, 0, 0 };
  UNROLL
  for (int p = 0; p < 27; ++p)
  {
    const int3 at = centre + (int3)(p % 3 - 1, p / 3 % 3 - 1, p / 9 - 1);
    if (any(at < 0) || any(at >= t->size.xyz))
    {
      continue;
    }
    const uint address = addressOf(at, t->table, t->strideY, t->strideZ);
    if (isElement(t, address))
    {
      const uint cuts = cutAt(t, address);
      around.elements |= 1u << p;
      around.cutX |= (cuts >> 1 & 1) << p;
      around.cutY |= (cuts >> 3 & 1) << p;
      around.cutZ |= (cuts >> 5 & 1) << p;
    }
  }
  return around;
}

// The displacement of corner n of a component that it is not part of: the mean over the elements of the 3 x 3 x 3 grid
// points around the corner that links within these points join to the component. Cells that share the corner and the
// tissue around it get the same value, so their virtual cells fit together.
inline float3 virtualCorner(const Tissue* t, const Cell* cell, int component, int n, Around around)
{
  // Links to the next point along each axis, if both ends are elements.
  const uint notLastX = 0x36DB6DBu; // p % 3 < 2
  const uint notLastY = 0x0FC7E3Fu; // p / 3 % 3 < 2
  const uint linkX = around.elements & around.elements >> 1 & ~around.cutX & notLastX;
  const uint linkY = around.elements & around.elements >> 3 & ~around.cutY & notLastY;
  const uint linkZ = around.elements & around.elements >> 9 & ~around.cutZ;
  uint reached = 0;
  for (int m = 0; m < 8; ++m)
  {
    if ((cell->elements >> m & 1) && cell->component[m] == component)
    {
      const int x = (m & 1) - (n & 1) + 1, y = (m >> 1 & 1) - (n >> 1 & 1) + 1, z = (m >> 2) - (n >> 2) + 1;
      reached |= 1u << ((t->flat.x ? 1 : x) + 3 * (t->flat.y ? 1 : y) + 9 * (t->flat.z ? 1 : z));
    }
  }
  for (uint before = 0; before != reached;)
  {
    before = reached;
    reached |= (reached & linkX) << 1 | (reached >> 1 & linkX);
    reached |= (reached & linkY) << 3 | (reached >> 3 & linkY);
    reached |= (reached & linkZ) << 9 | (reached >> 9 & linkZ);
  }
  const int3 centre = cornerAt(t, cell->base, n);
  if (reached >> 13 & 1) // joined to the component around the end of a cut
  {
    return displacementAt(t, addressOf(centre, t->table, t->strideY, t->strideZ));
  }
  float3 sum = (float3)(0.0f);
  float3 first = (float3)(0.0f);
  int count = 0;
  bool equal = true;
  UNROLL
  for (int p = 0; p < 27; ++p)
  {
    if (reached >> p & 1)
    {
      const int3 at = centre + (int3)(p % 3 - 1, p / 3 % 3 - 1, p / 9 - 1);
      const float3 u = displacementAt(t, addressOf(at, t->table, t->strideY, t->strideZ));
      first = count == 0 ? u : first;
      equal = equal && all(u == first);
      sum += u;
      ++count;
    }
  }
  return equal ? first : sum / (float)count; // tissue that moves as one takes its border along exactly
}

RULE bool isOwn(const Cell* cell, int component, int n)
{
  return (cell->elements >> n & 1) && cell->component[n] == component;
}

// `around`: of the corners that are not the component's own.
RULE void cornersOf(const Tissue* t, const Cell* cell, int component, const Around* around, float3* corners)
{
  UNROLL
  for (int n = 0; n < 8; ++n)
  {
    corners[n] =
      isOwn(cell, component, n) ? displacementAt(t, cell->address[n]) : virtualCorner(t, cell, component, n, around[n]);
  }
}

// A trilinear function of each axis over a cell: c[0] + c[1] x + c[2] y + c[3] z + c[4] xy + c[5] xz + c[6] yz +
// c[7] xyz, from its values at the corners.
#define TRILINEAR(u, c)                                                                                                \
  c[0] = u[0];                                                                                                         \
  c[1] = u[1] - u[0];                                                                                                  \
  c[2] = u[2] - u[0];                                                                                                  \
  c[3] = u[4] - u[0];                                                                                                  \
  c[4] = u[3] - u[2] - c[1];                                                                                           \
  c[5] = u[5] - u[4] - c[1];                                                                                           \
  c[6] = u[6] - u[4] - c[2];                                                                                           \
  c[7] = (u[7] - u[6]) - (u[5] - u[4]) - c[4];

// Solves x + U(x) = target for local coordinates x by Newton's method. Whether x lies in the cell.
RULE mask inverted(real (*c)[8], const real* target, real* x)
{
  UNROLL
  for (int a = 0; a < 3; ++a)
  {
    const real middle =
      c[a][0] + 0.5f * (c[a][1] + c[a][2] + c[a][3]) + 0.25f * (c[a][4] + c[a][5] + c[a][6]) + 0.125f * c[a][7];
    x[a] = target[a] - middle;
  }
  mask solved = (mask)(0), near = (mask)(0), lost = (mask)(0);
  for (int step = 0; step < 16; ++step)
  {
    real r[3], d[3][3]; // residual and derivatives, d[axis along][axis of]
    UNROLL
    for (int a = 0; a < 3; ++a)
    {
      const real xy = c[a][4] + x[2] * c[a][7];
      const real yz = c[a][6] + x[0] * c[a][7];
      d[0][a] = c[a][1] + x[1] * xy + x[2] * c[a][5];
      d[1][a] = c[a][2] + x[0] * c[a][4] + x[2] * yz;
      d[2][a] = c[a][3] + x[0] * c[a][5] + x[1] * yz;
      const real u = c[a][0] + x[0] * d[0][a] + x[1] * (c[a][2] + x[2] * c[a][6]) + x[2] * c[a][3];
      r[a] = x[a] + u - target[a];
    }
    const real worst = max(max(fabs(r[0]), fabs(r[1])), fabs(r[2]));
    const mask open = (solved == 0) & (lost == 0);
    solved |= open & (worst <= 1e-6f);
    const mask going = open & (solved == 0);
    if (!SOME(going))
    {
      break;
    }
    // Large displacements are known less exactly; what rounding leaves then is no reason to leave a hole.
    near = select(near, (mask)(worst <= 1e-5f), going);
    d[0][0] += 1.0f;
    d[1][1] += 1.0f;
    d[2][2] += 1.0f;
    real normal[3], side[3], front[3];
    CROSS(d[1], d[2], normal)
    CROSS(d[2], d[0], side)
    CROSS(d[0], d[1], front)
    const real det = DOT(d[0], normal);
    x[0] = select(x[0], x[0] - DOT(r, normal) / det, going);
    x[1] = select(x[1], x[1] - DOT(r, side) / det, going);
    x[2] = select(x[2], x[2] - DOT(r, front) / det, going);
    // Far away, or not a number where the cell is flat.
    const mask close = (fabs(x[0]) < 16.0f) & (fabs(x[1]) < 16.0f) & (fabs(x[2]) < 16.0f);
    lost |= going & (close == 0);
  }
  mask inside = (solved | near) & (lost == 0);
  UNROLL
  for (int a = 0; a < 3; ++a)
  {
    inside &= (x[a] >= -SLACK) & (x[a] <= 1.0f + SLACK);
  }
  return inside;
}

// Whether a point of a cell lies in a component's share of it.
inline bool isShareOf(const Cell* cell, int component, float3 x)
{
  for (int n = 0; !cell->whole && n < 8; ++n)
  {
    const float3 corner = (float3)(n & 1, n >> 1 & 1, n >> 2);
    if (cell->component[n] == component && all(fabs(x - corner) <= 0.5f + SLACK))
    {
      return true;
    }
  }
  return cell->whole;
}

typedef struct
{
  int4 boxFirst, boxBricks;
  global const int* places;
  volatile global uint* claims;
} Output;

// Claims an output voxel, if anybody asks for it.
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

// What of the tissue is where in a part of a brick, and two points around it: a bit for each point, so that a cell
// knows at once whether there is something to do. Rows along x begin one point before the part.
#define PART_X (BX < 32 ? BX : 32)
#define PART_Z (BZ < 8 ? BZ : 8)
#define AROUND_Y (BY + 3)
#define AROUND_ROWS (AROUND_Y * (PART_Z + 3))
typedef struct
{
  ulong elements[AROUND_ROWS];
  ulong moved[AROUND_ROWS]; // elements that are not at their rest place
  ulong near[BY * PART_Z];  // of cells: whether one of the 4 x 4 x 4 points around is such an element
#ifdef CUTS
  ulong cutX[AROUND_ROWS], cutY[AROUND_ROWS], cutZ[AROUND_ROWS];
#endif
} Part;

// begin: the point that bit 0 of the first row is for.
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

// Which corners of a cell at a place of a part have their bit set.
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

// The 3 x 3 x 3 points around one, likewise.
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

// The voxels that a component of a cell covers, and those that its corners leave.
inline void claimComponent(const Tissue* t, const Output* o, const Cell* cell, int component, const Around* around)
{
  const int3 base = cell->base, cells = max(t->size.xyz - 1, 1);
  const int4 size = t->size, flat = t->flat;
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
  const uint key = (uint)(base.x + size.x * (base.y + size.y * base.z)) * 8 + component;
  // Corners leave their voxels, unless they stay.
  UNROLL
  for (int n = 0; n < 8; ++n)
  {
    // Each element once: where it is corner 0, or in the last layers.
    const bool again =
      (cell->elements >> n & 1) &&
      (((n & 1) && base.x < cells.x - 1) || ((n >> 1 & 1) && base.y < cells.y - 1) || (n >> 2 && base.z < cells.z - 1));
    if (cell->component[n] == component && !again)
    {
      // Air that moved less than a voxel away takes its surroundings along, so that no seam opens there.
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

// at: the cell's place in the part.
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

// Cells of a brick: those whose lowest corner lies in it. list: bricks, as places in the table.
kernel void claim(global const int* list, global const int* table, int strideY, int strideZ, uint pitch,
  global const float* displacement, global const float* constraint, global const uchar* cut, int4 size, int4 flat,
  int4 boxFirst, int4 boxBricks, global const int* places, volatile global uint* claims)
{
  const Tissue tissue = { table, strideY, strideZ, size, flat, pitch, displacement, constraint, cut };
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

// From a voxel to where its material was, where that takes no inversion: 0 where nothing changes, NaN where nothing is
// left. Whether it is known.
inline bool isKnown(const Tissue* t, int3 voxel, uint key, float3* offset)
{
  *offset = (float3)(key == VACATED ? NAN : 0.0f);
  if (key >= RESTS)
  {
    return true;
  }
  if (key >= BORDER && all(voxel >= 0) && all(voxel < t->size.xyz))
  {
    const uint address = addressOf(voxel, t->table, t->strideY, t->strideZ);
    return isElement(t, address) && all(displacementAt(t, address) == 0.0f); // tissue that rests here
  }
  return false;
}

// firsts: lowest voxel of each listed brick of the output.
kernel void locate(global const int* table, int strideY, int strideZ, uint pitch, global const float* displacement,
  global const float* constraint, global const uchar* cut, int4 size, int4 flat, global const int4* firsts,
  global const uint* claims, global float* offsets)
{
  const Tissue tissue = { table, strideY, strideZ, size, flat, pitch, displacement, constraint, cut };
  const Tissue* t = &tissue;
  for (int work = get_local_id(0); work < ELEMENTS / WIDTH; work += get_local_size(0))
  {
    const int n = work * WIDTH;
    const size_t at = get_group_id(0) * (size_t)ELEMENTS + n;
    const int3 begin = firsts[get_group_id(0)].xyz + (int3)(n % BX, n / BX % BY, n / (BX * BY));
    Cell cells[WIDTH];
    float3 corners[WIDTH][8], known[WIDTH];
    float coefficients[3][8][WIDTH], targets[3][WIDTH];
    int asks[WIDTH];
    bool any = false;
    for (int lane = 0; lane < WIDTH; ++lane)
    {
      const int3 voxel = begin + (int3)(lane, 0, 0);
      const uint key = claims[at + lane];
      asks[lane] = !isKnown(t, voxel, key, &known[lane]);
      float3 target = (float3)(0.0f);
      for (int m = 0; m < 8; ++m)
      {
        corners[lane][m] = (float3)(0.0f);
      }
      if (asks[lane])
      {
        any = true;
        const uint claimed = key & ~BORDER;
        const int linear = (int)(claimed / 8);
        const int3 base = (int3)(linear % size.x, linear / size.x % size.y, linear / (size.x * size.y));
        cells[lane] = cellAt(t, base);
        findComponents(t, &cells[lane]);
        Around around[8];
        for (int m = 0; m < 8; ++m)
        {
          if (!isOwn(&cells[lane], claimed % 8, m))
          {
            around[m] = aroundPoint(t, cornerAt(t, base, m));
          }
        }
        cornersOf(t, &cells[lane], claimed % 8, around, corners[lane]);
        target = convert_float3(voxel - base);
      }
      UNROLL
      for (int a = 0; a < 3; ++a)
      {
        float values[8], c[8];
        UNROLL
        for (int m = 0; m < 8; ++m)
        {
          values[m] = a == 0 ? corners[lane][m].x : a == 1 ? corners[lane][m].y : corners[lane][m].z;
        }
        TRILINEAR(values, c)
        UNROLL
        for (int m = 0; m < 8; ++m)
        {
          coefficients[a][m][lane] = c[m];
        }
        targets[a][lane] = a == 0 ? target.x : a == 1 ? target.y : target.z;
      }
    }
    float found[3][WIDTH];
    int hits[WIDTH];
    if (any)
    {
      real c[3][8], x[3];
      for (int a = 0; a < 3; ++a)
      {
        for (int m = 0; m < 8; ++m)
        {
          c[a][m] = LOAD(coefficients[a][m]);
        }
      }
      const real target[3] = { LOAD(targets[0]), LOAD(targets[1]), LOAD(targets[2]) };
      const mask inside = inverted(c, target, x);
      STORE(inside, hits);
      for (int a = 0; a < 3; ++a)
      {
        STORE(x[a], found[a]);
      }
    }
    for (int lane = 0; lane < WIDTH; ++lane)
    {
      float3 offset = known[lane];
      if (asks[lane])
      {
        const float3 place = (float3)(found[0][lane], found[1][lane], found[2][lane]);
        const float3 target = (float3)(targets[0][lane], targets[1][lane], targets[2][lane]);
        const int corner = (int)target.x + 2 * (int)target.y + 4 * (int)target.z;
        const int component = (claims[at + lane] & ~BORDER) % 8;
        offset = hits[lane] && isShareOf(&cells[lane], component, place) ? place - target : -corners[lane][corner];
      }
      vstore3(offset, at + lane, offsets);
    }
  }
}
