// Recomputes the pressure of elements (volumetricstrain.clh) after anything except a relaxation has moved them. Resets
// their auxiliary variables to the minimiser: carry(a) = 0 and q(a) = m(a) (relaxrotations.cl). A relaxation updates
// all of these itself.
//
// With NOTED, a brick is marked in `activity` as moved in this sweep if the pressure of any element is or was not 0. So
// its neighbours are visited, too (sweepaccount.clh).
//
// The host guarantees that all 26 neighbours of a listed brick have a slot (brick.clh), and that the brick has a state.

#include "brick.clh"
#include "state.clh"
#include "element.clh"
#include "sweepaccount.clh"
#include "rotations.clh"

#include "volumetricstrain.clh"

#ifdef NOTED
#define NOTED_ARGUMENTS , global int *activity, int sweep
#else
#define NOTED_ARGUMENTS
#endif

kernel void volumetricStrains(global const int* list, STATE_ARGUMENTS NOTED_ARGUMENTS)
{
  const State state = STATE;
  const uint slot = list[get_group_id(0)];
  for (int work = get_local_id(0); work < 2 * VECTORS; work += get_local_size(0))
  {
    const Stencil s = stencilOf(&state.layout, slot, work / VECTORS, work % VECTORS);
    real lambda, middle[3];
    const real volumetricStrain = volumetricStrainAt(s.odd, &state, &s, &lambda, middle);
    const real next = lambda * volumetricStrain;
#ifdef NOTED
    if (SOME((next != 0.0f) | (LOAD(state.pressure + s.self) != 0.0f)))
    {
      atomic_max(activity + SWEEP_ROW * slot + SWEEP_NOTED, sweep);
    }
#endif
    STORE(next, state.pressure + s.self);
    UNROLL
    for (int a = 0; a < 3; ++a)
    {
      STORE((real)(0.0f), carryAlong(&state, a) + s.self);
      STORE(middle[a], auxiliaryAlong(&state, a) + s.self);
    }
  }
}
