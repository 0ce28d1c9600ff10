// Envelope propagation: every element is clamped to the bounds that its moved neighbours set (element.clh), until
// nothing in the brick changes. Raised values only grow and lowered ones only fall, so elements are updated in place,
// in any order. An element is updated again only where one of its links exceeds its limit. In lane groups beside held
// tissue it is updated again whenever a neighbour has moved.
//
// With ROTATIONS the rotations of elements stay constant during a wave. The unknowns are the shifts s = u - before. The
// strain of a link before the wave is e(i, j) = before(j) - before(i) - w(i, j). The rest offset w is the mean of those
// that the rotations of both ends give (rotations.clh). The link is within its limit D where
//
//   s(j) - (D - e(i, j)) <= s(i) <= s(j) + (D + e(i, j)).
//
// The lengths D - e and D + e count as 0 where they are negative. Rounding leaves links a little beyond their limits,
// and around a loop of such links a wave would raise elements without end. So a wave strains no link further that
// exceeds its limit, but may leave it beyond the limit. The extremes use the unclipped lengths. So the excess strain of
// links at held tissue does not grow from wave to wave. A link of limit 0 has lengths of 0: it passes shifts on
// exactly, to the bit.
//
// `poses` is a mask: -1 if the wave's probes have rotated their elements, else 0. Links around these may exceed their
// limits and are restored by the wave: lengths at held neighbours are then not clipped. This makes no loop, because
// held elements pass on nothing that they receive: a path has such a link only at its start.
//
// A brick copies its displacement to `before` on its first visit. Until then (no VISIT_SEEN) its displacement is still
// the state before the wave.
//
// The host guarantees:
// - The state before the wave is feasible. `before` holds it for the bricks in which the wave starts.
// - The elements that start the wave are held, and their displacement (or shift) differs from that before the wave. A
//   held element without a difference counts as not moved.
// - All 26 neighbours of an updatable brick have a slot (brick.clh).
//
// The extremes are, for each axis, by how much moved tissue is too high and too low for held tissue.

#define EXTREMES 6

#include "brick.clh"
#include "state.clh"
#include "element.clh"
#include "fixedpoint.clh"
#include "rotations.clh"

// What a wave reads and writes besides the state.
typedef struct
{
  global float* before;
#ifdef ROTATIONS
  global float* shift;
  int poses;
#endif
} Wave;

#ifdef ROTATIONS
#define WAVE_ARGUMENTS global float *before, global float *shift, int poses
#define WAVE                                                                                                           \
  {                                                                                                                    \
    before, shift, poses                                                                                               \
  }
#else
#define WAVE_ARGUMENTS global float* before
#define WAVE                                                                                                           \
  {                                                                                                                    \
    before                                                                                                             \
  }
#endif

// Whether neighbours at `other` need an update after elements went from u to `next`; u0 is their state before the wave.
// An element that moved further away from u0 affects a neighbour only if it is now more than `above` above it, or more
// than `below` below it. So the wave does not return to where it came from. Neither the elements nor their neighbours
// are held.
CHAINMAIL_INLINE mask isFollowed(real next, real u, real u0, real other, real below, real above)
{
  const mask raised = (next > u) & (u >= u0);
  const mask lowered = (next < u) & (u <= u0);
  return !(raised | lowered) | (raised & (next - above > other)) | (lowered & (next + below < other));
}

// The two ends of a link between elements that rotate find strains that differ by rounding. So a neighbour is updated
// again a little before the link exceeds its limit [fractions of the spacing].
#define FOLLOWED_EARLY 1e-4f

// The links of a lane group to its neighbours, on one axis.
typedef struct
{
  Link link[6];
  mask held[6];  // whether the neighbour is held
  real other[6]; // the neighbour's displacement or, where elements rotate, its shift
#ifdef ROTATIONS
  real restOffset[6];
  real below[6], above[6]; // the lengths for isFollowed()
#endif
} WaveLinks;

// Loads the links on an axis, of elements with the constraints c. `nearHeld`: see updateWave().
CHAINMAIL_INLINE void loadWaveLinks(
  const int odd, const int nearHeld, const State* state, const Stencil* s, int axis, real c, WaveLinks* links)
{
  UNROLL
  for (int d = 0; d < 6; ++d)
  {
    const real other = neighbourConstraint(state, axis, s, d, odd);
    links->link[d] = linkOf(c, other, d, axis);
    links->held[d] = nearHeld ? isHeld(other) : (mask)(0);
  }
}

// The bounds that neighbours put on the displacement of elements or, where elements rotate, on their shift. `saved`:
// see neighbourSaved(). `own`: which elements are held. links->other gets the neighbours' values.
CHAINMAIL_INLINE Envelope envelopeOf(const int odd, const State* state, const Wave* wave, const Stencil* s, int saved,
  int axis, mask own, WaveLinks* links)
{
  const uint run = axis * state->layout.pitch;
  Envelope e = unbounded();
  UNROLL
  for (int d = 0; d < 6; ++d)
  {
    const real limit = links->link[d].limit;
    const mask held = links->held[d];
    const real was = neighbourSaved(wave->before, state, axis, saved, s, d, odd);
#ifdef ROTATIONS
    const real strain = was - LOAD_WHOLE(wave->before + run + s->self) - links->restOffset[d];
    const real none = (real)(0.0f), below = limit - strain, above = limit + strain;
    const mask rigid = links->link[d].rigid;
    const real least = select(none, (real)(-INFINITY), held & (mask)(wave->poses));
    const real shift = neighbour(wave->shift + run, s, d, odd);
    links->below[d] = select(max(below, none), none, rigid) - FOLLOWED_EARLY;
    links->above[d] = select(max(above, none), none, rigid) - FOLLOWED_EARLY;
    envelopeAddMoved(&e, shift, none, held, select(select(max(below, least), none, rigid), below, own),
      select(select(max(above, least), none, rigid), above, own));
    envelopeAddStill(&e, shift, none, held, below, above);
    links->other[d] = shift;
#else
    const real u = neighbour(displacementAlong(state, axis), s, d, odd);
    envelopeAddMoved(&e, u, was, held, limit, limit);
    envelopeAddStill(&e, u, was, held, limit, limit);
    links->other[d] = u;
#endif
  }
  return e;
}

// Updates one lane group. Returns where neighbours need an update, as changedBeyond() does. `odd`: see BY_PARITY.
// `nearHeld`, a constant: whether an element of it or a neighbour may be held. `savedOutside`: savedBeyond().
// `conflict` is raised to the extremes.
CHAINMAIL_INLINE int updateWave(const int odd, const int nearHeld, const State* state, const Wave* wave,
  const Stencil* s, int savedOutside, float* conflict)
{
  const int saved = savedOutside | within(s);
  const uint pitch = state->layout.pitch;
  WaveLinks links;
#ifdef ROTATIONS
  real restOffsets[6][3];
  loadRestOffsets(odd, state, s, restOffsets);
#endif
  real c;
  mask moved = (mask)(0);
  mask followed[6] = { moved, moved, moved, moved, moved, moved };
  NO_UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    if (axis < AXES)
    {
      c = LOAD_WHOLE(constraintAlong(state, axis) + s->self);
      loadWaveLinks(odd, nearHeld, state, s, axis, c, &links);
    }
#ifdef ROTATIONS
    UNROLL
    for (int d = 0; d < 6; ++d)
    {
      links.restOffset[d] = restOffsets[d][axis];
    }
#endif
    const mask own = nearHeld ? isHeld(c) : (mask)(0);
    const Envelope e = envelopeOf(odd, state, wave, s, saved, axis, own, &links);
#ifdef ROTATIONS
    const real u = LOAD_WHOLE(wave->shift + axis * pitch + s->self);
    const real u0 = (real)(0.0f);
#else
    const real u = LOAD_WHOLE(displacementAlong(state, axis) + s->self);
    const real u0 = LOAD_WHOLE(wave->before + axis * pitch + s->self);
#endif
    const real next = select(envelopeNext(e, u, u0), u, own);
    const real tooHigh = envelopeTooHigh(e, u, own);
    const real tooLow = envelopeTooLow(e, u, own);
    if (SOME((tooHigh > 0.0f) | (tooLow > 0.0f)))
    {
      conflict[2 * axis] = max(conflict[2 * axis], largestOf(tooHigh));
      conflict[2 * axis + 1] = max(conflict[2 * axis + 1], largestOf(tooLow));
    }
    const mask goes = next != u;
    if (SOME(goes))
    {
      moved |= goes;
#ifdef ROTATIONS
      STORE_WHOLE(next, wave->shift + axis * pitch + s->self);
      STORE_WHOLE(
        LOAD_WHOLE(wave->before + axis * pitch + s->self) + next, displacementAlong(state, axis) + s->self);
#else
      STORE_WHOLE(next, displacementAlong(state, axis) + s->self);
#endif
      UNROLL
      for (int d = 0; d < 6; ++d)
      {
#ifdef ROTATIONS
        const real below = links.below[d], above = links.above[d];
#else
        const real below = links.link[d].limit, above = below;
#endif
        followed[d] |= goes & isFollowed(next, u, u0, links.other[d], below, above);
      }
    }
  }
  return nearHeld ? changedAround(s, moved) : changedBeyond(s, moved, followed);
}

// Whether an element of a lane group, or a neighbour of one, is held on any axis.
CHAINMAIL_INLINE int anyHeld(const State* state, const Stencil* s)
{
  mask held = (mask)(0);
  UNROLL
  for (int axis = 0; axis < AXES; ++axis)
  {
    held |= isHeld(LOAD_WHOLE(constraintAlong(state, axis) + s->self));
    UNROLL
    for (int d = 0; d < 6; ++d)
    {
      held |= isHeld(neighbourClamped(~0u, constraintAlong(state, axis), s, d, s->odd));
    }
  }
  return SOME(held);
}

#if WIDTH > 1

// Prefetches what a lane group reads beyond the ends of its row and beyond the faces of its brick. These addresses are
// too far apart for the prefetchers of CPUs to predict.
inline void prefetchAround(const State* state, const Wave* wave, const Stencil* s, int saved)
{
  const int inside = within(s);
  PREFETCH(state->constraint + s->edge);
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    UNROLL
    for (int n = 0; n < 5; ++n)
    {
      const int d = n > 0 ? n + 1 : s->odd;
      const uint at = axis * state->layout.pitch + stateAddress(s, n > 0 ? s->side[n - 1] : s->edge);
      if (!(inside >> d & 1))
      {
        PREFETCH(state->displacement + at);
        if (saved >> d & 1)
        {
          PREFETCH(wave->before + at);
        }
      }
    }
  }
}

// Whether any element of a brick, or any neighbour beyond its faces, is held on any axis: VISIT_HELD or VISIT_FREE.
// Computed on the first visit, and again after EnvelopePropagation::heldChanged(); most bricks have no held tissue in
// or around them. The loop over the stencils also prefetches what the visit will read.
inline int heldNear(const State* state, const Wave* wave, const Launch* launch, uint slot, int saved)
{
  global int* const own = launch->visits + VISIT_ROW * slot + VISIT_STATE;
  const int known = *own & (VISIT_FREE | VISIT_HELD);
  if (known)
  {
    return known;
  }
  for (int work = 0; work < 2 * VECTORS; ++work)
  {
    const Stencil s = stencilOf(&state->layout, slot, work & 1, work / 2);
    prefetchAround(state, wave, &s, saved);
  }
  int held = 0;
  for (int work = 0; work < 2 * VECTORS; ++work)
  {
    const Stencil s = stencilOf(&state->layout, slot, work & 1, work / 2);
    held |= anyHeld(state, &s);
  }
  const int found = held ? VISIT_HELD : VISIT_FREE;
  *own |= found;
  return found;
}
#define MAY_BE_HELD (heldNear(&state, &wave, &launch, visit.slot, saved) == VISIT_HELD)

#else
#define MAY_BE_HELD true
#endif

NOINLINE void propagateIn(const State* given, Wave wave, Launch launch, Visit visit)
{
  const State state = *given;
  float conflict[6] = { 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f };
  const int saved = savedBeyond(&launch, &state.layout, visit.slot);
  if (visit.changes != 0 && !wasSeen(&launch, visit.slot))
  {
    saveBrick(&visit, &state, wave.before);
  }
  const bool mayBeHeld = MAY_BE_HELD;
#define UPDATE_HELD updateWave(s.odd, 1, &state, &wave, &s, saved, conflict)
#define UPDATE_FREE(odd) updateWave(odd, 0, &state, &wave, &s, saved, conflict)
  FIXED_POINT(&state.layout, mayBeHeld && anyHeld(&state, &s) ? UPDATE_HELD : BY_PARITY(UPDATE_FREE, s))
#undef UPDATE_FREE
#undef UPDATE_HELD
  for (int n = 0; n < 6; ++n)
  {
    if (conflict[n] > 0.0f)
    {
      atomic_max(&launch.log[launch.number * ROW_OF_LOG + LOG_ROW + n], as_int(conflict[n]));
    }
  }
  passOn(&launch, &state.layout, &visit, faces, 0);
}

kernel void propagate(FIXED_POINT_ARGUMENTS, STATE_ARGUMENTS, WAVE_ARGUMENTS)
{
  const State state = STATE;
  const Wave wave = WAVE;
  FIXED_POINT_BEGIN(&state.layout)
  propagateIn(&state, wave, launch, visit);
}

// Initialises the shifts in the listed bricks: displacement - before, which is the motion of the handles.
kernel void beginShifts(
  global const int* list, uint pitch, global const float* displacement, global const float* before, global float* shift)
{
  const uint first = list[get_group_id(0)] * ELEMENTS;
  for (int axis = 0; axis < 3; ++axis)
  {
    for (uint at = axis * pitch + first + get_local_id(0); at < axis * pitch + first + ELEMENTS;
         at += get_local_size(0))
    {
      shift[at] = displacement[at] - before[at];
    }
  }
}
