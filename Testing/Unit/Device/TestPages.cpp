// The memory of buffers on processors: which pages are kept for later buffers, and which are returned to the system.
// For Linux alone, whose allocation of pages is known.
#ifdef __linux__

#include "Pages.h"
#include "Random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <vector>

namespace
{

using namespace chainmail;

constexpr std::size_t page = std::size_t(1) << 21;

class PagesTest : public testing::Test
{
protected:
  Pages::Memory take(std::size_t bytes, bool zeros = false) const { return Pages::take(this->pages, bytes, zeros); }

  std::shared_ptr<Pages> pages = std::make_shared<Pages>();
};

TEST_F(PagesTest, WhatIsFreedServesTheNextBuffers)
{
  const Pages::Memory field = this->take(8 * page, true);
  Pages::Memory before = this->take(6 * page);
  char* const at = before.get();
  before.reset();
  EXPECT_EQ(this->pages->kept(), 6 * page);
  // Two buffers reuse the place of one that is as large as both, then one buffer reuses both places.
  Pages::Memory claims = this->take(page + 1), offsets = this->take(4 * page);
  EXPECT_EQ(std::min(claims.get(), offsets.get()), at);
  EXPECT_EQ(std::max(claims.get(), offsets.get()), at + 2 * page);
  EXPECT_EQ(this->pages->kept(), 0u);
  claims.reset();
  offsets.reset();
  EXPECT_EQ(this->take(6 * page - 5).get(), at);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(at) % page, 0u);
}

// A buffer that no kept range is large enough for gets the pages of several.
TEST_F(PagesTest, ApartPagesServeOneBufferTogether)
{
  const Pages::Memory field = this->take(20 * page, true);
  std::vector<Pages::Memory> parts;
  for (int n = 0; n < 4; ++n)
  {
    parts.push_back(this->take(2 * page));
    std::memset(parts.back().get(), 1 + n, 2 * page);
  }
  const Pages::Memory between = this->take(page); // may lie beside one of them
  parts[2].reset();
  parts[0].reset();
  ASSERT_EQ(this->pages->kept(), 4 * page);
  const Pages::Memory whole = this->take(5 * page);
  ASSERT_TRUE(whole);
  EXPECT_EQ(this->pages->kept(), 0u);
  std::array<int, 5> counts{}; // of pages by what was written to them before; 0: new ones
  for (std::size_t n = 0; n < 5; ++n)
  {
    const char* first = whole.get() + n * page;
    ASSERT_TRUE(std::all_of(first, first + page, [first](char value) { return value == *first; }));
    ++counts.at(static_cast<std::size_t>(*first));
  }
  EXPECT_EQ(counts, (std::array<int, 5>{ 1, 2, 0, 2, 0 }));
  std::memset(whole.get(), 9, 5 * page);
  for (const std::size_t n : { std::size_t(1), std::size_t(3) })
  {
    EXPECT_EQ(parts[n].get()[0], static_cast<char>(1 + n));
    EXPECT_EQ(parts[n].get()[2 * page - 1], static_cast<char>(1 + n));
  }
}

TEST_F(PagesTest, ZerosAreZeros)
{
  const Pages::Memory field = this->take(4 * page, true);
  Pages::Memory used = this->take(2 * page);
  std::memset(used.get(), 7, 2 * page);
  used.reset();
  ASSERT_EQ(this->pages->kept(), 2 * page);
  const Pages::Memory zeros = this->take(2 * page, true);
  EXPECT_TRUE(std::all_of(zeros.get(), zeros.get() + 2 * page, [](char value) { return value == 0; }));
  EXPECT_EQ(this->pages->kept(), 0u) << "more than was once in use";
}

TEST_F(PagesTest, NothingIsKeptAfterTheLastBuffer)
{
  Pages::Memory field = this->take(page, true), before = this->take(9 * page);
  before.reset();
  EXPECT_EQ(this->pages->kept(), 2 * page) << "twice what is in use";
  field.reset();
  EXPECT_EQ(this->pages->kept(), 0u);
  // Earlier use does not count any more.
  field = this->take(page, true);
  before = this->take(page);
  before.reset();
  EXPECT_EQ(this->pages->kept(), page);
}

// Buffers of random life never share a byte, and the memory kept is at most the largest memory that was in use.
TEST_F(PagesTest, BuffersOfAnyOrderKeepTheirValues)
{
  struct Buffer
  {
    Pages::Memory memory;
    std::vector<std::size_t> marks; // where in the buffer its number is written
    char number;
  };
  Random random(5);
  std::vector<Buffer> buffers;
  std::size_t most = 0, mostPassing = 0;
  for (int step = 0; step < 2000; ++step)
  {
    if (buffers.size() < 12 && (buffers.empty() || random.below(2) == 0))
    {
      const std::size_t bytes = 1 + static_cast<std::size_t>(random.below(5 * static_cast<int>(page)));
      const bool zeros = random.below(3) == 0;
      Buffer buffer{ this->take(bytes, zeros), { 0, bytes / 2, bytes - 1 }, static_cast<char>(1 + step % 100) };
      ASSERT_TRUE(buffer.memory);
      for (const std::size_t mark : buffer.marks)
      {
        ASSERT_TRUE(!zeros || buffer.memory.get()[mark] == 0);
      }
      for (const std::size_t mark : buffer.marks)
      {
        buffer.memory.get()[mark] = buffer.number;
      }
      buffers.push_back(std::move(buffer));
    }
    else
    {
      const auto gone = buffers.begin() + random.below(static_cast<int>(buffers.size()));
      for (const std::size_t mark : gone->marks)
      {
        ASSERT_EQ(gone->memory.get()[mark], gone->number);
      }
      buffers.erase(gone);
    }
    std::size_t inUse = 0, passing = 0;
    for (const Buffer& buffer : buffers)
    {
      const Pages::GiveBack& memory = buffer.memory.get_deleter();
      inUse += memory.bytes;
      passing += memory.zeros ? 0 : memory.bytes;
    }
    most = inUse == 0 ? 0 : std::max(most, inUse);
    mostPassing = inUse == 0 ? 0 : std::max(mostPassing, passing);
    ASSERT_LE(this->pages->kept() + inUse, most);
    ASSERT_LE(this->pages->kept() + passing, mostPassing);
    ASSERT_LE(this->pages->kept(), 2 * inUse);
  }
}

}

#endif
