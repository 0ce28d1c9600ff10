// Writes (scatter) or reads (gather) single elements of a field of 4-byte values of any type:
// values[n * components + axis] <-> field[axis * pitch + addresses[n]]. The host guarantees that addresses are valid
// and, for scatter, distinct. From the address `atRest` on, every element has the value of that address.

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

kernel void gather(global const uint* field, uint pitch, uint atRest, int components, global const uint* addresses,
  global uint* values, uint count)
{
  const size_t n = get_global_id(0);
  if (n >= count)
  {
    return;
  }
  for (int axis = 0; axis < components; ++axis)
  {
    values[n * components + axis] = field[axis * pitch + min(addresses[n], atRest)];
  }
}

// Exchanges the values of bricks, one work-group per pair of slots. A brick has `length` values in each of `runs`
// components. The host guarantees that no slot is in two pairs.
kernel void exchange(global uint* field, uint pitch, int runs, uint length, global const uint* pairs)
{
  const uint one = pairs[2 * get_group_id(0)] * length, other = pairs[2 * get_group_id(0) + 1] * length;
  for (int run = 0; run < runs; ++run)
  {
    for (uint n = get_local_id(0); n < length; n += get_local_size(0))
    {
      const uint a = run * pitch + one + n, b = run * pitch + other + n;
      const uint value = field[a];
      field[a] = field[b];
      field[b] = value;
    }
  }
}

// Copies bricks of `length` values in each of three components, one work-group per slot of a list.
kernel void copyBricks(global const uint* from, global uint* to, uint pitch, uint length, global const int* list)
{
  const uint first = list[get_group_id(0)] * length;
  for (int run = 0; run < 3; ++run)
  {
    for (uint n = get_local_id(0); n < length; n += get_local_size(0))
    {
      to[run * pitch + first + n] = from[run * pitch + first + n];
    }
  }
}

// Sets the first `count` values to 0, `perGroup` in each work-group, as `copy` does.
kernel void clear(global uint* field, uint count, uint perGroup)
{
  const uint first = get_group_id(0) * perGroup;
  const uint end = min(first + perGroup, count);
  for (uint n = first + get_local_id(0); n < end; n += get_local_size(0))
  {
    field[n] = 0;
  }
}

// Copies the first `count` values, `perGroup` in each work-group. So all cores of a CPU share the copying and, for new
// memory, the allocation of its pages, which happens on the first write.
kernel void copy(global const uint* from, global uint* to, uint count, uint perGroup)
{
  const uint first = get_group_id(0) * perGroup;
  const uint end = min(first + perGroup, count);
  for (uint n = first + get_local_id(0); n < end; n += get_local_size(0))
  {
    to[n] = from[n];
  }
}
