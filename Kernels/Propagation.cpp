#include "Propagation.h"

#include <algorithm>
#include <cstring>

namespace chainmail
{

double Propagation::Conflict::largest() const
{
  return std::max(*std::max_element(this->tooHigh.begin(), this->tooHigh.end()),
    *std::max_element(this->tooLow.begin(), this->tooLow.end()));
}

void Propagation::start(const std::vector<int>& bricks)
{
  this->conflict_ = Conflict();
  this->spread_.start(bricks);
}

int Propagation::run(int iterations, double enough, const Checkpoint& checkpoint)
{
  int done = 0;
  while (!this->finished() && this->conflict_.largest() <= enough && (iterations == 0 || done < iterations))
  {
    checkpoint();
    this->turn(0);
    if (this->conflict_.largest() <= enough)
    {
      this->turn(1);
    }
    ++done;
  }
  return done;
}

void Propagation::turn(int parity)
{
  this->spread_.turn(parity,
    [this](cl::Kernel& kernel, int& argument)
    {
      kernel.setArg(argument++, this->bricks_.displacement);
      kernel.setArg(argument++, this->bricks_.before);
      kernel.setArg(argument++, this->bricks_.constraint);
      kernel.setArg(argument++, this->bricks_.cutsOrNothing());
    });
  for (std::size_t n = 0; n < this->spread_.slots().size(); ++n)
  {
    const cl_int* result = this->spread_.resultOf(n);
    if (result[0] != 0)
    {
      this->bricks_.touch(this->spread_.slots()[n]);
    }
    float values[6];
    std::memcpy(values, result + 1, sizeof(values));
    for (int a = 0; a < 3; ++a)
    {
      this->conflict_.tooHigh[a] = std::max(this->conflict_.tooHigh[a], static_cast<double>(values[2 * a]));
      this->conflict_.tooLow[a] = std::max(this->conflict_.tooLow[a], static_cast<double>(values[2 * a + 1]));
    }
  }
}

}
