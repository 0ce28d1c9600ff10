// Envelope propagation: every element goes into the bounds that moved elements around it set (element.clh), until
// nothing in the brick changes. Elements are updated in place, in any order: raised values only grow and lowered ones
// only fall. So a wave comes back to an element only where a link of it is beyond its limit.
//
// Where elements turn, spins stay as they are during a wave, which is one of shifts s = u - before. With e(i, j) the
// strain of a link before the wave, u(j) - u(i) less where the spins of both ends would have that, a link keeps to its
// limit D where
//
//   s(j) - (D - e(i, j)) <= s(i) <= s(j) + (D + e(i, j)).
//
// Both lengths count as 0 where they are less: rounding leaves links a little beyond their limits, and round a loop of
// these a wave would raise elements again and again, without end. So a wave never strains a link further that is beyond
// its limit, and may leave it there. The extremes count the lengths as they are, so that what a wave may strain links at
// held tissue too far by does not grow from wave to wave. A link of limit 0 has lengths of 0: it passes shifts on as
// they are, to the bit.
//
// With `poses` the wave's probes have rotated what they hold, which may leave the links around it beyond their limits.
// There lengths count as they are, so that the wave restores these links. That makes no loop: every path has such a link
// only where it begins, as held elements pass nothing on.
//
// A brick saves its state in `before` in its first turn. Where it has had none (VISIT_SEEN) its displacement is still
// that before the wave.
//
// The host guarantees: the state before the wave is feasible, and `before` has it for the bricks to start in; moved
// tissue differs from it or is held; all 26 neighbours of a brick that is ready have a slot (brick.clh,
// fixedpoint.clh).
//
// The extremes are, for each axis, how much too high and how much too low moved tissue is for held tissue.

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

// Whether neighbours at `other` have to follow elements that the wave took from u to `next`: where the link is now
// beyond its limit. One that has merely gone further the way that it went puts a neighbour within the limit under no
// bound that this would have to give way to, so there is no reason to go back to where the wave came from. No element
// here or beside is held.
RULE mask isFollowed(real next, real u, real u0, real other, real limit)
{
  const mask raised = (next > u) & (u >= u0);
  const mask lowered = (next < u) & (u <= u0);
  return !(raised | lowered) | (raised & (next - limit > other)) | (lowered & (next + limit < other));
}

// Updates one piece of work. `odd`: see BY_PARITY. `beside`, a constant, says whether it or a neighbour may be held.
RULE int wave(const int odd, const int beside, const Site* s, int savedBeside, uint pitch, uint tissuePitch,
  global float* displacement, global const float* before, global const float* constraint, global const uchar* cut,
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
  ROLLED
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

// Whether an element of a piece of work, or a neighbour of one, is held on any axis.
RULE int anyHeld(const Site* s, uint tissuePitch, global const float* constraint)
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

// Asks for what a piece of work reads beyond the ends of its row and beyond the faces of its brick, which lies too far
// apart for processors to foresee.
inline void askAround(const Site* s, int saved, uint pitch, global const float* displacement,
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

// Whether any element of a brick, or beside its faces, is held on any axis: VISIT_HELD or VISIT_FREE. It is found out
// once in a wave, since most bricks have nothing to do with held tissue.
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
    const Site s = siteOf(slot, work & 1, work / 2, pitch, table, place, strideY, strideZ);
    askAround(&s, saved, pitch, displacement, before, constraint);
  }
  int held = 0;
  for (int work = 0; work < 2 * VECTORS; ++work)
  {
    const Site s = siteOf(slot, work & 1, work / 2, pitch, table, place, strideY, strideZ);
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

APART void propagateIn(IN_BRICK_ARGUMENTS, FIXED_POINT_ARGUMENTS, LAYOUT_ARGUMENTS, int items,
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

// Sets the shifts in the bricks of a list to what handles have been moved by.
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
