#pragma once

#include <cmath>
#include <cstdint>
#include <initializer_list>

/// A small generator whose numbers are the same on every machine (the distributions of the standard library are not).
/// Source: splitmix64, Steele, Lea and Flood 2014, doi:10.1145/2660193.2660195.
class Random
{
public:
  explicit Random(std::uint64_t seed)
    : state_(seed)
  {
  }

  /// Uniform in [low, high).
  double operator()(double low, double high) { return low + (high - low) * (this->next() >> 11) * 0x1.0p-53; }

  /// Uniform in 0 .. n - 1.
  int below(int n) { return static_cast<int>(this->next() % static_cast<std::uint64_t>(n)); }

  /// Uniform in low .. high.
  int between(int low, int high) { return low + this->below(high - low + 1); }

  /// Log-uniform in [low, high).
  double logarithmic(double low, double high) { return std::exp((*this)(std::log(low), std::log(high))); }

  /// True with the probability `share`.
  bool chance(double share) { return (*this)(0.0, 1.0) < share; }
  bool oneIn(int n) { return this->below(n) == 0; }

  /// One of the values, all equally likely.
  template <typename T> T of(std::initializer_list<T> values)
  {
    return values.begin()[this->below(static_cast<int>(values.size()))];
  }

private:
  std::uint64_t next()
  {
    std::uint64_t z = (this->state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }

  std::uint64_t state_;
};
