#pragma once

#define CL_HPP_ENABLE_EXCEPTIONS
#define CL_HPP_TARGET_OPENCL_VERSION 120
#define CL_HPP_MINIMUM_OPENCL_VERSION 120
#include <CL/opencl.hpp>

#include <tuple>
#include <type_traits>

namespace chainmail
{

/// Sets the arguments of a kernel in the order of its parameters: buffers, local memory and scalars of OpenCL's own
/// types. Arguments that belong together may be given as one: a std::tuple of them, an object whose arguments() is such
/// a tuple, a pointer to one (null adds nothing), or a function that adds them to the list.
class ArgumentList
{
public:
  explicit ArgumentList(cl::Kernel& kernel)
    : kernel_(kernel)
  {
  }

  template <typename... Values> void add(const Values&... values) { (this->addOne(values), ...); }

private:
  template <typename T> struct IsTuple : std::false_type
  {
  };
  template <typename... Members> struct IsTuple<std::tuple<Members...>> : std::true_type
  {
  };
  template <typename T, typename = void> struct HasArguments : std::false_type
  {
  };
  template <typename T>
  struct HasArguments<T, std::void_t<decltype(std::declval<const T&>().arguments())>> : std::true_type
  {
  };
  template <typename T, typename... Known> static constexpr bool isOneOf = (std::is_same_v<T, Known> || ...);

  template <typename T> void addOne(const T& value)
  {
    if constexpr (IsTuple<T>::value)
    {
      std::apply([this](const auto&... members) { this->add(members...); }, value);
    }
    else if constexpr (HasArguments<T>::value)
    {
      this->addOne(value.arguments());
    }
    else if constexpr (std::is_pointer_v<T>)
    {
      if (value)
      {
        this->addOne(*value);
      }
    }
    else if constexpr (std::is_invocable_v<const T&, ArgumentList&>)
    {
      value(*this);
    }
    else
    {
      // The kernel would misread the bytes of any other type.
      static_assert(
        isOneOf<T, cl::Buffer, cl::LocalSpaceArg, cl_int, cl_uint, cl_float, cl_float4, cl_int4>, "no kernel takes it");
      this->kernel_.setArg(this->next_++, value);
    }
  }

  cl::Kernel& kernel_;
  cl_uint next_ = 0;
};

}
