#pragma once

#include "Error.h"
#include "Model.h"

#include <cstdint>

namespace chainmail
{

/// Calls `f` with a pointer of the array's own type.
template <typename F> auto dispatch(const ArrayView& view, F&& f)
{
  switch (view.type)
  {
  case ArrayView::Type::Int8:
    return f(static_cast<const std::int8_t*>(view.data));
  case ArrayView::Type::UInt8:
    return f(static_cast<const std::uint8_t*>(view.data));
  case ArrayView::Type::Int16:
    return f(static_cast<const std::int16_t*>(view.data));
  case ArrayView::Type::UInt16:
    return f(static_cast<const std::uint16_t*>(view.data));
  case ArrayView::Type::Int32:
    return f(static_cast<const std::int32_t*>(view.data));
  case ArrayView::Type::UInt32:
    return f(static_cast<const std::uint32_t*>(view.data));
  case ArrayView::Type::Int64:
    return f(static_cast<const std::int64_t*>(view.data));
  case ArrayView::Type::UInt64:
    return f(static_cast<const std::uint64_t*>(view.data));
  case ArrayView::Type::Float32:
    return f(static_cast<const float*>(view.data));
  case ArrayView::Type::Float64:
    return f(static_cast<const double*>(view.data));
  case ArrayView::Type::None:
    break;
  }
  throw InputError("An array without data was given.");
}

}
