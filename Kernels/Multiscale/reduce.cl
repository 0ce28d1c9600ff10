// Displaces voxels with the larger elements, each of which stands for FX x FY x FZ voxels. Displacements are fractions
// of each grid's own spacing; the centre of an element is the centre of its voxels.
//
// The host guarantees: both grids have bricks of the same size; WIDTH is 1; arguments named `whole` belong to the
// voxels, the others to the elements; tables are as brick.clh says; listed voxels are at rest; every tissue voxel has
// an element: with OWNERS, element owner - 1 where `owner` is not 0, else the one that contains the voxel.

#include "brick.clh"
#include "turning.clh"

inline float mix2(float a, float b, float c, float d, float3 w)
{
  const float low = a + w.x * (b - a), high = c + w.x * (d - c);
  return low + w.y * (high - low);
}

// The eight elements around a place, one bit each (x + 2 y + 4 z), and the links from each to the next one along an
// axis.
typedef struct
{
  uint address[8];
  uint elements, linkX, linkY, linkZ;
} Corners;

inline Corners cornersAt(int3 base, uint atRest, global const int* table, int strideY, int strideZ,
  global const float* constraint, global const uchar* cut)
{
  Corners c = { { 0 }, 0, 0, 0, 0 };
  uint cutX = 0, cutY = 0, cutZ = 0;
  for (int d = 0; d < 8; ++d)
  {
    const uint address = addressOf(base + (int3)(d & 1, d >> 1 & 1, d >> 2), table, strideY, strideZ);
    if (!isinf(constraint[address]))
    {
      c.elements |= 1u << d;
#ifdef CUTS
      const uint bits = cut[address];
      cutX |= (bits >> 1 & 1) << d;
      cutY |= (bits >> 3 & 1) << d;
      cutZ |= (bits >> 5 & 1) << d;
#endif
    }
    c.address[d] = min(address, atRest);
  }
  c.linkX = c.elements & c.elements >> 1 & ~cutX & 0x55u;
  c.linkY = c.elements & c.elements >> 2 & ~cutY & 0x33u;
  c.linkZ = c.elements & c.elements >> 4 & ~cutZ & 0x0Fu;
  return c;
}

// Displaces every voxel by the trilinear interpolation between the up to eight elements around it. Elements that no
// links between these eight join to the voxel's own element are left out. Equal displacements give exactly the same
// displacement. Rigid voxels move exactly with their own element and rotate about its centre; anchored voxels stay.
kernel void expand(global const int* list, uint wholePitch, uint wholeTissuePitch, global const int* wholeTable,
  global const int* wholePlace, int wholeStrideY, int wholeStrideZ, uint pitch, global const int* table, int strideY,
  int strideZ, int4 size, global const float* displacement, global const float* constraint,
  global const uchar* cut SPIN_ARGUMENTS, global const int* owner, global const float* wholeConstraint,
  global float* wholeDisplacement)
{
  const uint slot = list[get_group_id(0)];
  const int3 origin = brickAt(wholePlace[slot], wholeStrideY, wholeStrideZ) * (int3)(BX, BY, BZ);
  for (int n = get_local_id(0); n < ELEMENTS; n += get_local_size(0))
  {
    const uint at = slot * ELEMENTS + n;
    if (isinf(wholeConstraint[at]) || signbit(wholeConstraint[at]))
    {
      continue;
    }
    const int3 voxel = origin + elementAt(n);
    int3 own = (int3)(voxel.x / FX, voxel.y / FY, voxel.z / FZ);
#ifdef OWNERS
    if (owner[at] != 0)
    {
      const int element = owner[at] - 1;
      own = (int3)(element % size.x, element / size.x % size.y, element / (size.x * size.y));
    }
#endif
    const uint atRest = pitch - SKEW; // see brick.clh
    const uint ownAddress = min(addressOf(own, table, strideY, strideZ), atRest);
    const float3 where = (convert_float3(voxel) + 0.5f) * (float3)(1.0f / FX, 1.0f / FY, 1.0f / FZ) - 0.5f;
    const int3 base = convert_int3(floor(where));
    const float3 w = where - floor(where);
    float sums[3] = { 0.0f, 0.0f, 0.0f };
    float weight = 0.0f;
    if (all(own >= base) && all(own <= base + 1))
    {
      const Corners c = cornersAt(base, atRest, table, strideY, strideZ, constraint, cut);
      if (c.elements == 255 && c.linkX == 0x55 && c.linkY == 0x33 && c.linkZ == 0x0F)
      {
        // The case of nearly all voxels: no element or link is missing.
        for (int a = 0; a < 3; ++a)
        {
          global const float* u = displacement + a * pitch;
          const float u0 = mix2(u[c.address[0]], u[c.address[1]], u[c.address[2]], u[c.address[3]], w);
          const float u1 = mix2(u[c.address[4]], u[c.address[5]], u[c.address[6]], u[c.address[7]], w);
          sums[a] = u0 + w.z * (u1 - u0) - u[ownAddress];
        }
        weight = 1.0f;
      }
      uint reached = weight > 0.0f ? 0 : 1u << (own.x - base.x + 2 * (own.y - base.y) + 4 * (own.z - base.z));
      for (uint before = 0; before != reached;)
      {
        before = reached;
        reached |= (reached & c.linkX) << 1 | (reached >> 1 & c.linkX);
        reached |= (reached & c.linkY) << 2 | (reached >> 2 & c.linkY);
        reached |= (reached & c.linkZ) << 4 | (reached >> 4 & c.linkZ);
      }
      for (int d = 0; d < 8; ++d)
      {
        if (reached >> d & 1)
        {
          const float share =
            (d & 1 ? w.x : 1.0f - w.x) * (d >> 1 & 1 ? w.y : 1.0f - w.y) * (d >> 2 ? w.z : 1.0f - w.z);
          weight += share;
          for (int a = 0; a < 3; ++a)
          {
            sums[a] += share * (displacement[a * pitch + c.address[d]] - displacement[a * pitch + ownAddress]);
          }
        }
      }
    }
    const int factors[3] = { FX, FY, FZ };
    float more[3] = { 0.0f, 0.0f, 0.0f };
#ifdef TURNING
    // arm, rest: from the centre of the element to the voxel. more: what the rotation adds to the displacement.
    const float3 arm = convert_float3(voxel) + 0.5f - (convert_float3(own) + 0.5f) * (float3)(FX, FY, FZ);
    const float rest[3] = { arm.x / FX * proportions.x, arm.y / FY * proportions.y, arm.z / FZ * proportions.z };
    const float turns[3] = { spin[ownAddress], spin[pitch + ownAddress], spin[2 * pitch + ownAddress] };
    turned(turns, rest, more);
    for (int a = 0; a < 3; ++a)
    {
      more[a] /= proportion(proportions, a);
    }
#endif
    for (int a = 0; a < 3; ++a)
    {
      const bool rigid = wholeConstraint[min(a, AXES - 1) * wholeTissuePitch + at] == 0.0f;
      const float u = displacement[a * pitch + ownAddress];
      wholeDisplacement[a * wholePitch + at] =
        factors[a] * (rigid || weight == 0.0f ? u + more[a] : u + sums[a] / weight);
    }
  }
}
