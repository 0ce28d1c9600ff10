#include "ExactGeometry.h"

#include "Error.h"

#include <cmath>

namespace chainmail
{

namespace
{

constexpr double farthest = 1 << 26; // in voxels; keeps every product below within 128 bits

Fixed3 minus(const Fixed3& a, const Fixed3& b)
{
  return { a[0] - b[0], a[1] - b[1], a[2] - b[2] };
}

std::array<Wide, 3> cross(const Fixed3& a, const Fixed3& b)
{
  const auto minor = [&](int x, int y) { return Wide(a[x]) * b[y] - Wide(a[y]) * b[x]; };
  return { minor(1, 2), minor(2, 0), minor(0, 1) };
}

Wide dot(const std::array<Wide, 3>& a, const Fixed3& b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// The sign of `value` or, where that is zero, of its change under the shift (e, e^2, e^3), given its gradient.
int sign(Wide value, const std::array<Wide, 3>& gradient)
{
  for (const Wide v : { value, gradient[0], gradient[1], gradient[2] })
  {
    if (v != 0)
    {
      return v > 0 ? 1 : -1;
    }
  }
  return 0;
}

}

Fixed3 fixed(const Vector3& voxel)
{
  return { std::llround(voxel[0] * unitsPerVoxel), std::llround(voxel[1] * unitsPerVoxel),
    std::llround(voxel[2] * unitsPerVoxel) };
}

std::vector<Fixed3> fixedPoints(const Surface& surface, const Grid& grid, const std::string& name)
{
  std::vector<Fixed3> points;
  points.reserve(surface.points.size());
  for (std::size_t n = 0; n < surface.points.size(); ++n)
  {
    Vector3 voxel;
    for (int a = 0; a < 3; ++a)
    {
      voxel[a] = surface.points[n][a] / grid.spacing[a];
      if (!(std::fabs(voxel[a]) < farthest))
      {
        throw InputError("Point " + std::to_string(n) + " of the " + name +
                         " is not finite or is millions of voxels away from the image: give a " + name +
                         " near the image.");
      }
    }
    points.push_back(fixed(voxel));
  }
  for (const std::array<int, 3>& ids : surface.triangles)
  {
    for (const int id : ids)
    {
      if (id < 0 || static_cast<std::size_t>(id) >= points.size())
      {
        throw InputError("A triangle of the " + name + " names point " + std::to_string(id) + ", but there are only " +
                         std::to_string(points.size()) + ".");
      }
    }
  }
  return points;
}

ExactTriangle::ExactTriangle(const std::array<Fixed3, 3>& corners)
  : corner(corners)
  , normal(cross(minus(corners[1], corners[0]), minus(corners[2], corners[0])))
{
}

bool ExactTriangle::degenerate() const
{
  return this->normal[0] == 0 && this->normal[1] == 0 && this->normal[2] == 0;
}

int ExactTriangle::side(const Fixed3& place) const
{
  return sign(dot(this->normal, minus(place, this->corner[0])), this->normal);
}

bool ExactTriangle::meetsLine(const Fixed3& place, const Fixed3& along) const
{
  int turns[3];
  for (int e = 0; e < 3; ++e)
  {
    const Fixed3& a = this->corner[e];
    const Fixed3& b = this->corner[(e + 1) % 3];
    turns[e] = sign(dot(cross(minus(a, place), minus(b, place)), along), cross(minus(a, b), along));
  }
  return turns[0] == turns[1] && turns[1] == turns[2];
}

bool ExactTriangle::crosses(const Fixed3& from, const Fixed3& to) const
{
  return this->side(from) != this->side(to) && this->meetsLine(from, minus(to, from));
}

}
