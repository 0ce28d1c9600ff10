#pragma once

// Figures that tests measure. Each is printed as "NUMERICS: name | figure"; Testing/Numerics.md lists them.

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <iostream>
#include <string>

inline void record(const std::string& name, double figure, const std::string& unit)
{
  char text[64];
  std::snprintf(text, sizeof text, "%.3g", figure);
  std::string key = name;
  std::replace_if(
    key.begin(), key.end(), [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; }, '_');
  testing::Test::RecordProperty(key, text);
  std::cout << "NUMERICS: " << name << " | " << text << (unit.empty() ? "" : " " + unit) << std::endl;
}

/// Checks that a figure is at most `allowed`, and records it.
inline void expectAtMost(const std::string& name, double figure, double allowed, const std::string& unit = "")
{
  EXPECT_LE(figure, allowed) << name; // false for NaN
  record(name, figure, unit);
}
