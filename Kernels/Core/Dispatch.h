#pragma once

#include "Error.h"
#include "Model.h"

#include <cstdint>

namespace chainmail
{

/// The rows of an array of a known type, wherever it is.
template <typename T> class ArrayRows
{
public:
  explicit ArrayRows(const ArrayView& view)
    : view_(view)
  {
  }

  /// The values of `count` voxels along x from voxel number `first` on, until the next call.
  const T* operator()(std::size_t first, int count) const
  {
    return static_cast<const T*>(this->view_.read
                                   ? this->view_.read(first, count)
                                   : static_cast<const T*>(this->view_.data) + first * this->view_.components);
  }

private:
  ArrayView view_;
};

/// Calls `f` with a pointer of the array's own type; it is null where the array is elsewhere (ArrayView::read).
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
