#include "DenseSweep.h"

#include <cmath>
#include <limits>
#include <thread>

namespace baseline
{

namespace
{

constexpr float epsilon = 1e-6f;
constexpr float still = 1e-7f;

/// A row of elements of one colour: its constraints and displacements by axis, and those of its six neighbours.
struct Row
{
  const float* c;
  const float* besideC[6];
  float* u[3];
  const float* beside[3][6];
};

float least(float a, float b)
{
  return a < b ? a : b;
}

float most(float a, float b)
{
  return a > b ? a : b;
}

/// What the neighbours of an element ask for along one axis.
struct Wish
{
  float pull = 0.0f;
  float lower = -std::numeric_limits<float>::infinity();
  float upper = std::numeric_limits<float>::infinity();

  void add(float own, float other, float limit, float weight)
  {
    this->pull += weight * (other - own);
    this->lower = most(this->lower, other - limit);
    this->upper = least(this->upper, other + limit);
  }
  float place(float own, float c, float weights, float omega) const
  {
    const float residual = this->pull / weights;
    const float wanted = least(most(own + omega * residual, this->lower), this->upper);
    const bool moves = (c > 0.0f) & (std::fabs(residual) > still) & (this->lower <= this->upper);
    return moves ? wanted : own;
  }
};

void relaxRow(const Row& row, int count, float omega)
{
  const float* const c = row.c;
  float* const x = row.u[0];
  float* const y = row.u[1];
  float* const z = row.u[2];
#pragma GCC ivdep
  for (int n = 0; n < count; ++n)
  {
    const float own = std::fabs(c[n]);
    Wish wishes[3];
    float weights = 0.0f;
    // A loop over the neighbours would keep the compiler from making vectors of the loop over elements.
    const auto add = [&](int d)
    {
      const float limit = 0.5f * (own + std::fabs(row.besideC[d][n]));
      const float weight = 1.0f / (limit + epsilon);
      weights += weight;
      wishes[0].add(x[n], row.beside[0][d][n], limit, weight);
      wishes[1].add(y[n], row.beside[1][d][n], limit, weight);
      wishes[2].add(z[n], row.beside[2][d][n], limit, weight);
    };
    add(0);
    add(1);
    add(2);
    add(3);
    add(4);
    add(5);
    x[n] = wishes[0].place(x[n], c[n], weights, omega);
    y[n] = wishes[1].place(y[n], c[n], weights, omega);
    z[n] = wishes[2].place(z[n], c[n], weights, omega);
  }
}

}

DenseSweep::DenseSweep(const std::array<int, 3>& size, const std::vector<float>& constraint)
  : size_(size)
  , half_((size[0] + 1) / 2)
  , strideY_(static_cast<std::size_t>(this->half_) + 2)
  , strideZ_(this->strideY_ * (static_cast<std::size_t>(size[1]) + 2))
  , given_(constraint)
{
  const std::size_t places = this->strideZ_ * (static_cast<std::size_t>(size[2]) + 2);
  for (int colour = 0; colour < 2; ++colour)
  {
    this->constraint_[colour].assign(places, -std::numeric_limits<float>::infinity());
    for (std::vector<float>& axis : this->displaced_[colour])
    {
      axis.assign(places, 0.0f);
    }
  }
}

bool DenseSweep::runsHere()
{
#if defined(__AVX2__) && defined(__GNUC__)
  return __builtin_cpu_supports("avx2");
#else
  return true;
#endif
}

/// Calls f(voxel, colour, place) for all elements.
template <typename F> void DenseSweep::each(const F& f) const
{
  std::size_t voxel = 0;
  for (int k = 0; k < this->size_[2]; ++k)
  {
    for (int j = 0; j < this->size_[1]; ++j)
    {
      for (int i = 0; i < this->size_[0]; ++i, ++voxel)
      {
        f(voxel, (i + j + k) & 1, this->at(i / 2, j, k));
      }
    }
  }
}

void DenseSweep::start(const std::array<std::vector<float>, 3>& state, const std::vector<char>& held)
{
  this->each(
    [&](std::size_t voxel, int colour, std::size_t place)
    {
      this->constraint_[colour][place] = held[voxel] ? -this->given_[voxel] : this->given_[voxel];
      for (int a = 0; a < 3; ++a)
      {
        this->displaced_[colour][a][place] = state[a][voxel];
      }
    });
}

std::array<std::vector<float>, 3> DenseSweep::state() const
{
  std::array<std::vector<float>, 3> state;
  state.fill(std::vector<float>(this->given_.size()));
  this->each(
    [&](std::size_t voxel, int colour, std::size_t place)
    {
      for (int a = 0; a < 3; ++a)
      {
        state[a][voxel] = this->displaced_[colour][a][place];
      }
    });
  return state;
}

void DenseSweep::relaxLayers(int colour, int first, int last, float omega)
{
  for (int k = first; k < last; ++k)
  {
    for (int j = 0; j < this->size_[1]; ++j)
    {
      // Element n of a row is at x = 2 n + odd, so its neighbours along x are n and the one after or before that.
      const std::ptrdiff_t odd = (j + k + colour) & 1;
      const std::ptrdiff_t y = static_cast<std::ptrdiff_t>(this->strideY_);
      const std::ptrdiff_t z = static_cast<std::ptrdiff_t>(this->strideZ_);
      const std::ptrdiff_t steps[6] = { 0, odd ? 1 : -1, -y, y, -z, z };
      const std::ptrdiff_t self = static_cast<std::ptrdiff_t>(this->at(0, j, k));
      Row row;
      row.c = this->constraint_[colour].data() + self;
      for (int a = 0; a < 3; ++a)
      {
        row.u[a] = this->displaced_[colour][a].data() + self;
      }
      for (int d = 0; d < 6; ++d)
      {
        row.besideC[d] = this->constraint_[1 - colour].data() + self + steps[d];
        for (int a = 0; a < 3; ++a)
        {
          row.beside[a][d] = this->displaced_[1 - colour][a].data() + self + steps[d];
        }
      }
      relaxRow(row, this->half_, omega);
    }
  }
}

void DenseSweep::sweep(float omega)
{
  for (int colour = 0; colour < 2; ++colour)
  {
    const int middle = this->size_[2] / 2;
    std::thread other([&] { this->relaxLayers(colour, middle, this->size_[2], omega); });
    this->relaxLayers(colour, 0, middle, omega);
    other.join();
  }
}

}
