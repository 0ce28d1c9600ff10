// Second pass of resampling: finds the material point of each output voxel in the cell with the lowest claim
// (resample.clh).

#include "resample.clh"

// Finds the offset from a voxel to its material where that takes no inversion: 0 where nothing changes, NaN where
// nothing is left. Returns whether it did.
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

// `firsts` holds the lowest voxel of each listed brick of the output.
kernel void locate(global const int* table, int strideY, int strideZ, uint pitch, global const float* displacement,
  global const float* constraint, global const uchar* cut, int4 size, int4 flat, int4 firstCell, int4 cellCounts,
  global const int4* firsts, global const uint* claims, global float* offsets)
{
  const Tissue tissue = { table, strideY, strideZ, size, flat, firstCell, cellCounts, pitch, displacement, constraint,
    cut };
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
        const int3 base = cellOfNumber(t, claimed / 8);
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
