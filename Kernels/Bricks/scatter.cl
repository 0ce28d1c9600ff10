// Writes (scatter) or reads (gather) single elements of a field of 4-byte values of any type:
// values[n * components + axis] <-> field[axis * pitch + addresses[n]]. The host guarantees that addresses are valid
// and, for scatter, distinct.

kernel void scatter(
  global uint* field, uint pitch, int components, global const uint* addresses, global const uint* values, uint count)
{
  const size_t n = get_global_id(0);
  if (n >= count)
  {
    return;
  }
  for (int axis = 0; axis < components; ++axis)
  {
    field[axis * pitch + addresses[n]] = values[n * components + axis];
  }
}

kernel void gather(
  global const uint* field, uint pitch, int components, global const uint* addresses, global uint* values, uint count)
{
  const size_t n = get_global_id(0);
  if (n >= count)
  {
    return;
  }
  for (int axis = 0; axis < components; ++axis)
  {
    values[n * components + axis] = field[axis * pitch + addresses[n]];
  }
}
