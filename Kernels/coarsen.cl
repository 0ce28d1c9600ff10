// Between a grid and one of half its resolution, whose elements stand for 2 x 2 x 2 of it. Displacements are fractions
// of each grid's own spacing.
//
// The host guarantees: both grids have bricks of the same size, WIDTH is 1; `finer` and `coarser` arguments belong to
// the two grids, tables are as brick.clh says.

#include "brick.clh"

// Elements of the coarser grid to the mean of those they stand for; held ones to that of the held ones.
kernel void coarsen(global const int* list, uint pitch, global const int* table, global const int* place, int strideY,
  int strideZ, uint finerPitch, global const int* finerTable, global const int* finerPlace, int finerStrideY,
  int finerStrideZ, global const float* finerDisplacement, global const float* finerConstraint,
  global float* displacement)
{
  const uint slot = list[get_group_id(0)];
  const int3 brick = brickAt(place[slot], strideY, strideZ);
  for (int n = get_local_id(0); n < ELEMENTS; n += get_local_size(0))
  {
    const int3 twice = 2 * elementAt(n);
    const int3 finerBrick = 2 * brick + (int3)(twice.x >= BX, twice.y >= BY, twice.z >= BZ) + 1;
    const uint finerSlot = finerTable[finerBrick.x + finerBrick.y * finerStrideY + finerBrick.z * finerStrideZ];
    float3 free = (float3)(0.0f), held = (float3)(0.0f);
    int numberFree = 0, numberHeld = 0;
    for (int d = 0; d < 8; ++d)
    {
      const uint at = finerSlot * ELEMENTS +
                      localAddress(twice.x % BX + (d & 1), twice.y % BY + (d >> 1 & 1), twice.z % BZ + (d >> 2));
      const float c = finerConstraint[at];
      if (isinf(c))
      {
        continue;
      }
      const float3 u =
        (float3)(finerDisplacement[at], finerDisplacement[finerPitch + at], finerDisplacement[2 * finerPitch + at]);
      if (signbit(c))
      {
        held += u;
        ++numberHeld;
      }
      else
      {
        free += u;
        ++numberFree;
      }
    }
    const float3 u = numberHeld > 0 ? held / numberHeld : numberFree > 0 ? free / numberFree : (float3)(0.0f);
    const uint at = slot * ELEMENTS + n;
    displacement[at] = 0.5f * u.x;
    displacement[pitch + at] = 0.5f * u.y;
    displacement[2 * pitch + at] = 0.5f * u.z;
  }
}

// Takes the elements of the finer grid that are not held where the coarser one is: interpolated between the up to eight
// coarser elements around, those that no cut divides from the one it belongs to. For rigid ones the rigid of these
// alone count, axis by axis: so bone comes out where the coarser bone is.
kernel void refine(global const int* list, uint finerPitch, global const int* finerTable, global const int* finerPlace,
  int finerStrideY, int finerStrideZ, uint pitch, global const int* table, global const int* place, int strideY,
  int strideZ, global const float* displacement, global const float* constraint, global const uchar* cut,
  global const float* finerConstraint, global float* finerDisplacement)
{
  const uint finerSlot = list[get_group_id(0)];
  const int3 finerBrick = brickAt(finerPlace[finerSlot], finerStrideY, finerStrideZ);
  for (int n = get_local_id(0); n < ELEMENTS / 8; n += get_local_size(0))
  {
    // A coarser element and those around it: index x + 3 y + 9 z, 13 is its own.
    const int3 cell = (int3)(n % (BX / 2), n / (BX / 2) % (BY / 2), n / (BX * BY / 4));
    const int3 corner = finerBrick * (int3)(BX / 2, BY / 2, BZ / 2) + cell - 1;
    float4 around[27]; // displacement and 1, or nothing
    uint rigid[AXES];
    for (int axis = 0; axis < AXES; ++axis)
    {
      rigid[axis] = 0;
    }
    uint bits = 0;
    UNROLL
    for (int m = 0; m < 27; ++m)
    {
      const uint at = addressOf(corner + (int3)(m % 3, m / 3 % 3, m / 9), table, strideY, strideZ);
      around[m] = isinf(constraint[at])
                    ? (float4)(0.0f)
                    : (float4)(displacement[at], displacement[pitch + at], displacement[2 * pitch + at], 1.0f);
      for (int axis = 0; axis < AXES; ++axis)
      {
        rigid[axis] |= (constraint[axis * pitch + at] == 0.0f ? 1u : 0u) << m;
      }
#ifdef CUTS
      bits |= m == 13 ? cut[at] : 0;
#endif
    }

    for (int child = 0; child < 8; ++child)
    {
      const int3 side = (int3)(child & 1, child >> 1 & 1, child >> 2);
      const uint finer =
        finerSlot * ELEMENTS + localAddress(2 * cell.x + side.x, 2 * cell.y + side.y, 2 * cell.z + side.z);
      if (isinf(finerConstraint[finer]) || signbit(finerConstraint[finer]))
      {
        continue;
      }
      // Towards the neighbour that it lies nearer to, unless a cut is between.
      const float x = bits >> side.x & 1 ? 0.0f : 0.25f;
      const float y = bits >> (2 + side.y) & 1 ? 0.0f : 0.25f;
      const float z = bits >> (4 + side.z) & 1 ? 0.0f : 0.25f;
      float4 all = (float4)(0.0f), ofRigid[AXES];
      for (int axis = 0; axis < AXES; ++axis)
      {
        ofRigid[axis] = (float4)(0.0f);
      }
      UNROLL
      for (int d = 0; d < 8; ++d)
      {
        const int m = 13 + (d & 1 ? 2 * side.x - 1 : 0) + (d & 2 ? 6 * side.y - 3 : 0) + (d & 4 ? 18 * side.z - 9 : 0);
        const float4 part = (d & 1 ? x : 0.75f) * (d & 2 ? y : 0.75f) * (d & 4 ? z : 0.75f) * around[m];
        all += part;
        for (int axis = 0; axis < AXES; ++axis)
        {
          ofRigid[axis] += rigid[axis] >> m & 1 ? part : (float4)(0.0f);
        }
      }
      for (int axis = 0; axis < 3; ++axis)
      {
        const float4 bone = ofRigid[min(axis, AXES - 1)];
        const bool isRigid = finerConstraint[min(axis, AXES - 1) * finerPitch + finer] == 0.0f && bone.w > 0.0f;
        const float4 from = isRigid ? bone : all;
        if (from.w > 0.0f)
        {
          const float sum = axis == 0 ? from.x : axis == 1 ? from.y : from.z;
          finerDisplacement[axis * finerPitch + finer] = 2.0f * sum / from.w;
        }
      }
    }
  }
}
