// One iteration of the published propagation (Rodriguez, Leon and Arroyo, algorithms 1 and 2), for all elements at
// once. `arriveNext` computes the next displacement, time and wave id of each element from its neighbours. `shift`
// copies them to the state.
//
// Only neighbours that shifted in the previous iteration count. A neighbour of a newer wave takes the element over with
// its time. One of the same wave does so only if it arrives earlier, and one of an older wave never. Neighbours that
// arrive at the same time all count, so the result does not depend on their order.
//
// The host guarantees: WIDTH is 1; both kernels run over the same bricks, and these contain every neighbour of an
// element that shifted; all 26 neighbours of these bricks have a slot (brick.clh).
//
// front: id of the wave that the element belongs to, 0 for none
// time: propagation time of that wave, a fraction of the spacing
// stamp: iteration in which the element last shifted
// nextFront: 0 where no wave arrives, else the id of the wave; negated where the element need not shift and so does not
// pass the wave on

#include "brick.clh"
#include "state.clh"
#include "element.clh"

// The state of the published propagation, as it is and after the iteration.
#define TIMES_ARGUMENTS                                                                                                \
  global float *time, global int *front, global int *stamp, global float *nextDisplacement, global float *nextTime,    \
    global int *nextFront

kernel void arriveNext(global const int* list, STATE_ARGUMENTS, int iteration, TIMES_ARGUMENTS)
{
  const State state = STATE;
  const uint pitch = state.layout.pitch;
  const uint slot = list[get_group_id(0)];
  for (int colour = 0; colour < 2; ++colour)
  {
    for (int work = get_local_id(0); work < VECTORS; work += get_local_size(0))
    {
      const Stencil s = stencilOf(&state.layout, slot, colour, work);
      const uint neighbours[6] = { s.odd ? s.sameRow : s.edge, s.odd ? s.edge : s.sameRow, s.side[0], s.side[1],
        s.side[2], s.side[3] };
      for (int group = 0; group < AXES; ++group)
      {
        const uint base = group * pitch;
        const int firstAxis = AXES == 1 ? 0 : group, lastAxis = AXES == 1 ? 2 : group;
        const float c = constraintAlong(&state, group)[s.self];
        Link links[6];
        UNROLL
        for (int d = 0; d < 6; ++d)
        {
          links[d] = linkOf(c, neighbourConstraint(&state, group, &s, d, s.odd), d, group);
        }
        int newest = front[base + s.self];
        float earliest = newest == 0 ? INFINITY : time[base + s.self];
        bool comes = false;
        float lower[3], upper[3];
        for (int d = 0; d < 6 && !signbit(c); ++d)
        {
          const uint n = stateAddress(&s, neighbours[d]);
          if (!links[d].exists || stamp[base + n] != iteration - 1)
          {
            continue;
          }
          const float limit = links[d].limit;
          const float arrival = time[base + n] + limit;
          const int wave = front[base + n];
          if (wave < newest || (wave == newest && (arrival > earliest || (arrival == earliest && !comes))))
          {
            continue;
          }
          const bool first = wave > newest || arrival < earliest;
          for (int a = firstAxis; a <= lastAxis; ++a)
          {
            const float u = displacementAlong(&state, a)[n];
            lower[a] = first ? u - limit : max(lower[a], u - limit);
            upper[a] = first ? u + limit : min(upper[a], u + limit);
          }
          newest = wave;
          earliest = arrival;
          comes = true;
        }
        bool shifts = false;
        for (int a = firstAxis; comes && a <= lastAxis; ++a)
        {
          const float u = displacementAlong(&state, a)[s.self];
          const float next = shiftedPlace(u, lower[a], upper[a]);
          nextDisplacement[a * pitch + s.self] = next;
          shifts = shifts || next != u;
        }
        nextTime[base + s.self] = earliest;
        nextFront[base + s.self] = !comes ? 0 : shifts ? newest : -newest;
      }
    }
  }
}

// result[group]: the faces of the brick at which elements shifted (movedFaces).
kernel void shift(global const int* list, STATE_ARGUMENTS, int iteration, TIMES_ARGUMENTS, global int* result)
{
  const State state = STATE;
  const uint pitch = state.layout.pitch;
  local int faces;
  if (get_local_id(0) == 0)
  {
    faces = 0;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  const uint slot = list[get_group_id(0)];
  for (int colour = 0; colour < 2; ++colour)
  {
    for (int work = get_local_id(0); work < VECTORS; work += get_local_size(0))
    {
      const Stencil s = stencilOf(&state.layout, slot, colour, work);
      for (int group = 0; group < AXES; ++group)
      {
        const uint at = group * pitch + s.self;
        const int wave = nextFront[at];
        if (wave == 0)
        {
          continue;
        }
        time[at] = nextTime[at];
        front[at] = abs(wave);
        if (wave < 0)
        {
          continue;
        }
        stamp[at] = iteration;
        for (int a = AXES == 1 ? 0 : group; a <= (AXES == 1 ? 2 : group); ++a)
        {
          displacementAlong(&state, a)[s.self] = nextDisplacement[a * pitch + s.self];
        }
        atomic_or(&faces, movedFaces(&s, 1));
      }
    }
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (get_local_id(0) == 0)
  {
    result[get_group_id(0)] = faces;
  }
}
