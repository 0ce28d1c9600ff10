#pragma once

#include "Blades.h"
#include "Picture.h"

#include <numeric>

/// A motion of a whole scene: it permutes and flips the axes, moves the scene into a larger grid of air and scales all
/// lengths. The result of the moved scene must be the moved result of the scene.
struct Motion
{
  std::string name;
  chainmail::Index3 axis{ 0, 1, 2 }; ///< axis a of the image is axis axis[a] of the scene
  std::array<bool, 3> flip{};        ///< of the scene's axes
  chainmail::Index3 low{ 0, 0, 0 };  ///< voxels of air before the scene, along the image's axes
  chainmail::Index3 high{ 0, 0, 0 }; ///< voxels of air behind the scene
  double scale = 1.0;                ///< of lengths
  chainmail::Grid from{};            ///< of the scene; set by operator()(Scene)
  chainmail::Vector3 spacing() const
  {
    const auto& h = this->from.spacing;
    return { this->scale * h[this->axis[0]], this->scale * h[this->axis[1]], this->scale * h[this->axis[2]] };
  }

  chainmail::Index3 index(const chainmail::Index3& p) const
  {
    chainmail::Index3 q;
    for (int a = 0; a < 3; ++a)
    {
      const int s = this->axis[a];
      q[a] = this->low[a] + (this->flip[s] ? this->from.size[s] - 1 - p[s] : p[s]);
    }
    return q;
  }
  /// Moves a displacement: a length, or a fraction of the spacing if `lengths` is false.
  template <typename T> std::array<T, 3> vector(const std::array<T, 3>& v, bool lengths = true) const
  {
    std::array<T, 3> w;
    for (int a = 0; a < 3; ++a)
    {
      const int s = this->axis[a];
      w[a] = static_cast<T>((this->flip[s] ? -v[s] : v[s]) * (lengths ? this->scale : 1.0));
    }
    return w;
  }
  chainmail::Vector3 position(const chainmail::Vector3& x) const
  {
    chainmail::Vector3 y;
    for (int a = 0; a < 3; ++a)
    {
      const int s = this->axis[a];
      const double h = this->from.spacing[s];
      y[a] = this->scale * (this->low[a] * h + (this->flip[s] ? (this->from.size[s] - 1) * h - x[s] : x[s]));
    }
    return y;
  }
  int direction(int d) const
  {
    const int s = d / 2;
    const int a = static_cast<int>(std::find(this->axis.begin(), this->axis.end(), s) - this->axis.begin());
    return 2 * a + (this->flip[s] ? 1 - d % 2 : d % 2);
  }
  /// Whether red elements become black ones: the parity of i + j + k changes.
  bool swapsColours() const
  {
    const chainmail::Index3 q = this->index({ 0, 0, 0 });
    return (q[0] + q[1] + q[2]) % 2 != 0;
  }

  Scene operator()(const Scene& scene)
  {
    this->from = scene.grid;
    chainmail::Index3 size;
    for (int a = 0; a < 3; ++a)
    {
      size[a] = this->low[a] + scene.grid.size[this->axis[a]] + this->high[a];
    }
    Scene image(size, 0.0f, scene.components);
    image.grid.spacing = this->spacing();
    image.scalar.assign(image.grid.voxels(), 0.0f);
    scene.each(
      [&](int i, int j, int k)
      {
        const chainmail::Index3 q = this->index({ i, j, k });
        const std::size_t v = scene.grid.at(i, j, k), w = image.grid.at(q[0], q[1], q[2]);
        image.scalar[w] = scene.scalar[v];
        for (int a = 0; a < scene.components; ++a)
        {
          image.constraint[w * scene.components + a] =
            scene.constraint[v * scene.components + (scene.components == 3 ? this->axis[a] : 0)];
        }
      });
    for (int d = 0; d < 6; ++d)
    {
      image.anchors.faces[this->direction(d)] = scene.anchors.faces[d];
    }
    image.anchors.rigid = scene.anchors.rigid;
    return image;
  }
  chainmail::Probe operator()(chainmail::Probe probe) const
  {
    probe.position = this->position(probe.position);
    probe.displacement = this->vector(probe.displacement);
    probe.radius *= this->scale;
    return probe;
  }
  std::vector<chainmail::Probe> operator()(std::vector<chainmail::Probe> probes) const
  {
    for (chainmail::Probe& probe : probes)
    {
      probe = (*this)(probe);
    }
    return probes;
  }
  chainmail::Surface operator()(chainmail::Surface surface) const
  {
    for (chainmail::Vector3& point : surface.points)
    {
      point = this->position(point);
    }
    return surface;
  }
};

/// All eight ways to flip axes and all six to permute them, and some of both at once.
inline std::vector<Motion> mirrorsAndPermutations()
{
  std::vector<Motion> motions;
  for (int bits = 1; bits < 8; ++bits)
  {
    Motion motion;
    motion.flip = { { (bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0 } };
    motion.name =
      std::string("mirrored along ") + (bits & 1 ? "x" : "") + (bits & 2 ? "y" : "") + (bits & 4 ? "z" : "");
    motions.push_back(motion);
  }
  chainmail::Index3 axis{ 0, 1, 2 };
  while (std::next_permutation(axis.begin(), axis.end()))
  {
    Motion motion;
    motion.axis = axis;
    motion.name = "permuted to ";
    for (const int a : axis)
    {
      motion.name += "xyz"[a];
    }
    motions.push_back(motion);
    motion.flip[axis[1]] = true;
    motion.name += std::string(" and mirrored along ") + "xyz"[axis[1]];
    motions.push_back(motion);
  }
  return motions;
}

/// Translations within a larger grid: by multiples of brick sizes and by other numbers, even and odd.
inline std::vector<Motion> translations()
{
  std::vector<Motion> motions;
  for (const chainmail::Index3& low : { chainmail::Index3{ 8, 16, 32 }, chainmail::Index3{ 3, 1, 0 },
         chainmail::Index3{ 5, 2, 7 }, chainmail::Index3{ 1, 0, 0 }, chainmail::Index3{ 4, 9, 2 } })
  {
    Motion motion;
    motion.low = low;
    motion.high = { 2, 0, 5 };
    motion.name =
      "translated by " + std::to_string(low[0]) + ' ' + std::to_string(low[1]) + ' ' + std::to_string(low[2]);
    motions.push_back(motion);
  }
  return motions;
}

inline std::vector<Motion> scalings()
{
  std::vector<Motion> motions;
  for (const int power : { -20, -3, 1, 10, 30 })
  {
    Motion motion;
    motion.scale = std::ldexp(1.0, power);
    motion.name = "scaled by 2^" + std::to_string(power);
    motions.push_back(motion);
  }
  return motions;
}
