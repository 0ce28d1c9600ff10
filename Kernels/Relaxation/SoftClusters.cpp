#include "SoftClusters.h"

#include <algorithm>
#include <array>

namespace chainmail
{

namespace
{

/// Floats for each cluster, as in cluster.clh and rotatingclusters.cl.
constexpr std::size_t floatsOfPlace = 4;
constexpr std::size_t floatsOfRotating = 24;

using Links = std::vector<const SoftLink*>;

/// The sum of the weights, and the weighted mean of the places.
void sumUp(const Links& links, float* out)
{
  double weight = 0.0;
  std::array<double, 3> place{};
  for (const SoftLink* link : links)
  {
    weight += link->weight;
    for (int a = 0; a < 3; ++a)
    {
      place[a] += link->weight * link->place[a];
    }
  }
  out[0] = static_cast<float>(weight);
  for (int a = 0; a < 3; ++a)
  {
    out[1 + a] = weight > 0.0 ? static_cast<float>(place[a] / weight) : 0.0f;
  }
}

/// The sums that rotatingclusters.cl describes.
void sumUp(
  const Links& links, const Grid& grid, const RotatingClusters::Body& body, const cl_float4& proportions, float* out)
{
  const auto restOf = [&](const SoftLink& link)
  {
    const Index3 at = grid.indexOf(link.voxel);
    Vector3 rest;
    for (int a = 0; a < 3; ++a)
    {
      rest[a] = (at[a] - body.middle[a]) * proportions.s[a];
    }
    return rest;
  };
  double weight = 0.0;
  Vector3 rest{};
  Vector3 place{};
  for (const SoftLink* link : links)
  {
    const Vector3 arm = restOf(*link);
    weight += link->weight;
    for (int a = 0; a < 3; ++a)
    {
      rest[a] += link->weight * arm[a];
      place[a] += link->weight * link->place[a] * proportions.s[a];
    }
  }
  if (!(weight > 0.0))
  {
    return;
  }
  out[0] = static_cast<float>(2.0 * weight);
  for (int a = 0; a < 3; ++a)
  {
    rest[a] /= weight;
    place[a] /= weight;
    out[1 + a] = static_cast<float>(rest[a]);
    out[4 + a] = static_cast<float>(place[a]);
  }
  std::array<double, 6> second{};
  std::array<double, 9> mixed{};
  for (const SoftLink* link : links)
  {
    const Vector3 arm = restOf(*link);
    int n = 0;
    for (int a = 0; a < 3; ++a)
    {
      for (int b = 0; b < 3; ++b)
      {
        const double away = arm[b] - rest[b];
        mixed[3 * a + b] += 2.0 * link->weight * (link->place[a] * proportions.s[a] - place[a]) * away;
        if (b >= a)
        {
          second[n++] += 2.0 * link->weight * (arm[a] - rest[a]) * away;
        }
      }
    }
  }
  std::transform(second.begin(), second.end(), out + 7, [](double sum) { return static_cast<float>(sum); });
  std::transform(mixed.begin(), mixed.end(), out + 13, [](double sum) { return static_cast<float>(sum); });
}

}

void SoftClusters::upload(const std::vector<int>& clusters, const std::vector<RotatingClusters::Body>& bodies)
{
  if (!this->bricks_.softLinks())
  {
    return;
  }
  const bool rotate = !bodies.empty();
  const std::size_t row = rotate ? floatsOfRotating : floatsOfPlace;
  std::vector<cl_float> sums(row * clusters.size(), 0.0f);
  for (std::size_t n = 0; n < clusters.size(); ++n)
  {
    const auto links = this->links_.find(clusters[n]);
    if (links != this->links_.end() && rotate)
    {
      sumUp(
        links->second, this->bricks_.model().grid(), bodies[n], this->bricks_.rotations()->proportions, &sums[row * n]);
    }
    else if (links != this->links_.end())
    {
      sumUp(links->second, &sums[row * n]);
    }
  }
  this->sums_ = this->bricks_.context().upload(sums, "the soft probes");
}

}
