// OpenCL C for a C++ compiler, as much of it as the kernels use: vector types, built-in functions, work-item functions
// and qualifiers. CL/opencl.hpp says what is missing. The compiler includes this header before a program
// (HostOpenCL.cpp). The qualifiers are macros (`kernel`, `global`, ...), so no header of C++ may be included after it.
//
// Work-items run one after the other. That decides how the two kinds of kernels run:
//   - Kernels of independent work-items call get_global_id(). They run once for each work-item.
//   - Kernels of cooperating work-items call get_local_id(), get_local_size() or barrier(). They work with any size of
//     the work-group. Here it is 1, whatever the launch says, so barriers need not wait.
// A kernel shows its kind by the functions that it calls. One that calls functions of both kinds is an error.

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

/// Components of a vector of N components in another order, read only. Operators of the vector type `Result` take it:
/// C++ looks for operators in the template parameters of their operands.
template <typename T, int N, typename Result, int... Order> struct Swizzle
{
  T s[N];

  operator Result() const { return Result(this->s[Order]...); }
};

/// The components by name and by number. Size and alignment are those of OpenCL: float3 has the size of float4.
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
  using Mask = Vector<int, N>; ///< the result of a comparison: -1 where it is true, 0 where it is false

  Vector() = default;
  Vector(T scalar) ///< for all components
  {
    for (int n = 0; n < N; ++n)
    {
      this->s[n] = scalar;
    }
  }
  /// From scalars and vectors, whose components follow each other.
  template <typename A, typename B, typename... More> Vector(const A& a, const B& b, const More&... more)
  {
    int n = 0;
    this->append(n, a);
    this->append(n, b);
    (this->append(n, more), ...);
  }

  /// The vector of components f(n).
  template <typename F> static Vector generate(const F& f)
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
    return generate([&](int n) { return a.s[n] op b.s[n]; });                                                          \
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
  friend Mask operator op(const Vector& a, const Vector& b)                                                            \
  {                                                                                                                    \
    return Mask::generate([&](int n) { return a.s[n] op b.s[n] ? -1 : 0; });                                           \
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
    return generate([&](int n) { return -a.s[n]; });
  }
  friend Mask operator!(const Vector& a)
  {
    return Mask::generate([&](int n) { return a.s[n] ? 0 : -1; });
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

// --- Built-in functions

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
    return V::generate([&](int n) { return min(a.s[n], b.s[n]); });                                                    \
  }                                                                                                                    \
  inline V max(const V& a, const V& b)                                                                                 \
  {                                                                                                                    \
    return V::generate([&](int n) { return max(a.s[n], b.s[n]); });                                                    \
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
    return Vector<float, N>::generate([&](int n) { return name(a.s[n]); });                                            \
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
    return Vector<int, N>::generate([&](int n) { return name(a.s[n]) ? -1 : 0; });                                     \
  }
HOST_FUNCTION(isnan)
HOST_FUNCTION(isinf)
HOST_FUNCTION(isfinite)
HOST_FUNCTION(signbit)
#undef HOST_FUNCTION

template <int N> int any(const Vector<int, N>& a)
{
  bool result = false;
  for (const int component : a.s)
  {
    result = result || component < 0;
  }
  return result;
}
template <int N> int all(const Vector<int, N>& a)
{
  bool result = true;
  for (const int component : a.s)
  {
    result = result && component < 0;
  }
  return result;
}
// A scalar condition is true unless it is 0, a component of a vector where its highest bit is set.
template <typename T> T select(T a, T b, int condition)
{
  return condition ? b : a;
}
template <typename T, int N>
Vector<T, N> select(const Vector<T, N>& a, const Vector<T, N>& b, const Vector<int, N>& condition)
{
  return Vector<T, N>::generate([&](int n) { return condition.s[n] < 0 ? b.s[n] : a.s[n]; });
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
inline float mix(float a, float b, float t)
{
  return a + (b - a) * t;
}
inline float sign(float a)
{
  return a > 0.0f ? 1.0f : a < 0.0f ? -1.0f : a;
}

template <typename To, typename From> To convertVector(const From& from)
{
  return To::generate([&](int n) { return static_cast<std::decay_t<decltype(To::s[0])>>(from.s[n]); });
}
#define HOST_CONVERT(N)                                                                                                \
  template <typename T> int##N convert_int##N(const Vector<T, N>& a)                                                   \
  {                                                                                                                    \
    return convertVector<int##N>(a);                                                                                   \
  }                                                                                                                    \
  template <typename T> uint##N convert_uint##N(const Vector<T, N>& a)                                                 \
  {                                                                                                                    \
    return convertVector<uint##N>(a);                                                                                  \
  }                                                                                                                    \
  template <typename T> float##N convert_float##N(const Vector<T, N>& a)                                               \
  {                                                                                                                    \
    return convertVector<float##N>(a);                                                                                 \
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

template <typename To, typename From> To reinterpretBits(const From& from)
{
  static_assert(sizeof(To) == sizeof(From), "as_type() needs types of the same size");
  To to;
  memcpy(&to, &from, sizeof(to));
  return to;
}
template <typename T> int as_int(T a)
{
  return reinterpretBits<int>(a);
}
template <typename T> uint as_uint(T a)
{
  return reinterpretBits<uint>(a);
}
template <typename T> float as_float(T a)
{
  return reinterpretBits<float>(a);
}

template <typename T> T popcount(T a)
{
  return static_cast<T>(__builtin_popcountll(static_cast<std::make_unsigned_t<T>>(a)));
}
template <typename T> T abs_diff(T a, T b)
{
  return a < b ? b - a : a - b;
}

#define HOST_LOAD_STORE(N)                                                                                             \
  template <typename T> Vector<T, N> vload##N(size_t offset, const T* from)                                            \
  {                                                                                                                    \
    return Vector<T, N>::generate([&](int n) { return from[offset * N + n]; });                                        \
  }                                                                                                                    \
  template <typename T> void vstore##N(const Vector<T, N>& v, size_t offset, T* to)                                    \
  {                                                                                                                    \
    for (int n = 0; n < N; ++n)                                                                                        \
    {                                                                                                                  \
      to[offset * N + n] = v.s[n];                                                                                     \
    }                                                                                                                  \
  }
HOST_LOAD_STORE(2)
HOST_LOAD_STORE(3)
HOST_LOAD_STORE(4)
#undef HOST_LOAD_STORE

// Ordinary accesses do, because one work-item runs at a time.
#define HOST_ATOMIC(name, result)                                                                                      \
  template <typename T> T name(volatile T* address, std::common_type_t<T> value)                                       \
  {                                                                                                                    \
    const T old = *address;                                                                                            \
    *address = result;                                                                                                 \
    return old;                                                                                                        \
  }
HOST_ATOMIC(atomic_add, old + value)
HOST_ATOMIC(atomic_sub, old - value)
HOST_ATOMIC(atomic_min, min(old, value))
HOST_ATOMIC(atomic_max, max(old, value))
HOST_ATOMIC(atomic_or, old | value)
HOST_ATOMIC(atomic_and, old& value)
HOST_ATOMIC(atomic_xchg, value)
#undef HOST_ATOMIC
template <typename T> T atomic_inc(volatile T* address)
{
  return atomic_add(address, T(1));
}
template <typename T> T atomic_cmpxchg(volatile T* address, std::common_type_t<T> expected, std::common_type_t<T> value)
{
  const T old = *address;
  *address = old == expected ? value : old;
  return old;
}

// --- Work-items

namespace host_opencl
{

/// The work-item that runs, and which kind of kernel it is of (see the head of this file).
struct WorkItem
{
  size_t groupId = 0;
  size_t groupCount = 0;
  size_t idInGroup = 0;
  size_t groupSize = 0;
  bool independent = false; ///< it has called get_global_id() or get_global_size()
  bool cooperating = false; ///< it has called get_local_id(), get_local_size() or barrier()
};
static WorkItem workItem;

/// Whether an argument may be passed for a parameter of type P. Pointers are memory, all else are values.
template <typename P> bool fits(const Argument& argument)
{
  return std::is_pointer<P>::value ? argument.memory != nullptr : argument.value && argument.bytes == sizeof(P);
}
template <typename P> P parameter(const Argument& argument)
{
  if constexpr (std::is_pointer<P>::value)
  {
    return static_cast<P>(argument.memory);
  }
  else
  {
    P value;
    memcpy(&value, argument.value, sizeof(value));
    return value;
  }
}

/// Runs a kernel over an NDRange. `function` has parameters of the types P, I are their numbers.
template <typename... P, size_t... I>
const char* run(void (*function)(P...), const Launch& launch, std::index_sequence<I...>)
{
  if (launch.argumentCount != sizeof...(P) || !(fits<P>(launch.arguments[I]) && ...))
  {
    return "the number, kinds or sizes of the arguments differ from the kernel's parameters";
  }
  workItem = WorkItem();
  workItem.groupCount = launch.groupCount;
  workItem.groupSize = launch.groupSize;
  for (workItem.groupId = 0; workItem.groupId < launch.groupCount; ++workItem.groupId)
  {
    // The first work-item of a group shows whether the kernel's work-items cooperate. If so, the group has no other.
    workItem.cooperating = false;
    for (workItem.idInGroup = 0; workItem.idInGroup < launch.groupSize && !workItem.cooperating; ++workItem.idInGroup)
    {
      function(parameter<P>(launch.arguments[I])...);
      if (workItem.independent && workItem.cooperating)
      {
        return "HostOpenCL cannot run a kernel that calls get_global_id() and also get_local_id() or barrier()";
      }
    }
  }
  return nullptr;
}

template <typename... P> const char* run(void (*function)(P...), const Launch& launch)
{
  return run(function, launch, std::index_sequence_for<P...>());
}

}

inline size_t get_global_id(uint)
{
  host_opencl::workItem.independent = true;
  return host_opencl::workItem.groupId * host_opencl::workItem.groupSize + host_opencl::workItem.idInGroup;
}
inline size_t get_global_size(uint)
{
  host_opencl::workItem.independent = true;
  return host_opencl::workItem.groupCount * host_opencl::workItem.groupSize;
}
inline size_t get_group_id(uint)
{
  return host_opencl::workItem.groupId;
}
inline size_t get_num_groups(uint)
{
  return host_opencl::workItem.groupCount;
}
inline size_t get_local_id(uint)
{
  host_opencl::workItem.cooperating = true;
  return 0;
}
inline size_t get_local_size(uint)
{
  host_opencl::workItem.cooperating = true;
  return 1;
}

#define CLK_LOCAL_MEM_FENCE 1
#define CLK_GLOBAL_MEM_FENCE 2
inline void barrier(int)
{
  host_opencl::workItem.cooperating = true;
}
inline void mem_fence(int)
{
}

// The entry point of a kernel, which the host finds by its name (dlsym).
#define HOST_OPENCL_ENTRY(name)                                                                                        \
  extern "C" __attribute__((visibility("default"))) const char* host_opencl_##name(const host_opencl::Launch& launch)  \
  {                                                                                                                    \
    return host_opencl::run(&name, launch);                                                                            \
  }

// --- Qualifiers

#define kernel extern "C"
#define global
#define local
#define constant const
#define restrict __restrict
