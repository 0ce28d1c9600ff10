// Envelope propagation: every element is clamped to the bounds that its moved neighbours set (element.clh), until
// nothing in the brick changes. Raised values only grow and lowered ones only fall, so elements are updated in place,
// in any order. A wave returns to an element only where one of its links exceeds its limit.
//
// With TURNING the rotations of elements stay constant during a wave. The unknowns are the shifts s = u - before. The
// strain of a link before the wave is e(i, j) = before(j) - before(i) - w(i, j). The rest offset w is the mean of those
// that the rotations of both ends give (turning.clh). The link is within its limit D where
//
//   s(j) - (D - e(i, j)) <= s(i) <= s(j) + (D + e(i, j)).
//
// The lengths D - e and D + e count as 0 where they are negative. Rounding leaves links a little beyond their limits,
// and around a loop of such links a wave would raise elements without end. So a wave strains no link further that
// exceeds its limit, but may leave it beyond the limit. The extremes use the unclipped lengths. So the excess strain of
// links at held tissue does not grow from wave to wave. A link of limit 0 has lengths of 0: it passes shifts on
// exactly, to the bit.
//
// `poses` is -1 (else 0) if the wave's probes have rotated their elements. Links around these may exceed their limits
// and are restored by the wave: lengths at held neighbours are then not clipped. This makes no loop, because held
// elements pass nothing on: a path has such a link only at its start.
//
// A brick copies its displacement to `before` on its first visit. Until then (no VISIT_SEEN) its displacement is still
// the state before the wave.
//
// The host guarantees:
// - The state before the wave is feasible. `before` holds it for the bricks in which the wave starts.
// - Moved elements differ from `before` or are held.
// - All 26 neighbours of an updatable brick have a slot (brick.clh, fixedpoint.clh).
//
// The extremes are, for each axis, by how much moved tissue is too high and too low for held tissue.

#define EXTREMES 6

#include "brick.clh"
#include "element.clh"
#include "fixedpoint.clh"
#include "turning.clh"

#ifdef TURNING
#define SHIFT_ARGUMENTS , global float *shift, int poses
#define SHIFT_PASSED_ON , shift, poses
#else
#define SHIFT_ARGUMENTS
#define SHIFT_PASSED_ON
#endif

// Whether neighbours at `other` need an update after elements went from u to `next`; u0 is their state before the wave.
// An element that moved further away from u0 affects a neighbour only if their link now exceeds its limit. So the wave
// does not return to where it came from. Neither the elements nor their neighbours are held.
CHAINMAIL_INLINE mask isFollowed(real next, real u, real u0, real other, real limit)
{
  const mask raised = (next > u) & (u >= u0);
  const mask lowered = (next < u) & (u <= u0);
  return !(raised | lowered) | (raised & (next - limit > other)) | (lowered & (next + limit < other));
}

// Updates one lane group. `odd`: see BY_PARITY. `beside`, a constant: whether an element of it or a neighbour may be
// held.
CHAINMAIL_INLINE int wave(const int odd, const int beside, const Stencil* s, int savedBeside, uint pitch,
  uint tissuePitch, global float* displacement, global const float* before, global const float* constraint,
  global const uchar* cut,
  float* conflict SPIN_ARGUMENTS SHIFT_ARGUMENTS)
{
  const int saved = savedBeside | within(s);
#ifdef TURNING
  real wanted[6][3];
  loadApart(odd, s, pitch, spin, proportions, wanted);
#endif
  real c, limit[6];
  mask held[6];
  mask moved = (mask)(0);
  mask followed[6] = { moved, moved, moved, moved, moved, moved };
  NO_UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    if (axis < AXES)
    {
      c = LOAD_WHOLE(constraint + axis * tissuePitch + s->self);
      UNROLL
      for (int d = 0; d < 6; ++d)
      {
        const real cd = neighbourConstraint(constraint + axis * tissuePitch, cut, s, d, odd);
        limit[d] = linkLimit(c, cd);
        held[d] = beside ? isHeld(cd) : (mask)(0);
      }
    }
    const mask own = beside ? isHeld(c) : (mask)(0);
    Envelope e = unbounded();
    real other[6];
    UNROLL
    for (int d = 0; d < 6; ++d)
    {
#ifdef TURNING
      const real apart = neighbourSaved(before, displacement, axis * pitch, saved, s, d, odd) -
                         LOAD_WHOLE(before + axis * pitch + s->self);
      const real strain = apart - wanted[d][axis], none = (real)(0.0f);
      const real below = limit[d] - strain, above = limit[d] + strain;
      const mask rigid = limit[d] == 0.0f;
      const real least = select(none, (real)(-INFINITY), held[d] & (mask)(poses));
      other[d] = neighbour(shift + axis * pitch, s, d, odd);
      envelopeAddMoved(&e, other[d], none, held[d], select(select(max(below, least), none, rigid), below, own),
        select(select(max(above, least), none, rigid), above, own));
      envelopeAddStill(&e, other[d], none, held[d], below, above);
#else
      other[d] = neighbour(displacement + axis * pitch, s, d, odd);
      const real was = neighbourSaved(before, displacement, axis * pitch, saved, s, d, odd);
      envelopeAddMoved(&e, other[d], was, held[d], limit[d], limit[d]);
      envelopeAddStill(&e, other[d], was, held[d], limit[d], limit[d]);
#endif
    }
#ifdef TURNING
    const real u = LOAD_WHOLE(shift + axis * pitch + s->self);
    const real u0 = (real)(0.0f);
#else
    const real u = LOAD_WHOLE(displacement + axis * pitch + s->self);
    const real u0 = LOAD_WHOLE(before + axis * pitch + s->self);
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
#ifdef TURNING
      STORE_WHOLE(next, shift + axis * pitch + s->self);
      STORE_WHOLE(LOAD_WHOLE(before + axis * pitch + s->self) + next, displacement + axis * pitch + s->self);
#else
      STORE_WHOLE(next, displacement + axis * pitch + s->self);
      UNROLL
      for (int d = 0; d < 6; ++d)
      {
        followed[d] |= goes & isFollowed(next, u, u0, other[d], limit[d]);
      }
#endif
    }
  }
#ifdef TURNING
  return changedAround(s, moved);
#else
  return beside ? changedAround(s, moved) : changedBeyond(s, moved, followed);
#endif
}

// Whether an element of a lane group, or a neighbour of one, is held on any axis.
CHAINMAIL_INLINE int anyHeld(const Stencil* s, uint tissuePitch, global const float* constraint)
{
  mask held = (mask)(0);
  UNROLL
  for (int axis = 0; axis < AXES; ++axis)
  {
    held |= isHeld(LOAD_WHOLE(constraint + axis * tissuePitch + s->self));
    UNROLL
    for (int d = 0; d < 6; ++d)
    {
      held |= isHeld(neighbourBefore(~0u, constraint + axis * tissuePitch, s, d, s->odd));
    }
  }
  return SOME(held);
}

#if WIDTH > 1

// Prefetches what a lane group reads beyond the ends of its row and beyond the faces of its brick. These addresses are
// too far apart for the prefetchers of CPUs to predict.
inline void askAround(const Stencil* s, int saved, uint pitch, global const float* displacement,
  global const float* before, global const float* constraint)
{
  const int inside = within(s);
  ASK_FOR(constraint + s->edge);
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    UNROLL
    for (int n = 0; n < 5; ++n)
    {
      const int d = n > 0 ? n + 1 : s->odd;
      const uint at = axis * pitch + stateAddress(s, n > 0 ? s->side[n - 1] : s->edge);
      if (!(inside >> d & 1))
      {
        ASK_FOR(displacement + at);
        if (saved >> d & 1)
        {
          ASK_FOR(before + at);
        }
      }
    }
  }
}

// Whether any element of a brick, or any neighbour beyond its faces, is held on any axis: VISIT_HELD or VISIT_FREE.
// Computed once per brick in a wave, since most bricks have no held tissue in or around them.
inline int heldNear(uint slot, int saved, global int* visits, LAYOUT_ARGUMENTS, global const float* displacement,
  global const float* before, global const float* constraint)
{
  const int known = visits[VISIT_ROW * slot + VISIT_STATE] & (VISIT_FREE | VISIT_HELD);
  if (known)
  {
    return known;
  }
  for (int work = 0; work < 2 * VECTORS; ++work)
  {
    const Stencil s = stencilOf(slot, work & 1, work / 2, pitch, table, place, strideY, strideZ);
    askAround(&s, saved, pitch, displacement, before, constraint);
  }
  int held = 0;
  for (int work = 0; work < 2 * VECTORS; ++work)
  {
    const Stencil s = stencilOf(slot, work & 1, work / 2, pitch, table, place, strideY, strideZ);
    held |= anyHeld(&s, tissuePitch, constraint);
  }
  const int found = held ? VISIT_HELD : VISIT_FREE;
  visits[VISIT_ROW * slot + VISIT_STATE] |= found;
  return found;
}
#define MAY_BE_HELD                                                                                                    \
  (heldNear(slot, saved, visits, pitch, tissuePitch, table, place, strideY, strideZ, displacement, before,             \
     constraint) == VISIT_HELD)

#else
#define MAY_BE_HELD true
#endif

NOINLINE void propagateIn(IN_BRICK_ARGUMENTS, FIXED_POINT_ARGUMENTS, LAYOUT_ARGUMENTS, int items,
  global float* displacement, global float* before, global const float* constraint,
  global const uchar* cut SPIN_ARGUMENTS SHIFT_ARGUMENTS)
{
  float conflict[6] = { 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f };
  const int saved = savedBeyond(slot, visits, table, place, strideY, strideZ);
  if (from != 0 && !(visits[VISIT_ROW * slot + VISIT_STATE] & VISIT_SEEN))
  {
    saveBrick(lid, items, slot, pitch, displacement, before);
  }
  const bool mayBeHeld = MAY_BE_HELD;
#define WAVE(odd, beside)                                                                                              \
  wave(odd, beside, &s, saved, pitch, tissuePitch, displacement, before, constraint, cut,                              \
    conflict SPIN_PASSED_ON SHIFT_PASSED_ON)
#define FREE_WAVE(odd) WAVE(odd, 0)
  FIXED_POINT(mayBeHeld && anyHeld(&s, tissuePitch, constraint) ? WAVE(s.odd, 1) : BY_PARITY(FREE_WAVE, s))
#undef FREE_WAVE
#undef WAVE
  for (int n = 0; n < 6; ++n)
  {
    if (conflict[n] > 0.0f)
    {
      atomic_max(&log[turn.x * ROW_OF_LOG + 1 + n], as_int(conflict[n]));
    }
  }
  if (lid == 0 && from != 0)
  {
    passOn(faces, slot, visits, log, turn, enough, table, place, strideY, strideZ);
  }
}

kernel void propagate(FIXED_POINT_ARGUMENTS, LAYOUT_ARGUMENTS, global float* displacement, global float* before,
  global const float* constraint, global const uchar* cut SPIN_ARGUMENTS SHIFT_ARGUMENTS)
{
  FIXED_POINT_BEGIN
  propagateIn(IN_BRICK, visits, log, turn, enough, pitch, tissuePitch, table, place, strideY, strideZ,
    get_local_size(0), displacement, before, constraint, cut SPIN_PASSED_ON SHIFT_PASSED_ON);
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
