#include "Resampling.h"

#include "Measurement.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace chainmail
{

namespace
{

/// Voxels of one box: 16 bytes each on the device.
constexpr std::size_t voxelsPerBox = std::size_t(1) << 22;

/// A brick whose cells may have moved, and the output voxels that they may cover.
struct Source
{
  int brick;
  Index3 first;
  Index3 last;
};

cl_int4 int4(const Index3& v)
{
  return { { v[0], v[1], v[2], 0 } };
}

}

void Resampling::run(const Index3& padding, const std::function<void(double)>& checkpoint,
  const std::function<void(const ResampledBox&)>& visit)
{
  const Grid& grid = this->bricks_.model().grid();
  const Index3 size = this->bricks_.size();

  // A displaced element moves the cells around it, and through the border that follows tissue those one further: all
  // lie in its brick or in the 26 around.
  std::map<int, std::pair<Vector3, Vector3>> moved;
  const std::vector<BrickFigures> figures = measureBricks(this->bricks_);
  for (std::size_t n = 0; n < figures.size(); ++n)
  {
    if (figures[n].displaced == 0.0f)
    {
      continue;
    }
    const int brick = this->bricks_.brick(static_cast<int>(n) + 1);
    for (int z = -1; z <= 1; ++z)
    {
      for (int y = -1; y <= 1; ++y)
      {
        for (int x = -1; x <= 1; ++x)
        {
          auto& range = moved[this->bricks_.beside(brick, x, y, z)];
          for (int a = 0; a < 3; ++a)
          {
            range.first[a] = std::min(range.first[a], static_cast<double>(figures[n].low[a]));
            range.second[a] = std::max(range.second[a], static_cast<double>(figures[n].high[a]));
          }
        }
      }
    }
  }
  std::vector<Source> sources;
  Index3 first = grid.size;
  Index3 last{ -1, -1, -1 };
  for (const auto& [brick, range] : moved)
  {
    const Index3 origin = this->bricks_.origin(brick);
    if (!grid.contains(origin[0], origin[1], origin[2]))
    {
      continue;
    }
    Source source{ brick, {}, {} };
    for (int a = 0; a < 3; ++a)
    {
      // Clamped before the conversion: a displacement may be far larger than any image.
      const double low = origin[a] + std::floor(range.first[a]) - 1;
      const double high = origin[a] + size[a] + std::ceil(range.second[a]) + 1;
      source.first[a] = static_cast<int>(std::max(low, -static_cast<double>(padding[a])));
      source.last[a] = static_cast<int>(std::min(high, static_cast<double>(grid.size[a] - 1 + padding[a])));
      first[a] = std::min(first[a], source.first[a]);
      last[a] = std::max(last[a], source.last[a]);
    }
    sources.push_back(source);
  }
  if (sources.empty())
  {
    return;
  }

  // The kernels must know the tissue that is at rest where other tissue arrives.
  std::set<int> destinations;
  for (const Source& source : sources)
  {
    for (int k = std::max(0, source.first[2]) / size[2]; k * size[2] <= std::min(source.last[2], grid.size[2] - 1); ++k)
    {
      for (int j = std::max(0, source.first[1]) / size[1]; j * size[1] <= std::min(source.last[1], grid.size[1] - 1);
           ++j)
      {
        for (int i = std::max(0, source.first[0]) / size[0]; i * size[0] <= std::min(source.last[0], grid.size[0] - 1);
             ++i)
        {
          destinations.insert(this->bricks_.brickAt(i * size[0], j * size[1], k * size[2]));
        }
      }
    }
  }
  this->bricks_.require({ destinations.begin(), destinations.end() });

  Context& context = this->bricks_.context();
  const Index3 flat{ grid.size[0] == 1, grid.size[1] == 1, grid.size[2] == 1 };
  const std::size_t layer = static_cast<std::size_t>(last[0] - first[0] + 1) * (last[1] - first[1] + 1);
  const int layers = static_cast<int>(std::max<std::size_t>(1, voxelsPerBox / layer));
  std::vector<float> offsets;
  for (int z = first[2]; z <= last[2]; z += layers)
  {
    checkpoint(static_cast<double>(z - first[2]) / (last[2] + 1 - first[2]));
    const Index3 boxFirst{ first[0], first[1], z };
    const Index3 boxSize{ last[0] - first[0] + 1, last[1] - first[1] + 1, std::min(layers, last[2] + 1 - z) };
    const std::size_t voxels = layer * boxSize[2];
    std::vector<int> list;
    for (const Source& source : sources)
    {
      if (source.first[2] < z + boxSize[2] && source.last[2] >= z)
      {
        list.push_back(source.brick);
      }
    }
    if (list.empty())
    {
      continue;
    }

    const cl::Buffer& claims = this->claims_.sized(context, sizeof(cl_uint) * voxels);
    const cl::Buffer& offsetBuffer = this->offsets_.sized(context, sizeof(cl_float) * 3 * voxels);
    context.queue().enqueueFillBuffer(claims, cl_uint(0xFFFFFFFFu), 0, sizeof(cl_uint) * voxels);

    const std::string defines = this->bricks_.defines(false);
    cl::Kernel claim = context.kernel("resample.cl", defines, "claim");
    cl::Kernel locate = context.kernel("resample.cl", defines, "locate");
    int argument = 0;
    claim.setArg(argument++, this->list_.holding(context, list));
    for (cl::Kernel* kernel : { &claim, &locate })
    {
      argument = kernel == &claim ? 1 : 0;
      this->bricks_.bindTable(*kernel, argument, false);
      kernel->setArg(argument++, this->bricks_.pitch());
      kernel->setArg(argument++, this->bricks_.displacement);
      kernel->setArg(argument++, this->bricks_.constraint);
      kernel->setArg(argument++, this->bricks_.cutsOrNothing());
      kernel->setArg(argument++, int4(grid.size));
      kernel->setArg(argument++, int4(flat));
      kernel->setArg(argument++, int4(boxFirst));
      kernel->setArg(argument++, int4(boxSize));
      kernel->setArg(argument++, claims);
    }
    locate.setArg(argument, offsetBuffer);
    const std::size_t items = this->bricks_.workItems(false);
    context.queue().enqueueNDRangeKernel(claim, cl::NullRange, cl::NDRange(items * list.size()), cl::NDRange(items));
    context.queue().enqueueNDRangeKernel(locate, cl::NullRange, cl::NDRange(voxels));

    offsets.resize(3 * voxels);
    context.read(offsetBuffer, offsets);
    visit({ boxFirst, boxSize, offsets.data() });
  }
}

}
