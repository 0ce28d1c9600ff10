#include "Propagation.h"

#include <algorithm>
#include <cstring>
#include <set>

namespace chainmail
{

double Propagation::Conflict::largest() const
{
  return std::max(*std::max_element(this->tooHigh.begin(), this->tooHigh.end()),
    *std::max_element(this->tooLow.begin(), this->tooLow.end()));
}

Propagation::Conflict Propagation::run(const std::vector<int>& bricks, double enough, const Checkpoint& checkpoint)
{
  Context& context = this->bricks_.context();
  const Index3 size = this->bricks_.size();
  const int rounds = size[0] + size[1] + size[2];

  // Bricks of one parity never touch, so one launch may update all of them in place. The wave begins beside the moved
  // elements, which may lie across a face.
  std::set<int> pending[2];
  const auto parity = [&](int brick)
  {
    const Index3 origin = this->bricks_.origin(brick);
    return (origin[0] / size[0] + origin[1] / size[1] + origin[2] / size[2]) & 1;
  };
  for (const int brick : bricks)
  {
    pending[parity(brick)].insert(brick);
    for (int d = 0; d < 6; ++d)
    {
      const int near = this->bricks_.neighbour(brick, d);
      pending[parity(near)].insert(near);
    }
  }

  Conflict conflict;
  for (int turn = 0; (!pending[0].empty() || !pending[1].empty()) && conflict.largest() <= enough; turn = 1 - turn)
  {
    checkpoint();
    const std::vector<int> wanted(pending[turn].begin(), pending[turn].end());
    pending[turn].clear();
    this->bricks_.require(wanted);
    std::vector<int> list;
    for (const int brick : wanted)
    {
      if (this->bricks_.slot(brick) > 0)
      {
        list.push_back(this->bricks_.slot(brick));
      }
    }
    if (list.empty())
    {
      continue;
    }

    cl::Kernel kernel = context.kernel("propagate.cl", this->bricks_.defines(true), "propagate");
    std::vector<cl_int> result(7 * list.size());
    const cl::Buffer& resultBuffer = this->result_.sized(context, sizeof(cl_int) * result.size());
    int argument = 0;
    kernel.setArg(argument++, this->list_.holding(context, list));
    kernel.setArg(argument++, static_cast<cl_int>(rounds));
    kernel.setArg(argument++, this->bricks_.pitch());
    this->bricks_.bindTable(kernel, argument);
    kernel.setArg(argument++, this->bricks_.displacement);
    kernel.setArg(argument++, this->bricks_.before);
    kernel.setArg(argument++, this->bricks_.constraint);
    kernel.setArg(argument++, this->bricks_.cutsOrNothing());
    kernel.setArg(argument++, resultBuffer);
    const std::size_t items = this->bricks_.workItems(true);
    context.runGroups(kernel, list.size(), items);
    context.read(resultBuffer, result);

    for (std::size_t n = 0; n < list.size(); ++n)
    {
      const int brick = this->bricks_.brick(list[n]);
      const int faces = result[7 * n];
      if (faces != 0)
      {
        this->bricks_.touch(list[n]);
      }
      for (int d = 0; d < 6; ++d)
      {
        if (faces & (1 << d))
        {
          pending[1 - turn].insert(this->bricks_.neighbour(brick, d));
        }
      }
      if (faces & 128)
      {
        pending[turn].insert(brick);
      }
      float values[6];
      std::memcpy(values, &result[7 * n + 1], sizeof(values));
      for (int a = 0; a < 3; ++a)
      {
        conflict.tooHigh[a] = std::max(conflict.tooHigh[a], static_cast<double>(values[2 * a]));
        conflict.tooLow[a] = std::max(conflict.tooLow[a], static_cast<double>(values[2 * a + 1]));
      }
    }
  }
  return conflict;
}

}
