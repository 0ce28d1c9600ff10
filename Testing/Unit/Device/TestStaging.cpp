// The host memory for copies from devices with a memory of their own: which blocks serve again, and how many bytes
// there can be.

#include "Context.h"
#include "Environment.h"
#include "Scene.h"
#include "Staging.h"

#include <gtest/gtest.h>

#include <numeric>
#include <vector>

namespace
{

using namespace chainmail;

constexpr std::size_t megabyte = std::size_t(1) << 20;

class StagingTest : public testing::Test
{
protected:
  std::shared_ptr<Context> device = Context::of(testDevice());
  cl::Context context{ device->device() };
  cl::CommandQueue queue{ context, device->device() };
  Staging staging{ context, queue };
};

TEST_F(StagingTest, CopiesOfSimilarSizeShareABlock)
{
  Staging::Memory first = this->staging.take(5 * megabyte);
  ASSERT_TRUE(first);
  char* const at = first.get();
  EXPECT_EQ(this->staging.bytes(), 8 * megabyte);
  const Staging::Memory beside = this->staging.take(megabyte);
  EXPECT_NE(beside.get(), at);
  EXPECT_EQ(this->staging.bytes(), 12 * megabyte);
  first.reset();
  EXPECT_EQ(this->staging.take(7 * megabyte).get(), at);
  EXPECT_EQ(this->staging.bytes(), 12 * megabyte);
}

TEST_F(StagingTest, TheSmallestBlockThatSufficesIsTaken)
{
  Staging::Memory large = this->staging.take(40 * megabyte), small = this->staging.take(8 * megabyte);
  char* const at = small.get();
  large.reset();
  small.reset();
  EXPECT_EQ(this->staging.take(6 * megabyte).get(), at);
}

TEST_F(StagingTest, NeverMoreThanTheMost)
{
  Staging::Memory half = this->staging.take(Staging::most / 2);
  Staging::Memory quarter = this->staging.take(Staging::most / 4);
  ASSERT_TRUE(half && quarter);
  EXPECT_FALSE(this->staging.take(Staging::most / 2)) << "three quarters are in use";
  EXPECT_FALSE(this->staging.take(Staging::most + 1));
  quarter.reset();
  EXPECT_TRUE(this->staging.take(Staging::most / 2)) << "a kept block that is too small makes room";
  EXPECT_EQ(this->staging.bytes(), Staging::most);
}

TEST_F(StagingTest, WhatADeviceCopiesThereIsWhatTheBufferHolds)
{
  std::vector<cl_int> values(3 * megabyte);
  std::iota(values.begin(), values.end(), 7);
  const std::size_t bytes = sizeof(cl_int) * values.size();
  const cl::Buffer buffer(this->context, CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR, bytes, values.data());
  const Staging::Memory copy = this->staging.take(bytes);
  ASSERT_TRUE(copy);
  this->queue.enqueueReadBuffer(buffer, CL_TRUE, 0, bytes, copy.get());
  EXPECT_TRUE(std::equal(values.begin(), values.end(), reinterpret_cast<const cl_int*>(copy.get())));
}

}
