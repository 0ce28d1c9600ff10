#!/usr/bin/env bash
# Which lines and branches of the kernels no unit test reaches: builds the engine in the folder $2 from the sources $1
# with the kernels as C++, runs the tests and compares what gcov says with Testing/KernelCoverage.md. With --write as $3
# the list is brought up to date.
set -u
source=$1
build=$2
command -v gcov >/dev/null || { echo "gcov was not found"; exit 125; }
command -v python3 >/dev/null || { echo "python3 was not found"; exit 125; }
cmake -S "$source" -B "$build" -DCHAINMAIL_ENGINE_ONLY=ON -DCHAINMAIL_HOST_KERNELS=ON -DCMAKE_BUILD_TYPE=Release &&
  cmake --build "$build" --parallel "${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}" --target ChainMailUnitTests || exit 1

# Not optimised, as gcov then counts what is written. Tests of memory reach nothing that others do not.
export HOST_OPENCL_FLAGS="-O0 --coverage"
rm -f "$build"/HostKernels/*.gcda
failed=0
for ((shard = 0; shard < $(nproc); ++shard)); do
  GTEST_TOTAL_SHARDS=$(nproc) GTEST_SHARD_INDEX=$shard "$build/Testing/Unit/ChainMailUnitTests" --gtest_brief=1 \
    --gtest_filter=-Memory.* >"$build/tests-$shard.log" 2>&1 &
done
for job in $(jobs -p); do
  wait "$job" || failed=1
done
[ "$failed" -eq 0 ] || { echo "FAILED: tests"; cat "$build"/tests-*.log; exit 1; }
python3 "$source/Testing/Checks/kernel_coverage.py" "$build/HostKernels" "$source/Kernels" "$source/Testing/KernelCoverage.md" \
  ${3+"$3"}
