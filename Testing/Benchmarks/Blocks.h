#pragma once

#include "../Unit/Random.h"
#include "Simulation.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace bench
{

/// A block of tissue without air, of one byte a voxel, that engine and baselines are both given. Unit spacing; nothing
/// is anchored unless a benchmark says so.
class Block
{
public:
  static constexpr std::uint8_t rigid = 1;

  chainmail::Grid grid;
  std::vector<std::uint8_t> material; ///< see constraintOf()
  chainmail::Anchors anchors;

  explicit Block(const chainmail::Index3& size, double constraint = 0.25)
  {
    this->grid.size = size;
    this->material.assign(this->grid.voxels(), materialOf(constraint));
    this->anchors.faces.fill(false);
  }

  /// Fractions of the spacing that float32 holds exactly.
  static float constraintOf(std::uint8_t material) { return static_cast<float>(material - 1) / 512.0f; }
  static std::uint8_t materialOf(double constraint) { return static_cast<std::uint8_t>(constraint * 512.0 + 1.5); }

  float constraint(std::size_t voxel) const { return constraintOf(this->material[voxel]); }

  std::vector<float> constraints() const
  {
    std::vector<float> values(this->material.size());
    std::transform(this->material.begin(), this->material.end(), values.begin(), constraintOf);
    return values;
  }

  /// The model reads this block, which must outlive it.
  std::shared_ptr<const chainmail::Model> model() const
  {
    chainmail::ArrayView scalars;
    scalars.data = this->material.data();
    scalars.type = chainmail::ArrayView::Type::UInt8;
    chainmail::Material function;
    function.tissueThreshold = 0.5;
    function.constraint = [](double value) { return constraintOf(static_cast<std::uint8_t>(value)); };
    return std::make_shared<chainmail::Model>(this->grid, scalars, function, this->anchors);
  }

  std::string text() const
  {
    return std::to_string(this->grid.size[0]) + " x " + std::to_string(this->grid.size[1]) + " x " +
           std::to_string(this->grid.size[2]);
  }
};

/// Tissue of every kind: patches that are stiff or soft, with noise in them; a tenth of the block each, or so many
/// voxels.
inline Block heterogeneousBlock(const chainmail::Index3& size, std::uint64_t seed = 1, int patchSize = 0)
{
  Block block(size);
  Random random(seed);
  const int patch = patchSize > 0 ? patchSize : std::max(2, size[0] / 10);
  for (std::size_t v = 0; v < block.material.size(); ++v)
  {
    const chainmail::Index3 p = block.grid.indexOf(v);
    const bool soft = (p[0] / patch + p[1] / patch + p[2] / patch) % 2 == 0;
    block.material[v] = Block::materialOf(random(0.05, 0.25) + (soft ? 0.2 : 0.0));
  }
  return block;
}

/// A rod of bone across a block, along x or y, a third or two thirds of the way through it.
inline void addRod(Block& block, bool alongX = true)
{
  const chainmail::Index3& n = block.grid.size;
  const int thick = std::max(1, n[0] / 16);
  for (int along = n[0] / 5; along < n[0] - n[0] / 5; ++along)
  {
    for (int a = 0; a < thick; ++a)
    {
      for (int b = 0; b < thick; ++b)
      {
        const std::size_t voxel = alongX ? block.grid.at(along, n[1] / 3 + a, n[2] / 3 + b)
                                         : block.grid.at(2 * n[0] / 3 + a, along, 2 * n[2] / 3 + b);
        block.material[voxel] = Block::rigid;
      }
    }
  }
}

/// Two rods of bone across a block.
inline void addRods(Block& block)
{
  addRod(block, true);
  addRod(block, false);
}

/// A handle on the element at these indices, or on all within `radius` of it.
inline chainmail::Probe probeAt(const chainmail::Index3& p, const chainmail::Vector3& displacement, double radius = 0.0)
{
  chainmail::Probe probe;
  probe.position = { double(p[0]), double(p[1]), double(p[2]) };
  probe.displacement = displacement;
  probe.radius = radius;
  return probe;
}

}
