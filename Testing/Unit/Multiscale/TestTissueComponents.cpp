// The connected components of tissue, against the oracle's.

#include "TissueComponents.h"

#include "Scene.h"

#include <map>
#include <set>

namespace
{

using namespace chainmail;

/// Tissue in pieces: half is air, and many links are cut.
struct Pieces
{
  explicit Pieces(std::uint64_t seed, const Index3& size, const Index3& brick)
    : scene(size, 0.3f, seed % 2 == 0 ? 1 : 3)
  {
    Random random(seed);
    this->scene.each(
      [&](int i, int j, int k)
      {
        if (random.chance(0.5))
        {
          this->scene.air(i, j, k);
        }
      });
    this->scene.anchors.faces[seed % 6] = true;
    this->bricks = std::make_unique<Tissue>(Context::of(testDevice()), this->scene.model(), brick);
    this->block = this->scene.block();
    this->scene.each(
      [&](int i, int j, int k)
      {
        for (int a = 0; a < 3; ++a)
        {
          const Index3 next{ i + (a == 0), j + (a == 1), k + (a == 2) };
          if (next[a] < size[a] && random.chance(seed % 3 == 0 ? 0.0 : 0.15))
          {
            this->bricks->removeLink(i, j, k, 2 * a + 1);
            this->block.cut[this->block.at(i, j, k)] |= static_cast<std::uint8_t>(1 << a);
          }
        }
      });
  }

  Scene scene;
  oracle::Block block;
  std::unique_ptr<Tissue> bricks;
};

TEST(TissueComponents, AreThoseOfTheOracle)
{
  for (std::uint64_t seed = 1; seed <= 6; ++seed)
  {
    const Index3 brick = seed % 2 == 0 ? Index3{ 4, 2, 2 } : Index3{ 16, 4, 2 };
    const Pieces pieces(seed, { 37, 11, 9 }, brick);
    const TissueComponents components(*pieces.bricks);
    const std::vector<int> expected = oracle::parts(pieces.block);

    std::map<int, int> names; // of the oracle's components
    std::map<int, std::vector<std::size_t>> members;
    std::map<int, bool> anchored;
    std::map<int, std::map<int, std::vector<std::size_t>>> inBricks;
    for (std::size_t v = 0; v < pieces.block.count(); ++v)
    {
      if (pieces.block.tissue[v])
      {
        const int component = components.of(v);
        EXPECT_EQ(names.emplace(expected[v], component).first->second, component) << v;
        members[component].push_back(v);
        anchored[component] = anchored[component] || pieces.block.anchored[v];
        const Index3 at = pieces.scene.grid.indexOf(v);
        inBricks[pieces.bricks->brickAt(at[0], at[1], at[2])][component].push_back(v);
      }
    }
    ASSERT_EQ(members.size(), names.size()) << "components that the oracle keeps apart are one";
    ASSERT_EQ(static_cast<int>(members.size()), components.count());
    EXPECT_GT(components.count(), 10);
    for (const auto& [component, voxels] : members)
    {
      std::vector<std::size_t> visited;
      components.anyRun(component,
        [&](const ElementRun& run)
        {
          for (std::size_t n = 0; n < run.count; ++n)
          {
            visited.push_back(run.first + n);
          }
          return false;
        });
      EXPECT_EQ(visited, voxels);
      EXPECT_EQ(components.isAnchored(component), anchored[component]);
      EXPECT_LE(voxels.size(), members[components.largest()].size());
    }
    for (const auto& [brick, here] : inBricks)
    {
      std::vector<int> numbers;
      for (const auto& [component, voxels] : here)
      {
        numbers.push_back(component);
        EXPECT_EQ(components.elementsIn(brick, component), voxels);
      }
      EXPECT_EQ(components.inBrick(brick), numbers);
    }
  }
}

}
