// The least energy that a small block can have, with a proof, for measure.py: TASK and ANSWER are files of numbers.
//
// TASK: three int32, elements along x, y, z; then for each element, x fastest, its constraint (double, fraction of the
// spacing), whether it is held (byte), and where it is held (three doubles). ANSWER: doubles; the energy, what it can
// not be below, and three of displacement for each element.

#include "../Oracles/Optimiser.h"

#include <cstdio>
#include <exception>
#include <fstream>
#include <stdexcept>

namespace
{

template <typename T> std::vector<T> read(std::ifstream& file, std::size_t count)
{
  std::vector<T> values(count);
  file.read(reinterpret_cast<char*>(values.data()), static_cast<std::streamsize>(count * sizeof(T)));
  if (!file)
  {
    throw std::runtime_error("the task is too short");
  }
  return values;
}

void solve(const char* task, const char* answer)
{
  std::ifstream in(task, std::ios::binary);
  const auto size = read<std::int32_t>(in, 3);
  oracle::Block block({ size[0], size[1], size[2] });
  const auto constraint = read<double>(in, block.count());
  const auto held = read<char>(in, block.count());
  const auto start = read<oracle::Vector3>(in, block.count());
  for (std::size_t v = 0; v < block.count(); ++v)
  {
    block.give[v] = { constraint[v], constraint[v], constraint[v] };
  }
  const oracle::Optimum optimum = oracle::minimise(block, held, start);
  std::ofstream out(answer, std::ios::binary);
  out.write(reinterpret_cast<const char*>(&optimum.energy), sizeof(double));
  out.write(reinterpret_cast<const char*>(&optimum.bound), sizeof(double));
  out.write(reinterpret_cast<const char*>(optimum.state.data()),
    static_cast<std::streamsize>(optimum.state.size() * sizeof(oracle::Vector3)));
  if (!out.flush())
  {
    throw std::runtime_error(std::string("could not write ") + answer);
  }
}

}

int main(int argc, char** argv)
{
  if (argc != 3)
  {
    std::fprintf(stderr, "usage: %s TASK ANSWER\n", argv[0]);
    return 2;
  }
  try
  {
    solve(argv[1], argv[2]);
    return 0;
  }
  catch (const std::exception& error)
  {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
