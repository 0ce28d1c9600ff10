// SPDX-License-Identifier: BSD-3-Clause
// Fields of displacements become probes: so many voxels apart, inside a mask of any grid, where the field is finite.

#include "FilterTest.h"

#include "vtkChainMailFieldProbes.h"
#include "vtkFloatArray.h"
#include "vtkIntArray.h"

#include <limits>
#include <map>
#include <set>

using namespace FilterTest;

namespace
{

/// An array with a value of its own at each point.
void AddField(vtkDataSet* data, const char* name, vtkIdType nan = -1)
{
  vtkNew<vtkFloatArray> field;
  field->SetName(name);
  field->SetNumberOfComponents(3);
  for (vtkIdType n = 0; n < data->GetNumberOfPoints(); ++n)
  {
    field->InsertNextTuple3(n, n == nan ? std::numeric_limits<double>::quiet_NaN() : 0.5 * n, -1.0);
  }
  data->GetPointData()->AddArray(field);
}

/// The points of the input that became probes, by what the field had there; they have to lie where these do.
std::set<vtkIdType> Chosen(Checks& check, vtkPolyData* probes, vtkDataSet* input, const std::string& where)
{
  std::set<vtkIdType> chosen;
  vtkDataArray* displacement = probes->GetPointData()->GetArray("Displacement");
  for (vtkIdType n = 0; displacement && n < probes->GetNumberOfPoints(); ++n)
  {
    const auto id = static_cast<vtkIdType>(displacement->GetComponent(n, 0));
    check.That(chosen.insert(id).second, where + ": once");
    check.That(displacement->GetComponent(n, 1) == 0.5 * id && displacement->GetComponent(n, 2) == -1.0, where);
    double rest[3];
    input->GetPoint(id, rest);
    check.That(std::equal(rest, rest + 3, probes->GetPoint(n)), where + ": is where the field is");
  }
  check.Equal(probes->GetNumberOfVerts(), probes->GetNumberOfPoints(), where + ": are seen");
  return chosen;
}

}

int TestChainMailFieldProbes(int, char*[])
{
  Checks check;
  auto image = MakeImage({ { -5, 6, 3, 12, 0, 8 } });
  image->SetSpacing(1.0, 1.5, 3.0);
  image->SetOrigin(10.0, -20.0, 30.0);
  image->SetDirectionMatrix(0, -1, 0, 0.6, 0, 0.8, -0.8, 0, 0.6);
  AddField(image, "Displacement", 17);
  vtkNew<vtkChainMailFieldProbes> filter;
  EventLog log(filter);
  check.That(std::string(filter->GetField()).empty() && std::string(filter->GetMaskArray()).empty() &&
               filter->GetMaskMinimum() == 1.0 && filter->GetSpacing() == 0.0 && filter->GetRadius() == 0.0 &&
               filter->GetTolerance() == 0.0,
    "defaults");
  filter->SetInputData(image);
  const auto update = [&](const std::string& where)
  {
    filter->Update();
    check.Equal(log.TakeErrors() + log.TakeWarnings(), std::string(), where);
    return Chosen(check, filter->GetOutput(), image, where);
  };
  const auto expected = [&](const std::function<bool(int, int, int, const double*)>& takes)
  {
    std::set<vtkIdType> ids;
    for (vtkIdType n = 0; n < image->GetNumberOfPoints(); ++n)
    {
      const int i = static_cast<int>(n % 12) - 5;
      const int j = static_cast<int>(n / 12 % 10) + 3;
      const int k = static_cast<int>(n / 120);
      double place[3];
      image->GetPoint(n, place);
      if (n != 17 && takes(i, j, k, place))
      {
        ids.insert(n);
      }
    }
    return ids;
  };

  check.That(update("all") == expected([](int, int, int, const double*) { return true; }), "all but NaN");
  check.Contains(filter->GetReport(), "1079 probes", "report");
  check.Contains(filter->GetReport(), "0 places outside the mask, 1 without a finite displacement", "report");
  // Steps of 4.4, that is 4, 3 and 1 voxels, counted from index 0.
  filter->SetSpacing(4.4);
  check.That(update("some") == expected([](int i, int j, int, const double*) { return i % 4 == 0 && j % 3 == 0; }),
    "every so many voxels");
  filter->SetSpacing(1e300); // of y index 0 is not part of the image
  check.That(update("none").empty(), "a spacing beyond the image");
  filter->SetSpacing(0.0);

  // Masks: of the same grid, of another one, by value, by name.
  auto mask = MakeImage({ { 0, 4, 0, 4, 0, 4 } }, VTK_FLOAT);
  mask->SetSpacing(3.0, 3.0, 3.0);
  mask->SetOrigin(image->GetPoint(300)[0] - 6.0, image->GetPoint(300)[1] - 6.0, image->GetPoint(300)[2] - 6.0);
  Fill(mask->GetPointData()->GetScalars(), mask,
    [](int i, int j, int k) { return i == 1 ? std::nan("") : (i + j + k) % 3 - 0.5; });
  filter->SetMaskData(mask);
  for (const double minimum : { 1.0, 0.5, -0.5, -10.0, 2.0 })
  {
    filter->SetMaskMinimum(minimum);
    const auto inside = [&](int, int, int, const double* place)
    {
      int ijk[3];
      for (int a = 0; a < 3; ++a)
      {
        ijk[a] = static_cast<int>(std::floor((place[a] - mask->GetOrigin()[a]) / 3.0 + 0.5));
        if (ijk[a] < 0 || ijk[a] > 4)
        {
          return false;
        }
      }
      return ijk[0] != 1 && (ijk[0] + ijk[1] + ijk[2]) % 3 - 0.5 >= minimum;
    };
    const auto ids = expected(inside);
    check.That(minimum > 1.5 ? ids.empty() : !ids.empty(), "the mask says something");
    check.That(update("mask") == ids, "inside the mask, from " + std::to_string(minimum));
  }
  filter->SetMaskArray("Other");
  filter->Update();
  check.Contains(log.TakeErrors(),
    "MaskArray is \"Other\", but the mask has no such point array of one component. It has: Scan.", "no mask");
  filter->SetMaskArray("");
  filter->SetMaskConnection(nullptr);

  // Other arrays.
  filter->SetField("Motion");
  filter->Update();
  check.Contains(log.TakeErrors(),
    "Field is \"Motion\", but the input has no such point array of 3 components. It has: Scan, Displacement.",
    "no field");
  filter->SetField("Scan");
  filter->Update();
  check.Contains(
    log.TakeErrors(), "Field is \"Scan\", but the input has no such point array of 3 components", "scalars");
  filter->SetField("");
  image->GetPointData()->GetArray("Displacement")->SetName("Way");
  image->Modified();
  filter->Modified();
  filter->Update();
  check.Contains(log.TakeErrors(), "neither a point array Displacement", "another name");
  image->GetPointData()->SetActiveVectors("Way");
  image->Modified();
  check.Equal(update("active vectors").size(), std::size_t(1079), "active vectors");

  // A mesh: one point in each cube, the first.
  vtkNew<vtkPolyData> mesh;
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  Noise noise(3);
  for (int n = 0; n < 2000; ++n)
  {
    points->InsertNextPoint(40 * noise.Uniform() - 20, 40 * noise.Uniform() - 20, 10 * noise.Uniform());
  }
  mesh->SetPoints(points);
  AddField(mesh, "Displacement", 3);
  filter->SetInputData(mesh);
  filter->SetSpacing(5.0);
  filter->SetRadius(1.5);
  filter->SetTolerance(0.75);
  filter->Update();
  check.Equal(log.TakeErrors(), std::string(), "a mesh");
  std::map<std::array<int, 3>, vtkIdType> first;
  for (vtkIdType n = 0; n < 2000; ++n)
  {
    const double* p = points->GetPoint(n);
    if (n != 3)
    {
      first.insert({ { { static_cast<int>(std::floor(p[0] / 5)), static_cast<int>(std::floor(p[1] / 5)),
                       static_cast<int>(std::floor(p[2] / 5)) } },
        n });
    }
  }
  std::set<vtkIdType> ids;
  for (const auto& cube : first)
  {
    ids.insert(cube.second);
  }
  check.Equal(ids.size(), std::size_t(128), "all cubes have points");
  check.That(Chosen(check, filter->GetOutput(), mesh, "a mesh") == ids, "one in each cube");
  for (const char* const name : { "Radius", "Tolerance" })
  {
    vtkDataArray* array = filter->GetOutput()->GetPointData()->GetArray(name);
    const double value = name[0] == 'R' ? 1.5 : 0.75;
    check.That(array && array->GetRange()[0] == value && array->GetRange()[1] == value, name);
  }
  vtkNew<vtkPolyData> nothing;
  filter->SetInputData(nothing);
  filter->Update();
  check.Equal(log.TakeErrors(), std::string(), "nothing comes of nothing");
  check.Equal(filter->GetOutput()->GetNumberOfPoints(), vtkIdType(0), "nothing comes of nothing");

  std::ostringstream text;
  filter->PrintSelf(text, vtkIndent());
  for (const char* const line : { "Field: \n", "MaskArray: \n", "MaskMinimum: 2", "Spacing: 5", "Radius: 1.5",
         "Tolerance: 0.75", "Report: 0 probes" })
  {
    check.Contains(text.str(), line, "PrintSelf");
  }
  return check.Finish();
}
