// Numbers in messages.

#include "Format.h"

#include <gtest/gtest.h>

#include <limits>

namespace
{

using chainmail::toString;

TEST(Words, NumbersAsAPersonWritesThem)
{
  EXPECT_EQ(toString(0.35), "0.35");
  EXPECT_EQ(toString(0.1f), "0.1");
  EXPECT_EQ(toString(6.0), "6");
  EXPECT_EQ(toString(-12.0), "-12");
  EXPECT_EQ(toString(0.0), "0");
  EXPECT_EQ(toString(-0.0), "0");
  EXPECT_EQ(toString(16777217.0), "16777217");
  EXPECT_EQ(toString(9007199254740.0), "9007199254740");
  EXPECT_EQ(toString(12345678.9), "12345679");
  EXPECT_EQ(toString(-1234.5678901), "-1234.568");
  EXPECT_EQ(toString(1e30), "1e+30");
  EXPECT_EQ(toString(1e300), "1e+300");
  EXPECT_EQ(toString(1e-9), "1e-09");
  EXPECT_EQ(toString(std::numeric_limits<double>::infinity()), "inf");
  EXPECT_EQ(toString(std::numeric_limits<double>::quiet_NaN()), "nan");
  EXPECT_EQ(toString(chainmail::Vector3{ { 1.0, -2.5, 1e7 } }), "(1, -2.5, 10000000)");
}

TEST(Words, NumbersOfFewDigits)
{
  EXPECT_EQ(toString(1.23456, 3), "1.23");
  EXPECT_EQ(toString(1234.5, 3), "1234") << "no exponent";
  EXPECT_EQ(toString(1500.0, 3), "1500");
  EXPECT_EQ(toString(999.7, 3), "1000");
  EXPECT_EQ(toString(9.97, 2), "10");
  EXPECT_EQ(toString(0.0123456, 2), "0.012");
}

}
