// SPDX-License-Identifier: BSD-3-Clause
// Matrices of bodies become probes that turn: read from the formats of ITK and from tables, along the scan's axes, both
// ways; what the probes say is held against the matrix itself; what is no rotation and shift is refused.

#include "../TemporaryFolder.h"
#include "FilterTest.h"

#include "vtkChainMailMatrices.h"
#include "vtkChainMailMatrixReader.h"
#include "vtkIntArray.h"
#include "vtkTable.h"

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sstream>

using namespace FilterTest;

namespace
{

using Matrix = std::array<double, 16>;
constexpr double pi = 3.14159265358979323846;

Vector Apply(const Matrix& m, const Vector& x)
{
  Vector y;
  for (int a = 0; a < 3; ++a)
  {
    y[a] = m[4 * a] * x[0] + m[4 * a + 1] * x[1] + m[4 * a + 2] * x[2] + m[4 * a + 3];
  }
  return y;
}

/// Rodrigues' formula, of a rotation vector in degrees.
Vector Rotate(const Vector& degrees, const Vector& x)
{
  const double length = std::sqrt(degrees[0] * degrees[0] + degrees[1] * degrees[1] + degrees[2] * degrees[2]);
  if (length == 0.0)
  {
    return x;
  }
  const Vector k = { { degrees[0] / length, degrees[1] / length, degrees[2] / length } };
  const double c = std::cos(length * pi / 180.0);
  const double s = std::sin(length * pi / 180.0);
  const double dot = k[0] * x[0] + k[1] * x[1] + k[2] * x[2];
  const Vector cross = { { k[1] * x[2] - k[2] * x[1], k[2] * x[0] - k[0] * x[2], k[0] * x[1] - k[1] * x[0] } };
  Vector y;
  for (int a = 0; a < 3; ++a)
  {
    y[a] = c * x[a] + s * cross[a] + (1.0 - c) * dot * k[a];
  }
  return y;
}

/// A rotation about an axis through a centre, then a shift.
Matrix Rigid(const Vector& degrees, const Vector& centre, const Vector& shift)
{
  Matrix m{};
  for (int j = 0; j < 4; ++j)
  {
    Vector e = { { 0, 0, 0 } };
    for (int a = 0; a < 3; ++a)
    {
      e[a] = (j == a ? 1.0 : 0.0) - (j == 3 ? centre[a] : 0.0);
    }
    const Vector image = Rotate(degrees, e);
    for (int a = 0; a < 3; ++a)
    {
      m[4 * a + j] = image[a] + (j == 3 ? centre[a] + shift[a] : 0.0);
    }
  }
  m[15] = 1.0;
  return m;
}

std::string Written(const Matrix& m, const char* separator = ",")
{
  std::ostringstream text;
  text.precision(17);
  for (int n = 0; n < 16; ++n)
  {
    text << (n ? separator : "") << m[n];
  }
  return text.str();
}

/// How far what a probe says is from the matrix, at places all about.
double Off(vtkPolyData* probes, vtkIdType row, const Matrix& m)
{
  Vector displacement;
  Vector rotation;
  Vector centre;
  probes->GetPointData()->GetArray("Displacement")->GetTuple(row, displacement.data());
  probes->GetPointData()->GetArray("Rotation")->GetTuple(row, rotation.data());
  probes->GetPointData()->GetArray("Centre")->GetTuple(row, centre.data());
  double off = 0.0;
  for (const Vector& x : { Vector{ { 0, 0, 0 } }, Vector{ { 100, -50, 20 } }, Vector{ { -30, 200, -400 } } })
  {
    const Vector there = Apply(m, x);
    const Vector turned = Rotate(rotation, { { x[0] - centre[0], x[1] - centre[1], x[2] - centre[2] } });
    for (int a = 0; a < 3; ++a)
    {
      off = std::max(off, std::fabs(centre[a] + displacement[a] + turned[a] - there[a]));
    }
  }
  return off;
}

std::string Tfm(const std::string& type, const std::string& parameters, const std::string& fixed = "0 0 0")
{
  return "#Insight Transform File V1.0\n#Transform 0\nTransform: " + type + "\nParameters: " + parameters +
         "\nFixedParameters: " + fixed + "\n";
}

/// A matrix of one column in Matlab's format of level 4, on a little-endian machine.
std::string Mat(const std::string& name, const std::vector<double>& values, bool asFloat = false)
{
  const std::int32_t header[5] = { asFloat ? 10 : 0, static_cast<std::int32_t>(values.size()), 1, 0,
    static_cast<std::int32_t>(name.size() + 1) };
  std::string text(reinterpret_cast<const char*>(header), sizeof(header));
  text.append(name.c_str(), name.size() + 1);
  for (const double value : values)
  {
    const auto single = static_cast<float>(value);
    text.append(asFloat ? reinterpret_cast<const char*>(&single) : reinterpret_cast<const char*>(&value),
      asFloat ? sizeof(single) : sizeof(value));
  }
  return text;
}

}

int TestChainMailMatrices(int, char*[])
{
  Checks check;
  const TemporaryFolder folder;
  const auto write = [&](const std::string& name, const std::string& content)
  {
    const std::string path = (folder.path / name).string();
    std::ofstream(path, std::ios::binary) << content;
    return path;
  };
  vtkNew<vtkChainMailMatrixReader> reader;
  EventLog log(reader);
  check.That(reader->GetWorld() == 0 && reader->GetFileWorld() == 0 && !reader->GetInvert() &&
               reader->GetBody() == -1 && reader->GetPosition()[2] == 0.0,
    "defaults");
  const auto read = [&](const std::string& path, const std::string& where)
  {
    reader->SetFileName(path.c_str());
    reader->Modified(); // the same name may have other contents
    check.Equal(reader->CanReadFile(path.c_str()), 1, where + " can be read");
    reader->Update();
    check.Equal(log.TakeErrors() + log.TakeWarnings(), std::string(), where + ": no error");
    return reader->GetOutput();
  };

  // Transforms of ITK. What they do to three places was worked out by hand.
  struct Case
  {
    const char* Name;
    std::string Content;
    std::vector<std::pair<Vector, Vector>> Moves;
  };
  const double half = std::sqrt(0.5);
  std::ostringstream versor;
  versor.precision(17);
  versor << "0 0 " << half; // a quarter turn about z
  std::ostringstream angles;
  angles.precision(17);
  angles << pi / 2 << ' ' << pi / 2 << " 0 1 2 3";
  const Case cases[] = {
    { "affine.tfm", Tfm("AffineTransform_double_3_3", "0 -1 0 1 0 0 0 0 1 1 2 3", "10 20 30"),
      { { { { 10, 20, 30 } }, { { 11, 22, 33 } } }, { { { 11, 20, 30 } }, { { 11, 23, 33 } } },
        { { { 10, 20, 40 } }, { { 11, 22, 43 } } } } },
    { "offset.txt", Tfm("MatrixOffsetTransformBase_float_3_3", "1 0 0 0 0 -1 0 1 0 0 0 5"),
      { { { { 1, 2, 3 } }, { { 1, -3, 7 } } } } },
    { "versor.tfm", Tfm("VersorRigid3DTransform_double_3_3", versor.str() + " 1 0 0", "1 1 1"),
      { { { { 2, 1, 7 } }, { { 2, 2, 7 } } }, { { { 1, 1, 1 } }, { { 2, 1, 1 } } } } },
    { "turn.tfm", Tfm("VersorTransform_double_3_3", versor.str(), "1 1 1"), { { { { 2, 1, 7 } }, { { 1, 2, 7 } } } } },
    { "quaternion.tfm",
      Tfm("QuaternionRigidTransform_double_3_3", versor.str() + " " + versor.str().substr(4) + " 0 0 4"),
      { { { { 1, 0, 0 } }, { { 0, 1, 4 } } } } },
    { "similarity.tfm", Tfm("Similarity3DTransform_double_3_3", versor.str() + " 1 0 0 1", "1 1 1"),
      { { { { 2, 1, 7 } }, { { 2, 2, 7 } } } } },
    // The z axis: turned about y it is x, which a turn about x leaves; or turned about x it is -y, which y leaves.
    { "euler.tfm", Tfm("Euler3DTransform_double_3_3", angles.str()),
      { { { { 0, 0, 1 } }, { { 2, 2, 3 } } }, { { { 0, 1, 0 } }, { { 1, 2, 4 } } } } },
    { "zyx.tfm", Tfm("Euler3DTransform_double_3_3", angles.str(), "0 0 0 1"),
      { { { { 0, 0, 1 } }, { { 1, 1, 3 } } } } },
    { "shift.tfm", Tfm("TranslationTransform_double_3_3", "1 -2 3", ""), { { { { 4, 5, 6 } }, { { 5, 3, 9 } } } } },
    { "identity.tfm", Tfm("IdentityTransform_double_3_3", "", ""), { { { { 4, 5, 6 } }, { { 4, 5, 6 } } } } },
    // The last one is applied first: a shift by 10 along x, then a quarter turn about z.
    { "composite.tfm",
      "#Insight Transform File V1.0\r\n#Transform 0\r\nTransform: CompositeTransform_double_3_3\r\nParameters:\r\n"
      "FixedParameters:\r\n#Transform 1\r\nTransform: VersorTransform_double_3_3\r\nParameters: " +
        versor.str() +
        "\r\nFixedParameters: 0 0 0\r\n#Transform 2\r\nTransform: TranslationTransform_double_3_3\r\n"
        "Parameters: 10 0 0\r\nFixedParameters:\r\n",
      { { { { 0, 0, 0 } }, { { 0, 10, 0 } } } } },
    { "0GenericAffine.mat",
      Mat("AffineTransform_double_3_3", { 0, -1, 0, 1, 0, 0, 0, 0, 1, 1, 2, 3 }) + Mat("fixed", { 10, 20, 30 }),
      { { { { 11, 20, 30 } }, { { 11, 23, 33 } } } } },
    { "single.mat",
      Mat("AffineTransform_float_3_3", { 0, -1, 0, 1, 0, 0, 0, 0, 1, 1, 2, 3 }, true) +
        Mat("fixed", { 10, 20, 30 }, true),
      { { { { 11, 20, 30 } }, { { 11, 23, 33 } } } } },
  };
  for (const Case& one : cases)
  {
    const std::string path = write(one.Name, one.Content);
    for (const int world : { 0, 1 })
    {
      for (const bool inverted : { false, true })
      {
        const std::string where = one.Name + std::string(world ? " in RAS" : "") + (inverted ? " inverted" : "");
        reader->SetWorld(world);
        reader->SetInvert(inverted);
        vtkPolyData* probes = read(path, where);
        check.Equal(probes->GetNumberOfPoints(), vtkIdType(1), where);
        Vector displacement;
        Vector rotation;
        Vector centre;
        probes->GetPointData()->GetArray("Displacement")->GetTuple(0, displacement.data());
        probes->GetPointData()->GetArray("Rotation")->GetTuple(0, rotation.data());
        probes->GetPointData()->GetArray("Centre")->GetTuple(0, centre.data());
        for (const auto& move : one.Moves)
        {
          Vector from = inverted ? move.second : move.first;
          Vector to = inverted ? move.first : move.second;
          for (int a = 0; a < 2; ++a)
          {
            from[a] *= world ? -1.0 : 1.0;
            to[a] *= world ? -1.0 : 1.0;
          }
          const Vector turned = Rotate(rotation, { { from[0] - centre[0], from[1] - centre[1], from[2] - centre[2] } });
          for (int a = 0; a < 3; ++a)
          {
            check.Near(centre[a] + displacement[a] + turned[a], to[a], 1e-9, where);
          }
        }
        check.Contains(reader->GetReport(), "axes LPS, from the format of ITK", where);
        check.Contains(
          reader->GetReport(), world ? "the signs of x and y were changed" : "nothing was converted", where);
        check.Equal(probes->GetPointData()->GetArray("Body")->GetComponent(0, 0), -1.0, where + ": the body");
      }
    }
  }
  reader->SetWorldToLPS();
  reader->InvertOff();
  // The centre of ITK's transform, and a body given.
  vtkPolyData* probes = read((folder.path / "affine.tfm").string(), "affine");
  check.That(probes->GetPointData()->GetArray("Centre")->GetComponent(0, 2) == 30.0, "ITK's centre");
  check.Equal(probes->GetPoint(0)[0], 0.0, "a body at a place");
  reader->SetPosition(7, 8, 9);
  probes = read((folder.path / "affine.tfm").string(), "affine");
  check.That(probes->GetPoint(0)[0] == 7.0 && probes->GetPoint(0)[2] == 9.0, "a body at another place");
  reader->SetBody(25);
  probes = read((folder.path / "affine.tfm").string(), "affine");
  check.Equal(probes->GetPointData()->GetArray("Body")->GetComponent(0, 0), 25.0, "a body by its label");
  check.Equal(probes->GetPoint(0)[1], 20.0, "is at its centre");

  // Tables and 4 x 4 numbers, of rotations of all sizes.
  const Vector axis = { { 2.0 / 3.0, -1.0 / 3.0, 2.0 / 3.0 } };
  std::vector<Matrix> matrices;
  std::string rows;
  std::string named = "label;a;b;c;d;e;f;g;h;i;j;k;l;m;n;o;p\n";
  for (const double angle : { 0.0, 1e-7, 0.01, 2.0, 5.0, 20.0, 90.0, 179.0, 179.9999, 180.0, 250.0, -30.0 })
  {
    matrices.push_back(
      Rigid({ { angle * axis[0], angle * axis[1], angle * axis[2] } }, { { 30, -200, -1100 } }, { { 1, 2, -3 } }));
    rows += std::to_string(matrices.size() + 24) + "," + Written(matrices.back()) + "\n";
    named += "\"" + std::to_string(matrices.size() + 24) + ".0\";" + Written(matrices.back(), ";") + "\r\n";
  }
  for (const std::string& content : { rows, named })
  {
    probes = read(write("bones.csv", content), "a table");
    check.Equal(probes->GetNumberOfPoints(), static_cast<vtkIdType>(matrices.size()), "a row for each");
    check.Equal(probes->GetNumberOfVerts(), static_cast<vtkIdType>(matrices.size()), "are seen");
    for (std::size_t n = 0; n < matrices.size(); ++n)
    {
      const auto row = static_cast<vtkIdType>(n);
      check.Near(Off(probes, row, matrices[n]), 0.0, 1e-8, "matrix " + std::to_string(n));
      check.Equal(
        probes->GetPointData()->GetArray("Body")->GetComponent(row, 0), 25.0 + static_cast<double>(n), "its body");
      check.That(std::fabs(probes->GetPointData()->GetArray("Matrix")->GetComponent(row, 7) - matrices[n][7]) == 0.0,
        "its matrix is kept");
    }
    check.Contains(reader->GetReport(), "12 matrices; ", "the report");
    check.Contains(reader->GetReport(), "names none", "the report");
    check.Contains(reader->GetReport(), "Rotations up to 180 degrees", "the report");
  }
  const Matrix& five = matrices[4];
  const double angle = [&]
  {
    Vector r;
    probes->GetPointData()->GetArray("Rotation")->GetTuple(4, r.data());
    return std::sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
  }();
  check.Near(angle, 5.0, 1e-9, "degrees");
  // About a point on its axis: what is left is the shift along the axis.
  Vector left;
  probes->GetPointData()->GetArray("Displacement")->GetTuple(4, left.data());
  const double along = 1 * axis[0] + 2 * axis[1] - 3 * axis[2];
  for (int a = 0; a < 3; ++a)
  {
    check.Near(left[a], along * axis[a], 1e-9, "a screw");
  }
  std::string square = Written(five, " ");
  for (int n = 0, blank = 0; n < static_cast<int>(square.size()); ++n)
  {
    square[n] = square[n] == ' ' && ++blank % 4 == 0 ? '\n' : square[n];
  }
  for (const std::string& content :
    { square, "# a comment\n" + square + "\n\n", Written(five, ","), Written(five, "\t") })
  {
    reader->SetFileWorldToRAS();
    reader->SetWorldToLPS();
    probes = read(write("matrix.txt", content), "numbers");
    Matrix other = five;
    for (const int n : { 2, 3, 6, 7, 8, 9 })
    {
      other[n] = -other[n];
    }
    check.Near(Off(probes, 0, other), 0.0, 1e-9, "of other axes");
    reader->SetWorldToRAS();
    reader->Update();
    check.Near(Off(reader->GetOutput(), 0, five), 0.0, 1e-9, "of the same axes");
  }
  reader->SetFileWorldToAsSaid();
  reader->SetWorldToLPS();
  // Few digits: put right, and where the body is the matrix says.
  Matrix rough = five;
  for (double& value : rough)
  {
    value = std::round(value * 1e5) / 1e5;
  }
  probes = read(write("rough.csv", "3," + Written(rough)), "few digits");
  check.Near(Off(probes, 0, five), 0.0, 0.02, "few digits");

  // What is wrong.
  Matrix wrong = five;
  const auto scaled = [&](double x, double y, double z)
  {
    Matrix m = five;
    for (int a = 0; a < 3; ++a)
    {
      m[4 * a] *= x;
      m[4 * a + 1] *= y;
      m[4 * a + 2] *= z;
    }
    return "1," + Written(five) + "\n7," + Written(m) + "\n";
  };
  Matrix transposed = five;
  for (int i = 0; i < 4; ++i)
  {
    for (int j = 0; j < 4; ++j)
    {
      transposed[4 * i + j] = five[4 * j + i];
    }
  }
  wrong[14] = 1.0;
  const std::vector<std::pair<std::string, std::string>> wrongs = {
    { scaled(1.0, 1.01, 1.0), "it scales or shears. The axes become 1, 1.01, 1 times as long" },
    { scaled(1.0, 1.01, 1.0), "line 2" },
    { scaled(1.0, 1.01, 1.0), "(body 7)" },
    { scaled(1.0, 1.01, 1.0), "differs from the identity by 0.0201" },
    { scaled(1.0, 1.0, -1.0), "it mirrors (determinant -1)" },
    { scaled(1.0001, 1.0, 1.0), "it scales or shears" },
    { scaled(0.0, 0.0, 0.0), "it scales or shears" },
    { Written(transposed), "column by column" },
    { Written(wrong), "does not end with the row 0 0 0 1" },
    { "", "is empty" },
    { "1,2,3\n", "line 1 has 3 fields" },
    { "a b c d\n", "the file has no matrix" },
    { "1 0 0 0\n0 1 0 0\n0 0 1 0\n", "the number of rows is 3" },
    { "1 0 0 0\n0 1 0 0\n0 0 x 0\n0 0 0 1", "line 3, field 3: \"x\" is not a number" },
    { "L5," + Written(five), "\"L5\" is not a label" },
    { "-3," + Written(five), "\"-3\" is not a label" },
    { "2.5," + Written(five), "\"2.5\" is not a label" },
    { "4," + Written(five) + "\n4," + Written(five), "Two matrices are for body 4: line 1" },
    { Written(five) + "\n" + Written(five), "not all have a label" },
    { Tfm("AffineTransform_double_3_3", "1 0 0 0 1 0 0 0 1 0 0"), "12 parameters, but the file has 11" },
    { Tfm("AffineTransform_double_3_3", "1 0 0 0 1 0 0 0 1 0 0 x"), "line 4: \"x\" is not a number" },
    { Tfm("AffineTransform_double_2_2", "1 0 0 1 0 0"), "not three-dimensional" },
    { Tfm("ScaleSkewVersor3DTransform_double_3_3", "0 0 0 0 0 0 1 1 1 0 0 0 0 0 0"),
      "Save the transform as an AffineTransform" },
    { Tfm("BSplineTransform_double_3_3", "0"), "cannot be read" },
    { Tfm("AffineTransform_double_3_3", "1.02 0 0 0 1 0 0 0 1 0 0 0"), "it scales or shears" },
    { "#Insight Transform File V1.0\n", "the file has no transform" },
    { "#Insight Transform File V1.0\nParameters: 1\n", "before the first" },
    { Tfm("CompositeTransform_double_3_3", "", ""), "the file has no transform" },
    { Tfm("IdentityTransform_double_3_3", "", "") + Tfm("IdentityTransform_double_3_3", "", ""),
      "the file has 2 transforms" },
    { Mat("AffineTransform_double_3_3", { 1, 0, 0 }).substr(0, 60), "cut off" },
    { Mat("AffineTransform_double_3_3", { 1, 0, 0 }) + "xyz", "cut off" },
    { "\x89HDF\r\n\x1a\n", "Save the transform as text (.tfm)" },
  };
  for (const auto& one : wrongs)
  {
    reader->SetFileName(write("wrong", one.first).c_str());
    reader->Modified();
    reader->Update();
    const std::string errors = log.TakeErrors();
    check.Contains(errors, one.second, one.first.substr(0, 200));
    check.Contains(errors, "wrong\"", "names the file");
    check.Equal(reader->GetOutput()->GetNumberOfPoints(), vtkIdType(0), "nothing comes of it");
  }
  reader->SetFileName((folder.path / "affine.tfm").string().c_str());
  reader->Update();
  check.Equal(log.TakeErrors(), std::string(), "then a right one");
  for (const char* const other : { "x,y,z\n1,2,3\n", "point\n1\n1 2 3\n", "Some text\n", "" })
  {
    check.Equal(reader->CanReadFile(write("other", other).c_str()), 0, std::string("has no matrices: ") + other);
  }

  // A table of VTK's, with the labels: each body turns about its own middle.
  auto labels = MakeImage({ { 2, 11, -3, 6, 0, 7 } }, VTK_UNSIGNED_SHORT);
  labels->SetSpacing(1.5, 2.0, 2.5);
  labels->SetOrigin(30.0, -200.0, -1100.0);
  labels->SetDirectionMatrix(0, -1, 0, 0.6, 0, 0.8, -0.8, 0, 0.6);
  Fill(labels->GetPointData()->GetScalars(), labels,
    [](int i, int j, int k) { return i < 4 && j > 1 ? 25.0 : (i == 9 && k == 7 ? 33.0 : (k == 0 ? 40.0 : 0.0)); });
  vtkNew<vtkTable> table;
  const Matrix first = Rigid({ { 0, 3, 4 } }, { { 1, 2, 3 } }, { { 5, 0, 0 } });
  for (int c = 0; c < 17; ++c)
  {
    vtkNew<vtkDoubleArray> column;
    column->SetName(("c" + std::to_string(c)).c_str());
    column->InsertNextValue(c == 0 ? 33.0 : first[c - 1]);
    column->InsertNextValue(c == 0 ? 25.0 : five[c - 1]);
    table->AddColumn(column);
  }
  vtkNew<vtkChainMailMatrices> filter;
  EventLog filterLog(filter);
  check.That(!filter->GetInvert() && std::string(filter->GetLabelArray()).empty(), "the filter's defaults");
  filter->SetInputData(table);
  filter->Update();
  check.Equal(filterLog.TakeErrors(), std::string(), "a table alone");
  check.Near(Off(filter->GetOutput(), 0, first), 0.0, 1e-9, "a table alone");
  check.Near(Off(filter->GetOutput(), 1, five), 0.0, 1e-9, "a table alone");
  filter->SetLabelsData(labels);
  filter->Update();
  check.Equal(filterLog.TakeErrors(), std::string(), "with labels");
  check.Near(Off(filter->GetOutput(), 0, first), 0.0, 1e-9, "with labels");
  check.Near(Off(filter->GetOutput(), 1, five), 0.0, 1e-9, "with labels");
  Vector sum = { { 0, 0, 0 } };
  int count = 0;
  for (vtkIdType n = 0; n < labels->GetNumberOfPoints(); ++n)
  {
    if (labels->GetPointData()->GetScalars()->GetComponent(n, 0) == 25.0)
    {
      double p[3];
      labels->GetPoint(n, p);
      ++count;
      for (int a = 0; a < 3; ++a)
      {
        sum[a] += p[a];
      }
    }
  }
  for (int a = 0; a < 3; ++a)
  {
    check.Near(filter->GetOutput()->GetPoint(1)[a], sum[a] / count, 1e-9, "the middle of a body");
    check.Equal(filter->GetOutput()->GetPointData()->GetArray("Centre")->GetComponent(1, a),
      filter->GetOutput()->GetPoint(1)[a], "is the centre");
  }
  check.Contains(filter->GetReport(), "2 matrices. Rotations up to 5 degrees", "the filter's report");
  filter->InvertOn();
  filter->Update();
  for (int a = 0; a < 3; ++a)
  {
    // There and back: the point that came from the origin.
    const Vector there = Apply(five, { { 0, 0, 0 } });
    Vector rotation;
    Vector centre;
    Vector displacement;
    filter->GetOutput()->GetPointData()->GetArray("Rotation")->GetTuple(1, rotation.data());
    filter->GetOutput()->GetPointData()->GetArray("Centre")->GetTuple(1, centre.data());
    filter->GetOutput()->GetPointData()->GetArray("Displacement")->GetTuple(1, displacement.data());
    const Vector back = Rotate(rotation, { { there[0] - centre[0], there[1] - centre[1], there[2] - centre[2] } });
    check.Near(centre[a] + displacement[a] + back[a], 0.0, 1e-9, "the way back");
  }
  filter->InvertOff();

  // Of the reader, which has the arrays; a body without a label stays where it is held.
  filter->SetInputConnection(reader->GetOutputPort());
  reader->SetBody(33);
  filter->Update();
  check.Equal(filterLog.TakeErrors(), std::string(), "of the reader");
  check.Near(Off(filter->GetOutput(), 0, Rigid({ { 0, 0, 90 } }, { { 10, 20, 30 } }, { { 1, 2, 3 } })), 0.0, 1e-9,
    "of the reader");
  reader->SetBody(-1);
  filter->Update();
  check.Equal(filter->GetOutput()->GetPoint(0)[1], 8.0, "without a label it is where it was");
  check.Equal(
    filter->GetOutput()->GetPointData()->GetArray("Centre")->GetComponent(0, 1), 20.0, "and so is its centre");

  // What is wrong, of the filter.
  const auto expectError = [&](const std::string& part, const std::string& where)
  {
    filter->Update();
    check.Contains(filterLog.TakeErrors(), part, where);
    check.Equal(filter->GetOutput()->GetNumberOfPoints(), vtkIdType(0), where + ": nothing comes of it");
  };
  reader->SetBody(26);
  expectError("no voxel with the label 26 of point 0", "a body that is not there");
  filter->SetLabelArray("Bones");
  expectError(
    "LabelArray is \"Bones\", but the image of labels has no such point array of one component. It has: Scan.",
    "no such array");
  filter->SetLabelArray("");
  filter->SetInputData(table);
  table->GetColumn(6)->SetVariantValue(1, vtkVariant(0.5));
  table->Modified();
  expectError("row 2 (body 25) is not a rigid motion", "a row that is not rigid");
  vtkArrayDownCast<vtkDoubleArray>(table->GetColumn(6))->SetValue(1, std::nan(""));
  table->Modified();
  filter->Modified();
  expectError("row 2 (body 25) has a number that is not finite", "NaN");
  vtkArrayDownCast<vtkDoubleArray>(table->GetColumn(0))->SetValue(0, 1.5);
  table->Modified();
  filter->Modified();
  expectError("The label of row 1 is 1.5", "a label that is none");
  table->RemoveColumn(16);
  table->Modified();
  filter->Modified();
  expectError("The table has 16 numbers in each row", "a column too few");
  filter->SetInputData(MakeProbes({ { { { 1, 2, 3 } }, { { 0, 0, 0 } } } }));
  expectError("no point arrays Body (a label) and Matrix", "points without matrices");

  std::ostringstream text;
  reader->PrintSelf(text, vtkIndent());
  filter->PrintSelf(text, vtkIndent());
  for (const char* const line : { "FileName: ", "World: LPS", "FileWorld: as said", "Invert: Off", "Body: 26",
         "Position: 7 8 9", "LabelArray: \n", "Report: " })
  {
    check.Contains(text.str(), line, "PrintSelf");
  }
  return check.Finish();
}
