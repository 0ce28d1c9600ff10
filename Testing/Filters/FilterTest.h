// SPDX-License-Identifier: BSD-3-Clause
// What the tests of the filters share: checks that count their failures, a log of VTK's error and warning events, and
// small scenes.

#ifndef FilterTest_h
#define FilterTest_h

#include "vtkAlgorithm.h"
#include "vtkBitArray.h"
#include "vtkCallbackCommand.h"
#include "vtkChainMailDeformation.h"
#include "vtkCommand.h"
#include "vtkDataArray.h"
#include "vtkDoubleArray.h"
#include "vtkExecutive.h"
#include "vtkFieldData.h"
#include "vtkImageData.h"
#include "vtkNew.h"
#include "vtkPiecewiseFunction.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"
#include "vtkSmartPointer.h"
#include "vtkStringArray.h"
#include "vtkUnsignedCharArray.h"
#include "vtkVariant.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <iostream>
#include <string>
#include <vector>

namespace FilterTest
{

/// Counts checks and failures; the first failures are printed.
class Checks
{
public:
  void That(bool holds, const std::string& what)
  {
    ++this->Count;
    if (!holds && ++this->Failures <= 50)
    {
      std::cerr << "FAILED: " << what << "\n";
    }
  }

  template <typename A, typename B> void Equal(const A& actual, const B& expected, const std::string& what)
  {
    const bool holds = actual == expected;
    if (!holds && this->Failures < 50)
    {
      std::cerr << "got " << actual << ", expected " << expected << ": ";
    }
    this->That(holds, what);
  }

  void Near(double actual, double expected, double tolerance, const std::string& what)
  {
    const bool holds = std::fabs(actual - expected) <= tolerance; // false for NaN
    if (!holds && this->Failures < 50)
    {
      std::cerr << "got " << actual << ", expected " << expected << " +- " << tolerance << ": ";
    }
    this->That(holds, what);
  }

  void Contains(const std::string& text, const std::string& part, const std::string& what)
  {
    const bool holds = text.find(part) != std::string::npos;
    if (!holds && this->Failures < 50)
    {
      std::cerr << "\"" << text << "\" does not contain \"" << part << "\": ";
    }
    this->That(holds, what);
  }

  /// The test's exit status.
  int Finish() const
  {
    std::cout << this->Count << " checks, " << this->Failures << " failed\n";
    return this->Count > 0 && this->Failures == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
  }

private:
  int Count = 0;
  int Failures = 0;
};

/// Collects the errors and warnings of an algorithm, which then do not reach the terminal.
class EventLog
{
public:
  explicit EventLog(vtkAlgorithm* algorithm)
  {
    this->Observer->SetClientData(this);
    this->Observer->SetCallback(
      [](vtkObject*, unsigned long event, void* log, void* text)
      {
        auto* self = static_cast<EventLog*>(log);
        (event == vtkCommand::ErrorEvent ? self->Errors : self->Warnings).emplace_back(static_cast<const char*>(text));
      });
    algorithm->AddObserver(vtkCommand::ErrorEvent, this->Observer);
    algorithm->AddObserver(vtkCommand::WarningEvent, this->Observer);
    // An executive that repeats a message, or complains of its own, is one report too many.
    algorithm->GetExecutive()->AddObserver(vtkCommand::ErrorEvent, this->Observer);
  }

  std::string TakeErrors() { return Take(this->Errors); }
  std::string TakeWarnings() { return Take(this->Warnings); }

private:
  static std::string Take(std::vector<std::string>& messages)
  {
    std::string all;
    for (const std::string& message : messages)
    {
      all += message;
    }
    messages.clear();
    return all;
  }

  vtkNew<vtkCallbackCommand> Observer;
  std::vector<std::string> Errors;
  std::vector<std::string> Warnings;
};

/// Numbers that look random and are the same everywhere.
class Noise
{
public:
  explicit Noise(unsigned seed)
    : State(seed * 2654435761u + 12345u)
  {
  }
  unsigned Next()
  {
    this->State ^= this->State << 13;
    this->State ^= this->State >> 17;
    this->State ^= this->State << 5;
    return this->State;
  }
  /// In [0, 1).
  double Uniform() { return (this->Next() >> 8) / 16777216.0; }

private:
  unsigned State;
};

inline vtkSmartPointer<vtkImageData> MakeImage(
  const std::array<int, 6>& extent, int type = VTK_SHORT, int components = 1)
{
  auto image = vtkSmartPointer<vtkImageData>::New();
  image->SetExtent(const_cast<int*>(extent.data()));
  image->AllocateScalars(type, components);
  image->GetPointData()->GetScalars()->SetName("Scan");
  return image;
}

/// Scalars from a function of the voxel's indices, counted from the first voxel.
inline void Fill(vtkDataArray* array, vtkImageData* image, const std::function<double(int, int, int)>& value)
{
  int size[3];
  image->GetDimensions(size);
  vtkIdType id = 0;
  for (int k = 0; k < size[2]; ++k)
  {
    for (int j = 0; j < size[1]; ++j)
    {
      for (int i = 0; i < size[0]; ++i, ++id)
      {
        for (int c = 0; c < array->GetNumberOfComponents(); ++c)
        {
          array->SetComponent(id, c, value(i, j, k) + c);
        }
      }
    }
  }
}

inline vtkSmartPointer<vtkPiecewiseFunction> ConstantMaterial(double constraint)
{
  auto function = vtkSmartPointer<vtkPiecewiseFunction>::New();
  function->AddPoint(0.0, constraint);
  return function;
}

using Vector = std::array<double, 3>;

/// Adds an array Place with the place of each voxel. That is linear in space, so between voxels, too, what resampling
/// shows of it is where it took its values from.
inline void AddPlaces(vtkImageData* image)
{
  vtkNew<vtkDoubleArray> place;
  place->SetName("Place");
  place->SetNumberOfComponents(3);
  for (vtkIdType p = 0; p < image->GetNumberOfPoints(); ++p)
  {
    place->InsertNextTuple(image->GetPoint(p));
  }
  image->GetPointData()->AddArray(place);
}

/// Gives an image an odd spacing and oblique directions, and the array Place.
inline void PlaceObliquely(vtkImageData* image)
{
  image->SetSpacing(1.5, 0.75, 2.0);
  image->SetOrigin(-40.0, 12.0, 7.0);
  const double c = std::cos(0.5), s = std::sin(0.5);
  image->SetDirectionMatrix(c, -s * 0.8, s * 0.6, s, c * 0.8, -c * 0.6, 0.0, 0.6, 0.8);
  AddPlaces(image);
}

/// Where a voxel is, counted from the image's first one.
inline Vector PlaceOfVoxel(vtkImageData* image, double i, double j, double k)
{
  int extent[6];
  image->GetExtent(extent);
  const double index[3] = { extent[0] + i, extent[2] + j, extent[4] + k };
  Vector place;
  image->TransformContinuousIndexToPhysicalPoint(index, place.data());
  return place;
}

struct Probe
{
  Vector Position;
  Vector Displacement;
  double Radius = 0.0;
  bool Anchor = false;
};

inline vtkSmartPointer<vtkPolyData> MakeProbes(const std::vector<Probe>& probes)
{
  auto data = vtkSmartPointer<vtkPolyData>::New();
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  vtkNew<vtkDoubleArray> displacement;
  displacement->SetName("Displacement");
  displacement->SetNumberOfComponents(3);
  vtkNew<vtkDoubleArray> radius;
  radius->SetName("Radius");
  vtkNew<vtkUnsignedCharArray> anchor;
  anchor->SetName("Anchor");
  for (const Probe& probe : probes)
  {
    points->InsertNextPoint(probe.Position.data());
    displacement->InsertNextTuple(probe.Displacement.data());
    radius->InsertNextValue(probe.Radius);
    anchor->InsertNextValue(probe.Anchor ? 1 : 0);
  }
  data->SetPoints(points);
  data->GetPointData()->AddArray(displacement);
  data->GetPointData()->AddArray(radius);
  data->GetPointData()->AddArray(anchor);
  return data;
}

/// A quadrilateral blade.
inline vtkSmartPointer<vtkPolyData> MakeBlade(const std::array<Vector, 4>& corners)
{
  auto data = vtkSmartPointer<vtkPolyData>::New();
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (const Vector& corner : corners)
  {
    points->InsertNextPoint(corner.data());
  }
  vtkNew<vtkCellArray> polygons;
  polygons->InsertNextCell({ 0, 1, 2, 3 });
  data->SetPoints(points);
  data->SetPolys(polygons);
  return data;
}

inline double Field(vtkDataObject* data, const char* name, int component = 0, vtkIdType tuple = 0)
{
  vtkDataArray* array = data->GetFieldData()->GetArray(name);
  return array && tuple < array->GetNumberOfTuples() && component < array->GetNumberOfComponents()
           ? array->GetComponent(tuple, component)
           : std::nan("");
}

/// Rows of the field array Milliseconds.
enum Times
{
  UPLOAD,
  PROPAGATE,
  RELAX,
  RESAMPLE,
  DOWNLOAD
};

/// A value as text. VTK's variants hold no bits.
inline std::string ValueText(vtkAbstractArray* array, vtkIdType value)
{
  vtkBitArray* bits = vtkBitArray::SafeDownCast(array);
  return bits ? std::to_string(bits->GetValue(value)) : array->GetVariantValue(value).ToString();
}

/// The same name, type, components and bits.
inline bool SameBits(vtkAbstractArray* a, vtkAbstractArray* b)
{
  if (!a || !b || a->GetDataType() != b->GetDataType() || a->GetNumberOfComponents() != b->GetNumberOfComponents() ||
      a->GetNumberOfTuples() != b->GetNumberOfTuples() || std::string(a->GetName()) != b->GetName())
  {
    return false;
  }
  vtkDataArray* numbers = vtkDataArray::SafeDownCast(a);
  if (!numbers || a->GetDataType() == VTK_BIT)
  {
    for (vtkIdType v = 0; v < a->GetNumberOfValues(); ++v)
    {
      if (ValueText(a, v) != ValueText(b, v))
      {
        return false;
      }
    }
    return true;
  }
  const std::size_t bytes = static_cast<std::size_t>(a->GetNumberOfValues()) * a->GetDataTypeSize();
  return bytes == 0 || std::memcmp(a->GetVoidPointer(0), b->GetVoidPointer(0), bytes) == 0;
}

/// Whether two images have the same place, and the same point arrays with the same bits in the same order.
inline bool SameImage(vtkImageData* a, vtkImageData* b)
{
  bool same = std::equal(a->GetExtent(), a->GetExtent() + 6, b->GetExtent()) &&
              std::equal(a->GetOrigin(), a->GetOrigin() + 3, b->GetOrigin()) &&
              std::equal(a->GetSpacing(), a->GetSpacing() + 3, b->GetSpacing()) &&
              a->GetPointData()->GetNumberOfArrays() == b->GetPointData()->GetNumberOfArrays();
  for (int n = 0; same && n < a->GetPointData()->GetNumberOfArrays(); ++n)
  {
    same = SameBits(a->GetPointData()->GetAbstractArray(n), b->GetPointData()->GetAbstractArray(n));
  }
  return same;
}

/// Gives `fresh` the probes, cuts and carves of a filter, and its properties of the output.
inline void TakeInputsAndOutput(vtkChainMailDeformation* fresh, vtkChainMailDeformation* filter)
{
  fresh->SetOutputPadding(filter->GetOutputPadding());
  fresh->SetOutputMagnification(filter->GetOutputMagnification());
  fresh->SetUseOutputBounds(filter->GetUseOutputBounds());
  fresh->SetOutputBounds(filter->GetOutputBounds());
  fresh->SetSmoothCuts(filter->GetSmoothCuts());
  fresh->SetScalarSmoothing(filter->GetScalarSmoothing());
  for (int port = 1; port < 4; ++port)
  {
    if (filter->GetNumberOfInputConnections(port) > 0)
    {
      fresh->SetInputDataObject(port, filter->GetInputDataObject(port, 0));
    }
  }
}

/// The message that outputs carry which are not those of the present inputs; empty: there is none.
inline std::string ErrorOf(vtkImageData* output)
{
  auto error = vtkStringArray::SafeDownCast(output->GetFieldData()->GetAbstractArray("Error"));
  return error && error->GetNumberOfValues() == 1 ? std::string(error->GetValue(0)) : std::string();
}

}

#endif
