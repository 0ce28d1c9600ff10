// Reads or writes single elements of a field: values[n * components + axis] <-> field[axis * pitch + addresses[n]].
// The host guarantees: addresses are valid and, for scatter, distinct.

kernel void scatter(
  global float* field, uint pitch, int components, global const uint* addresses, global const float* values,
  uint count)
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
  global const float* field, uint pitch, int components, global const uint* addresses, global float* values, uint count)
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
