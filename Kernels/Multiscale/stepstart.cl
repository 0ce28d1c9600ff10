// The kernels of a step of a relaxation: how far it moved the elements, and back on its way (StepStart.h).

#include "brick.clh"

#define FIGURES 2

// Squares of changes are counted in units of 2^-48, up to 8.
#define UNITS 0x1p48f
#define MOST_UNITS 0x1p51f
#if WIDTH == 1
typedef ulong units;
#define TO_UNITS(v) ((ulong)(v))
#else
typedef PASTE(ulong, WIDTH) units;
#define TO_UNITS(v) PASTE(convert_ulong, WIDTH)(v)
#endif
REDUCE(sumOfUnits, ulong, PLUS)

// Finds the largest displacement squared in each brick. `scale`: of each axis, to the unit of lengths.
kernel void largestSquare(global const int* list, uint pitch, global const float* displacement, float4 scale,
  local float* partial, global float* result)
{
  global const float* u = displacement + list[get_group_id(0)] * ELEMENTS;
  const int lid = get_local_id(0);
  real largest = (real)(0.0f);
  for (int n = lid * WIDTH; n < ELEMENTS; n += get_local_size(0) * WIDTH)
  {
    const real x = LOAD_WHOLE(u + n) * scale.x, y = LOAD_WHOLE(u + pitch + n) * scale.y,
               z = LOAD_WHOLE(u + 2 * pitch + n) * scale.z;
    largest = max(largest, x * x + y * y + z * z);
  }
  partial[lid] = largestOf(largest);
  barrier(CLK_LOCAL_MEM_FENCE);
  if (lid == 0)
  {
    float whole = partial[0];
    for (int n = 1; n < (int)get_local_size(0); ++n)
    {
      whole = max(whole, partial[n]);
    }
    result[get_group_id(0)] = whole;
  }
}

// Measures a step, one row of figures for each brick.
//
// result[group * 2], per brick:
//   0   the sum of the squares of all changes since the start, in units and rounded down
//   1   the number of elements whose displacement squared is above `floor`
kernel void measureStep(global const int* list, uint pitch, global const float* start,
  global const float* displacement, float4 scale, float floor, local ulong* partial,
  global ulong* result)
{
  const uint first = list[get_group_id(0)] * ELEMENTS;
  const int lid = get_local_id(0);
  units squares = (units)(0);
  real displaced = (real)(0.0f);
  for (int n = lid * WIDTH; n < ELEMENTS; n += get_local_size(0) * WIDTH)
  {
    real square = (real)(0.0f), moved = (real)(0.0f);
    UNROLL
    for (int axis = 0; axis < 3; ++axis)
    {
      const uint at = axis * pitch + first + n;
      const float factor = axis == 0 ? scale.x : axis == 1 ? scale.y : scale.z;
      const real u = LOAD_WHOLE(displacement + at) * factor;
      const real change = u - LOAD_WHOLE(start + at) * factor;
      square += u * u;
      moved += change * change;
    }
    squares += TO_UNITS(min(UNITS * moved, (real)(MOST_UNITS)));
    displaced += select((real)(0.0f), (real)(1.0f), square > floor);
  }
  partial[lid * FIGURES] = sumOfUnits(squares);
  partial[lid * FIGURES + 1] = (ulong)sumOf(displaced);
  barrier(CLK_LOCAL_MEM_FENCE);
  for (int f = lid; f < FIGURES; f += get_local_size(0))
  {
    ulong whole = partial[f];
    for (int n = 1; n < (int)get_local_size(0); ++n)
    {
      whole += partial[n * FIGURES + f];
    }
    result[get_group_id(0) * FIGURES + f] = whole;
  }
}

// Scales the move of every element: u = start + share (u - start).
kernel void goBack(
  global const int* list, uint pitch, float share, global const float* start, global float* displacement)
{
  const uint first = list[get_group_id(0)] * ELEMENTS;
  for (int axis = 0; axis < 3; ++axis)
  {
    for (int n = get_local_id(0); n < ELEMENTS; n += get_local_size(0))
    {
      const uint at = axis * pitch + first + n;
      displacement[at] = fma(share, displacement[at] - start[at], start[at]);
    }
  }
}
