// Measures the state, one row of figures for each brick.
//
// result[group * 15], per brick:
//   0 to 2   energy per axis: links of the elements of one colour (each link joins two colours), soft links of all
//            elements; the first one also has the volumetric energy of all elements
//   3        largest violation of the limit of one of these links
//   4        number of displaced elements
//   5 to 9   smallest displacement per axis, or 0; first row (y, z) with a displaced element
//   10 to 14 largest displacement per axis, or 0; last row (y, z) with a displaced element
//
// The host guarantees what brick.clh requires, for every brick with a displaced element.

#include "brick.clh"
#include "element.clh"
#include "turning.clh"

#include "halo.clh"
#include "softlinks.clh"
#include "volumetricstrain.clh"

#define FIGURES 15

// Adds the energy of all links of a lane group, and updates the largest violation.
CHAINMAIL_INLINE void addLinks(const int odd, const Stencil* s, const Stencil* state, float slack, uint pitch,
  uint tissuePitch, global const float* displacement, global const float* constraint, global const uchar* cut,
  real* energy,
  real* excess SPIN_ARGUMENTS)
{
#ifdef TURNING
  real own[3], other[3], mine[6][3], theirs[6][3];
  for (int axis = 0; axis < 3; ++axis)
  {
    own[axis] = LOAD(spin + axis * pitch + state->self);
  }
  UNROLL
  for (int d = 0; d < 6; ++d)
  {
    for (int axis = 0; axis < 3; ++axis)
    {
      other[axis] = neighbour(spin + axis * pitch, state, d, odd);
    }
    restOffset(own, d, proportions, mine[d]);
    restOffset(other, d, proportions, theirs[d]);
  }
#endif
  real limit[6], weight[6];
  NO_UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    if (axis < AXES)
    {
      const real c = LOAD(constraint + axis * tissuePitch + s->self);
      loadConstraints(constraint + axis * tissuePitch, cut, s, limit);
      UNROLL
      for (int d = 0; d < 6; ++d)
      {
        limit[d] = linkLimit(c, limit[d]);
        weight[d] = linkWeight(limit[d]);
      }
    }
    const real u = LOAD(displacement + axis * pitch + state->self);
    UNROLL
    for (int d = 0; d < 6; ++d)
    {
      const real other = neighbour(displacement + axis * pitch, state, d, odd);
#ifdef TURNING
      const real byMine = other - u - mine[d][axis];
      const real byTheirs = other - u - theirs[d][axis];
      const float length = proportion(proportions, d / 2);
      energy[axis] += weight[d] * 0.5f * (byMine * byMine + byTheirs * byTheirs) *
                      (proportion(proportions, axis) / (length * length));
      *excess = max(*excess, 0.5f * fabs(byMine + byTheirs) - limit[d]);
#else
      const real pull = linkPull(u, other, limit[d], slack);
      energy[axis] += weight[d] * pull * pull;
      *excess = max(*excess, fabs(other - u) - limit[d]);
#endif
    }
  }
}

kernel void measure(global const int* list, float slack, LAYOUT_ARGUMENTS, global const float* displacement,
  global const float* constraint, global const uchar* cut SPIN_ARGUMENTS SOFT_ARGUMENTS, local float* partial,
  global float* result)
{
  const int lid = get_local_id(0);
  const uint slot = list[get_group_id(0)];
  real energy[3], low[3], high[3];
  real excess = (real)(0.0f), count = (real)(0.0f);
  float firstRow[2] = { INFINITY, INFINITY }, lastRow[2] = { -INFINITY, -INFINITY };
  for (int axis = 0; axis < 3; ++axis)
  {
    energy[axis] = low[axis] = high[axis] = (real)(0.0f);
  }
  for (int colour = 0; colour < 2; ++colour)
  {
    for (int work = lid; work < VECTORS; work += get_local_size(0))
    {
      const Stencil s = stencilOf(slot, colour, work, pitch, table, place, strideY, strideZ);
      const Stencil state = stateStencil(&s);
#if WIDTH > 1
      if (colour == 0) // this prefetches both colours
      {
        askAhead(&s, slot, list[get_num_groups(0) - 1], colour, pitch, tissuePitch, table, place, strideY, strideZ,
          displacement, constraint SPIN_PASSED_ON);
      }
#endif
      mask displaced = (mask)(0);
      for (int axis = 0; axis < 3; ++axis)
      {
        const real u = LOAD(displacement + axis * pitch + state.self);
        displaced |= u != 0.0f;
        low[axis] = min(low[axis], u);
        high[axis] = max(high[axis], u);
      }
      if (colour == 0)
      {
        addLinks(s.odd, &s, &state, slack, pitch, tissuePitch, displacement, constraint, cut, energy,
          &excess SPIN_PASSED_ON);
      }
#ifdef SOFT
      real softWeight, softPlaces[3];
      if (loadSoftLinks(&s, place SOFT_PASSED_ON, &softWeight, softPlaces))
      {
        for (int axis = 0; axis < 3; ++axis)
        {
          const real way = softPlaces[axis] - LOAD(displacement + axis * pitch + state.self);
          energy[axis] += softProportion(softProportions, axis) * softWeight * way * way;
        }
      }
#endif
#ifdef VOLUMETRIC_STRAIN
      // The volumetric energy belongs to no axis. It is added to that of x, in units of the spacing of x.
      real bulk, middle[3];
      const real volumetricStrain = volumetricStrainAt(
        s.odd, &s, &state, pitch, tissuePitch, displacement, constraint, cut, spin, proportions, &bulk, middle);
      energy[0] += 0.5f * bulk * volumetricStrain * volumetricStrain * (1.0f / proportions.x);
#endif
      if (SOME(displaced))
      {
        firstRow[0] = min(firstRow[0], (float)s.j);
        firstRow[1] = min(firstRow[1], (float)s.k);
        lastRow[0] = max(lastRow[0], (float)s.j);
        lastRow[1] = max(lastRow[1], (float)s.k);
      }
      count += select((real)(0.0f), (real)(1.0f), displaced);
    }
  }
  const float figures[FIGURES] = { sumOf(energy[0]), sumOf(energy[1]), sumOf(energy[2]),
    largestOf(excess), sumOf(count), smallestOf(low[0]), smallestOf(low[1]), smallestOf(low[2]), firstRow[0],
    firstRow[1], largestOf(high[0]), largestOf(high[1]), largestOf(high[2]), lastRow[0], lastRow[1] };
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
