// One iteration of the published relaxation (PaperRelaxation.h): a Jacobi iteration without limits. Every element that
// is not held moves to the weighted mean of the target places of its links (element.clh). The kernel reads one copy of
// the displacements and writes the other.
//
// With WAVES only the elements that wavefronts.clh allows relax. With SOFT soft links count (softlinks.clh).
//
// The host guarantees: a work-group for each slot except 0; all 26 neighbours of a brick that is ready have a slot
// (brick.clh, sweep.clh); both copies are equal at first. Later both copies are equal in every brick that is not
// visited: after the last visit in which elements of it moved, a brick is visited once more.

#include "brick.clh"
#include "state.clh"
#include "element.clh"
#include "softlinks.clh"
#include "sweep.clh"
#include "wavefronts.clh"

// Relaxes one lane group and updates the largest move and the faces.
CHAINMAIL_INLINE void relaxGroup(const State* state, const Stencil* s, const WavesUnderWay* waves, float still,
  float slack, global float* after, float* most, int* faces)
{
  Link link[6];
  real us[6];
#ifdef SOFT
  real softWeight, softPlaces[3];
  const bool soft = loadSoftLinks(state, s, &softWeight, softPlaces);
#endif
  mask relaxes;
  for (int axis = 0; axis < 3; ++axis)
  {
    if (axis < AXES)
    {
      const real c = LOAD(constraintAlong(state, axis) + s->self);
      relaxes = (!signbit(c)) & isUnmoved(waves, &state->layout, axis, s);
      for (int d = 0; d < 6; ++d)
      {
        link[d] = linkOf(c, neighbourConstraint(state, axis, s, d, s->odd), d, axis);
        relaxes &= isOfSameWave(waves, &state->layout, axis, s, d, !link[d].exists);
      }
    }
    const real u = LOAD(displacementAlong(state, axis) + s->self);
    loadNeighbours(displacementAlong(state, axis), s, us);
    Neighbours n = noNeighbours();
    for (int d = 0; d < 6; ++d)
    {
      neighboursAdd(&n, u, us[d], link[d], slack);
    }
#ifdef SOFT
    if (soft)
    {
      neighboursAddSoft(&n, u, softPlaces[axis], SOFT_FACTOR(axis) * softWeight);
    }
#endif
    // Limits do not apply.
    n.lower = (real)(-INFINITY);
    n.upper = (real)(INFINITY);
    const real next = select(u, relaxedPlace(n, u, 1.0f, still), relaxes);
    STORE(next, after + axis * state->layout.pitch + s->self);
    const mask moved = next != u;
    if (SOME(moved))
    {
      *faces |= movedFaces(s, moved);
      *most = max(*most, largestOf(fabs(next - u)));
    }
  }
}

kernel void relaxAll(
  PASS_ARGUMENTS, STATE_ARGUMENTS, int kind, float still, float slack, global float* after WAVES_ARGUMENTS)
{
  const Pass pass = PASS;
  const State state = STATE;
  const WavesUnderWay waves = WAVES_UNDER_WAY;
  local Visit visit;
  const uint slot = get_group_id(0) + 1;
  beginVisit(&visit, &pass, &state.layout, slot, kind, pass.sweep - 1);
  int faces = 0;
  float move = 0.0f;
  for (int colour = 0; visit.due == DUE_AND_READY && colour < 2; ++colour)
  {
    for (int work = get_local_id(0); work < VECTORS; work += get_local_size(0))
    {
      const Stencil s = stencilOf(&state.layout, slot, colour, work);
      relaxGroup(&state, &s, &waves, still, slack, after, &move, &faces);
    }
  }
  endVisit(&visit, &pass, slot, kind, faces, move, SWEEP_EVER);
}
