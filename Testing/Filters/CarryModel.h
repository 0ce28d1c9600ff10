// SPDX-License-Identifier: BSD-3-Clause
// Models at rest that are made by hand, for the tests of what carries things along.

#ifndef CarryModel_h
#define CarryModel_h

#include "FilterTest.h"

#include "vtkFloatArray.h"

namespace FilterTest
{

/// An oblique grid of odd spacing whose extent begins anywhere.
struct Space
{
  Vector Origin{ { -40.0, 12.0, 7.0 } };
  Vector Spacing{ { 1.5, 0.75, 2.0 } };
  std::array<double, 9> Direction; // its columns are the axes
  std::array<int, 3> First{ { -3, 5, 2 } };
  std::array<int, 3> Size{ { 12, 14, 10 } };

  Space()
  {
    const double c = std::cos(0.5), s = std::sin(0.5);
    this->Direction = { { c, -s * 0.8, s * 0.6, s, c * 0.8, -c * 0.6, 0.0, 0.6, 0.8 } };
  }

  /// The place of a voxel, counted from the first one.
  Vector World(const Vector& voxel) const
  {
    Vector world = this->Origin;
    for (int a = 0; a < 3; ++a)
    {
      for (int b = 0; b < 3; ++b)
      {
        world[a] += this->Direction[3 * a + b] * this->Spacing[b] * (this->First[b] + voxel[b]);
      }
    }
    return world;
  }

  Vector WorldVector(const Vector& voxels) const
  {
    const Vector from = this->World({ { 0, 0, 0 } });
    Vector to = this->World(voxels);
    for (int a = 0; a < 3; ++a)
    {
      to[a] -= from[a];
    }
    return to;
  }

  vtkSmartPointer<vtkImageData> Image() const
  {
    auto image = vtkSmartPointer<vtkImageData>::New();
    image->SetExtent(this->First[0], this->First[0] + this->Size[0] - 1, this->First[1],
      this->First[1] + this->Size[1] - 1, this->First[2], this->First[2] + this->Size[2] - 1);
    image->SetOrigin(this->Origin.data());
    image->SetSpacing(this->Spacing.data());
    image->SetDirectionMatrix(this->Direction.data());
    return image;
  }

  vtkIdType Id(int i, int j, int k) const { return i + this->Size[0] * (j + this->Size[1] * vtkIdType(k)); }

  template <typename F> void Each(const F& f) const
  {
    for (int k = 0; k < this->Size[2]; ++k)
    {
      for (int j = 0; j < this->Size[1]; ++j)
      {
        for (int i = 0; i < this->Size[0]; ++i)
        {
          f(i, j, k);
        }
      }
    }
  }
};

/// A model at rest, with displacements given in voxels.
struct Model
{
  Space S;
  std::vector<Vector> U;
  std::vector<unsigned char> Element;
  std::vector<unsigned char> Links; // empty: the array is not there

  explicit Model(const Space& space)
    : S(space)
    , U(static_cast<std::size_t>(space.Size[0]) * space.Size[1] * space.Size[2])
    , Element(this->U.size(), 1)
  {
  }

  /// All links between elements.
  void LinkAll()
  {
    this->Links.assign(this->U.size(), 0);
    this->S.Each(
      [&](int i, int j, int k)
      {
        const int at[3] = { i, j, k };
        for (int a = 0; a < 3; ++a)
        {
          const vtkIdType from = this->S.Id(i, j, k), to = this->S.Id(i + (a == 0), j + (a == 1), k + (a == 2));
          if (at[a] + 1 < this->S.Size[a] && this->Element[from] && this->Element[to])
          {
            this->Links[from] |= 2 << 2 * a;
            this->Links[to] |= 1 << 2 * a;
          }
        }
      });
  }

  /// Cuts all links between x and x + 1.
  void CutAcrossX(int x)
  {
    this->S.Each([&](int i, int j, int k) { this->Links[this->S.Id(i, j, k)] &= i == x ? ~2 : i == x + 1 ? ~1 : ~0; });
  }

  vtkSmartPointer<vtkImageData> Image() const
  {
    auto image = this->S.Image();
    vtkNew<vtkFloatArray> displacement;
    displacement->SetName("Displacement");
    displacement->SetNumberOfComponents(3);
    vtkNew<vtkUnsignedCharArray> element;
    element->SetName("Element");
    vtkNew<vtkUnsignedCharArray> links;
    links->SetName("Links");
    for (std::size_t v = 0; v < this->U.size(); ++v)
    {
      displacement->InsertNextTuple(this->S.WorldVector(this->U[v]).data());
      element->InsertNextValue(this->Element[v]);
      links->InsertNextValue(this->Links.empty() ? 0 : this->Links[v]);
    }
    image->GetPointData()->SetVectors(displacement);
    image->GetPointData()->AddArray(element);
    if (!this->Links.empty())
    {
      image->GetPointData()->AddArray(links);
    }
    return image;
  }

  /// x + u(x) between the voxels of a block without air and cuts.
  Vector Forward(const Vector& x) const
  {
    Vector y = x;
    int low[3];
    for (int a = 0; a < 3; ++a)
    {
      low[a] = std::min(static_cast<int>(x[a]), this->S.Size[a] - 2);
    }
    for (int n = 0; n < 8; ++n)
    {
      const int p[3] = { n & 1, n >> 1 & 1, n >> 2 };
      double weight = 1.0;
      for (int a = 0; a < 3; ++a)
      {
        const double t = x[a] - low[a];
        weight *= p[a] ? t : 1.0 - t;
      }
      for (int a = 0; a < 3; ++a)
      {
        y[a] += weight * this->U[this->S.Id(low[0] + p[0], low[1] + p[1], low[2] + p[2])][a];
      }
    }
    return y;
  }
};

inline vtkSmartPointer<vtkPolyData> MakePoints(const std::vector<Vector>& places, int type = VTK_DOUBLE)
{
  auto data = vtkSmartPointer<vtkPolyData>::New();
  vtkNew<vtkPoints> points;
  points->SetDataType(type);
  for (const Vector& place : places)
  {
    points->InsertNextPoint(place.data());
  }
  data->SetPoints(points);
  return data;
}

/// A block full of tissue with links strained by up to a third of a voxel, below which nothing folds.
inline Model RandomBlock(unsigned seed)
{
  Model model{ Space() };
  Noise noise(seed);
  for (Vector& u : model.U)
  {
    for (int a = 0; a < 3; ++a)
    {
      u[a] = 4.0 * a - 3.0 + 0.3 * (noise.Uniform() - 0.5);
    }
  }
  return model;
}

}

#endif
