// SPDX-License-Identifier: BSD-3-Clause
// Where nothing moves, every output array equals its input bit for bit: for all types, several components, any extent,
// slices, with and without cuts, with padding around, and away from a probe.

#include "FilterTest.h"

#include "vtkBitArray.h"
#include "vtkCellData.h"
#include "vtkIdTypeArray.h"
#include "vtkIntArray.h"
#include "vtkSOADataArrayTemplate.h"
#include "vtkSphereSource.h"
#include "vtkVariantArray.h"

#include <limits>

using namespace FilterTest;

namespace
{

const int types[] = { VTK_CHAR, VTK_SIGNED_CHAR, VTK_UNSIGNED_CHAR, VTK_SHORT, VTK_UNSIGNED_SHORT, VTK_INT,
  VTK_UNSIGNED_INT, VTK_LONG, VTK_UNSIGNED_LONG, VTK_LONG_LONG, VTK_UNSIGNED_LONG_LONG, VTK_ID_TYPE, VTK_FLOAT,
  VTK_DOUBLE };

/// Bits that no detour through another type keeps: low bits of 64-bit integers, NaN with a payload, -0.
void FillWithAnyBits(vtkDataArray* array, Noise& noise)
{
  auto* bytes = static_cast<unsigned char*>(array->GetVoidPointer(0));
  const vtkIdType size = array->GetNumberOfValues() * array->GetDataTypeSize();
  for (vtkIdType b = 0; b < size; ++b)
  {
    bytes[b] = static_cast<unsigned char>(noise.Next());
  }
}

/// Arrays of every kind beside the scalars.
void AddArrays(vtkImageData* image, Noise& noise)
{
  const vtkIdType voxels = image->GetNumberOfPoints();
  for (int type : types)
  {
    auto array = vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(type));
    array->SetName(("any" + std::to_string(type)).c_str());
    array->SetNumberOfComponents(type % 3 + 1);
    array->SetNumberOfTuples(voxels);
    FillWithAnyBits(array, noise);
    image->GetPointData()->AddArray(array);
  }
  vtkNew<vtkBitArray> bits;
  vtkNew<vtkStringArray> strings;
  vtkNew<vtkVariantArray> variants;
  vtkNew<vtkSOADataArrayTemplate<vtkTypeInt64>> byComponent;
  vtkNew<vtkUnsignedCharArray> ghosts;
  vtkNew<vtkIntArray> labels;
  byComponent->SetNumberOfComponents(2);
  byComponent->SetNumberOfTuples(voxels);
  for (vtkIdType v = 0; v < voxels; ++v)
  {
    bits->InsertNextValue(noise.Next() & 1);
    strings->InsertNextValue(std::to_string(noise.Next()));
    variants->InsertNextValue(vtkVariant(static_cast<int>(noise.Next())));
    ghosts->InsertNextValue(0);
    labels->InsertNextValue(noise.Next() % 5);
    byComponent->SetTypedComponent(v, 0, (vtkTypeInt64(noise.Next()) << 32) | noise.Next());
    byComponent->SetTypedComponent(v, 1, -(vtkTypeInt64(noise.Next()) << 31) - 1);
  }
  const std::pair<vtkAbstractArray*, const char*> arrays[] = { { bits, "bits" }, { strings, "strings" },
    { variants, "variants" }, { byComponent, "byComponent" }, { ghosts, vtkDataSetAttributes::GhostArrayName() },
    { labels, "labels" } };
  for (const auto& array : arrays)
  {
    array.first->SetName(array.second);
    image->GetPointData()->AddArray(array.first);
  }
}

/// Every array of `input` is in `output`, with the same bits.
void CheckIdentity(Checks& check, vtkImageData* input, vtkImageData* output, const std::string& where)
{
  vtkPointData* in = input->GetPointData();
  vtkPointData* out = output->GetPointData();
  check.Equal(out->GetNumberOfArrays(), in->GetNumberOfArrays(), where + ": number of arrays");
  for (int a = 0; a < in->GetNumberOfArrays(); ++a)
  {
    check.That(SameBits(out->GetAbstractArray(in->GetArrayName(a)), in->GetAbstractArray(a)),
      where + ": array " + in->GetArrayName(a));
  }
  check.That(out->GetScalars() && std::string(out->GetScalars()->GetName()) == in->GetScalars()->GetName(),
    where + ": active scalars");
  for (int a = 0; a < 3; ++a)
  {
    check.Equal(output->GetOrigin()[a], input->GetOrigin()[a], where + ": origin");
    check.Equal(output->GetSpacing()[a], input->GetSpacing()[a], where + ": spacing");
  }
}

/// The part of a padded output that is the input's grid, against the input; around it, the background.
void CheckPadded(Checks& check, vtkImageData* input, vtkImageData* output, int padding, const std::string& where)
{
  int in[6];
  int out[6];
  input->GetExtent(in);
  output->GetExtent(out);
  for (int a = 0; a < 3; ++a)
  {
    const int expected = in[2 * a + 1] > in[2 * a] ? padding : 0; // a slice stays a slice
    check.Equal(out[2 * a], in[2 * a] - expected, where + ": lower extent");
    check.Equal(out[2 * a + 1], in[2 * a + 1] + expected, where + ": upper extent");
  }
  for (int a = 0; a < input->GetPointData()->GetNumberOfArrays(); ++a)
  {
    vtkAbstractArray* from = input->GetPointData()->GetAbstractArray(a);
    vtkAbstractArray* to = output->GetPointData()->GetAbstractArray(from->GetName());
    if (!to || to->GetDataType() != from->GetDataType())
    {
      check.That(false, where + ": padded array " + from->GetName());
      continue;
    }
    // Cropped back, the array is the input's.
    auto cropped = vtkSmartPointer<vtkAbstractArray>::Take(from->NewInstance());
    cropped->SetName(from->GetName());
    cropped->SetNumberOfComponents(from->GetNumberOfComponents());
    cropped->SetNumberOfTuples(from->GetNumberOfTuples());
    auto interleaved = vtkSmartPointer<vtkAbstractArray>::Take(to->NewInstance());
    interleaved->SetNumberOfComponents(to->GetNumberOfComponents());
    interleaved->SetNumberOfTuples(from->GetNumberOfTuples());
    interleaved->SetName(from->GetName());
    vtkIdType id = 0;
    for (int k = in[4]; k <= in[5]; ++k)
    {
      for (int j = in[2]; j <= in[3]; ++j)
      {
        for (int i = in[0]; i <= in[1]; ++i, ++id)
        {
          int ijk[3] = { i, j, k };
          interleaved->SetTuple(id, output->ComputePointId(ijk), to);
        }
      }
    }
    check.That(SameBits(interleaved, from), where + ": padded array " + from->GetName());
  }
}

/// Unlike the scalars, which have to be tissue, air and finite.
void FillScan(vtkImageData* image, Noise& noise)
{
  vtkDataArray* scalars = image->GetPointData()->GetScalars();
  for (vtkIdType v = 0; v < scalars->GetNumberOfTuples(); ++v)
  {
    for (int c = 0; c < scalars->GetNumberOfComponents(); ++c)
    {
      scalars->SetComponent(v, c, noise.Next() % 100);
    }
  }
}

}

int TestChainMailIdentity(int, char*[])
{
  Checks check;
  Noise noise(1);

  const std::array<int, 6> extents[] = { { { 0, 8, 0, 6, 0, 4 } }, { { -3, 4, 7, 12, 100, 105 } },
    { { 0, 16, 0, 10, 3, 3 } }, { { 5, 5, 0, 12, 0, 9 } }, { { 0, 6, -2, -2, 0, 9 } }, { { 4, 4, 5, 5, 0, 20 } },
    { { 0, 33, 0, 2, 0, 2 } } };

  // Every type as the scalars, in every kind of extent.
  for (int type : types)
  {
    for (const auto& extent : extents)
    {
      for (int components : { 1, 3 })
      {
        auto image = MakeImage(extent, type, components);
        image->SetOrigin(10.0, -20.0, 1000.0);
        image->SetSpacing(0.7, 1.0, 2.5);
        FillScan(image, noise);
        vtkNew<vtkChainMailDeformation> filter;
        filter->SetInputData(image);
        filter->SetTissueThreshold(30.0);
        filter->SetMaterialFunction(ConstantMaterial(0.2));
        filter->Update();
        const std::string where = "scalars of type " + std::string(image->GetScalarTypeAsString()) + ", " +
                                  std::to_string(components) + " components, extent from " + std::to_string(extent[0]);
        CheckIdentity(check, image, filter->GetOutput(), where);
        check.Equal(Field(filter->GetOutput(), "DisplacedElements"), 0.0, where + ": nothing moved");
      }
    }
  }

  // All kinds of arrays at once, without and with cuts, and with a probe that holds.
  for (const auto& extent : extents)
  {
    auto image = MakeImage(extent, VTK_FLOAT);
    FillScan(image, noise);
    AddArrays(image, noise);
    double centre[3];
    image->GetCenter(centre);
    vtkNew<vtkSphereSource> closed;
    closed->SetCenter(centre[0] + 0.1, centre[1] + 0.2, centre[2] + 0.3);
    closed->SetRadius(3.3);
    const double x = centre[0] + 0.25;
    auto blade =
      MakeBlade({ { { { x, centre[1] - 100.0, centre[2] - 100.0 } }, { { x, centre[1] + 100.0, centre[2] - 100.0 } },
        { { x, centre[1] + 100.0, centre[2] + 100.0 } }, { { x, centre[1] - 100.0, centre[2] + 100.0 } } } });
    const std::string where = "all arrays, extent from " + std::to_string(extent[0]);

    vtkNew<vtkChainMailDeformation> filter;
    filter->SetInputData(image);
    filter->SetTissueThreshold(20.0);
    filter->SetMaterialFunction(ConstantMaterial(0.3));
    filter->AddLabelArray("labels");
    filter->Update();
    CheckIdentity(check, image, filter->GetOutput(), where);
    filter->AddInputConnection(2, closed->GetOutputPort());
    filter->Update();
    CheckIdentity(check, image, filter->GetOutput(), where + ", closed cut");
    filter->AddInputDataObject(2, blade);
    filter->Update();
    CheckIdentity(check, image, filter->GetOutput(), where + ", closed and plane cut");
    filter->SetInputDataObject(1, MakeProbes({ { { { centre[0], centre[1], centre[2] } }, {}, 3.0, true } }));
    filter->Update();
    CheckIdentity(check, image, filter->GetOutput(), where + ", held");
    filter->SetOutputPadding(2);
    filter->Update();
    CheckPadded(check, image, filter->GetOutput(), 2, where);
  }

  // Around a probe whose wave dies out, bits stay; near it, they change.
  {
    auto image = MakeImage({ { 0, 40, 0, 8, 0, 8 } }, VTK_FLOAT);
    FillScan(image, noise);
    AddArrays(image, noise);
    vtkNew<vtkChainMailDeformation> filter;
    filter->SetInputData(image);
    filter->SetTissueThreshold(-1.0);
    filter->SetMaterialFunction(ConstantMaterial(0.4));
    filter->SetRelaxationIterations(0);
    filter->SetInputDataObject(1, MakeProbes({ { { { 5.0, 4.0, 4.0 } }, { { 2.0, 0.0, 0.0 } } } }));
    filter->Update();
    vtkImageData* output = filter->GetOutput();
    for (int a = 0; a < image->GetPointData()->GetNumberOfArrays(); ++a)
    {
      vtkAbstractArray* from = image->GetPointData()->GetAbstractArray(a);
      vtkAbstractArray* to = output->GetPointData()->GetAbstractArray(from->GetName());
      vtkIdType changedNear = 0;
      vtkIdType changedFar = 0;
      for (vtkIdType p = 0; p < image->GetNumberOfPoints(); ++p)
      {
        // A displacement of 2 voxels reaches 2 / 0.4 = 5 links; the resampling one cell more, plus 2 for where it
        // lands.
        const bool near = image->GetPoint(p)[0] < 5.0 + 5.0 + 1.0 + 2.0;
        for (int c = 0; c < from->GetNumberOfComponents(); ++c)
        {
          const vtkIdType v = p * from->GetNumberOfComponents() + c;
          (near ? changedNear : changedFar) += ValueText(from, v) != ValueText(to, v);
        }
      }
      check.Equal(changedFar, 0, std::string("far from the probe, array ") + from->GetName());
      const bool constant = std::string(from->GetName()) == vtkDataSetAttributes::GhostArrayName();
      check.That(constant || changedNear > 0, std::string("near the probe, array ") + from->GetName() + " changes");
    }
  }

  // Field data stays, cell data goes.
  {
    auto image = MakeImage({ { 0, 4, 0, 4, 0, 4 } });
    FillScan(image, noise);
    vtkNew<vtkIntArray> cells;
    cells->SetName("cells");
    cells->SetNumberOfTuples(image->GetNumberOfCells());
    image->GetCellData()->AddArray(cells);
    vtkNew<vtkStringArray> patient;
    patient->SetName("Patient");
    patient->InsertNextValue("anonymous");
    image->GetFieldData()->AddArray(patient);
    vtkNew<vtkChainMailDeformation> filter;
    filter->SetInputData(image);
    filter->Update();
    for (int port : { 0, 1 })
    {
      auto* output = vtkImageData::SafeDownCast(filter->GetOutputDataObject(port));
      check.That(output->GetFieldData()->HasArray("Patient"), "field data is passed on");
      check.Equal(output->GetCellData()->GetNumberOfArrays(), 0, "cell data is not passed on");
    }
  }
  return check.Finish();
}
