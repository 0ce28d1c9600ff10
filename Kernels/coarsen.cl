// Between a grid and one of half its resolution, whose elements stand for 2 x 2 x 2 of it. Displacements are fractions of
// each grid's own spacing.
//
// The host guarantees: both grids have bricks of the same size, WIDTH is 1; `finer` and `coarser` arguments belong to the
// two grids, tables are as brick.clh says.

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
      const float3 u = (float3)(
        finerDisplacement[at], finerDisplacement[finerPitch + at], finerDisplacement[2 * finerPitch + at]);
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
// coarser elements around, those that no cut divides from the one it belongs to.
kernel void refine(global const int* list, uint finerPitch, global const int* finerTable, global const int* finerPlace,
  int finerStrideY, int finerStrideZ, uint pitch, global const int* table, global const int* place, int strideY,
  int strideZ, global const float* displacement, global const float* constraint, global const uchar* cut,
  global const float* finerConstraint, global float* finerDisplacement)
{
  const uint finerSlot = list[get_group_id(0)];
  const int3 finerBrick = brickAt(finerPlace[finerSlot], finerStrideY, finerStrideZ);
  for (int n = get_local_id(0); n < ELEMENTS; n += get_local_size(0))
  {
    const uint finer = finerSlot * ELEMENTS + n;
    if (isinf(finerConstraint[finer]) || signbit(finerConstraint[finer]))
    {
      continue;
    }
    const int3 at = finerBrick * (int3)(BX, BY, BZ) + elementAt(n);
    // For each axis: of all elements around, and of the rigid ones, which alone count for a rigid element: so bone comes
    // out where the coarser bone is.
    float weights[2][3], sums[2][3];
    for (int a = 0; a < 3; ++a)
    {
      weights[0][a] = weights[1][a] = sums[0][a] = sums[1][a] = 0.0f;
    }
    uint bits = 0;
    for (int d = 0; d < 8; ++d)
    {
      // Bit a of d: towards the neighbour that the element lies nearer to.
      int3 from = at / 2;
      from.x += d & 1 ? (at.x & 1 ? 1 : -1) : 0;
      from.y += d >> 1 & 1 ? (at.y & 1 ? 1 : -1) : 0;
      from.z += d >> 2 ? (at.z & 1 ? 1 : -1) : 0;
      const uint coarse = addressOf(from, table, strideY, strideZ);
#ifdef CUTS
      if (d == 0)
      {
        bits = cut[coarse];
      }
      if ((d & 1 && bits >> (at.x & 1) & 1) || (d >> 1 & 1 && bits >> (2 + (at.y & 1)) & 1) ||
        (d >> 2 && bits >> (4 + (at.z & 1)) & 1))
      {
        continue;
      }
#endif
      if (isinf(constraint[coarse]))
      {
        continue;
      }
      const float w = (d & 1 ? 0.25f : 0.75f) * (d >> 1 & 1 ? 0.25f : 0.75f) * (d >> 2 ? 0.25f : 0.75f);
      for (int a = 0; a < 3; ++a)
      {
        const int rigid = constraint[min(a, AXES - 1) * pitch + coarse] == 0.0f;
        weights[rigid][a] += w;
        sums[rigid][a] += w * displacement[a * pitch + coarse];
      }
    }
    for (int a = 0; a < 3; ++a)
    {
      const bool rigid = finerConstraint[min(a, AXES - 1) * finerPitch + finer] == 0.0f && weights[1][a] > 0.0f;
      const float weight = rigid ? weights[1][a] : weights[0][a] + weights[1][a];
      const float sum = rigid ? sums[1][a] : sums[0][a] + sums[1][a];
      if (weight > 0.0f)
      {
        finerDisplacement[a * finerPitch + finer] = 2.0f * sum / weight;
      }
    }
  }
}
