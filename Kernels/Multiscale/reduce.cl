// Displaces voxels with the larger elements, each of which stands for FX x FY x FZ voxels. Displacements are fractions
// of each grid's own spacing; the centre of an element is the centre of its voxels.
//
// The host guarantees: both grids have bricks of the same size; WIDTH is 1; the State is that of the elements;
// arguments named `whole` belong to the voxels; tables are as brick.clh says; listed voxels are at rest; every tissue
// voxel has an element: with OWNERS, element owner - 1 where `owner` is not 0, else the one that contains the voxel.

#include "brick.clh"
#include "state.clh"
#include "rotations.clh"

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

inline Corners cornersAt(const State* state, int3 base)
{
  const uint atRest = state->layout.pitch - SKEW; // see brick.clh
  Corners c = { { 0 }, 0, 0, 0, 0 };
  uint cutX = 0, cutY = 0, cutZ = 0;
  for (int d = 0; d < 8; ++d)
  {
    const uint address = addressOf(&state->layout, base + (int3)(d & 1, d >> 1 & 1, d >> 2));
    if (!isinf(state->constraint[address]))
    {
      c.elements |= 1u << d;
#ifdef CUTS
      const uint bits = state->cut[address];
      cutX |= IS_CUT_UP(bits, 0) << d;
      cutY |= IS_CUT_UP(bits, 1) << d;
      cutZ |= IS_CUT_UP(bits, 2) << d;
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
//
// Each work-item has rows of voxels, of which FX in sequence lie between the same elements.
kernel void expand(global const int* list, STATE_ARGUMENTS, LAYOUT_ARGUMENTS(whole), int4 size, global const int* owner,
  global const float* wholeConstraint, global float* wholeDisplacement)
{
  const State state = STATE;
  const Layout whole = LAYOUT(whole);
  const uint slot = list[get_group_id(0)];
  const int3 origin = brickOf(&whole, slot) * (int3)(BX, BY, BZ);
  for (int row = get_local_id(0); row < ROWS; row += get_local_size(0))
  {
    Corners c;
    bool isKnown = false;
    int known = 0;  // the place along x that `c` and `around` are for
    float around[3][8]; // the displacements of the eight elements
    for (int n = 0; n < BX; ++n)
    {
      const uint at = slot * ELEMENTS + localAddress(n, row % BY, row / BY);
      if (isinf(wholeConstraint[at]) || signbit(wholeConstraint[at]))
      {
        continue;
      }
      const int3 voxel = origin + (int3)(n, row % BY, row / BY);
      const float3 where = (convert_float3(voxel) + 0.5f) * (float3)(1.0f / FX, 1.0f / FY, 1.0f / FZ) - 0.5f;
      const int3 base = convert_int3(floor(where));
      const float3 w = where - floor(where);
      if (!isKnown || base.x != known)
      {
        c = cornersAt(&state, base);
        isKnown = true;
        known = base.x;
        for (int a = 0; a < 3; ++a)
        {
          for (int d = 0; d < 8; ++d)
          {
            around[a][d] = displacementAlong(&state, a)[c.address[d]];
          }
        }
      }
      int3 own = (int3)(voxel.x / FX, voxel.y / FY, voxel.z / FZ);
#ifdef OWNERS
      if (owner[at] != 0)
      {
        const int element = owner[at] - 1;
        own = (int3)(element % size.x, element / size.x % size.y, element / (size.x * size.y));
      }
#endif
      const bool isNear = all(own >= base) && all(own <= base + 1); // one of the eight elements
      const int corner = isNear ? own.x - base.x + 2 * (own.y - base.y) + 4 * (own.z - base.z) : 0;
      const uint ownAddress =
        isNear ? c.address[corner] : min(addressOf(&state.layout, own), state.layout.pitch - SKEW); // see brick.clh
      const float mine[3] = { displacementAlong(&state, 0)[ownAddress], displacementAlong(&state, 1)[ownAddress],
        displacementAlong(&state, 2)[ownAddress] };
      float sums[3] = { 0.0f, 0.0f, 0.0f };
      float weight = 0.0f;
      if (isNear && c.elements == 255 && c.linkX == 0x55 && c.linkY == 0x33 && c.linkZ == 0x0F)
      {
        // The case of nearly all voxels: no element or link is missing.
        UNROLL
        for (int a = 0; a < 3; ++a)
        {
          const float u0 = mix2(around[a][0], around[a][1], around[a][2], around[a][3], w);
          const float u1 = mix2(around[a][4], around[a][5], around[a][6], around[a][7], w);
          sums[a] = u0 + w.z * (u1 - u0) - mine[a];
        }
        weight = 1.0f;
      }
      else if (isNear)
      {
        uint reached = 1u << corner;
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
              sums[a] += share * (around[a][d] - mine[a]);
            }
          }
        }
      }
      const int factors[3] = { FX, FY, FZ };
      float more[3] = { 0.0f, 0.0f, 0.0f };
#ifdef ROTATIONS
      // leverArm, rest: from the centre of the element to the voxel, in voxels and in mean spacings. more: what the
      // rotation adds to the displacement.
      const float4 proportions = state.proportions;
      const float3 leverArm = convert_float3(voxel) + 0.5f - (convert_float3(own) + 0.5f) * (float3)(FX, FY, FZ);
      const float rest[3] = { leverArm.x / FX * proportions.x, leverArm.y / FY * proportions.y,
        leverArm.z / FZ * proportions.z };
      const float rotation[3] = { spinAlong(&state, 0)[ownAddress], spinAlong(&state, 1)[ownAddress],
        spinAlong(&state, 2)[ownAddress] };
      rotationOffset(rotation, rest, more);
      for (int a = 0; a < 3; ++a)
      {
        more[a] /= alongAxis(proportions, a);
      }
#endif
      UNROLL
      for (int a = 0; a < 3; ++a)
      {
        const bool rigid = wholeConstraint[min(a, AXES - 1) * whole.tissuePitch + at] == 0.0f;
        wholeDisplacement[a * whole.pitch + at] =
          factors[a] * (rigid || weight == 0.0f ? mine[a] + more[a] : mine[a] + sums[a] / weight);
      }
    }
  }
}
