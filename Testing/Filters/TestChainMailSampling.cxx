// SPDX-License-Identifier: BSD-3-Clause
// Resampling against closed forms: whole-voxel translations and gaps are exact in every type, a linear displacement of
// linear scalars is its analytic pre-image, labels are never blended, vacated voxels show the background.

#include "FilterTest.h"

#include "vtkDoubleArray.h"
#include "vtkIntArray.h"
#include "vtkLongLongArray.h"
#include "vtkShortArray.h"
#include "vtkTypeUInt64Array.h"

#include <limits>
#include <set>

using namespace FilterTest;

namespace
{

const int size = 10;

/// An array over the image with random values of the type's whole range; 64-bit integers differ in their low bits.
vtkSmartPointer<vtkDataArray> AddRandomArray(vtkImageData* image, int type, const char* name, Noise& noise)
{
  auto array = vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(type));
  array->SetName(name);
  array->SetNumberOfComponents(2);
  array->SetNumberOfTuples(image->GetNumberOfPoints());
  for (vtkIdType v = 0; v < array->GetNumberOfValues(); ++v)
  {
    const double value = noise.Uniform() * 200.0 - (array->GetDataTypeMin() < 0 ? 100.0 : 0.0);
    array->SetVariantValue(v, vtkVariant(value));
    if (type == VTK_LONG_LONG)
    {
      static_cast<long long*>(array->GetVoidPointer(0))[v] =
        (static_cast<long long>(noise.Next()) << 31) + static_cast<long long>(noise.Next());
    }
  }
  image->GetPointData()->AddArray(array);
  return array;
}

/// A probe on every voxel, so that the displacement is exactly the given one.
vtkSmartPointer<vtkPolyData> Prescribe(vtkImageData* image, const std::function<Vector(const double*)>& displacement)
{
  std::vector<Probe> probes;
  for (vtkIdType p = 0; p < image->GetNumberOfPoints(); ++p)
  {
    double x[3];
    image->GetPoint(p, x);
    probes.push_back({ { { x[0], x[1], x[2] } }, displacement(x) });
  }
  return MakeProbes(probes);
}

}

int TestChainMailSampling(int, char*[])
{
  Checks check;
  Noise noise(3);

  // Two stiff halves, cut apart and pulled apart by 2 + 3 voxels along x: each appears whole, shifted, in every type;
  // the gap of 5 voxels shows the background.
  {
    auto image = MakeImage({ { 10, 10 + size - 1, -3, size - 4, 0, size - 1 } }, VTK_SHORT);
    Fill(image->GetPointData()->GetScalars(), image, [&](int, int, int) { return 100 + noise.Next() % 900; });
    image->SetOrigin(5.0, 6.0, 7.0);
    image->SetSpacing(2.0, 1.0, 0.5);
    const std::pair<int, const char*> arrays[] = { { VTK_UNSIGNED_CHAR, "uchar" }, { VTK_CHAR, "char" },
      { VTK_UNSIGNED_SHORT, "ushort" }, { VTK_INT, "int" }, { VTK_LONG_LONG, "longlong" }, { VTK_FLOAT, "float" },
      { VTK_DOUBLE, "double" }, { VTK_ID_TYPE, "id" } };
    for (const auto& array : arrays)
    {
      AddRandomArray(image, array.first, array.second, noise);
    }
    vtkNew<vtkStringArray> names;
    names->SetName("names");
    vtkNew<vtkBitArray> bits;
    bits->SetName("bits");
    for (vtkIdType p = 0; p < image->GetNumberOfPoints(); ++p)
    {
      names->InsertNextValue(std::to_string(p));
      bits->InsertNextValue(1);
    }
    image->GetPointData()->AddArray(names);
    image->GetPointData()->AddArray(bits);
    // A value that would spread if neighbours of weight 0 were read.
    image->GetPointData()->GetArray("float")->SetComponent(555, 0, std::nan(""));
    image->GetPointData()->GetArray("double")->SetComponent(444, 1, std::numeric_limits<double>::infinity());

    double first[3];
    double last[3];
    int lowest[3] = { 10, -3, 0 };
    int highest[3] = { 10 + size - 1, size - 4, size - 1 };
    image->TransformIndexToPhysicalPoint(lowest, first);
    image->TransformIndexToPhysicalPoint(highest, last);
    const double x = 0.5 * (first[0] + last[0]);
    auto blade =
      MakeBlade({ { { { x, -1e3, -1e3 } }, { { x, 1e3, -1e3 } }, { { x, 1e3, 1e3 } }, { { x, -1e3, 1e3 } } } });

    vtkNew<vtkChainMailDeformation> filter;
    filter->SetInputData(image);
    filter->SetTissueThreshold(0.0);
    filter->SmoothCutsOff(); // voxels are one or the other here
    filter->SetMaterialFunction(ConstantMaterial(0.0));
    filter->SetAnchoredFaces(0, 0, 0, 0, 0, 0);
    filter->SetInputDataObject(2, blade);
    filter->SetInputDataObject(1, MakeProbes({ { { { first[0], first[1], first[2] } }, { { -4.0, 0.0, 0.0 } } },
                                    { { { last[0], last[1], last[2] } }, { { 6.0, 0.0, 0.0 } } } }));
    for (int padding : { 4, 0 })
    {
      filter->SetOutputPadding(padding);
      filter->SetBackgroundValue(padding ? -77.4 : std::nan(""));
      filter->Update();
      vtkImageData* output = filter->GetOutput();
      const std::string where = "pulled apart, padding " + std::to_string(padding) + ": ";
      check.Equal(
        output->GetPointData()->GetNumberOfArrays(), image->GetPointData()->GetNumberOfArrays(), where + "arrays");
      for (int a = 0; a < image->GetPointData()->GetNumberOfArrays(); ++a)
      {
        vtkAbstractArray* from = image->GetPointData()->GetAbstractArray(a);
        vtkAbstractArray* to = output->GetPointData()->GetAbstractArray(from->GetName());
        const int components = from->GetNumberOfComponents();
        // What a place shows that no tissue came to.
        std::vector<std::string> background;
        for (int c = 0; c < components; ++c)
        {
          vtkDataArray* numbers = vtkDataArray::SafeDownCast(from);
          if (!numbers)
          {
            background.emplace_back("");
            continue;
          }
          vtkIdType smallest = -1;
          for (vtkIdType p = 0; p < from->GetNumberOfTuples(); ++p)
          {
            if (std::isfinite(numbers->GetComponent(p, c)) &&
                (smallest < 0 || from->GetDataType() == VTK_LONG_LONG
                    ? smallest < 0 || from->GetVariantValue(p * components + c) < from->GetVariantValue(smallest)
                    : numbers->GetComponent(p, c) < numbers->GetComponent(smallest / components, c)))
            {
              smallest = p * components + c;
            }
          }
          background.push_back(from->GetDataType() == VTK_BIT ? "0" : ValueText(from, smallest));
        }
        if (from == image->GetPointData()->GetScalars() && padding)
        {
          background = { "-77" }; // rounded to the type
        }
        int extent[6];
        output->GetExtent(extent);
        for (int k = extent[4]; k <= extent[5]; ++k)
        {
          for (int j = extent[2]; j <= extent[3]; ++j)
          {
            for (int i = extent[0]; i <= extent[1]; ++i)
            {
              // The left half, x index 10 to 14, moved by -2; the right one by +3.
              const int left = i + 2;
              const int right = i - 3;
              const bool inside = j >= -3 && j <= size - 4 && k >= 0 && k <= size - 1;
              const int source = inside && left >= 10 && left <= 14     ? left
                                 : inside && right >= 15 && right <= 19 ? right
                                                                        : -1;
              int at[3] = { i, j, k };
              int origin[3] = { source, j, k };
              for (int c = 0; c < components; ++c)
              {
                const std::string shown = ValueText(to, output->ComputePointId(at) * components + c);
                const std::string expected =
                  source < 0 ? background[c] : ValueText(from, image->ComputePointId(origin) * components + c);
                check.Equal(shown, expected,
                  where + "array " + from->GetName() + " at " + std::to_string(i) + " " + std::to_string(j) + " " +
                    std::to_string(k));
              }
            }
          }
        }
      }
    }
  }

  // u = A (x - c) + t with |A| < 1/3: scalars s(X) = g.X + h at y come from X = c + (1 + A)^-1 (y - c - t).
  {
    auto image = MakeImage({ { 2, 2 + size - 1, 0, size - 1, 0, size - 1 } }, VTK_DOUBLE);
    image->SetSpacing(0.5, 1.0, 2.0);
    image->SetOrigin(-3.0, 0.0, 50.0);
    const Vector gradient{ { 3.0, -2.0, 0.5 } };
    const auto scalar = [&](const double* X)
    { return 1000.0 + gradient[0] * X[0] + gradient[1] * X[1] + gradient[2] * X[2]; };
    vtkNew<vtkShortArray> rounded;
    rounded->SetName("rounded");
    vtkNew<vtkIntArray> labels;
    labels->SetName("labels");
    vtkNew<vtkTypeUInt64Array> large;
    large->SetName("large");
    const vtkTypeUInt64 huge = vtkTypeUInt64(1) << 63;
    for (vtkIdType p = 0; p < image->GetNumberOfPoints(); ++p)
    {
      double X[3];
      image->GetPoint(p, X);
      image->GetPointData()->GetScalars()->SetTuple1(p, scalar(X));
      rounded->InsertNextValue(static_cast<short>(std::lround(10.0 * scalar(X))));
      labels->InsertNextValue(X[0] > -1.0 ? 100 : 7);
      // Needs all 64 bits: its low digits are the scalar's.
      large->InsertNextValue(huge + static_cast<vtkTypeUInt64>(std::llround(1024.0 * scalar(X))));
    }
    image->GetPointData()->AddArray(rounded);
    image->GetPointData()->AddArray(labels);
    image->GetPointData()->AddArray(large);
    const Vector stretch{ { 0.10, -0.15, 0.05 } };
    const double shear = 0.08; // u_x grows with y
    double centre[3];
    image->GetCenter(centre);
    vtkNew<vtkChainMailDeformation> filter;
    filter->SetInputData(image);
    filter->SetTissueThreshold(0.0);
    filter->SetMaterialFunction(ConstantMaterial(0.45));
    filter->SetAnchoredFaces(0, 0, 0, 0, 0, 0);
    filter->AddLabelArray("labels");
    filter->SetInputDataObject(1, Prescribe(image,
                                    [&](const double* X)
                                    {
                                      return Vector{ { stretch[0] * (X[0] - centre[0]) + shear * (X[1] - centre[1]),
                                        stretch[1] * (X[1] - centre[1]), stretch[2] * (X[2] - centre[2]) } };
                                    }));
    filter->Update();
    vtkImageData* output = filter->GetOutput();
    double bounds[6];
    image->GetBounds(bounds);
    int inside = 0;
    int vacated = 0;
    for (vtkIdType p = 0; p < output->GetNumberOfPoints(); ++p)
    {
      double y[3];
      output->GetPoint(p, y);
      double X[3];
      X[1] = centre[1] + (y[1] - centre[1]) / (1.0 + stretch[1]);
      X[2] = centre[2] + (y[2] - centre[2]) / (1.0 + stretch[2]);
      X[0] = centre[0] + (y[0] - centre[0] - shear * (X[1] - centre[1])) / (1.0 + stretch[0]);
      // Positions in voxels, so that the margin of rounding means the same on every axis.
      bool in = true;
      bool out = false;
      for (int a = 0; a < 3; ++a)
      {
        const double low = (X[a] - bounds[2 * a]) / image->GetSpacing()[a];
        const double high = (bounds[2 * a + 1] - X[a]) / image->GetSpacing()[a];
        in = in && low > 1e-4 && high > 1e-4;
        out = out || low < -1e-4 || high < -1e-4;
      }
      vtkPointData* arrays = output->GetPointData();
      if (in)
      {
        ++inside;
        // Offsets are floats of a few voxels, and the inversion stops at about 1e-5 voxel, with a gradient of at most
        // 2 a voxel.
        check.Near(arrays->GetScalars()->GetTuple1(p), scalar(X), 1e-4, "linear scalars");
        check.Near(arrays->GetArray("rounded")->GetTuple1(p), 10.0 * scalar(X), 0.5 + 0.5 + 1e-3,
          "integers are interpolated between rounded values, and rounded");
        const auto low =
          static_cast<vtkTypeInt64>(vtkTypeUInt64Array::SafeDownCast(arrays->GetArray("large"))->GetValue(p) - huge);
        check.Near(static_cast<double>(low), 1024.0 * scalar(X), 1.0 + 0.1, "64-bit integers keep their low digits");
        const double label = arrays->GetArray("labels")->GetTuple1(p);
        check.That(label == 7.0 || label == 100.0, "no label is invented");
        // The label of the nearest voxel, unless X is half-way between two.
        const double voxel = (X[0] - bounds[0]) / image->GetSpacing()[0];
        if (std::fabs(voxel - std::floor(voxel) - 0.5) > 1e-3)
        {
          const double nearest = bounds[0] + std::floor(voxel + 0.5) * image->GetSpacing()[0];
          check.Equal(label, nearest > -1.0 ? 100.0 : 7.0, "nearest label");
        }
      }
      if (out)
      {
        ++vacated;
        check.Equal(arrays->GetScalars()->GetTuple1(p), image->GetScalarRange()[0], "vacated voxels show the minimum");
      }
    }
    check.That(inside > 400 && vacated > 100, "both kinds of voxels were met");

    // The integers are the scalars within rounding: half a unit, not a whole one on average.
    double bias = 0.0;
    for (vtkIdType p = 0; p < output->GetNumberOfPoints(); ++p)
    {
      bias += output->GetPointData()->GetArray("rounded")->GetTuple1(p) -
              10.0 * output->GetPointData()->GetScalars()->GetTuple1(p);
    }
    check.Near(
      bias / static_cast<double>(output->GetNumberOfPoints()), 0.0, 0.1, "rounding is to the nearest, not down");

    // Nearest for all: only values of the input.
    filter->SetInterpolationToNearest();
    filter->Update();
    std::set<double> values;
    for (vtkIdType p = 0; p < image->GetNumberOfPoints(); ++p)
    {
      values.insert(image->GetPointData()->GetScalars()->GetTuple1(p));
    }
    for (vtkIdType p = 0; p < output->GetNumberOfPoints(); ++p)
    {
      check.That(values.count(output->GetPointData()->GetScalars()->GetTuple1(p)) == 1, "nearest invents no value");
    }
  }

  // Half a voxel along one axis: what is beside a row on the other axes is not read, whatever it is.
  {
    auto image = MakeImage({ { 0, 8, 0, 8, 0, 8 } }, VTK_DOUBLE);
    Fill(image->GetPointData()->GetScalars(), image, [](int i, int j, int k) { return 1 + i * i + 3 * j + 100 * k; });
    vtkNew<vtkDoubleArray> spoiled;
    spoiled->DeepCopy(image->GetPointData()->GetScalars());
    spoiled->SetName("spoiled");
    int hole[3] = { 4, 4, 4 };
    spoiled->SetTuple1(image->ComputePointId(hole), std::nan(""));
    image->GetPointData()->AddArray(spoiled);
    for (int along = 0; along < 3; ++along)
    {
      vtkNew<vtkChainMailDeformation> filter;
      filter->SetInputData(image);
      filter->SetTissueThreshold(0.0);
      filter->SetMaterialFunction(ConstantMaterial(0.0));
      filter->SetAnchoredFaces(0, 0, 0, 0, 0, 0);
      Vector pull{};
      pull[along] = 0.5;
      filter->SetInputDataObject(1, MakeProbes({ { { { 4.0, 4.0, 4.0 } }, pull } }));
      filter->Update();
      vtkDataArray* clean = filter->GetOutput()->GetPointData()->GetScalars();
      vtkDataArray* holed = filter->GetOutput()->GetPointData()->GetArray("spoiled");
      for (vtkIdType p = 0; p < image->GetNumberOfPoints(); ++p)
      {
        double x[3];
        image->GetPoint(p, x);
        x[along] -= 0.5;
        const bool touched = std::fabs(x[along] - 4.0) < 1.0 && std::fabs(x[(along + 1) % 3] - 4.0) < 1.0 &&
                             std::fabs(x[(along + 2) % 3] - 4.0) < 1.0;
        check.Equal(std::isnan(holed->GetTuple1(p)), touched, "only what lies beside it along the pull sees the hole");
        check.That(touched || holed->GetTuple1(p) == clean->GetTuple1(p), "the rest is as without it");
        if (x[along] > 0.0)
        {
          double low[3] = { x[0], x[1], x[2] };
          double high[3] = { x[0], x[1], x[2] };
          low[along] -= 0.5;
          high[along] += 0.5;
          check.Equal(clean->GetTuple1(p),
            0.5 * (image->GetPointData()->GetScalars()->GetTuple1(image->FindPoint(low)) +
                    image->GetPointData()->GetScalars()->GetTuple1(image->FindPoint(high))),
            "half-way between two voxels is their mean");
        }
      }
    }
  }

  // The background of unsigned types is brought into their range, infinite ones too.
  for (const auto& background : { std::pair<double, double>{ -1000.0, 0.0 }, { 300.0, 255.0 }, { 12.6, 13.0 },
         { -std::numeric_limits<double>::infinity(), 0.0 } })
  {
    auto image = MakeImage({ { 0, 5, 0, 5, 0, 5 } }, VTK_UNSIGNED_CHAR);
    Fill(image->GetPointData()->GetScalars(), image, [](int, int, int) { return 50; });
    vtkNew<vtkChainMailDeformation> filter;
    filter->SetInputData(image);
    filter->SetTissueThreshold(10.0);
    filter->SetMaterialFunction(ConstantMaterial(0.0));
    filter->SetAnchoredFaces(0, 0, 0, 0, 0, 0);
    filter->SetBackgroundValue(background.first);
    filter->SetInputDataObject(1, MakeProbes({ { { { 0.0, 0.0, 0.0 } }, { { 1.0, 0.0, 0.0 } } } }));
    filter->Update();
    check.Equal(filter->GetOutput()->GetPointData()->GetScalars()->GetTuple1(0), background.second, "vacated face");
    check.Equal(filter->GetOutput()->GetPointData()->GetScalars()->GetTuple1(1), 50.0, "moved face");
  }

  // A single slice, pulled within its plane and, with a component across it, staying a slice.
  for (int flat = 0; flat < 3; ++flat)
  {
    std::array<int, 6> extent{ { 0, 8, 0, 8, 0, 8 } };
    extent[2 * flat + 1] = extent[2 * flat] = 4;
    const int along = (flat + 1) % 3;
    auto image = MakeImage(extent, VTK_FLOAT);
    Fill(image->GetPointData()->GetScalars(), image, [&](int i, int j, int k) { return 10 + i + 20 * j + 400 * k; });
    vtkNew<vtkChainMailDeformation> filter;
    filter->SetInputData(image);
    filter->SetTissueThreshold(0.0);
    filter->SetMaterialFunction(ConstantMaterial(0.0));
    filter->SetAnchoredFaces(0, 0, 0, 0, 0, 0);
    Vector pull{};
    pull[along] = 2.0;
    filter->SetInputDataObject(1, MakeProbes({ { { { 4.0, 4.0, 4.0 } }, pull } }));
    filter->Update();
    for (vtkIdType p = 0; p < image->GetNumberOfPoints(); ++p)
    {
      double x[3];
      image->GetPoint(p, x);
      x[along] -= 2.0;
      const vtkIdType source = image->FindPoint(x);
      check.Equal(filter->GetOutput()->GetPointData()->GetScalars()->GetTuple1(p),
        source < 0 ? image->GetScalarRange()[0] : image->GetPointData()->GetScalars()->GetTuple1(source),
        "slice across axis " + std::to_string(flat));
    }
  }
  return check.Finish();
}
