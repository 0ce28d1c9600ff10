// SPDX-License-Identifier: BSD-3-Clause
#include "LabelVoxels.h"

#include "Convert.h"
#include "SpreadImage.h"

#include "Dispatch.h"
#include "Threads.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <type_traits>

namespace vtkChainMail
{

namespace
{

/// Whether a value of the array equals a label. Compared without rounding: doubles are not exact for integers beyond
/// 2^53.
template <typename T> bool IsLabel(T value, vtkTypeInt64 label)
{
  if constexpr (std::is_floating_point<T>::value)
  {
    return static_cast<double>(value) == static_cast<double>(label); // false for NaN
  }
  else if constexpr (std::is_same<T, std::uint64_t>::value)
  {
    return label >= 0 && value == static_cast<std::uint64_t>(label);
  }
  else
  {
    return static_cast<vtkTypeInt64>(value) == label;
  }
}

}

void LabelVoxels::Read(const ArrayContents& labels, SpreadImage* spread, const chainmail::Grid& grid,
  const std::vector<vtkTypeInt64>& wanted)
{
  if (!(labels == this->Labels))
  {
    this->Known.clear();
  }
  this->Labels = labels;
  std::vector<vtkTypeInt64> missing;
  std::copy_if(wanted.begin(), wanted.end(), std::back_inserter(missing),
    [this](vtkTypeInt64 label) { return this->Known.count(label) == 0; });
  std::sort(missing.begin(), missing.end());
  missing.erase(std::unique(missing.begin(), missing.end()), missing.end());
  if (missing.empty())
  {
    return;
  }
  const vtkSmartPointer<vtkDataArray> values = ToEngineArray(labels.Array);
  const chainmail::ArrayView view = spread ? spread->View(values) : View(values);
  const std::size_t rows = static_cast<std::size_t>(grid.size[1]) * static_cast<std::size_t>(grid.size[2]);
  const std::size_t parts = spread ? 1 : 64;                           // what is elsewhere is read from one thread
  std::vector<std::vector<std::size_t>> found(parts * missing.size()); // [part][label]
  chainmail::dispatch(view,
    [&](const auto* typed)
    {
      using T = std::remove_const_t<std::remove_pointer_t<decltype(typed)>>;
      const chainmail::ArrayRows<T> read(view);
      const auto step = static_cast<std::size_t>(view.components);
      const auto width = static_cast<std::size_t>(grid.size[0]);
      const auto search = [&](std::size_t part)
      {
        for (std::size_t row = rows * part / parts; row < rows * (part + 1) / parts; ++row)
        {
          const T* const value = read(row * width, grid.size[0]);
          std::size_t m = missing.size();
          for (std::size_t x = 0; x < width; ++x)
          {
            const T here = value[x * step];
            if (x == 0 || here != value[(x - 1) * step]) // runs of equal labels
            {
              m = static_cast<std::size_t>(std::find_if(missing.begin(), missing.end(),
                                             [here](vtkTypeInt64 label) { return IsLabel(here, label); }) -
                                           missing.begin());
            }
            if (m < missing.size())
            {
              found[part * missing.size() + m].push_back(row * width + x);
            }
          }
        }
      };
      chainmail::inParallel(parts, search);
    });
  for (std::size_t m = 0; m < missing.size(); ++m)
  {
    auto all = std::make_shared<std::vector<std::size_t>>();
    for (std::size_t part = 0; part < parts; ++part)
    {
      const std::vector<std::size_t>& some = found[part * missing.size() + m];
      all->insert(all->end(), some.begin(), some.end());
    }
    const Fingerprint number = FingerprintOf(&missing[m], sizeof(missing[m]));
    this->Known[missing[m]] = { all, FingerprintOf(all->data(), sizeof(std::size_t) * all->size(), number) };
  }
}

}
