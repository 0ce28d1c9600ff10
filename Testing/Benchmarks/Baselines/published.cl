// The published methods, one work-item an element, from one copy of the state to the other.
//
// TIMESTAMPS: with propagation times and wavefront numbers (Rodriguez, Leon and Arroyo, algorithms 1 and 2); else an
// element goes into the box of every neighbour that moved, in whatever order (SP-ChainMail, 2015).
// BX, BY, BZ: elements of a block per axis, powers of two. LISTED: one launch over a list of blocks, a work-group each;
// else over a box of elements from `origin` on.
//
// The host guarantees: outside the elements that a launch visits both copies are the same, but for stamps, which are of
// earlier iterations there; every element beside one that changed in the iteration before is visited.
//
// stamp: iteration in which an element last moved. changed[block]: something moved there, or beside it.

#define EPSILON 1e-6f

typedef struct
{
  int4 p;
  int self;
  bool exists;
} Place;

Place placeOf(int4 p, int4 size)
{
  Place place;
  place.p = p;
  place.exists = p.x < size.x && p.y < size.y && p.z < size.z;
  place.self = p.x + size.x * (p.y + size.y * p.z);
  return place;
}

// The neighbour in direction d (x- x+ y- y+ z- z+), or -1.
int neighbour(const Place* place, int4 size, int d)
{
  const int4 p = place->p;
  switch (d)
  {
  case 0:
    return p.x > 0 ? place->self - 1 : -1;
  case 1:
    return p.x + 1 < size.x ? place->self + 1 : -1;
  case 2:
    return p.y > 0 ? place->self - size.x : -1;
  case 3:
    return p.y + 1 < size.y ? place->self + size.x : -1;
  case 4:
    return p.z > 0 ? place->self - size.x * size.y : -1;
  default:
    return p.z + 1 < size.z ? place->self + size.x * size.y : -1;
  }
}

// The block of the element, and those that it is a neighbour of, are to be visited next.
void wake(const Place* place, int4 size, global uchar* changed)
{
  const int4 blocks = (int4)((size.x + BX - 1) / BX, (size.y + BY - 1) / BY, (size.z + BZ - 1) / BZ, 0);
  const int4 b = (int4)(place->p.x / BX, place->p.y / BY, place->p.z / BZ, 0);
  const int self = b.x + blocks.x * (b.y + blocks.y * b.z);
  changed[self] = 1;
  if (place->p.x % BX == 0 && b.x > 0)
  {
    changed[self - 1] = 1;
  }
  if (place->p.x % BX == BX - 1 && b.x + 1 < blocks.x)
  {
    changed[self + 1] = 1;
  }
  if (place->p.y % BY == 0 && b.y > 0)
  {
    changed[self - blocks.x] = 1;
  }
  if (place->p.y % BY == BY - 1 && b.y + 1 < blocks.y)
  {
    changed[self + blocks.x] = 1;
  }
  if (place->p.z % BZ == 0 && b.z > 0)
  {
    changed[self - blocks.x * blocks.y] = 1;
  }
  if (place->p.z % BZ == BZ - 1 && b.z + 1 < blocks.z)
  {
    changed[self + blocks.x * blocks.y] = 1;
  }
}

#ifdef TIMESTAMPS
#define WAVE_PARAMETERS                                                                                                \
  , global const float *time, global const int *front, global float *timeAfter, global int *frontAfter
#define WAVE_ARGUMENTS , time, front, timeAfter, frontAfter
#else
#define WAVE_PARAMETERS
#define WAVE_ARGUMENTS
#endif

#define STATE_PARAMETERS                                                                                               \
  int4 size, int iteration, global const float *constraint, global const uchar *held, global const float *ux,          \
    global const float *uy, global const float *uz, global const int *stamp, global float *vx, global float *vy,       \
    global float *vz, global int *stampAfter, global uchar *changed
#define STATE_ARGUMENTS size, iteration, constraint, held, ux, uy, uz, stamp, vx, vy, vz, stampAfter, changed

void propagateOne(int4 p, STATE_PARAMETERS WAVE_PARAMETERS)
{
  const Place place = placeOf(p, size);
  if (!place.exists)
  {
    return;
  }
  const int i = place.self;
  const float4 u = (float4)(ux[i], uy[i], uz[i], 0.0f);
  const float c = constraint[i];
  float4 next = u;
#ifdef TIMESTAMPS
  float earliest = time[i];
  int newest = front[i];
#endif
  for (int d = 0; d < 6 && !held[i]; ++d)
  {
    const int j = neighbour(&place, size, d);
    if (j < 0 || stamp[j] != iteration - 1)
    {
      continue;
    }
    const float limit = 0.5f * (c + constraint[j]);
    const float4 n = (float4)(ux[j], uy[j], uz[j], 0.0f);
#ifdef TIMESTAMPS
    const float arrival = time[j] + limit;
    if (front[j] < newest || (front[j] == newest && arrival >= earliest))
    {
      continue;
    }
    newest = front[j];
    earliest = arrival;
    next = clamp(u, n - limit, n + limit);
#else
    next = clamp(next, n - limit, n + limit);
#endif
  }
  vx[i] = next.x;
  vy[i] = next.y;
  vz[i] = next.z;
#ifdef TIMESTAMPS
  timeAfter[i] = earliest;
  frontAfter[i] = newest;
#endif
  const bool moved = next.x != u.x || next.y != u.y || next.z != u.z;
  stampAfter[i] = moved ? iteration : stamp[i];
  if (moved)
  {
    wake(&place, size, changed);
  }
}

// Times and wavefronts stay as they are.
void relaxOne(int4 p, float tolerance, STATE_PARAMETERS)
{
  const Place place = placeOf(p, size);
  if (!place.exists)
  {
    return;
  }
  const int i = place.self;
  const float4 u = (float4)(ux[i], uy[i], uz[i], 0.0f);
  const float c = constraint[i];
  float weight = 0.0f;
  float4 sum = (float4)(0.0f);
  for (int d = 0; d < 6; ++d)
  {
    const int j = neighbour(&place, size, d);
    if (j >= 0)
    {
      const float w = 1.0f / (0.5f * (c + constraint[j]) + EPSILON);
      weight += w;
      sum += w * (float4)(ux[j], uy[j], uz[j], 0.0f);
    }
  }
  const float4 mean = sum / weight;
  const float4 move = fabs(mean - u);
  const bool moves = !held[i] && max(move.x, max(move.y, move.z)) > tolerance;
  vx[i] = moves ? mean.x : u.x;
  vy[i] = moves ? mean.y : u.y;
  vz[i] = moves ? mean.z : u.z;
  if (moves)
  {
    wake(&place, size, changed);
  }
}

#ifdef LISTED
// blocks: their first elements.
#define VISIT(CALL)                                                                                                    \
  const int4 first = blocks[get_group_id(0)];                                                                          \
  for (int n = get_local_id(0); n < BX * BY * BZ; n += get_local_size(0))                                              \
  {                                                                                                                    \
    const int4 p = first + (int4)(n % BX, n / BX % BY, n / (BX * BY), 0);                                              \
    CALL;                                                                                                              \
  }
#define WHERE global const int4* blocks
#else
#define VISIT(CALL)                                                                                                    \
  const int4 p = origin + (int4)(get_global_id(0), get_global_id(1), get_global_id(2), 0);                             \
  CALL;
#define WHERE int4 origin
#endif

kernel void propagate(WHERE, STATE_PARAMETERS WAVE_PARAMETERS){ VISIT(propagateOne(p, STATE_ARGUMENTS WAVE_ARGUMENTS)) }

kernel void relax(WHERE, float tolerance, STATE_PARAMETERS)
{
  VISIT(relaxOne(p, tolerance, STATE_ARGUMENTS))
}
