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
// Output voxels come in bricks, too; `output` maps the bricks of a box that starts at voxel `boxFirst` (a multiple of the
// brick size away from voxel 0) to their places in the list of those that tissue may reach, or -1.
//
// The host guarantees: brick.clh's promise for every brick with a displaced element; WIDTH is 1; flat[axis] says that
// the grid has a single layer there, in which case the axis takes no part.

#include "brick.clh"

// Claims: cell * 8 + component, and above all of these, in falling rank:
#define BORDER 0x80000000u  // + claim: air at the border of that component, never before the tissue of another
#define RESTS 0xFFFFFFFDu   // material that is still at its rest place
#define VACATED 0xFFFFFFFEu // material was here and went away
#define NOTHING 0xFFFFFFFFu

// Local coordinates may be off by this much, so that rounding opens no gap between two cells.
#define SLACK 1e-4f

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
  return (float3)(t->flat.x ? 0.0f : t->displacement[address],
    t->flat.y ? 0.0f : t->displacement[t->pitch + address],
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

#define NO_COMPONENT 8

// Corner n of a cell: bit 0 x, bit 1 y, bit 2 z.
typedef struct
{
  int3 base;
  uint elements;         // bit n: corner n is an element
  bool whole;            // all corners belong to one component
  uchar component[8];    // lowest corner of the component that corner n belongs to; air corners join the nearest one;
                         // NO_COMPONENT where it is carved
  uint address[8];
} Cell;

inline Cell cellAt(const Tissue* t, int3 base)
{
  Cell cell;
  cell.base = base;
  cell.elements = 0;
  for (int n = 0; n < 8; ++n)
  {
    const int x = t->flat.x ? 0 : n & 1, y = t->flat.y ? 0 : n >> 1 & 1, z = t->flat.z ? 0 : n >> 2;
    cell.address[n] = addressOf(base + (int3)(x, y, z), t->table, t->strideY, t->strideZ);
    cell.component[n] = n;
    if (isElement(t, cell.address[n]))
    {
      cell.elements |= 1u << n;
    }
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
    for (int n = 0; n < 7; ++n)
    {
      cuts |= cutAt(t, cell->address[n]);
    }
#endif
    if (cuts == 0)
    {
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

// The displacement of corner n of a component that it is not part of: the mean over the elements of the 3 x 3 x 3 grid
// points around the corner that links within these points join to the component. Cells that share the corner and the
// tissue around it get the same value, so their virtual cells fit together.
inline float3 virtualCorner(const Tissue* t, const Cell* cell, int component, int n)
{
  const int3 centre = cell->base + (int3)(n & 1, n >> 1 & 1, n >> 2);
  uint elements = 0, cutX = 0, cutY = 0, cutZ = 0;
  uint addresses[27];
  for (int p = 0; p < 27; ++p)
  {
    const int i = centre.x + p % 3 - 1, j = centre.y + p / 3 % 3 - 1, k = centre.z + p / 9 - 1;
    addresses[p] = 0;
    if ((t->flat.x && p % 3 != 1) || (t->flat.y && p / 3 % 3 != 1) || (t->flat.z && p / 9 != 1) || i < 0 || j < 0 ||
      k < 0 || i >= t->size.x || j >= t->size.y || k >= t->size.z)
    {
      continue;
    }
    addresses[p] = addressOf((int3)(i, j, k), t->table, t->strideY, t->strideZ);
    if (isElement(t, addresses[p]))
    {
      const uint cuts = cutAt(t, addresses[p]);
      elements |= 1u << p;
      cutX |= (cuts >> 1 & 1) << p;
      cutY |= (cuts >> 3 & 1) << p;
      cutZ |= (cuts >> 5 & 1) << p;
    }
  }
  // Links to the next point along each axis, if both ends are elements.
  const uint notLastX = 0x36DB6DBu; // p % 3 < 2
  const uint notLastY = 0x0FC7E3Fu; // p / 3 % 3 < 2
  const uint linkX = elements & elements >> 1 & ~cutX & notLastX;
  const uint linkY = elements & elements >> 3 & ~cutY & notLastY;
  const uint linkZ = elements & elements >> 9 & ~cutZ;
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
  if (reached >> 13 & 1)
  {
    return displacementAt(t, addresses[13]); // joined to the component around the end of a cut
  }
  float3 sum = (float3)(0.0f);
  float3 first = (float3)(0.0f);
  int count = 0;
  bool equal = true;
  for (int p = 0; p < 27; ++p)
  {
    if (reached >> p & 1)
    {
      const float3 u = displacementAt(t, addresses[p]);
      first = count == 0 ? u : first;
      equal = equal && all(u == first);
      sum += u;
      ++count;
    }
  }
  return equal ? first : sum / (float)count; // tissue that moves as one takes its border along exactly
}

inline void cornersOf(const Tissue* t, const Cell* cell, int component, float3* corners)
{
  for (int n = 0; n < 8; ++n)
  {
    const bool own = (cell->elements >> n & 1) && cell->component[n] == component;
    corners[n] = own ? displacementAt(t, cell->address[n]) : virtualCorner(t, cell, component, n);
  }
}

inline float3 mixed(float3 a, float3 b, float s)
{
  return a + s * (b - a);
}

// Solves x + U(x) = target, U trilinear, for local coordinates x by Newton's method. True if x lies in the cell, in the
// component's share of it.
inline bool invert(const Tissue* t, const Cell* cell, int component, const float3* u, float3 target, float3* out)
{
  float3 x = target - 0.125f * (u[0] + u[1] + u[2] + u[3] + u[4] + u[5] + u[6] + u[7]);
  bool solved = false;
  for (int step = 0; step < 16; ++step)
  {
    const float3 u00 = mixed(u[0], u[1], x.x), u10 = mixed(u[2], u[3], x.x);
    const float3 u01 = mixed(u[4], u[5], x.x), u11 = mixed(u[6], u[7], x.x);
    const float3 u0 = mixed(u00, u10, x.y), u1 = mixed(u01, u11, x.y);
    const float3 residual = x + mixed(u0, u1, x.z) - target;
    if (all(fabs(residual) <= 1e-6f))
    {
      solved = true;
      break;
    }
    const float3 dx = mixed(mixed(u[1] - u[0], u[3] - u[2], x.y), mixed(u[5] - u[4], u[7] - u[6], x.y), x.z) +
      (float3)(1.0f, 0.0f, 0.0f);
    const float3 dy = mixed(u10 - u00, u11 - u01, x.z) + (float3)(0.0f, 1.0f, 0.0f);
    const float3 dz = u1 - u0 + (float3)(0.0f, 0.0f, 1.0f);
    const float3 normal = cross(dy, dz);
    const float det = dot(dx, normal);
    x -= (float3)(dot(residual, normal), dot(residual, cross(dz, dx)), dot(residual, cross(dx, dy))) / det;
    if (!all(fabs(x) < 16.0f)) // far away, or not a number where the cell is flat
    {
      return false;
    }
    // Large displacements are known less exactly; what rounding leaves then is no reason to leave a hole.
    solved = all(fabs(residual) <= 1e-5f);
  }
  if (!solved || any(x < -SLACK) || any(x > 1.0f + SLACK))
  {
    return false;
  }
  *out = x;
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

// Where the claim on an output voxel is kept; -1 where nobody asks for the voxel.
inline int claimOf(int3 voxel, global const int* output, int4 boxFirst, int4 boxBricks)
{
  const int3 at = voxel - boxFirst.xyz;
  const int3 brick = at / (int3)(BX, BY, BZ);
  if (any(at < 0) || any(brick >= boxBricks.xyz))
  {
    return -1;
  }
  const int place = output[brick.x + boxBricks.x * (brick.y + boxBricks.y * brick.z)];
  const int3 local3 = at - brick * (int3)(BX, BY, BZ);
  return place < 0 ? -1 : place * ELEMENTS + local3.x + BX * (local3.y + BY * local3.z);
}

// Cells of a brick: those whose lowest corner lies in it. list: bricks, as places in the table.
kernel void claim(global const int* list, global const int* table, int strideY, int strideZ,
  uint pitch, global const float* displacement, global const float* constraint, global const uchar* cut, int4 size,
  int4 flat, int4 boxFirst, int4 boxBricks, global const int* output, volatile global uint* claims)
{
  const Tissue tissue = { table, strideY, strideZ, size, flat, pitch, displacement, constraint, cut };
  const Tissue* t = &tissue;
  const int at = list[get_group_id(0)];
  const int3 origin = brickAt(at, strideY, strideZ) * (int3)(BX, BY, BZ);
  for (int work = get_local_id(0); work < ELEMENTS; work += get_local_size(0))
  {
    const int3 base = origin + (int3)(work % BX, work / BX % BY, work / (BX * BY));
    if (isCarved(t, addressOf(base, t->table, t->strideY, t->strideZ)))
    {
      const int claimed = claimOf(base, output, boxFirst, boxBricks);
      if (claimed >= 0)
      {
        atomic_min(claims + claimed, VACATED);
      }
    }
    const int3 cells = max(size.xyz - 1, 1);
    if (any(base >= cells))
    {
      continue;
    }
    Cell cell = cellAt(t, base);
    if (cell.elements == 0)
    {
      continue;
    }
    if (cell.elements == 255)
    {
      bool rests = true;
      for (int n = 0; rests && n < 8; ++n)
      {
        rests = all(displacementAt(t, cell.address[n]) == 0.0f);
      }
      if (rests)
      {
        continue;
      }
    }
    findComponents(t, &cell);
    for (int component = 0; component < 8; ++component)
    {
      if (!(cell.elements >> component & 1) || cell.component[component] != component)
      {
        continue;
      }
      float3 u[8];
      cornersOf(t, &cell, component, u);
      float3 low = (float3)(INFINITY), high = (float3)(-INFINITY);
      bool rests = true;
      for (int n = 0; n < 8; ++n)
      {
        const float3 corner = u[n] + (float3)(n & 1, n >> 1 & 1, n >> 2);
        low = min(low, corner);
        high = max(high, corner);
        rests = rests && all(u[n] == 0.0f);
      }
      if (rests)
      {
        continue;
      }
      const uint key = (uint)(base.x + size.x * (base.y + size.y * base.z)) * 8 + component;
      // Corners leave their voxels, unless they stay.
      for (int n = 0; n < 8; ++n)
      {
        if (cell.component[n] == component)
        {
          const int claimed = claimOf(base + (int3)(flat.x ? 0 : n & 1, flat.y ? 0 : n >> 1 & 1, flat.z ? 0 : n >> 2),
            output, boxFirst, boxBricks);
          if (claimed >= 0)
          {
            // Air that moved less than a voxel away takes its surroundings along, so that no seam opens there.
            const bool follows = !(cell.elements >> n & 1) && all(fabs(u[n]) < 1.0f);
            atomic_min(claims + claimed, all(u[n] == 0.0f) ? RESTS : follows ? BORDER + key : VACATED);
          }
        }
      }
      const int3 lowest = max(convert_int3(ceil(low - SLACK)) + base, boxFirst.xyz);
      const int3 highest = min(convert_int3(floor(high + SLACK)) + base, boxFirst.xyz + boxBricks.xyz * (int3)(BX, BY, BZ) - 1);
      for (int z = flat.z ? base.z : lowest.z; z <= (flat.z ? base.z : highest.z); ++z)
      {
        for (int y = flat.y ? base.y : lowest.y; y <= (flat.y ? base.y : highest.y); ++y)
        {
          for (int x = flat.x ? base.x : lowest.x; x <= (flat.x ? base.x : highest.x); ++x)
          {
            const int claimed = claimOf((int3)(x, y, z), output, boxFirst, boxBricks);
            float3 found;
            if (claimed >= 0 && invert(t, &cell, component, u, convert_float3((int3)(x, y, z) - base), &found))
            {
              const int nearest = (found.x > 0.5f) | (found.y > 0.5f) << 1 | (found.z > 0.5f) << 2;
              atomic_min(claims + claimed, cell.elements >> nearest & 1 ? key : BORDER + key);
            }
          }
        }
      }
    }
  }
}

// From a voxel to where its material was; 0 where nothing changes, NaN where nothing is left.
inline float3 offsetOf(const Tissue* t, int3 voxel, uint key)
{
  if (key == VACATED)
  {
    return (float3)(NAN);
  }
  if (key >= RESTS)
  {
    return (float3)(0.0f);
  }
  if (key >= BORDER && all(voxel >= 0) && all(voxel < t->size.xyz))
  {
    const uint address = addressOf(voxel, t->table, t->strideY, t->strideZ);
    if (isElement(t, address) && all(displacementAt(t, address) == 0.0f))
    {
      return (float3)(0.0f); // tissue that rests here
    }
  }
  const uint claimed = key & ~BORDER;
  const int linear = (int)(claimed / 8);
  const int component = claimed % 8;
  Cell cell =
    cellAt(t, (int3)(linear % t->size.x, linear / t->size.x % t->size.y, linear / (t->size.x * t->size.y)));
  findComponents(t, &cell);
  float3 u[8];
  cornersOf(t, &cell, component, u);
  const int3 corner = voxel - cell.base;
  const float3 target = convert_float3(corner);
  float3 found;
  if (invert(t, &cell, component, u, target, &found))
  {
    return found - target;
  }
  return -u[corner.x + 2 * corner.y + 4 * corner.z];
}

// firsts: lowest voxel of each listed brick of the output.
kernel void locate(global const int* table, int strideY, int strideZ, uint pitch, global const float* displacement,
  global const float* constraint, global const uchar* cut, int4 size, int4 flat, global const int4* firsts,
  global const uint* claims, global float* offsets)
{
  const Tissue tissue = { table, strideY, strideZ, size, flat, pitch, displacement, constraint, cut };
  const Tissue* t = &tissue;
  for (uint n = get_local_id(0); n < ELEMENTS; n += get_local_size(0))
  {
    const size_t at = get_group_id(0) * (size_t)ELEMENTS + n;
    const int3 voxel = firsts[get_group_id(0)].xyz + (int3)(n % BX, n / BX % BY, n / (BX * BY));
    vstore3(offsetOf(t, voxel, claims[at]), at, offsets);
  }
}
