// The kernels of a step of a relaxation: how far it moved the elements, and back on its way (StepStart.h).

#include "brick.clh"

#define FIGURES 3

// Squares of changes are counted in units of 2^-48, up to 8.
#define UNITS 0x1p48f
#define MOST_UNITS 0x1p51f

// Measures a step, one row of figures for each brick. `scale`: of each axis, to the unit of lengths.
//
// result[group * 3], per brick:
//   0   the sum of the squares of all changes since the start, in units and rounded down
//   1   the number of elements whose displacement squared is above `floor`
//   2   the largest displacement squared, as the bits of a float, whose order is that of the numbers
kernel void measureStep(global const int* list, uint pitch, global const float* start,
  global const float* displacement, float4 scale, float floor, local ulong* partial,
  global ulong* result)
{
  const uint first = list[get_group_id(0)] * ELEMENTS;
  const int lid = get_local_id(0);
  ulong squares = 0, displaced = 0;
  float largest = 0.0f;
  for (int n = lid; n < ELEMENTS; n += get_local_size(0))
  {
    const uint at = first + n;
    const float3 u =
      (float3)(displacement[at], displacement[pitch + at], displacement[2 * pitch + at]) * scale.xyz;
    const float3 change = u - (float3)(start[at], start[pitch + at], start[2 * pitch + at]) * scale.xyz;
    const float square = u.x * u.x + u.y * u.y + u.z * u.z;
    const float moved = change.x * change.x + change.y * change.y + change.z * change.z;
    squares += (ulong)min(UNITS * moved, MOST_UNITS);
    displaced += square > floor ? 1 : 0;
    largest = max(largest, square);
  }
  partial[lid * FIGURES] = squares;
  partial[lid * FIGURES + 1] = displaced;
  partial[lid * FIGURES + 2] = as_uint(largest);
  barrier(CLK_LOCAL_MEM_FENCE);
  for (int f = lid; f < FIGURES; f += get_local_size(0))
  {
    ulong whole = partial[f];
    for (int n = 1; n < (int)get_local_size(0); ++n)
    {
      const ulong part = partial[n * FIGURES + f];
      whole = f == 2 ? max(whole, part) : whole + part;
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
