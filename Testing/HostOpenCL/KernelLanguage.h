// OpenCL C, as much of it as the kernels use, for a C++ compiler that is given a kernel's text (HostOpenCL.cpp).
// Included before that text; the qualifiers become macros, so nothing of C++ may be included after it.
//
// A kernel works by the item, and asks for its global number, or by the group, and asks for its place in the group and
// for the group's size, which may then be any. By the group, a group has a single item here: it meets all barriers
// alone.

#include "Launch.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <type_traits>
#include <utility>

typedef unsigned char uchar;
typedef unsigned short ushort;
typedef unsigned int uint;
typedef unsigned long ulong;

// --- Vectors

template <typename T, int N> struct Vector;

/// Components of a vector in another order, to be read. `Result` is a parameter because its operators then apply.
template <typename T, int N, typename Result, int... Order> struct Swizzle
{
  T s[N];

  operator Result() const { return Result(this->s[Order]...); }
};

template <typename T, int N> struct Components;
template <typename T> struct alignas(2 * sizeof(T)) Components<T, 2>
{
  union
  {
    struct
    {
      T x, y;
    };
    T s[2];
  };
};
template <typename T> struct alignas(4 * sizeof(T)) Components<T, 3>
{
  union
  {
    struct
    {
      T x, y, z;
    };
    Vector<T, 2> xy;
    T s[3];
  };
};
template <typename T> struct alignas(4 * sizeof(T)) Components<T, 4>
{
  union
  {
    struct
    {
      T x, y, z, w;
    };
    Vector<T, 2> xy;
    Vector<T, 3> xyz;
    Swizzle<T, 4, Vector<T, 4>, 1, 1, 2, 3> yyzw;
    Swizzle<T, 4, Vector<T, 4>, 1, 2, 0, 3> yzxw;
    Swizzle<T, 4, Vector<T, 4>, 1, 2, 2, 3> yzzw;
    Swizzle<T, 4, Vector<T, 4>, 2, 0, 1, 3> zxyw;
    T s[4];
  };
};

template <typename T, int N> struct Vector : Components<T, N>
{
  using Truth = Vector<int, N>; // of a comparison: -1 or 0

  Vector() = default;
  Vector(T everywhere)
  {
    for (int n = 0; n < N; ++n)
    {
      this->s[n] = everywhere;
    }
  }
  template <typename A, typename B, typename... More> Vector(const A& a, const B& b, const More&... more)
  {
    int n = 0;
    this->append(n, a);
    this->append(n, b);
    (this->append(n, more), ...);
  }

  template <typename F> static Vector each(const F& f)
  {
    Vector v;
    for (int n = 0; n < N; ++n)
    {
      v.s[n] = f(n);
    }
    return v;
  }

#define HOST_OPERATOR(op)                                                                                              \
  friend Vector operator op(const Vector& a, const Vector& b)                                                          \
  {                                                                                                                    \
    return each([&](int n) { return a.s[n] op b.s[n]; });                                                              \
  }                                                                                                                    \
  friend Vector& operator op##=(Vector& a, const Vector& b)                                                            \
  {                                                                                                                    \
    return a = a op b;                                                                                                 \
  }
  HOST_OPERATOR(+)
  HOST_OPERATOR(-)
  HOST_OPERATOR(*)
  HOST_OPERATOR(/)
  HOST_OPERATOR(%)
  HOST_OPERATOR(&)
  HOST_OPERATOR(|)
#undef HOST_OPERATOR
#define HOST_OPERATOR(op)                                                                                              \
  friend Truth operator op(const Vector& a, const Vector& b)                                                           \
  {                                                                                                                    \
    return Truth::each([&](int n) { return a.s[n] op b.s[n] ? -1 : 0; });                                              \
  }
  HOST_OPERATOR(==)
  HOST_OPERATOR(!=)
  HOST_OPERATOR(<)
  HOST_OPERATOR(<=)
  HOST_OPERATOR(>)
  HOST_OPERATOR(>=)
  HOST_OPERATOR(&&)
  HOST_OPERATOR(||)
#undef HOST_OPERATOR
  friend Vector operator-(const Vector& a)
  {
    return each([&](int n) { return -a.s[n]; });
  }
  friend Truth operator!(const Vector& a)
  {
    return Truth::each([&](int n) { return a.s[n] ? 0 : -1; });
  }

private:
  template <typename A> void append(int& n, const A& value)
  {
    if constexpr (std::is_arithmetic<A>::value)
    {
      this->s[n++] = static_cast<T>(value);
    }
    else
    {
      for (const T component : value.s)
      {
        this->s[n++] = component;
      }
    }
  }
};

typedef Vector<int, 2> int2;
typedef Vector<int, 3> int3;
typedef Vector<int, 4> int4;
typedef Vector<uint, 2> uint2;
typedef Vector<uint, 3> uint3;
typedef Vector<uint, 4> uint4;
typedef Vector<float, 2> float2;
typedef Vector<float, 3> float3;
typedef Vector<float, 4> float4;

// --- Functions

#define HOST_FUNCTIONS(T)                                                                                              \
  inline T min(T a, T b)                                                                                               \
  {                                                                                                                    \
    return b < a ? b : a;                                                                                              \
  }                                                                                                                    \
  inline T max(T a, T b)                                                                                               \
  {                                                                                                                    \
    return a < b ? b : a;                                                                                              \
  }                                                                                                                    \
  inline T clamp(T v, T low, T high)                                                                                   \
  {                                                                                                                    \
    return min(max(v, low), high);                                                                                     \
  }
HOST_FUNCTIONS(char)
HOST_FUNCTIONS(uchar)
HOST_FUNCTIONS(short)
HOST_FUNCTIONS(ushort)
HOST_FUNCTIONS(int)
HOST_FUNCTIONS(uint)
HOST_FUNCTIONS(long)
HOST_FUNCTIONS(ulong)
HOST_FUNCTIONS(float)
HOST_FUNCTIONS(double)
#undef HOST_FUNCTIONS

#define HOST_FUNCTIONS(V)                                                                                              \
  inline V min(const V& a, const V& b)                                                                                 \
  {                                                                                                                    \
    return V::each([&](int n) { return min(a.s[n], b.s[n]); });                                                        \
  }                                                                                                                    \
  inline V max(const V& a, const V& b)                                                                                 \
  {                                                                                                                    \
    return V::each([&](int n) { return max(a.s[n], b.s[n]); });                                                        \
  }                                                                                                                    \
  inline V clamp(const V& v, const V& low, const V& high)                                                              \
  {                                                                                                                    \
    return min(max(v, low), high);                                                                                     \
  }
HOST_FUNCTIONS(int2)
HOST_FUNCTIONS(int3)
HOST_FUNCTIONS(int4)
HOST_FUNCTIONS(uint2)
HOST_FUNCTIONS(uint3)
HOST_FUNCTIONS(uint4)
HOST_FUNCTIONS(float2)
HOST_FUNCTIONS(float3)
HOST_FUNCTIONS(float4)
#undef HOST_FUNCTIONS

#define HOST_FUNCTION(name)                                                                                            \
  template <int N> Vector<float, N> name(const Vector<float, N>& a)                                                    \
  {                                                                                                                    \
    return Vector<float, N>::each([&](int n) { return name(a.s[n]); });                                                \
  }
HOST_FUNCTION(fabs)
HOST_FUNCTION(floor)
HOST_FUNCTION(ceil)
HOST_FUNCTION(rint)
HOST_FUNCTION(sqrt)
#undef HOST_FUNCTION

#define HOST_FUNCTION(name)                                                                                            \
  template <int N> Vector<int, N> name(const Vector<float, N>& a)                                                      \
  {                                                                                                                    \
    return Vector<int, N>::each([&](int n) { return name(a.s[n]) ? -1 : 0; });                                         \
  }
HOST_FUNCTION(isnan)
HOST_FUNCTION(isinf)
HOST_FUNCTION(isfinite)
HOST_FUNCTION(signbit)
#undef HOST_FUNCTION

template <int N> int any(const Vector<int, N>& a)
{
  bool found = false;
  for (const int component : a.s)
  {
    found = found || component < 0;
  }
  return found;
}
template <int N> int all(const Vector<int, N>& a)
{
  bool whole = true;
  for (const int component : a.s)
  {
    whole = whole && component < 0;
  }
  return whole;
}
template <typename T> T select(T a, T b, int choice)
{
  return choice ? b : a;
}
template <typename T, int N>
Vector<T, N> select(const Vector<T, N>& a, const Vector<T, N>& b, const Vector<int, N>& choice)
{
  return Vector<T, N>::each([&](int n) { return choice.s[n] < 0 ? b.s[n] : a.s[n]; });
}

template <int N> float dot(const Vector<float, N>& a, const Vector<float, N>& b)
{
  float sum = 0.0f;
  for (int n = 0; n < N; ++n)
  {
    sum += a.s[n] * b.s[n];
  }
  return sum;
}
inline float3 cross(const float3& a, const float3& b)
{
  return float3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
template <int N> float length(const Vector<float, N>& a)
{
  return sqrt(dot(a, a));
}
inline float mix(float a, float b, float s)
{
  return a + (b - a) * s;
}
inline float sign(float a)
{
  return a > 0.0f ? 1.0f : a < 0.0f ? -1.0f : a;
}

template <typename To, typename From> To converted(const From& from)
{
  return To::each([&](int n) { return static_cast<std::decay_t<decltype(To::s[0])>>(from.s[n]); });
}
#define HOST_CONVERT(N)                                                                                                \
  template <typename T> int##N convert_int##N(const Vector<T, N>& a)                                                   \
  {                                                                                                                    \
    return converted<int##N>(a);                                                                                       \
  }                                                                                                                    \
  template <typename T> uint##N convert_uint##N(const Vector<T, N>& a)                                                 \
  {                                                                                                                    \
    return converted<uint##N>(a);                                                                                      \
  }                                                                                                                    \
  template <typename T> float##N convert_float##N(const Vector<T, N>& a)                                               \
  {                                                                                                                    \
    return converted<float##N>(a);                                                                                     \
  }
HOST_CONVERT(2)
HOST_CONVERT(3)
HOST_CONVERT(4)
#undef HOST_CONVERT
template <typename T> int convert_int(T a)
{
  return static_cast<int>(a);
}
template <typename T> uint convert_uint(T a)
{
  return static_cast<uint>(a);
}
template <typename T> float convert_float(T a)
{
  return static_cast<float>(a);
}

template <typename To, typename From> To sameBits(const From& from)
{
  static_assert(sizeof(To) == sizeof(From), "as_type() keeps the size");
  To to;
  memcpy(&to, &from, sizeof(to));
  return to;
}
template <typename T> int as_int(T a)
{
  return sameBits<int>(a);
}
template <typename T> uint as_uint(T a)
{
  return sameBits<uint>(a);
}
template <typename T> float as_float(T a)
{
  return sameBits<float>(a);
}

template <typename T> T popcount(T a)
{
  return static_cast<T>(__builtin_popcountll(static_cast<std::make_unsigned_t<T>>(a)));
}
template <typename T> T abs_diff(T a, T b)
{
  return a < b ? b - a : a - b;
}

#define HOST_MEMORY(N)                                                                                                 \
  template <typename T> Vector<T, N> vload##N(size_t at, const T* from)                                                \
  {                                                                                                                    \
    return Vector<T, N>::each([&](int n) { return from[at * N + n]; });                                                \
  }                                                                                                                    \
  template <typename T> void vstore##N(const Vector<T, N>& v, size_t at, T* to)                                        \
  {                                                                                                                    \
    for (int n = 0; n < N; ++n)                                                                                        \
    {                                                                                                                  \
      to[at * N + n] = v.s[n];                                                                                         \
    }                                                                                                                  \
  }
HOST_MEMORY(2)
HOST_MEMORY(3)
HOST_MEMORY(4)
#undef HOST_MEMORY

// One item at a time: a plain access is atomic.
#define HOST_ATOMIC(name, result)                                                                                      \
  template <typename T> T name(volatile T* at, std::common_type_t<T> value)                                            \
  {                                                                                                                    \
    const T before = *at;                                                                                              \
    *at = result;                                                                                                      \
    return before;                                                                                                     \
  }
HOST_ATOMIC(atomic_add, before + value)
HOST_ATOMIC(atomic_sub, before - value)
HOST_ATOMIC(atomic_min, min(before, value))
HOST_ATOMIC(atomic_max, max(before, value))
HOST_ATOMIC(atomic_or, before | value)
HOST_ATOMIC(atomic_and, before& value)
HOST_ATOMIC(atomic_xchg, value)
#undef HOST_ATOMIC
template <typename T> T atomic_inc(volatile T* at)
{
  return atomic_add(at, T(1));
}
template <typename T> T atomic_cmpxchg(volatile T* at, std::common_type_t<T> expected, std::common_type_t<T> value)
{
  const T before = *at;
  *at = before == expected ? value : before;
  return before;
}

// --- Work-items

namespace host_opencl
{

struct Place
{
  size_t group = 0;
  size_t groups = 0;
  size_t item = 0;
  size_t items = 0;
  bool byItem = false;
  bool byGroup = false;
};
static Place place;

template <typename A> bool fits(const Argument& argument)
{
  return std::is_pointer<A>::value ? argument.memory != nullptr : argument.value && argument.bytes == sizeof(A);
}
template <typename A> A valueOf(const Argument& argument)
{
  if constexpr (std::is_pointer<A>::value)
  {
    return static_cast<A>(argument.memory);
  }
  else
  {
    A value;
    memcpy(&value, argument.value, sizeof(value));
    return value;
  }
}

template <typename... A, size_t... N>
const char* run(void (*kernel)(A...), const Launch& launch, std::index_sequence<N...>)
{
  if (launch.count != sizeof...(A) || !(fits<A>(launch.arguments[N]) && ...))
  {
    return "the arguments are not those that the kernel takes";
  }
  place = Place();
  place.groups = launch.groups;
  place.items = launch.items;
  for (place.group = 0; place.group < launch.groups; ++place.group)
  {
    for (place.item = 0; place.item < launch.items && !place.byGroup; ++place.item)
    {
      kernel(valueOf<A>(launch.arguments[N])...);
      if (place.byItem && place.byGroup)
      {
        return "the kernel works by the item and by the group at once, which is not emulated";
      }
    }
    place.byGroup = false;
  }
  return nullptr;
}

template <typename... A> const char* run(void (*kernel)(A...), const Launch& launch)
{
  return run(kernel, launch, std::index_sequence_for<A...>());
}

}

inline size_t get_global_id(uint)
{
  host_opencl::place.byItem = true;
  return host_opencl::place.group * host_opencl::place.items + host_opencl::place.item;
}
inline size_t get_global_size(uint)
{
  host_opencl::place.byItem = true;
  return host_opencl::place.groups * host_opencl::place.items;
}
inline size_t get_group_id(uint)
{
  return host_opencl::place.group;
}
inline size_t get_num_groups(uint)
{
  return host_opencl::place.groups;
}
inline size_t get_local_id(uint)
{
  host_opencl::place.byGroup = true;
  return 0;
}
inline size_t get_local_size(uint)
{
  host_opencl::place.byGroup = true;
  return 1;
}

#define CLK_LOCAL_MEM_FENCE 1
#define CLK_GLOBAL_MEM_FENCE 2
inline void barrier(int)
{
  host_opencl::place.byGroup = true;
}
inline void mem_fence(int)
{
}

#define HOST_OPENCL_ENTRY(name)                                                                                        \
  extern "C" __attribute__((visibility("default"))) const char* host_opencl_##name(const host_opencl::Launch& launch)  \
  {                                                                                                                    \
    return host_opencl::run(&name, launch);                                                                            \
  }

#define kernel extern "C"
#define global
#define local
#define constant const
#define restrict __restrict
