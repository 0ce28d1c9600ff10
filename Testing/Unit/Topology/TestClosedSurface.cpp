// The inside of closed surfaces with several parts: against the winding number of each part alone, and against
// formulas.

#include "../../Oracles/Inside.h"
#include "Blades.h"
#include "ClosedSurface.h"

#include <algorithm>
#include <functional>

namespace
{

using namespace chainmail;

const Index3 size{ 26, 24, 22 };

Scene tissue()
{
  Scene scene(size, 0.2f);
  scene.grid.spacing = { 0.9, 1.0, 1.1 };
  return scene;
}

/// Inverts triangles at random.
Surface shuffled(Surface surface, std::uint64_t seed)
{
  Random random(seed);
  for (std::array<int, 3>& t : surface.triangles)
  {
    if (random.below(2))
    {
      std::swap(t[0], t[1]);
    }
  }
  return surface;
}

Surface all(const std::vector<Surface>& parts)
{
  Surface surface;
  for (const Surface& part : parts)
  {
    surface = both(surface, part);
  }
  return surface;
}

/// Nine overlapping balls, none within another.
std::vector<Surface> nineBalls()
{
  std::vector<Surface> balls;
  Random random(11);
  for (int n = 0; n < 9; ++n)
  {
    const Vector3 centre{ 7.0 + 4.5 * (n % 3) + random(-0.4, 0.4), 7.0 + 4.5 * (n / 3) + random(-0.4, 0.4),
      11.0 + random(-1.5, 1.5) };
    balls.push_back(sphere(centre, 4.0 + random(-0.3, 0.3), 9, 13));
  }
  return balls;
}

/// Whether a place is beyond all points of a surface along some axis: faster than winding numbers.
bool isFar(const Vector3& place, const Surface& surface)
{
  for (int a = 0; a < 3; ++a)
  {
    const auto further = [&](const Vector3& p) { return p[a] > place[a] + 2e-3; };
    const auto nearer = [&](const Vector3& p) { return p[a] < place[a] - 2e-3; };
    if (std::all_of(surface.points.begin(), surface.points.end(), further) ||
        std::all_of(surface.points.begin(), surface.points.end(), nearer))
    {
      return true;
    }
  }
  return false;
}

/// 1 inside of a part, 0 outside of all, -1 within 1e-3 mm of a change between the two.
int insideAny(const Vector3& place, const std::vector<Surface>& parts)
{
  int result = 0;
  for (const Surface& part : parts)
  {
    if (isFar(place, part))
    {
      continue;
    }
    const int here = oracle::inside(place, 1e-3, part.points, part.triangles);
    result = here == 1 || result == 1 ? 1 : std::min(here, result);
  }
  return result;
}

/// For each voxel: 1 if it is removed, 0 if it stays, -1 if either may happen.
using Expected = std::vector<int>;

Expected everywhere(const std::function<int(const Vector3&)>& expected)
{
  const Scene scene = tissue();
  Expected result(scene.grid.voxels());
  scene.each([&](int i, int j, int k) { result[scene.grid.at(i, j, k)] = expected(scene.place(i, j, k)); });
  return result;
}

SurfaceParts expectCarved(const Surface& surface, const Expected& expected)
{
  const Scene scene = tissue();
  Simulation simulation = simulate(scene);
  SurfaceParts parts;
  const std::size_t removed = simulation.carve(surface, &parts);
  std::vector<std::uint8_t> left(scene.grid.voxels());
  simulation.elements(left.data());
  std::size_t wrong = 0, unsure = 0, gone = 0;
  for (std::size_t v = 0; v < left.size(); ++v)
  {
    const bool carved = left[v] == 0;
    gone += carved;
    unsure += expected[v] < 0;
    wrong += expected[v] >= 0 && carved != (expected[v] == 1);
  }
  EXPECT_EQ(wrong, 0u);
  EXPECT_EQ(removed, gone);
  EXPECT_GT(gone, 100u);
  EXPECT_LT(unsure, 20u) << "the surface is not in general position";
  return parts;
}

TEST(ClosedSurface, PartsThatOverlapAreCarvedTogether)
{
  const std::vector<Surface> balls = nineBalls();
  std::vector<Surface> someInverted, mixed;
  for (std::size_t n = 0; n < balls.size(); ++n)
  {
    someInverted.push_back(n % 3 == 1 ? inverted(balls[n]) : balls[n]);
    mixed.push_back(n == 4 || n == 5 ? shuffled(balls[n], n) : balls[n]);
  }
  const Expected any = everywhere([&](const Vector3& place) { return insideAny(place, balls); });
  struct Case
  {
    const char* name;
    Surface surface;
    SurfaceParts parts;
  };
  const Case cases[] = { { "outwards", all(balls), { 9, 0, 0, 0 } },
    { "inwards", inverted(all(balls)), { 9, 0, 0, 0 } }, { "some inwards", all(someInverted), { 9, 0, 0, 3 } },
    { "the triangles of two shuffled", all(mixed), { 9, 2, 0, 0 } },
    { "all triangles shuffled", shuffled(all(balls), 3), { 9, 9, 0, 0 } },
    { "without shared points", soup(shuffled(all(balls), 4)), { 9, 9, 0, 0 } } };
  for (const Case& one : cases)
  {
    SCOPED_TRACE(one.name);
    const SurfaceParts parts = expectCarved(one.surface, any);
    EXPECT_EQ(parts.count, one.parts.count);
    EXPECT_EQ(parts.mixed, one.parts.mixed);
    EXPECT_EQ(parts.hollows, one.parts.hollows);
    EXPECT_TRUE(parts.reversed == one.parts.reversed || parts.reversed == 9 - one.parts.reversed) << parts.reversed;
  }
}

TEST(ClosedSurface, FineBallsAreTheUnionOfTheBalls)
{
  const Vector3 one{ 9.1, 11.2, 11.3 }, other{ 14.2, 11.9, 10.1 };
  const Surface surface = both(sphere(one, 6.0, 101, 101), inverted(sphere(other, 5.0, 101, 101)));
  expectCarved(surface, everywhere(
                          [&](const Vector3& p)
                          {
                            // The triangles are at most 0.006 mm below the sphere: r (1 - cos(pi / 101)) for rings and
                            // for sectors.
                            const double outside =
                              std::min(std::hypot(p[0] - one[0], p[1] - one[1], p[2] - one[2]) - 6.0,
                                std::hypot(p[0] - other[0], p[1] - other[1], p[2] - other[2]) - 5.0);
                            return outside > 1e-3 ? 0 : outside < -0.007 ? 1 : -1;
                          }));
}

TEST(ClosedSurface, PartsWithinOthersThatFaceTheOtherWayAreHollows)
{
  const Surface ball = sphere({ 11.2, 11.3, 12.1 }, 9.3, 13, 17), hole = sphere({ 11.0, 11.9, 12.3 }, 6.1, 11, 13),
                island = sphere({ 11.4, 11.6, 12.0 }, 3.2, 9, 11);
  const Expected whole = everywhere([&](const Vector3& p) { return insideAny(p, { ball }); });
  const Expected inHole = everywhere([&](const Vector3& p) { return insideAny(p, { hole }); });
  const Expected inIsland = everywhere([&](const Vector3& p) { return insideAny(p, { island }); });
  Expected shell = whole;
  for (std::size_t v = 0; v < shell.size(); ++v)
  {
    shell[v] = inHole[v] == 0 ? whole[v] : inHole[v] == 1 ? 0 : -1;
  }
  Expected withIsland = shell;
  for (std::size_t v = 0; v < shell.size(); ++v)
  {
    withIsland[v] = inIsland[v] != 0 ? inIsland[v] : shell[v];
  }

  EXPECT_EQ(expectCarved(both(ball, inverted(hole)), shell).hollows, 1u);
  EXPECT_EQ(expectCarved(both(inverted(hole), ball), shell).hollows, 1u) << "in another order";
  EXPECT_EQ(expectCarved(both(inverted(ball), hole), shell).hollows, 1u) << "the other way round";
  EXPECT_EQ(expectCarved(both(ball, hole), whole).hollows, 0u) << "facing the same way";
  EXPECT_EQ(expectCarved(inverted(both(ball, hole)), whole).hollows, 0u) << "both inwards";
  EXPECT_EQ(expectCarved(all({ ball, inverted(hole), island }), withIsland).hollows, 1u);
  EXPECT_EQ(expectCarved(all({ inverted(island), hole, inverted(ball) }), withIsland).hollows, 1u);
  for (std::uint64_t seed = 1; seed <= 4; ++seed)
  {
    SCOPED_TRACE(seed);
    EXPECT_EQ(expectCarved(shuffled(both(hole, ball), seed), shell).hollows, 1u) << "nobody says which way";
    EXPECT_EQ(expectCarved(shuffled(all({ ball, hole, island }), seed), withIsland).hollows, 1u);
  }
}

// A surface and its mirrored copy: both have their hollow.
TEST(ClosedSurface, AShellInsideOutNextToAnother)
{
  const Surface left = sphere({ 6.1, 11.3, 12.1 }, 5.1, 11, 13), leftHole = sphere({ 6.2, 11.1, 12.0 }, 2.9, 9, 11),
                right = sphere({ 17.1, 11.3, 12.1 }, 4.9, 11, 13), rightHole = sphere({ 17.2, 11.1, 12.0 }, 2.8, 9, 11);
  const SurfaceParts parts = expectCarved(all({ left, inverted(leftHole), inverted(right), rightHole }),
    everywhere(
      [&](const Vector3& p)
      {
        const int hole = insideAny(p, { leftHole, rightHole });
        return hole == 0 ? insideAny(p, { left, right }) : hole == 1 ? 0 : -1;
      }));
  EXPECT_EQ(parts.hollows, 2u);
  EXPECT_EQ(parts.reversed, 1u);
}

// A hollow in the union of two parts, in neither alone.
TEST(ClosedSurface, AHollowAcrossTwoParts)
{
  const Surface left = sphere({ 8.1, 11.3, 12.1 }, 6.4, 11, 13), right = sphere({ 15.1, 11.3, 12.1 }, 6.3, 11, 13),
                hole = box({ 5.33, 9.71, 10.52 }, { 17.91, 12.87, 13.43 });
  // In the intersection the winding number is 2, minus 1 by the hollow, so the remaining 1 is inside.
  expectCarved(all({ left, right, inverted(hole) }),
    everywhere(
      [&](const Vector3& p)
      {
        const int l = insideAny(p, { left }), r = insideAny(p, { right }), h = insideAny(p, { hole });
        return l < 0 || r < 0 || h < 0 ? -1 : l + r - h != 0;
      }));
}

TEST(ClosedSurface, AHollowThatTouchesWhatItIsIn)
{
  const Surface cube = box({ 3.3, 3.2, 3.4 }, { 19.3, 19.2, 19.4 });
  Surface hole{ { cube.points[0], { 12.1, 7.3, 8.2 }, { 8.3, 13.2, 7.1 }, { 7.2, 8.1, 14.3 } },
    { { 0, 1, 2 }, { 0, 3, 1 }, { 0, 2, 3 }, { 1, 3, 2 } } };
  for (const Surface& tetrahedron : { hole, inverted(hole) })
  {
    const bool outwards = oracle::winding({ 7.7, 8.0, 8.2 }, tetrahedron.points, tetrahedron.triangles) > 0.0;
    const SurfaceParts parts = expectCarved(
      both(cube, tetrahedron), everywhere(
                                 [&](const Vector3& p)
                                 {
                                   const int inHole = insideAny(p, { hole });
                                   return outwards || inHole == 0 ? insideAny(p, { cube }) : inHole == 1 ? 0 : -1;
                                 }));
    EXPECT_EQ(parts.hollows, outwards ? 0u : 1u);
  }
}

// Exactly, for parts that share faces and edges.
TEST(ClosedSurface, PartsThatTouchShareNoElementAndLeaveNone)
{
  Scene scene({ 20, 16, 12 });
  const auto carved = [&](const Surface& surface)
  {
    Simulation simulation = simulate(scene);
    return simulation.carve(surface);
  };
  const Surface left = box({ 3, 4, 5 }, { 9, 8, 7 }), right = box({ 9, 4, 5 }, { 12, 8, 7 }),
                corner = box({ 9, 8, 5 }, { 12, 10, 7 }), across = box({ 7, 5, 4 }, { 11, 7, 9 });
  EXPECT_EQ(carved(both(left, right)), 9u * 4u * 2u);
  EXPECT_EQ(carved(inverted(both(left, right))), 9u * 4u * 2u);
  EXPECT_EQ(carved(both(left, corner)), 6u * 4u * 2u + 3u * 2u * 2u);
  EXPECT_EQ(carved(both(left, across)), 6u * 4u * 2u + 4u * 2u * 5u - 2u * 2u * 2u);
  EXPECT_EQ(carved(both(left, inverted(across))), 6u * 4u * 2u + 4u * 2u * 5u - 2u * 2u * 2u);
  EXPECT_EQ(carved(both(left, left)), 6u * 4u * 2u);
  EXPECT_EQ(carved(shuffled(both(left, across), 5)), 6u * 4u * 2u + 4u * 2u * 5u - 2u * 2u * 2u);
}

/// A Klein bottle: a figure of eight that rotates by half a revolution on its path around the z axis. It is closed and
/// has one side.
Surface kleinBottle(const Vector3& centre, double ring, double width)
{
  constexpr int around = 32, across = 24;
  const double pi = std::acos(-1.0);
  Surface surface;
  for (int s = 0; s < around; ++s)
  {
    for (int t = 0; t < across; ++t)
    {
      const double a = 2 * pi * s / around, b = 2 * pi * (t + 0.5) / across;
      const double x = width * std::sin(b), y = 0.7 * width * std::sin(2 * b);
      const double r = ring + std::cos(a / 2) * x - std::sin(a / 2) * y;
      surface.points.push_back({ centre[0] + r * std::cos(a), centre[1] + r * std::sin(a),
        centre[2] + std::sin(a / 2) * x + std::cos(a / 2) * y });
    }
  }
  // After half a revolution the figure of eight is its own image under b -> -b.
  const auto at = [&](int s, int t) { return s == around ? (2 * across - 1 - t) % across : s * across + t % across; };
  for (int s = 0; s < around; ++s)
  {
    for (int t = 0; t < across; ++t)
    {
      surface.triangles.push_back({ at(s, t), at(s + 1, t), at(s + 1, t + 1) });
      surface.triangles.push_back({ at(s, t), at(s + 1, t + 1), at(s, t + 1) });
    }
  }
  return surface;
}

/// Whether a ray from a place crosses triangles an odd number of times.
bool crossesOddly(const Vector3& place, const Vector3& along, const Surface& surface)
{
  const auto less = [](const Vector3& a, const Vector3& b) { return Vector3{ a[0] - b[0], a[1] - b[1], a[2] - b[2] }; };
  int count = 0;
  for (const std::array<int, 3>& t : surface.triangles)
  {
    const Vector3 a = less(surface.points[t[0]], place), b = less(surface.points[t[1]], place),
                  c = less(surface.points[t[2]], place);
    const double u = oracle::dot(along, oracle::cross(b, c)), v = oracle::dot(along, oracle::cross(c, a)),
                 w = oracle::dot(along, oracle::cross(a, b)), sum = u + v + w;
    const bool meets = (u > 0 && v > 0 && w > 0) || (u < 0 && v < 0 && w < 0);
    count += meets && oracle::dot(a, oracle::cross(b, c)) / sum > 0;
  }
  return count % 2 != 0;
}

TEST(ClosedSurface, SurfacesWithoutTwoSidesCountCrossings)
{
  const Surface bottle = kleinBottle({ 11.3, 11.4, 12.2 }, 6.2, 3.6);
  const Surface ball = sphere({ 17.1, 11.2, 12.3 }, 4.1, 11, 13);
  const Vector3 along{ 0.31, 0.52, 0.79 }, other{ -0.61, 0.33, -0.42 };
  const auto odd = [&](const Vector3& p)
  {
    const bool one = crossesOddly(p, along, bottle);
    return crossesOddly(p, other, bottle) == one ? one : -1;
  };
  const Expected inBottle = everywhere(odd);
  SurfaceParts parts = expectCarved(bottle, inBottle);
  EXPECT_EQ(parts.count, 1u);
  EXPECT_EQ(parts.mixed, 1u);
  Expected inEither = everywhere([&](const Vector3& p) { return insideAny(p, { ball }); });
  for (std::size_t v = 0; v < inEither.size(); ++v)
  {
    inEither[v] = inEither[v] == 0 ? inBottle[v] : inEither[v];
  }
  parts = expectCarved(both(bottle, ball), inEither);
  EXPECT_EQ(parts.count, 2u);
  EXPECT_EQ(parts.hollows, 0u);
  const ClosedSurface closed(both(bottle, ball), tissue().grid);
  EXPECT_EQ(std::count(closed.alternating.begin(), closed.alternating.end(), 0), 1);
}

}
