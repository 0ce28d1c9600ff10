// Figures of the state, one row a brick.
//
// result[group * 15]: energy per axis (links leaving the brick count half), largest violation of a link, number of
// displaced elements, smallest displacement per axis and first row (y, z) with a displaced element, largest displacement
// per axis and last such row. 0 is always among the displacements.
//
// The host guarantees: brick.clh's promise for every brick with a displaced element.

#include "brick.clh"
#include "element.clh"

#define FIGURES 15

kernel void measure(global const int* list, float slack, uint pitch, global const int* table, global const int* place,
  int strideY, int strideZ, global const float* displacement, global const float* constraint, global const uchar* cut,
  local float* partial, global float* result)
{
  const int lid = get_local_id(0);
  const uint slot = list[get_group_id(0)];
  float figures[FIGURES];
  for (int f = 0; f < FIGURES; ++f)
  {
    figures[f] = 0.0f;
  }
  figures[8] = figures[9] = INFINITY;
  figures[13] = figures[14] = -INFINITY;
  for (int colour = 0; colour < 2; ++colour)
  {
    for (int work = lid; work < VECTORS; work += get_local_size(0))
    {
      const Site s = siteOf(slot, colour, work, table, place, strideY, strideZ);
      mask displaced = (mask)(0);
      real c, cs[6], us[6];
      for (int axis = 0; axis < 3; ++axis)
      {
        if (axis < AXES)
        {
          c = LOAD(constraint + axis * pitch + s.self);
          loadConstraints(constraint + axis * pitch, cut, &s, cs);
        }
        const real u = LOAD(displacement + axis * pitch + s.self);
        loadNeighbours(displacement + axis * pitch, &s, us);
        real energy = (real)(0.0f);
        real excess = (real)(0.0f);
        for (int d = 0; d < 6; ++d)
        {
          const real limit = linkLimit(c, cs[d]);
          const real pull = linkPull(u, us[d], limit, slack);
          energy += linkWeight(limit) * pull * pull;
          excess = max(excess, fabs(us[d] - u) - limit);
        }
        displaced |= u != 0.0f;
        figures[axis] += 0.5f * sumOf(energy);
        figures[3] = max(figures[3], largestOf(excess));
        figures[5 + axis] = min(figures[5 + axis], smallestOf(u));
        figures[10 + axis] = max(figures[10 + axis], largestOf(u));
      }
      if (SOME(displaced))
      {
        figures[8] = min(figures[8], (float)s.j);
        figures[9] = min(figures[9], (float)s.k);
        figures[13] = max(figures[13], (float)s.j);
        figures[14] = max(figures[14], (float)s.k);
      }
      figures[4] += sumOf(select((real)(0.0f), (real)(1.0f), displaced));
    }
  }
  for (int f = 0; f < FIGURES; ++f)
  {
    partial[lid * FIGURES + f] = figures[f];
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  for (int f = lid; f < FIGURES; f += get_local_size(0))
  {
    float whole = partial[f];
    for (int n = 1; n < (int)get_local_size(0); ++n)
    {
      const float part = partial[n * FIGURES + f];
      whole = f == 3 || f >= 10 ? max(whole, part) : f >= 5 ? min(whole, part) : whole + part;
    }
    result[get_group_id(0) * FIGURES + f] = whole;
  }
}
