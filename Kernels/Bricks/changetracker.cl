// Hashes the displacements of bricks and finds their extent, one row of numbers per brick. The bricks have a state.
//
// result[group * 14], floats stored as their bits:
//   0, 1     two hashes of all displacements
//   2 to 7   per axis the smallest displacement of all places; then the first place with a displaced element
//   8 to 13  per axis the largest displacement of all places; then the last place with a displaced element
//
// Places count from the brick's first corner. Along x they may be off by one, towards a larger extent.

#include "brick.clh"

#define FIGURES 14

#if WIDTH == 1
typedef uint word;
#define AS_WORD(v) as_uint(v)
#else
typedef PASTE(uint, WIDTH) word;
#define AS_WORD(v) PASTE(as_uint, WIDTH)(v)
#endif

// Mixes a word: each of its bits affects all others. It is invertible, so different words stay different.
#define STIR(h)                                                                                                        \
  h ^= h >> 16;                                                                                                        \
  h *= 0x7feb352du;                                                                                                    \
  h ^= h >> 15;                                                                                                        \
  h *= 0x846ca68bu;                                                                                                    \
  h ^= h >> 16;

// The hash of a sequence: `before` is the hash of its beginning, `next` the next element.
inline uint hashOf(uint before, uint next)
{
  uint h = before * 0x9e3779b9u + next;
  STIR(h)
  return h;
}

inline uint hashOfLanes(word lanes)
{
  uint each[WIDTH], whole = 0;
  STORE(lanes, each);
  for (int lane = 0; lane < WIDTH; ++lane)
  {
    whole = hashOf(whole, each[lane]);
  }
  return whole;
}

// Surveys the share of work-item `lid`, one of `items`, in a brick.
NOINLINE void surveyShare(int lid, int items, uint first, uint pitch, global const float* displacement, local uint* row)
{
  real low[3], high[3], lanes, firstX = (real)(INFINITY), lastX = (real)(-INFINITY);
  word sums[2];
  float begin[3] = { INFINITY, INFINITY, INFINITY }, end[3] = { -INFINITY, -INFINITY, -INFINITY };
  float numbers[WIDTH];
  for (int lane = 0; lane < WIDTH; ++lane)
  {
    numbers[lane] = 2 * lane;
  }
  lanes = LOAD(numbers);
  sums[0] = sums[1] = (word)(0);
  for (int axis = 0; axis < 3; ++axis)
  {
    low[axis] = (real)(INFINITY);
    high[axis] = (real)(-INFINITY);
  }
  for (int n = lid * WIDTH; n < ELEMENTS; n += items * WIDTH)
  {
    mask displaced = (mask)(0);
    UNROLL
    for (int axis = 0; axis < 3; ++axis)
    {
      const real u = LOAD(displacement + axis * pitch + first + n);
      low[axis] = min(low[axis], u);
      high[axis] = max(high[axis], u);
      displaced |= fabs(u) >= NEGLIGIBLE;
      word h = AS_WORD(u) + (uint)(3 * n + axis) * 0x9e3779b9u;
      STIR(h)
      sums[0] += h;
      h *= 0x2c1b3c6du;
      h ^= h >> 12;
      sums[1] += h * 0x297a2d39u;
    }
    if (SOME(displaced))
    {
      const int row = n % COLOUR / HALF;
      const real x = lanes + (float)(2 * (n % HALF));
      firstX = min(firstX, select((real)(INFINITY), x, displaced));
      lastX = max(lastX, select((real)(-INFINITY), x + 1.0f, displaced));
      begin[1] = min(begin[1], (float)(row % BY));
      begin[2] = min(begin[2], (float)(row / BY));
      end[1] = max(end[1], (float)(row % BY));
      end[2] = max(end[2], (float)(row / BY));
    }
  }
  begin[0] = smallestOf(firstX);
  end[0] = largestOf(lastX);
  const float figures[FIGURES - 2] = { smallestOf(low[0]), smallestOf(low[1]), smallestOf(low[2]), begin[0], begin[1],
    begin[2], largestOf(high[0]), largestOf(high[1]), largestOf(high[2]), end[0], end[1], end[2] };
  row[0] = hashOfLanes(sums[0]);
  row[1] = hashOfLanes(sums[1]);
  for (int f = 2; f < FIGURES; ++f)
  {
    row[f] = as_uint(figures[f - 2]);
  }
}

kernel void survey(
  global const int* list, uint pitch, global const float* displacement, local uint* partial, global uint* result)
{
  const int lid = get_local_id(0);
  surveyShare(lid, get_local_size(0), list[get_group_id(0)] * ELEMENTS, pitch, displacement, partial + lid * FIGURES);
  barrier(CLK_LOCAL_MEM_FENCE);
  for (int f = lid; f < FIGURES; f += get_local_size(0))
  {
    uint whole = partial[f];
    for (int n = 1; n < (int)get_local_size(0); ++n)
    {
      const uint part = partial[n * FIGURES + f];
      whole = f < 2   ? hashOf(whole, part)
              : f < 8 ? as_uint(min(as_float(whole), as_float(part)))
                      : as_uint(max(as_float(whole), as_float(part)));
    }
    result[get_group_id(0) * FIGURES + f] = whole;
  }
}
