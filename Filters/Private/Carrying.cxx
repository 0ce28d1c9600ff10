// SPDX-License-Identifier: BSD-3-Clause
#include "Carrying.h"

#include "Arrays.h"
#include "Sampling.h"
#include "vtkChainMailScanStatistics.h"

#include "Error.h"
#include "Threads.h"

#include "vtkCellData.h"
#include "vtkFieldData.h"
#include "vtkMatrix4x4.h"
#include "vtkPointData.h"
#include "vtkPointSet.h"
#include "vtkPoints.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

namespace vtkChainMail
{

using chainmail::CarryMap;
using chainmail::InputError;
using chainmail::Vector3;

namespace
{

/// Number of points or voxels that are carried between two progress reports.
constexpr vtkIdType portion = vtkIdType(1) << 18;

std::array<double, 9> LinearPart(vtkMatrix4x4* matrix)
{
  std::array<double, 9> part;
  for (int n = 0; n < 9; ++n)
  {
    part[n] = matrix->GetElement(n / 3, n % 3);
  }
  return part;
}

std::array<double, 9> Product(const std::array<double, 9>& a, const std::array<double, 9>& b)
{
  std::array<double, 9> product;
  for (int n = 0; n < 9; ++n)
  {
    product[n] = a[n / 3 * 3] * b[n % 3] + a[n / 3 * 3 + 1] * b[n % 3 + 3] + a[n / 3 * 3 + 2] * b[n % 3 + 6];
  }
  return product;
}

Vector3 Times(const std::array<double, 9>& m, const Vector3& v)
{
  return { m[0] * v[0] + m[1] * v[1] + m[2] * v[2], m[3] * v[0] + m[4] * v[1] + m[5] * v[2],
    m[6] * v[0] + m[7] * v[1] + m[8] * v[2] };
}

Vector3 TransposedTimes(const std::array<double, 9>& m, const Vector3& v)
{
  return { m[0] * v[0] + m[3] * v[1] + m[6] * v[2], m[1] * v[0] + m[4] * v[1] + m[7] * v[2],
    m[2] * v[0] + m[5] * v[1] + m[8] * v[2] };
}

/// An array of the model, converted to the type that the engine reads.
template <typename ArrayType>
vtkSmartPointer<ArrayType> Read(vtkImageData* model, const char* name, int components, const std::string& lacks)
{
  vtkDataArray* array = model->GetPointData()->GetArray(name);
  if (!array)
  {
    throw InputError(lacks);
  }
  if (array->GetNumberOfComponents() != components || array->GetNumberOfTuples() != model->GetNumberOfPoints())
  {
    throw InputError("The array " + std::string(name) + " of the deformation needs " + std::to_string(components) +
                     (components == 1 ? " component" : " components") +
                     " at each voxel. Connect the second output of ChainMail Deformation, the model at rest.");
  }
  vtkSmartPointer<ArrayType> typed = ArrayType::SafeDownCast(array);
  if (!typed) // another type, from some files
  {
    typed = MakeArray<ArrayType>(name, components, array->GetNumberOfTuples());
    for (vtkIdType t = 0; t < array->GetNumberOfTuples(); ++t)
    {
      typed->SetTuple(t, t, array);
    }
  }
  return typed;
}

/// Calls f(n) for n in [0, count), from several threads, and reports progress in between.
template <typename F> void ForAll(vtkIdType count, const std::function<void(double)>& progress, const F& f)
{
  constexpr vtkIdType task = 1024;
  for (vtkIdType first = 0; first < count; first += portion)
  {
    progress(static_cast<double>(first) / static_cast<double>(count));
    const vtkIdType last = std::min(first + portion, count);
    chainmail::inParallel(static_cast<std::size_t>((last - first + task - 1) / task),
      [&](std::size_t n)
      {
        const vtkIdType begin = first + static_cast<vtkIdType>(n) * task;
        for (vtkIdType i = begin; i < std::min(begin + task, last); ++i)
        {
          f(i);
        }
      });
  }
}

}

Carrying::Carrying(vtkImageData* model)
  : Model(vtkSmartPointer<vtkImageData>::New())
{
  if (model->GetNumberOfPoints() == 0)
  {
    throw InputError(
      "The deformation is empty. Connect the second output of ChainMail Deformation, the model at rest.");
  }
  const std::string about = "The deformation has no array ";
  const char* const displaced =
    model->GetPointData()->HasArray("PullBack")
      ? "Displacement, because it is the deformed image. Connect the second output of ChainMail "
        "Deformation, the model at rest."
      : "Displacement. Connect the second output of ChainMail Deformation, the model at "
        "rest, with Displacement among its ModelArrays.";
  this->Displacement = Read<vtkFloatArray>(model, "Displacement", 3, about + displaced);
  this->Element = Read<vtkUnsignedCharArray>(model, "Element", 1,
    about + "Element, which tells tissue from air. Choose it among the ModelArrays of ChainMail Deformation.");
  if (model->GetPointData()->HasArray("Links"))
  {
    this->Links = Read<vtkUnsignedCharArray>(model, "Links", 1, about);
  }
  std::atomic<bool> isFinite{ true };
  const float* u = this->Displacement->GetPointer(0);
  ForAll(
    model->GetNumberOfPoints(), [](double) {},
    [&](vtkIdType v)
    {
      if (!std::isfinite(u[3 * v]) || !std::isfinite(u[3 * v + 1]) || !std::isfinite(u[3 * v + 2]))
      {
        isFinite = false;
      }
    });
  if (!isFinite)
  {
    throw InputError("The array Displacement of the deformation has values that are not finite. Compute the "
                     "deformation again, or check its file.");
  }

  this->Model->CopyStructure(model);
  this->ToVoxels = LinearPart(model->GetPhysicalToIndexMatrix());
  this->ToWorld = LinearPart(model->GetIndexToPhysicalMatrix());
  chainmail::RestModel rest;
  int extent[6];
  model->GetExtent(extent);
  for (int a = 0; a < 3; ++a)
  {
    this->First[a] = extent[2 * a];
    rest.grid.size[a] = extent[2 * a + 1] - extent[2 * a] + 1;
    rest.grid.spacing[a] = model->GetSpacing()[a];
  }
  rest.displacement = u;
  rest.toVoxels = this->ToVoxels;
  rest.element = this->Element->GetPointer(0);
  rest.links = this->Links ? this->Links->GetPointer(0) : nullptr;
  this->Map = std::make_unique<CarryMap>(rest);
}

void Carrying::Carry(vtkPointSet* input, const Options& options, vtkPointSet* output) const
{
  output->ShallowCopy(input);
  vtkPoints* from = input->GetPoints();
  if (!from || from->GetNumberOfPoints() == 0)
  {
    return;
  }
  vtkMatrix4x4* toIndex = this->Model->GetPhysicalToIndexMatrix();
  vtkMatrix4x4* toPhysical = this->Model->GetIndexToPhysicalMatrix();
  const auto apply = [](vtkMatrix4x4* m, const double v[3], int row)
  {
    return m->GetElement(row, 0) * v[0] + m->GetElement(row, 1) * v[1] + m->GetElement(row, 2) * v[2] +
           m->GetElement(row, 3);
  };
  vtkNew<vtkPoints> to;
  to->SetDataType(from->GetDataType());
  to->SetNumberOfPoints(from->GetNumberOfPoints());
  ForAll(from->GetNumberOfPoints(), options.Progress,
    [&](vtkIdType n)
    {
      double world[3];
      from->GetPoint(n, world);
      Vector3 place;
      for (int a = 0; a < 3; ++a)
      {
        place[a] = apply(toIndex, world, a) - this->First[a];
      }
      if (std::isfinite(place[0]) && std::isfinite(place[1]) && std::isfinite(place[2]))
      {
        const Vector3 there = options.Backward ? this->Map->backward(place) : this->Map->forward(place);
        // A point that does not move keeps its bits.
        if (there != place)
        {
          const double index[3] = { there[0] + this->First[0], there[1] + this->First[1], there[2] + this->First[2] };
          for (int a = 0; a < 3; ++a)
          {
            world[a] = apply(toPhysical, index, a);
          }
        }
      }
      to->SetPoint(n, world);
    });
  output->SetPoints(to);
  this->TurnNormals(input, options, output);
}

/// Transforms point normals as covectors, by the inverse transpose of the deformation gradient F. Cell normals are left
/// out: renderers compute them again.
void Carrying::TurnNormals(vtkPointSet* input, const Options& options, vtkPointSet* output) const
{
  if (vtkDataArray* ofCells = input->GetCellData()->GetNormals())
  {
    output->GetCellData()->RemoveArray(ofCells->GetName());
  }
  vtkDataArray* from = input->GetPointData()->GetNormals();
  if (!from || (from->GetDataType() != VTK_FLOAT && from->GetDataType() != VTK_DOUBLE))
  {
    return;
  }
  vtkPoints* rest = options.Backward ? output->GetPoints() : input->GetPoints();
  auto to = vtkSmartPointer<vtkDataArray>::Take(from->NewInstance());
  Describe(to, from);
  Allocate(to, from->GetNumberOfTuples());
  vtkMatrix4x4* toIndex = this->Model->GetPhysicalToIndexMatrix();
  ForAll(from->GetNumberOfTuples(), options.Progress,
    [&](vtkIdType n)
    {
      double world[3];
      rest->GetPoint(n, world);
      Vector3 place;
      for (int a = 0; a < 3; ++a)
      {
        place[a] = toIndex->GetElement(a, 0) * world[0] + toIndex->GetElement(a, 1) * world[1] +
                   toIndex->GetElement(a, 2) * world[2] + toIndex->GetElement(a, 3) - this->First[a];
      }
      Matrix f;
      this->Map->forward(place, &f);
      from->GetTuple(n, world);
      Vector3 normal = TransposedTimes(this->ToWorld, { world[0], world[1], world[2] });
      if (options.Backward)
      {
        normal = TransposedTimes(f, normal);
      }
      else
      {
        std::swap(f[1], f[3]);
        std::swap(f[2], f[6]);
        std::swap(f[5], f[7]);
        if (!chainmail::CarryCells::solve(f, normal))
        {
          to->SetTuple(n, world);
          return;
        }
      }
      normal = TransposedTimes(this->ToVoxels, normal);
      const double length = std::sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
      for (int a = 0; a < 3 && length > 0.0 && std::isfinite(length); ++a)
      {
        world[a] = normal[a] / length;
      }
      to->SetTuple(n, world);
    });
  output->GetPointData()->SetNormals(to);
}

std::vector<std::string> Carrying::Carry(
  vtkImageData* input, const Options& options, const Extent& extent, vtkImageData* output) const
{
  output->CopyStructure(input);
  output->GetFieldData()->ShallowCopy(input->GetFieldData());
  std::vector<std::string> lost;
  vtkCellData* cells = input->GetCellData();
  for (int a = 0; a < cells->GetNumberOfArrays(); ++a)
  {
    vtkAbstractArray* array = cells->GetAbstractArray(a);
    const std::string name = array->GetName() ? array->GetName() : "";
    if (name == vtkDataSetAttributes::GhostArrayName())
    {
      output->GetCellData()->AddArray(array);
    }
    else
    {
      lost.push_back(name);
    }
  }
  const Extent whole = ExtentOf(input);
  if (IsEmpty(whole) || IsEmpty(extent))
  {
    return lost;
  }

  const chainmail::Index3 size{ { whole[1] - whole[0] + 1, whole[3] - whole[2] + 1, whole[5] - whole[4] + 1 } };
  const Grids grids(size, { {}, size }, {}, {});
  vtkPointData* arrays = input->GetPointData();
  std::vector<std::unique_ptr<ArraySampler>> samplers;
  for (int a = 0; a < arrays->GetNumberOfArrays(); ++a)
  {
    vtkAbstractArray* array = arrays->GetAbstractArray(a);
    const std::string name = array->GetName() ? array->GetName() : "";
    if (name == vtkDataSetAttributes::GhostArrayName())
    {
      samplers.push_back(std::make_unique<StillArray>(array, grids));
      continue;
    }
    bool nearest = options.Nearest || options.IsLabelArray(name) || array == arrays->GetGlobalIds() ||
                   array == arrays->GetPedigreeIds();
    double background = vtkMath::Nan();
    PaddingValues notMeasured;
    vtkDataArray* numbers = vtkDataArray::SafeDownCast(array);
    if (numbers && numbers->GetNumberOfComponents() == 1 && numbers->GetDataType() != VTK_BIT)
    {
      const auto statistics = vtkChainMailScanStatistics::Of(input, numbers);
      nearest = nearest || statistics->GetKind() == vtkChainMailScanStatistics::KIND_LABELS;
      if (array == arrays->GetScalars())
      {
        background = std::isnan(options.Background) ? statistics->GetBackgroundValue() : options.Background;
        notMeasured = { statistics->GetLowPadding(), statistics->GetHighPadding() };
      }
    }
    samplers.push_back(
      MakeSampler(array, grids, nearest, background, nullptr, notMeasured, [](vtkIdType) { return false; }));
  }
  for (const auto& sampler : samplers)
  {
    sampler->Begin();
  }

  vtkNew<vtkMatrix4x4> toVoxel;
  vtkMatrix4x4::Multiply4x4(this->Model->GetPhysicalToIndexMatrix(), input->GetIndexToPhysicalMatrix(), toVoxel);
  const Matrix toIndices = Product(LinearPart(input->GetPhysicalToIndexMatrix()), this->ToWorld);
  const int rows[2] = { extent[3] - extent[2] + 1, extent[5] - extent[4] + 1 };
  const int width = extent[1] - extent[0] + 1;
  const vtkIdType allRows = static_cast<vtkIdType>(rows[0]) * rows[1];
  const vtkIdType rowsAtOnce = std::max<vtkIdType>(portion / width, 1);
  std::vector<float> offsets(3 * static_cast<std::size_t>(std::min(rowsAtOnce, allRows)) * width);
  std::vector<chainmail::ResampledBox> boxes;
  std::atomic<bool> atRest{ true };
  for (vtkIdType first = 0; first < allRows; first += rowsAtOnce)
  {
    options.Progress(static_cast<double>(first) / static_cast<double>(allRows));
    boxes.resize(static_cast<std::size_t>(std::min(rowsAtOnce, allRows - first)));
    chainmail::inParallel(boxes.size(),
      [&](std::size_t n)
      {
        const vtkIdType row = first + static_cast<vtkIdType>(n);
        const int j = static_cast<int>(row % rows[0]) + extent[2];
        const int k = static_cast<int>(row / rows[0]) + extent[4];
        float* out = &offsets[3 * n * width];
        boxes[n] = { { { extent[0] - whole[0], j - whole[2], k - whole[4] } }, { { width, 1, 1 } }, out,
          { { 3, 3 * width, 3 * width } } };
        for (int i = extent[0]; i <= extent[1]; ++i, out += 3)
        {
          Vector3 place;
          for (int a = 0; a < 3; ++a)
          {
            place[a] = toVoxel->GetElement(a, 0) * i + toVoxel->GetElement(a, 1) * j + toVoxel->GetElement(a, 2) * k +
                       toVoxel->GetElement(a, 3) - this->First[a];
          }
          const CarryMap::Shown shown = options.Backward ? this->Map->shownAtRest(place) : this->Map->shownNow(place);
          std::fill_n(out, 3, 0.0f);
          if (shown.what == CarryMap::Shown::What::Same)
          {
            continue;
          }
          atRest = false;
          const Vector3 way =
            Times(toIndices, { shown.from[0] - place[0], shown.from[1] - place[1], shown.from[2] - place[2] });
          const int index[3] = { i, j, k };
          bool isShown = shown.what == CarryMap::Shown::What::Material;
          for (int a = 0; a < 3; ++a)
          {
            // The outermost voxels extend by half a voxel; 1e-4 is the allowance for rounding.
            constexpr double half = 0.5 + 1e-4;
            const double from = index[a] + way[a];
            isShown = isShown && from >= whole[2 * a] - half && from <= whole[2 * a + 1] + half;
            out[a] = static_cast<float>(way[a]);
          }
          if (!isShown)
          {
            std::fill_n(out, 3, std::numeric_limits<float>::quiet_NaN());
          }
        }
      });
    for (const auto& sampler : samplers)
    {
      sampler->Sample(boxes);
    }
  }
  for (const auto& sampler : samplers)
  {
    output->GetPointData()->AddArray(sampler->End(1, atRest));
  }
  CopyActiveAttributes(arrays, output->GetPointData());
  return lost;
}

}
