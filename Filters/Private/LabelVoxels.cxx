// SPDX-License-Identifier: BSD-3-Clause
#include "LabelVoxels.h"

#include "Convert.h"

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

void LabelVoxels::Read(vtkDataArray* labels, vtkMTimeType imageTime, const std::vector<vtkTypeInt64>& wanted)
{
  ArrayContents now;
  now.Take(labels, imageTime, this->Labels);
  if (!(now == this->Labels))
  {
    this->Known.clear();
  }
  this->Labels = now;
  std::vector<vtkTypeInt64> missing;
  std::copy_if(wanted.begin(), wanted.end(), std::back_inserter(missing),
    [this](vtkTypeInt64 label) { return this->Known.count(label) == 0; });
  std::sort(missing.begin(), missing.end());
  missing.erase(std::unique(missing.begin(), missing.end()), missing.end());
  if (missing.empty())
  {
    return;
  }
  constexpr std::size_t parts = 64;
  const std::size_t voxels = static_cast<std::size_t>(labels->GetNumberOfTuples());
  std::vector<std::vector<std::size_t>> found(parts * missing.size()); // [part][label]
  const vtkSmartPointer<vtkDataArray> values = ToEngineArray(labels);
  const chainmail::ArrayView view = View(values);
  chainmail::dispatch(view,
    [&](const auto* value)
    {
      chainmail::inParallel(parts,
        [&](std::size_t part)
        {
          const std::size_t step = static_cast<std::size_t>(view.components);
          const std::size_t end = voxels * (part + 1) / parts;
          std::size_t m = missing.size();
          for (std::size_t n = voxels * part / parts; n < end; ++n)
          {
            const auto here = value[n * step];
            if (n == voxels * part / parts || here != value[(n - 1) * step]) // runs of equal labels
            {
              m = static_cast<std::size_t>(std::find_if(missing.begin(), missing.end(),
                                             [here](vtkTypeInt64 label) { return IsLabel(here, label); }) -
                                           missing.begin());
            }
            if (m < missing.size())
            {
              found[part * missing.size() + m].push_back(n);
            }
          }
        });
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
