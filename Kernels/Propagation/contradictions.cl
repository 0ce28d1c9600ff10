// Finds rotations with which no state is feasible. Around a loop of links the differences u(j) - u(i) cancel out. So
// |sum of rest offsets| <= sum of limits has to hold there on every axis. Otherwise the bounds of feasibility.cl
// diverge. Only the smallest loops are tested, squares of four elements: in scans the contradictions show in them.
//
// The host guarantees: TURNING; WIDTH is 1; all 26 neighbours of the listed bricks have a slot (brick.clh).

#include "brick.clh"
#include "element.clh"
#include "turning.clh"

// For a link between two neighbours along axis a: adds its limit, and `way` (1 or -1) times its strain from the first
// to the second.
CHAINMAIL_INLINE void addLink(uint first, uint second, int a, float way, uint pitch, uint tissuePitch,
  global const float* displacement, global const float* constraint, float* strain, float* limits SPIN_ARGUMENTS)
{
  const uint at[2] = { min(first, pitch - SKEW), min(second, pitch - SKEW) };
  float wanted[2][3];
  UNROLL
  for (int end = 0; end < 2; ++end)
  {
    const float own[3] = { spin[at[end]], spin[pitch + at[end]], spin[2 * pitch + at[end]] };
    restOffset(own, 2 * a + 1, proportions, wanted[end]);
  }
  UNROLL
  for (int axis = 0; axis < 3; ++axis)
  {
    global const float* c = constraint + min(axis, AXES - 1) * tissuePitch;
    const float limit = linkLimit(c[first], c[second]);
    const float apart = displacement[axis * pitch + at[1]] - displacement[axis * pitch + at[0]];
    limits[axis] += limit;
    strain[axis] += limit == 0.0f ? 0.0f : way * (apart - 0.5f * (wanted[0][axis] + wanted[1][axis]));
  }
}

// Whether the four links of a square along axes a and b contradict each other; false where one is missing. `x`: the
// lowest corner.
CHAINMAIL_INLINE bool isContradicted(int3 x, int a, int b, uint pitch, uint tissuePitch, global const int* table,
  int strideY, int strideZ, global const float* displacement, global const float* constraint,
  global const uchar* cut SPIN_ARGUMENTS)
{
  const int3 alongA = (int3)(a == 0, a == 1, a == 2), alongB = (int3)(b == 0, b == 1, b == 2);
  const uint at[4] = { addressOf(x, table, strideY, strideZ), addressOf(x + alongA, table, strideY, strideZ),
    addressOf(x + alongB, table, strideY, strideZ), addressOf(x + alongA + alongB, table, strideY, strideZ) };
  for (int n = 0; n < 4; ++n)
  {
    if (isinf(constraint[at[n]]))
    {
      return false;
    }
  }
#ifdef CUTS
  const uchar upA = 2 << 2 * a, upB = 2 << 2 * b;
  if ((cut[at[0]] & (upA | upB)) || (cut[at[1]] & upB) || (cut[at[2]] & upA))
  {
    return false;
  }
#endif
  float strain[3] = { 0.0f, 0.0f, 0.0f }, limits[3] = { 0.0f, 0.0f, 0.0f };
  addLink(at[0], at[1], a, 1.0f, pitch, tissuePitch, displacement, constraint, strain, limits SPIN_PASSED_ON);
  addLink(at[1], at[3], b, 1.0f, pitch, tissuePitch, displacement, constraint, strain, limits SPIN_PASSED_ON);
  addLink(at[2], at[3], a, -1.0f, pitch, tissuePitch, displacement, constraint, strain, limits SPIN_PASSED_ON);
  addLink(at[0], at[2], b, -1.0f, pitch, tissuePitch, displacement, constraint, strain, limits SPIN_PASSED_ON);
  bool is = false;
  for (int axis = 0; axis < 3; ++axis)
  {
    is |= fabs(strain[axis]) > 1.0001f * limits[axis] + 1e-5f; // more than rounding
  }
  return is;
}

// Whether an element's link along axis a exceeds its limit and belongs to a contradicted square. A square whose links
// are all within their limits cannot be contradicted.
CHAINMAIL_INLINE bool isInContradiction(int3 x, int a, uint pitch, uint tissuePitch, global const int* table,
  int strideY, int strideZ, global const float* displacement, global const float* constraint,
  global const uchar* cut SPIN_ARGUMENTS)
{
  const int3 along = (int3)(a == 0, a == 1, a == 2);
  const uint first = addressOf(x, table, strideY, strideZ), second = addressOf(x + along, table, strideY, strideZ);
  if (isinf(constraint[first]) || isinf(constraint[second]))
  {
    return false;
  }
  float strain[3] = { 0.0f, 0.0f, 0.0f }, limits[3] = { 0.0f, 0.0f, 0.0f };
  addLink(first, second, a, 1.0f, pitch, tissuePitch, displacement, constraint, strain, limits SPIN_PASSED_ON);
  if (fabs(strain[0]) <= limits[0] && fabs(strain[1]) <= limits[1] && fabs(strain[2]) <= limits[2])
  {
    return false;
  }
  for (int b = 0; b < 3; ++b)
  {
    const int3 below = x - (int3)(b == 0, b == 1, b == 2);
    if (b != a && (isContradicted(x, a, b, pitch, tissuePitch, table, strideY, strideZ, displacement, constraint,
                     cut SPIN_PASSED_ON) ||
                    isContradicted(below, a, b, pitch, tissuePitch, table, strideY, strideZ, displacement, constraint,
                      cut SPIN_PASSED_ON)))
    {
      return true;
    }
  }
  return false;
}

// `found` is set to 1 for bricks with such links.
kernel void contradicted(global const int* list, LAYOUT_ARGUMENTS, global const float* displacement,
  global const float* constraint, global const uchar* cut SPIN_ARGUMENTS, global int* found)
{
  const int3 origin = brickAt(place[list[get_group_id(0)]], strideY, strideZ) * (int3)(BX, BY, BZ);
  for (int n = get_local_id(0); n < BX * BY * BZ; n += get_local_size(0))
  {
    const int3 x = origin + (int3)(n % BX, n / BX % BY, n / (BX * BY));
    for (int a = 0; a < 3; ++a)
    {
      if (isInContradiction(
            x, a, pitch, tissuePitch, table, strideY, strideZ, displacement, constraint, cut SPIN_PASSED_ON))
      {
        found[get_group_id(0)] = 1;
        return;
      }
    }
  }
}
