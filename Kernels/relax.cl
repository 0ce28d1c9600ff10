// One colour of a relaxation sweep: every free element to the over-relaxed weighted mean of the places that its
// neighbours offer, within their boxes (element.clh). In place: neighbours have the other colour.
//
// WAVES: of the free elements only those that waves.clh says.
//
// The host guarantees: the state is feasible, brick.clh's promise.
//
// result[group]: faces that moved elements touch (movedFaces), and the largest move as the bits of a float.

#include "brick.clh"
#include "element.clh"
#include "waves.clh"

kernel void relax(global const int* list, int colour, float omega, float still, float slack, uint pitch,
  global const int* table, global const int* place, int strideY, int strideZ, global float* displacement,
  global const float* constraint, global const uchar* cut, global int2* result WAVES_ARGUMENTS)
{
  local int faces;
  local int largest;
  const int lid = get_local_id(0);
  const uint slot = list[get_group_id(0)];
  if (lid == 0)
  {
    faces = 0;
    largest = 0;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  for (int work = lid; work < VECTORS; work += get_local_size(0))
  {
    const Site s = siteOf(slot, colour, work, table, place, strideY, strideZ);
    int touched = 0;
    float move = 0.0f;
    real c, limit[6], weight[6], us[6];
    mask relaxes;
    for (int axis = 0; axis < 3; ++axis)
    {
      if (axis < AXES)
      {
        c = LOAD(constraint + axis * pitch + s.self);
        loadConstraints(constraint + axis * pitch, cut, &s, limit);
        for (int d = 0; d < 6; ++d)
        {
          limit[d] = linkLimit(c, limit[d]);
          weight[d] = linkWeight(limit[d]);
        }
        relaxes = (c > 0.0f) & MAY_RELAX(axis, &s, limit);
      }
      const real u = LOAD(displacement + axis * pitch + s.self);
      loadNeighbours(displacement + axis * pitch, &s, us);
      Neighbours n = { (real)(0.0f), (real)(0.0f), (real)(-INFINITY), (real)(INFINITY) };
      for (int d = 0; d < 6; ++d)
      {
        neighboursAdd(&n, u, us[d], limit[d], weight[d], slack);
      }
      const real next = select(u, relaxedPlace(n, u, omega, still), relaxes);
      const mask moved = next != u;
      if (SOME(moved))
      {
        STORE(next, displacement + axis * pitch + s.self);
        touched |= movedFaces(&s, moved);
        move = max(move, largestOf(fabs(next - u)));
      }
    }
    if (touched)
    {
      atomic_or(&faces, touched);
      atomic_max(&largest, as_int(move));
    }
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (lid == 0)
  {
    result[get_group_id(0)] = (int2)(faces, largest);
  }
}
