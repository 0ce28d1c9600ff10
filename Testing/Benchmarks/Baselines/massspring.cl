// One step of explicit (Verlet) integration of a mass-spring model, a work-item a node, which gathers the forces of its
// springs. Unit masses, unit stiffness; springs pull towards their length at rest.
//
// neighbour, rest: VALENCE entries a node, of all nodes for the first entry, then for the second; a node that has fewer
// is its own neighbour there. before: places one step ago, which become those one step on.

kernel void integrate(uint count, float dt2, float keep, global const uchar* held, global const int* neighbour,
  global const float* rest, global const float4* now, global float4* before)
{
  const uint i = get_global_id(0);
  if (i >= count)
  {
    return;
  }
  const float4 x = now[i];
  float4 force = (float4)(0.0f);
  for (uint n = i; n < VALENCE * count; n += count)
  {
    const float4 d = now[neighbour[n]] - x;
    const float square = dot(d, d);
    force += square > 0.0f ? d * (1.0f - rest[n] * rsqrt(square)) : (float4)(0.0f);
  }
  before[i] = held[i] ? x : x + keep * (x - before[i]) + dt2 * force;
}
