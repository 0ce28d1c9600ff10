// Host access to single elements: values by voxel, in the order of the list, and the addresses that a list keeps.

#include "Elements.h"
#include "Scene.h"

#include <cmath>

namespace
{

using namespace chainmail;

class ElementsOfBricks : public testing::Test
{
protected:
  ElementsOfBricks()
    : scene({ 24, 12, 8 }, 0.3f, 3)
  {
    for (std::size_t n = 0; n < this->scene.constraint.size(); ++n)
    {
      this->scene.constraint[n] = 0.001f * static_cast<float>(n % 997 + 1);
    }
    this->bricks = std::make_unique<Bricks>(
      Context::of(testDevice()), this->scene.model(), Index3{ 4, 2, 2 }, RotationSettings{ true, 0.3 });
  }

  int brickOf(const Index3& at) const { return this->bricks->brickAt(at[0], at[1], at[2]); }
  std::size_t voxel(const Index3& at) const { return this->scene.grid.at(at[0], at[1], at[2]); }

  std::vector<float> constraintsOf(const std::vector<Index3>& list) const
  {
    std::vector<float> values;
    for (const Index3& at : list)
    {
      const auto first = this->scene.constraint.begin() + static_cast<std::ptrdiff_t>(3 * this->voxel(at));
      values.insert(values.end(), first, first + 3);
    }
    return values;
  }

  Scene scene;
  std::unique_ptr<Bricks> bricks;
};

TEST_F(ElementsOfBricks, ValuesAreThoseOfTheVoxelsInTheOrderOfTheList)
{
  const std::vector<Index3> list{ { 9, 5, 3 }, { 0, 0, 0 }, { 8, 5, 3 }, { 9, 4, 2 }, { 23, 11, 7 } };
  std::vector<int> owners;
  for (const Index3& at : list)
  {
    owners.push_back(this->brickOf(at));
  }
  this->bricks->makeUpdatable(owners);
  Elements elements(*this->bricks);
  std::vector<std::size_t> backwards;
  std::vector<float> places;
  std::vector<float> reversed;
  for (const Index3& at : list)
  {
    elements.add(at);
    backwards.insert(backwards.begin(), this->voxel(at));
    for (int a = 0; a < 3; ++a)
    {
      places.push_back(static_cast<float>(100 * at[0] + 10 * at[1] + at[2]) + 0.25f * static_cast<float>(a));
    }
    reversed.insert(reversed.begin(), places.end() - 3, places.end());
  }
  const Elements others(*this->bricks, backwards);
  ASSERT_EQ(elements.size(), list.size());

  elements.setDisplacements(places);
  EXPECT_EQ(elements.displacements(), places);
  EXPECT_EQ(others.displacements(), reversed);
  for (std::size_t n = 0; n < list.size(); ++n)
  {
    std::vector<float> u;
    this->bricks->readSlot(this->bricks->slot(owners[n]), u);
    const Vector3 now = this->bricks->place(list[n][0], list[n][1], list[n][2], u);
    for (std::size_t a = 0; a < 3; ++a)
    {
      EXPECT_EQ(now[a], list[n][a] + static_cast<double>(places[3 * n + a]));
    }
  }

  EXPECT_EQ(elements.constraints(), this->constraintsOf(list));
  std::vector<float> held = elements.constraints();
  for (float& c : held)
  {
    c = -c;
  }
  elements.setConstraints(held);
  EXPECT_EQ(elements.constraints(), held);

  Field field{ 2, sizeof(float), "a test" };
  this->bricks->addField(field);
  const std::vector<float> own{ 1, 2, 3, 4, 5, 6, 7, 8, 9, 10 };
  elements.set(field, own);
  EXPECT_EQ(elements.values(field), own);
  EXPECT_EQ(others.values(field), (std::vector<float>{ 9, 10, 7, 8, 5, 6, 3, 4, 1, 2 }));
  this->bricks->removeField(field);
}

TEST_F(ElementsOfBricks, RotationsCountOnceOneIsNotZero)
{
  this->bricks->makeUpdatable({ this->brickOf({ 5, 5, 5 }) });
  const Elements elements(*this->bricks, { this->voxel({ 5, 5, 5 }) });
  elements.setRotations({ 0.0f, 0.0f, 0.0f });
  EXPECT_EQ(this->bricks->activeRotations(), nullptr);
  const std::vector<float> rotation{ 0.0f, 0.125f, -0.5f };
  elements.setRotations(rotation);
  EXPECT_NE(this->bricks->activeRotations(), nullptr);
  EXPECT_EQ(elements.rotations(), rotation);
  elements.setRotations({ 0.0f, 0.0f, 0.0f });
  EXPECT_NE(this->bricks->activeRotations(), nullptr) << "other elements may have rotated";
  EXPECT_EQ(elements.pressures(), std::vector<float>{ 0.0f });
}

TEST_F(ElementsOfBricks, WithoutAStateTheyAreAtRest)
{
  const Index3 at{ 5, 5, 5 }, beside{ 9, 5, 5 }, far{ 22, 5, 5 };
  this->bricks->makeUpdatable({ this->brickOf(at) });
  ASSERT_TRUE(this->bricks->hasState(this->brickOf(at)));
  ASSERT_FALSE(this->bricks->hasState(this->brickOf(beside)));
  ASSERT_GT(this->bricks->slot(this->brickOf(beside)), 0);
  ASSERT_EQ(this->bricks->slot(this->brickOf(far)), 0);
  const Elements own(*this->bricks, { this->voxel(at) });
  own.setDisplacements({ 1.0f, 2.0f, 3.0f });
  const Elements all(*this->bricks, { this->voxel(far), this->voxel(beside), this->voxel(at) });
  EXPECT_EQ(all.displacements(), (std::vector<float>{ 0, 0, 0, 0, 0, 0, 1, 2, 3 }));
  EXPECT_EQ(all.rotations(), std::vector<float>(9, 0.0f));
  const std::vector<float> c = all.constraints();
  EXPECT_TRUE(std::isinf(c[0]) && c[0] < 0.0f) << "air";
  EXPECT_EQ(std::vector<float>(c.begin() + 3, c.end()), this->constraintsOf({ beside, at }));

  // A list of elements that have a state stays valid, whatever bricks get one later.
  this->bricks->makeUpdatable({ this->brickOf(far), this->brickOf({ 1, 1, 1 }) });
  this->bricks->makeUpdatable({ this->brickOf(beside) });
  EXPECT_EQ(own.displacements(), (std::vector<float>{ 1, 2, 3 }));
  EXPECT_EQ(own.constraints(), this->constraintsOf({ at }));
}

TEST_F(ElementsOfBricks, ListsJoinAndMayBeEmpty)
{
  this->bricks->makeUpdatable({ this->brickOf({ 5, 5, 5 }) });
  Elements elements(*this->bricks);
  EXPECT_TRUE(elements.displacements().empty());
  elements.setDisplacements({});
  elements.add(Elements(*this->bricks, { this->voxel({ 5, 5, 5 }), this->voxel({ 4, 5, 5 }) }));
  elements.add(this->voxel({ 4, 4, 4 }));
  EXPECT_EQ(elements.constraints(), this->constraintsOf({ { 5, 5, 5 }, { 4, 5, 5 }, { 4, 4, 4 } }));
  elements.clear();
  EXPECT_EQ(elements.size(), 0u);
}

}
