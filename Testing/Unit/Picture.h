#pragma once

#include "Scene.h"

#include <algorithm>
#include <cmath>

/// The output of resample(): an offset and a coverage for each voxel. Unvisited voxels have offset 0 and coverage 1.
struct Picture
{
  chainmail::Index3 first{}; ///< lowest voxel
  chainmail::Index3 size{};
  std::vector<float> offset;
  std::vector<float> coverage;
  std::vector<int> visits;

  std::size_t at(int i, int j, int k) const
  {
    return static_cast<std::size_t>(i - first[0]) +
           static_cast<std::size_t>(size[0]) * ((j - first[1]) + static_cast<std::size_t>(size[1]) * (k - first[2]));
  }
  bool contains(int i, int j, int k) const
  {
    const int p[3] = { i, j, k };
    for (int a = 0; a < 3; ++a)
    {
      if (p[a] < first[a] || p[a] >= first[a] + size[a])
      {
        return false;
      }
    }
    return true;
  }
  chainmail::Vector3 operator()(int i, int j, int k) const
  {
    const float* o = offset.data() + 3 * this->at(i, j, k);
    return { o[0], o[1], o[2] };
  }
  /// The share of a voxel that shows tissue.
  double covered(int i, int j, int k) const { return this->vacated(i, j, k) ? 0.0 : this->coverage[this->at(i, j, k)]; }
  bool vacated(int i, int j, int k) const { return std::isnan(offset[3 * this->at(i, j, k)]); }

  template <typename F> void each(F&& f) const
  {
    for (int k = first[2]; k < first[2] + size[2]; ++k)
    {
      for (int j = first[1]; j < first[1] + size[1]; ++j)
      {
        for (int i = first[0]; i < first[0] + size[0]; ++i)
        {
          f(i, j, k);
        }
      }
    }
  }
};

inline Picture resample(const chainmail::Simulation& simulation, const chainmail::Index3& padding = { 0, 0, 0 },
  chainmail::CutSurfaces cuts = chainmail::CutSurfaces::Stepped, const chainmail::OutputDetail& detail = {})
{
  Picture picture;
  for (int a = 0; a < 3; ++a)
  {
    const int last = simulation.model().grid().size[a] - 1 + padding[a];
    picture.first[a] = detail.finer * std::max(-padding[a], detail.first[a]);
    picture.size[a] = detail.finer * std::min(last, detail.last[a]) - picture.first[a] + 1;
  }
  const std::size_t voxels = static_cast<std::size_t>(picture.size[0]) * picture.size[1] * picture.size[2];
  picture.offset.assign(3 * voxels, 0.0f);
  picture.coverage.assign(voxels, 1.0f);
  picture.visits.assign(voxels, 0);
  simulation.resample(
    padding,
    [&](const std::vector<chainmail::ResampledBox>& boxes)
    {
      for (const chainmail::ResampledBox& box : boxes)
      {
        box.forCovered(
          [&](const chainmail::Index3& voxel, const float* o, float coverage)
          {
            ASSERT_TRUE(picture.contains(voxel[0], voxel[1], voxel[2])) << "a voxel outside of the output";
            const std::size_t v = picture.at(voxel[0], voxel[1], voxel[2]);
            ASSERT_EQ(++picture.visits[v], 1) << "boxes overlap";
            std::copy(o, o + 3, picture.offset.begin() + 3 * v);
            picture.coverage[v] = coverage;
          });
      }
    },
    0, cuts, detail);
  return picture;
}
