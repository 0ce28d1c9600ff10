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
#include "state.clh"
#include "element.clh"
#include "rotations.clh"

#include "halo.clh"
#include "softlinks.clh"
#include "volumetricstrain.clh"

#define FIGURES 15

// Adds the energy of all links of a lane group, and updates the largest violation.
CHAINMAIL_INLINE void addLinks(
  const int odd, const State* state, const Stencil* s, float slack, real* energy, real* excess)
{
  const Stencil moving = stateStencil(s);
#ifdef ROTATIONS
  real own[3], other[3], mine[6][3], theirs[6][3];
  for (int axis = 0; axis < 3; ++axis)
  {
    own[axis] = LOAD(spinAlong(state, axis) + moving.self);
  }
  UNROLL
  for (int d = 0; d < 6; ++d)
  {
    for (int axis = 0; axis < 3; ++axis)
    {
      other[axis] = neighbour(spinAlong(state, axis), &moving, d, odd);
    }
    restOffset(own, d, state->proportions, mine[d]);
    restOffset(other, d, state->proportions, theirs[d]);
  }
#endif
  Link link[6];
  NO_UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    if (axis < AXES)
    {
      const real c = LOAD(constraintAlong(state, axis) + s->self);
      UNROLL
      for (int d = 0; d < 6; ++d)
      {
        link[d] = linkOf(c, neighbourConstraint(state, axis, s, d, s->odd), d, axis);
      }
    }
    const real u = LOAD(displacementAlong(state, axis) + moving.self);
    UNROLL
    for (int d = 0; d < 6; ++d)
    {
      const real other = neighbour(displacementAlong(state, axis), &moving, d, odd);
#ifdef ROTATIONS
      const real byMine = other - u - mine[d][axis];
      const real byTheirs = other - u - theirs[d][axis];
      const float length = alongAxis(state->proportions, d / 2);
      energy[axis] += link[d].weight * 0.5f * (byMine * byMine + byTheirs * byTheirs) *
                      (alongAxis(state->proportions, axis) / (length * length));
      *excess = max(*excess, 0.5f * fabs(byMine + byTheirs) - link[d].limit);
#else
      const real pull = linkPull(u, other, link[d].limit, slack);
      energy[axis] += link[d].weight * pull * pull;
      *excess = max(*excess, fabs(other - u) - link[d].limit);
#endif
    }
  }
}

kernel void measure(global const int* list, STATE_ARGUMENTS, float slack, local float* partial, global float* result)
{
  const State state = STATE;
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
      const Stencil s = stencilOf(&state.layout, slot, colour, work);
      const Stencil moving = stateStencil(&s);
      if (colour == 0) // this prefetches both colours
      {
        prefetchAhead(&state, &s, slot, list[get_num_groups(0) - 1], colour);
      }
      mask displaced = (mask)(0);
      for (int axis = 0; axis < 3; ++axis)
      {
        const real u = LOAD(displacementAlong(&state, axis) + moving.self);
        displaced |= u != 0.0f;
        low[axis] = min(low[axis], u);
        high[axis] = max(high[axis], u);
      }
      if (colour == 0)
      {
        addLinks(s.odd, &state, &s, slack, energy, &excess);
      }
#ifdef SOFT
      real softWeight, softPlaces[3];
      if (loadSoftLinks(&state, &s, &softWeight, softPlaces))
      {
        for (int axis = 0; axis < 3; ++axis)
        {
          const real offset = softPlaces[axis] - LOAD(displacementAlong(&state, axis) + moving.self);
          energy[axis] += alongAxis(state.softProportions, axis) * softWeight * offset * offset;
        }
      }
#endif
#ifdef VOLUMETRIC_STRAIN
      // The volumetric energy belongs to no axis. It is added to that of x, in units of the spacing of x.
      real lambda, middle[3];
      const real volumetricStrain = volumetricStrainAt(s.odd, &state, &s, &lambda, middle);
      energy[0] += 0.5f * lambda * volumetricStrain * volumetricStrain * (1.0f / state.proportions.x);
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
  const float figures[FIGURES] = { sumOf(energy[0]), sumOf(energy[1]), sumOf(energy[2]), largestOf(excess),
    sumOf(count), smallestOf(low[0]), smallestOf(low[1]), smallestOf(low[2]), firstRow[0], firstRow[1],
    largestOf(high[0]), largestOf(high[1]), largestOf(high[2]), lastRow[0], lastRow[1] };
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
