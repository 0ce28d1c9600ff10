// SPDX-License-Identifier: BSD-3-Clause
#include "Convert.h"

#include "Arrays.h"

#include "vtkBitArray.h"
#include "vtkPiecewiseFunction.h"
#include "vtkUnsignedCharArray.h"

#include <algorithm>
#include <type_traits>
#include <vector>

namespace vtkChainMail
{

namespace
{

template <typename T> constexpr chainmail::ArrayView::Type EngineType()
{
  using Type = chainmail::ArrayView::Type;
  if constexpr (std::is_floating_point<T>::value)
  {
    return sizeof(T) == 4 ? Type::Float32 : Type::Float64;
  }
  else if constexpr (std::is_signed<T>::value)
  {
    return sizeof(T) == 1 ? Type::Int8 : sizeof(T) == 2 ? Type::Int16 : sizeof(T) == 4 ? Type::Int32 : Type::Int64;
  }
  else
  {
    return sizeof(T) == 1 ? Type::UInt8 : sizeof(T) == 2 ? Type::UInt16 : sizeof(T) == 4 ? Type::UInt32 : Type::UInt64;
  }
}

}

vtkSmartPointer<vtkDataArray> ToEngineArray(vtkDataArray* array)
{
  if (vtkBitArray* bits = vtkBitArray::SafeDownCast(array))
  {
    const auto bytes =
      MakeArray<vtkUnsignedCharArray>(array->GetName(), array->GetNumberOfComponents(), array->GetNumberOfTuples());
    for (vtkIdType v = 0; v < bytes->GetNumberOfValues(); ++v)
    {
      bytes->SetValue(v, static_cast<unsigned char>(bits->GetValue(v)));
    }
    return bytes;
  }
  return Interleaved(array);
}

chainmail::ArrayView View(vtkDataArray* array)
{
  chainmail::ArrayView view;
  if (array)
  {
    view.data = array->GetVoidPointer(0);
    view.components = array->GetNumberOfComponents();
    switch (array->GetDataType())
    {
      vtkTemplateMacro(view.type = EngineType<VTK_TT>());
    }
  }
  return view;
}

std::function<double(double)> ToEngineFunction(const std::vector<double>& function)
{
  if (function.empty())
  {
    return nullptr;
  }
  std::vector<double> scalars;
  std::vector<double> constraints;
  const auto curve = vtkSmartPointer<vtkPiecewiseFunction>::New();
  curve->AllowDuplicateScalarsOn();
  curve->SetClamping(static_cast<int>(function[function.size() - 2]));
  curve->SetUseLogScale(function.back() != 0.0);
  bool straight = curve->GetClamping() && !curve->GetUseLogScale();
  for (std::size_t n = 0; n + 4 < function.size(); n += 4)
  {
    const double* const node = function.data() + n; // scalar, constraint, midpoint, sharpness
    scalars.push_back(node[0]);
    constraints.push_back(node[1]);
    straight = straight && node[2] == 0.5 && node[3] == 0.0;
    curve->AddPoint(node[0], node[1], node[2], node[3]);
  }
  if (!straight)
  {
    return [curve](double scalar) { return curve->GetValue(scalar); };
  }
  return [scalars, constraints](double scalar)
  {
    const auto after = std::upper_bound(scalars.begin(), scalars.end(), scalar);
    if (after == scalars.begin() || after == scalars.end())
    {
      return after == scalars.begin() ? constraints.front() : constraints.back();
    }
    const std::size_t n = static_cast<std::size_t>(after - scalars.begin());
    const double share = (scalar - scalars[n - 1]) / (scalars[n] - scalars[n - 1]);
    return constraints[n - 1] + share * (constraints[n] - constraints[n - 1]);
  };
}

}
