#pragma once

#include "Scene.h"

#include <cmath>

/// A sheet z = height(x, y) [mm], with two triangles for each square of edge `step`, nx x ny squares from (lowX, lowY)
/// on.
template <typename F> chainmail::Surface sheet(double lowX, double lowY, double step, int nx, int ny, F&& height)
{
  chainmail::Surface surface;
  for (int j = 0; j <= ny; ++j)
  {
    for (int i = 0; i <= nx; ++i)
    {
      const double x = lowX + step * i, y = lowY + step * j;
      surface.points.push_back({ x, y, height(x, y) });
    }
  }
  for (int j = 0; j < ny; ++j)
  {
    for (int i = 0; i < nx; ++i)
    {
      const int a = j * (nx + 1) + i, b = a + 1, c = a + nx + 1, d = c + 1;
      surface.triangles.push_back({ a, b, d });
      surface.triangles.push_back({ a, d, c });
    }
  }
  return surface;
}

/// A closed sphere, divided by latitude into rings and by longitude into sectors.
inline chainmail::Surface sphere(const chainmail::Vector3& centre, double radius, int rings, int sectors)
{
  chainmail::Surface surface;
  const double pi = std::acos(-1.0);
  surface.points.push_back({ centre[0], centre[1], centre[2] - radius });
  for (int r = 1; r < rings; ++r)
  {
    const double latitude = pi * r / rings - pi / 2;
    for (int s = 0; s < sectors; ++s)
    {
      const double longitude = 2 * pi * s / sectors;
      surface.points.push_back({ centre[0] + radius * std::cos(latitude) * std::cos(longitude),
        centre[1] + radius * std::cos(latitude) * std::sin(longitude), centre[2] + radius * std::sin(latitude) });
    }
  }
  surface.points.push_back({ centre[0], centre[1], centre[2] + radius });
  const int top = static_cast<int>(surface.points.size()) - 1;
  const auto at = [&](int r, int s) { return 1 + (r - 1) * sectors + s % sectors; };
  for (int s = 0; s < sectors; ++s)
  {
    surface.triangles.push_back({ 0, at(1, s + 1), at(1, s) });
    for (int r = 1; r + 1 < rings; ++r)
    {
      surface.triangles.push_back({ at(r, s), at(r, s + 1), at(r + 1, s) });
      surface.triangles.push_back({ at(r, s + 1), at(r + 1, s + 1), at(r + 1, s) });
    }
    surface.triangles.push_back({ top, at(rings - 1, s), at(rings - 1, s + 1) });
  }
  return surface;
}

/// The twelve triangles of an axis-parallel box, facing outwards.
inline chainmail::Surface box(const chainmail::Vector3& low, const chainmail::Vector3& high)
{
  chainmail::Surface surface;
  for (int n = 0; n < 8; ++n)
  {
    surface.points.push_back({ n & 1 ? high[0] : low[0], n & 2 ? high[1] : low[1], n & 4 ? high[2] : low[2] });
  }
  for (const auto& face :
    { std::array<int, 4>{ 0, 2, 6, 4 }, std::array<int, 4>{ 1, 5, 7, 3 }, std::array<int, 4>{ 0, 4, 5, 1 },
      std::array<int, 4>{ 2, 3, 7, 6 }, std::array<int, 4>{ 0, 1, 3, 2 }, std::array<int, 4>{ 4, 6, 7, 5 } })
  {
    surface.triangles.push_back({ face[0], face[2], face[1] });
    surface.triangles.push_back({ face[0], face[3], face[2] });
  }
  return surface;
}

/// A rectangle at x [mm], larger than any grid of these tests.
inline chainmail::Surface planeAcrossX(double x)
{
  return { { { x, -60.0, -50.0 }, { x, 110.0, -50.0 }, { x, -60.0, 110.0 }, { x, 110.0, 110.0 } },
    { { 0, 1, 2 }, { 1, 3, 2 } } };
}

/// Two surfaces as one.
inline chainmail::Surface both(chainmail::Surface a, const chainmail::Surface& b)
{
  const int first = static_cast<int>(a.points.size());
  a.points.insert(a.points.end(), b.points.begin(), b.points.end());
  for (const std::array<int, 3>& t : b.triangles)
  {
    a.triangles.push_back({ t[0] + first, t[1] + first, t[2] + first });
  }
  return a;
}

/// A closed torus around the z axis.
inline chainmail::Surface torus(const chainmail::Vector3& centre, double ring, double tube, int sectors, int sides)
{
  chainmail::Surface surface;
  const double pi = std::acos(-1.0);
  for (int s = 0; s < sectors; ++s)
  {
    for (int t = 0; t < sides; ++t)
    {
      const double a = 2 * pi * s / sectors, b = 2 * pi * t / sides, r = ring + tube * std::cos(b);
      surface.points.push_back(
        { centre[0] + r * std::cos(a), centre[1] + r * std::sin(a), centre[2] + tube * std::sin(b) });
      const auto at = [&](int x, int y) { return x % sectors * sides + y % sides; };
      surface.triangles.push_back({ at(s, t), at(s + 1, t), at(s + 1, t + 1) });
      surface.triangles.push_back({ at(s, t), at(s + 1, t + 1), at(s, t + 1) });
    }
  }
  return surface;
}

/// The triangles without common points, as in STL files.
inline chainmail::Surface soup(const chainmail::Surface& surface)
{
  chainmail::Surface result;
  for (const std::array<int, 3>& t : surface.triangles)
  {
    const int first = static_cast<int>(result.points.size());
    for (const int id : t)
    {
      result.points.push_back(surface.points[id]);
    }
    result.triangles.push_back({ first, first + 1, first + 2 });
  }
  return result;
}

/// With the opposite orientation of every triangle.
inline chainmail::Surface inverted(chainmail::Surface surface)
{
  for (std::array<int, 3>& t : surface.triangles)
  {
    std::swap(t[1], t[2]);
  }
  return surface;
}
