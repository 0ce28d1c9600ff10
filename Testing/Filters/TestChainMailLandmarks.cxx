// SPDX-License-Identifier: BSD-3-Clause
// Pairs of landmarks become probes: by order, by label, from one list with an array, from tables; what cannot be paired
// is an error, and what looks mixed up a warning.

#include "FilterTest.h"

#include "vtkChainMailLandmarks.h"
#include "vtkFloatArray.h"
#include "vtkIntArray.h"
#include "vtkTable.h"

#include <limits>

using namespace FilterTest;

namespace
{

vtkSmartPointer<vtkPolyData> MakeList(const std::vector<Vector>& places, const std::vector<std::string>& labels = {})
{
  auto data = vtkSmartPointer<vtkPolyData>::New();
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  vtkNew<vtkStringArray> names;
  names->SetName("Label");
  for (const Vector& place : places)
  {
    points->InsertNextPoint(place.data());
  }
  for (const std::string& label : labels)
  {
    names->InsertNextValue(label);
  }
  data->SetPoints(points);
  if (!labels.empty())
  {
    data->GetPointData()->AddArray(names);
  }
  return data;
}

template <typename ArrayType>
void AddColumn(vtkTable* table, const char* name, int components, const std::vector<double>& values)
{
  vtkNew<ArrayType> column;
  column->SetName(name);
  column->SetNumberOfComponents(components);
  for (std::size_t n = 0; n < values.size(); ++n)
  {
    column->InsertNextValue(static_cast<typename ArrayType::ValueType>(values[n]));
  }
  table->AddColumn(column);
}

}

int TestChainMailLandmarks(int, char*[])
{
  Checks check;
  vtkNew<vtkChainMailLandmarks> filter;
  EventLog log(filter);
  check.Equal(filter->GetRadius(), 0.0, "default radius");
  check.Equal(filter->GetTolerance(), 0.0, "default tolerance");
  check.That(!filter->GetMatchLabels(), "default order");
  check.Equal(std::string(filter->GetTargetArray()), std::string(), "default target array");
  filter->SetRadius(-1.0);
  filter->SetTolerance(-1.0);
  check.That(filter->GetRadius() == 0.0 && filter->GetTolerance() == 0.0, "ranges");

  const auto expect = [&](const std::vector<Vector>& places, const std::vector<Vector>& ways, const std::string& where)
  {
    filter->Update();
    check.Equal(log.TakeErrors(), std::string(), where);
    vtkPolyData* output = filter->GetOutput();
    check.Equal(output->GetNumberOfPoints(), static_cast<vtkIdType>(places.size()), where);
    check.Equal(output->GetNumberOfVerts(), static_cast<vtkIdType>(places.size()), where);
    vtkDataArray* displacement = output->GetPointData()->GetArray("Displacement");
    check.That(displacement && displacement->GetNumberOfComponents() == 3, where);
    for (std::size_t n = 0; displacement && n < places.size(); ++n)
    {
      Vector place;
      Vector way;
      output->GetPoint(static_cast<vtkIdType>(n), place.data());
      displacement->GetTuple(static_cast<vtkIdType>(n), way.data());
      check.That(place == places[n] && way == ways[n], where + ", pair " + std::to_string(n));
    }
    for (const char* const name : { "Radius", "Tolerance" })
    {
      vtkDataArray* array = output->GetPointData()->GetArray(name);
      const double expected = name[0] == 'R' ? filter->GetRadius() : filter->GetTolerance();
      check.That(array && array->GetNumberOfTuples() == static_cast<vtkIdType>(places.size()) &&
                   array->GetRange()[0] == expected && array->GetRange()[1] == expected,
        where + ": " + name);
    }
  };
  const auto expectError = [&](const std::string& part, const std::string& where)
  {
    filter->Update();
    check.Contains(log.TakeErrors(), part, where);
    check.Equal(filter->GetOutput()->GetNumberOfPoints(), vtkIdType(0), where + ": nothing comes of it");
  };

  // By order.
  const std::vector<Vector> from = { { { 1, 2, 3 } }, { { 4, 6, 8 } }, { { -7, 0.5, 100 } } };
  const std::vector<Vector> to = { { { 2, 2, 3 } }, { { 4, 8, 8 } }, { { -7, 0.5, 97 } } };
  const std::vector<Vector> ways = { { { 1, 0, 0 } }, { { 0, 2, 0 } }, { { 0, 0, -3 } } };
  filter->SetInputData(MakeList(from));
  filter->SetToData(MakeList(to));
  filter->SetRadius(2.5);
  filter->SetTolerance(1.25);
  expect(from, ways, "by order");
  check.Equal(log.TakeWarnings(), std::string(), "by order");
  check.Contains(
    filter->GetReport(), "3 pairs. Displacements: 2 mm on average, at most 3 mm (landmark 3 of From).", "report");
  check.That(!filter->GetOutput()->GetPointData()->GetAbstractArray("Label"), "no labels");

  // By label.
  filter->SetInputData(MakeList(from, { "a", "b", "c" }));
  filter->SetToData(MakeList({ to[2], to[0], to[1] }, { "c", "a", "b" }));
  filter->Update();
  check.Contains(log.TakeWarnings(), "same labels in another order", "shuffled");
  filter->MatchLabelsOn();
  expect(from, ways, "by label");
  check.Equal(log.TakeWarnings(), std::string(), "by label");
  auto* labels = vtkStringArray::SafeDownCast(filter->GetOutput()->GetPointData()->GetAbstractArray("Label"));
  check.That(labels && labels->GetValue(2) == "c", "labels are kept");
  filter->SetToData(MakeList({ to[2], to[0], from[0], from[0] }, { "c", "a", "d", "e" }));
  expect({ from[0], from[2] }, { ways[0], ways[2] }, "some alone");
  check.Contains(log.TakeWarnings(), "only one of From and To has them: \"b\", \"d\", \"e\".", "some alone");
  filter->SetToData(MakeList({ to[2], to[0] }, { "c", "c" }));
  expectError("Two landmarks of To have the label \"c\"", "a label twice");
  filter->SetToData(MakeList({ to[2], to[0] }, { "x", "y" }));
  expectError("no label in common. From has a, b, c; To has x, y.", "none in common");
  filter->SetToData(MakeList(to));
  expectError("To has no array Label", "no labels");
  filter->MatchLabelsOff();
  expect(from, ways, "and by order again");

  // What cannot be paired.
  filter->SetToData(MakeList({ to[0], to[1] }));
  expectError("From has 3 landmarks and To has 2", "unequal");
  filter->SetToData(MakeList({ to[0], { { 0, std::nan(""), 0 } }, to[2] }));
  expectError("position of landmark 2 of To is (0, nan, 0); it must be finite", "NaN");
  filter->SetToData(MakeList(to));
  filter->SetInputData(
    MakeList({ from[0], from[1], { { std::numeric_limits<double>::infinity(), 0, 0 } } }, { "p", "q", "r" }));
  expectError("position of landmark 3 (r) of From is (inf, 0, 0); it must be finite", "infinite");
  filter->SetInputData(MakeList({}));
  expectError("From has no landmarks", "none");
  vtkNew<vtkPolyData> nothing;
  filter->SetInputData(nothing);
  expectError("From has no landmarks", "no points at all");
  filter->SetInputData(MakeList(from));
  filter->SetToConnection(nullptr);
  expectError("Connect a second list as To", "no targets");
  filter->SetTargetArray("Goal");
  expectError("TargetArray is \"Goal\", but From has no such point array", "no such array");

  // One list with an array, of any type.
  auto both = MakeList(from);
  vtkNew<vtkFloatArray> goal;
  goal->SetName("Goal");
  goal->SetNumberOfComponents(3);
  for (const Vector& place : to)
  {
    goal->InsertNextTuple(place.data());
  }
  both->GetPointData()->AddArray(goal);
  filter->SetInputData(both);
  expect(from, ways, "one list");
  filter->SetTargetArray("");
  expectError("Connect a second list as To", "another name than Target");
  goal->SetName("Target");
  both->Modified();
  filter->Modified();
  expect(from, ways, "Target");
  vtkNew<vtkIntArray> flat;
  flat->SetName("Target");
  flat->SetNumberOfTuples(3);
  both->GetPointData()->AddArray(flat);
  expectError("has 1 components; it needs 3", "scalars");
  both->GetPointData()->RemoveArray("Target");

  // Tables: columns of one number each, or of three; a label beside them.
  vtkNew<vtkTable> table;
  AddColumn<vtkDoubleArray>(table, "x", 1, { 1, 4, -7 });
  AddColumn<vtkFloatArray>(table, "y", 1, { 2, 6, 0.5 });
  AddColumn<vtkIntArray>(table, "id", 1, { 11, 12, 13 });
  AddColumn<vtkIntArray>(table, "z", 1, { 3, 8, 100 });
  filter->SetInputData(table);
  filter->SetToData(MakeList(to));
  expect(from, ways, "table and points");
  filter->SetToConnection(nullptr);
  expectError("Connect a second list as To", "a table of places");
  AddColumn<vtkDoubleArray>(table, "goal", 3, { 2, 2, 3, 4, 8, 8, -7, 0.5, 97 });
  table->Modified(); // which AddColumn() does not say
  expect(from, ways, "a table of pairs");
  check.Contains(filter->GetReport(), "landmark 3 (13)", "its labels");
  AddColumn<vtkDoubleArray>(table, "more", 1, { 1, 1, 1 });
  table->Modified();
  expectError("has 7 numbers in each row", "too many");

  // Axes mixed up. Lists that fit stay without a warning, also where all is moved far or turned a little.
  Noise noise(5);
  std::vector<Vector> places;
  std::vector<Vector> moved;
  std::vector<Vector> mirrored;
  for (int n = 0; n < 20; ++n)
  {
    const Vector p = { { 200 * noise.Uniform() - 300, 150 * noise.Uniform(), 300 * noise.Uniform() } };
    const double angle = 0.5;
    const Vector q = { { std::cos(angle) * p[0] - std::sin(angle) * p[1] + 100,
      std::sin(angle) * p[0] + std::cos(angle) * p[1], p[2] + 10 * noise.Uniform() } };
    places.push_back(p);
    moved.push_back(q);
    mirrored.push_back({ { -q[0], -q[1], q[2] } });
  }
  filter->SetInputData(MakeList(places));
  filter->SetToData(MakeList(moved));
  filter->Update();
  check.Equal(log.TakeErrors() + log.TakeWarnings(), std::string(), "moved and turned by 29 degrees");
  filter->SetToData(MakeList(mirrored));
  filter->Update();
  check.Equal(log.TakeErrors(), std::string(), "mixed up is no error");
  check.Contains(log.TakeWarnings(), "LPS axes", "mixed up");
  check.Contains(filter->GetReport(), "LPS axes", "mixed up");
  check.Equal(filter->GetOutput()->GetNumberOfPoints(), vtkIdType(20), "mixed up");

  std::ostringstream text;
  filter->PrintSelf(text, vtkIndent());
  for (const char* const line :
    { "TargetArray: \n", "MatchLabels: Off", "Radius: 2.5", "Tolerance: 1.25", "Report: 20" })
  {
    check.Contains(text.str(), line, "PrintSelf");
  }
  return check.Finish();
}
