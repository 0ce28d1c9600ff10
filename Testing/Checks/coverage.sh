#!/usr/bin/env bash
# Which lines and branches of the kernels no unit test reaches: builds the engine in the folder $2 from the sources $1
# with the kernels as C++, runs the tests and holds what gcov says against thresholds (kernel_coverage.py).
set -u
source=$1
build=$2
command -v gcov >/dev/null || { echo "gcov was not found"; exit 125; }
command -v python3 >/dev/null || { echo "python3 was not found"; exit 125; }
cmake -S "$source" -B "$build" -DCHAINMAIL_ENGINE_ONLY=ON -DCHAINMAIL_HOST_KERNELS=ON -DCMAKE_BUILD_TYPE=Release &&
  cmake --build "$build" --parallel "${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}" --target ChainMailUnitTests || exit 1

# Not optimised, as gcov then counts what is written. That is slow: tests that take long and reach nothing that others do
# not are left out, and random scenes are few. In many parts, as some tests take much longer than others.
export HOST_OPENCL_FLAGS="-O0 --coverage"
export CHAINMAIL_RANDOM_SCENES=8
rm -f "$build"/HostKernels/*.gcda "$build"/tests-*.log
export GTEST_TOTAL_SHARDS=24
seq 0 $((GTEST_TOTAL_SHARDS - 1)) | xargs -P "$(nproc)" -I @ sh -c 'GTEST_SHARD_INDEX=@ "$1/Testing/Unit/ChainMailUnitTests" \
  --gtest_brief=1 --gtest_filter="-Extremes.*:Memory.*:Metamorphic.*:Paper.*:Plastic.*:*BitsDoNotDependOnBricks*" \
  >"$1/tests-@.log" 2>&1' sh "$build" ||
  { echo "FAILED: tests"; cat "$build"/tests-*.log; exit 1; }
python3 "$source/Testing/Checks/kernel_coverage.py" "$build/HostKernels" "$source/Kernels"
