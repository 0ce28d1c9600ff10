#!/usr/bin/env bash
# Everything that is measured on a GPU, in one go, without VTK: bash Testing/Benchmarks/run-on-gpu.sh [options of the
# programs, e.g. --device=NAME or --small].
#
# Needs a C++ compiler, CMake, the OpenCL headers (C and C++) and the driver. Where headers or loader are not in the system's
# folders, OPENCL_HEADERS names the folder that holds CL/cl.h and CL/opencl.hpp, OPENCL_LIBRARY the file libOpenCL.so.1.
# The unit tests of propagation run where GoogleTest is found. Builds in build-gpu/ (or $CHAINMAIL_BUILD_DIR) and leaves
# benchmarks-DEVICE-DATE.json there, for report.py.
set -u
. "$(dirname "${BASH_SOURCE[0]}")/../prepare.sh"
build=${CHAINMAIL_BUILD_DIR:-$root/build-gpu}
here=$root/Testing/Benchmarks

options=(-DCHAINMAIL_ENGINE_ONLY=ON -DCHAINMAIL_BENCHMARKS=ON -DCMAKE_BUILD_TYPE=Release)
library=${OPENCL_LIBRARY:-$(ldconfig -p 2>/dev/null | sed -n 's/.*libOpenCL\.so\.1.* => //p' | head -n 1)}
[ -n "$library" ] && options+=("-DOpenCL_LIBRARY=$library")
[ -n "${OPENCL_HEADERS-}" ] &&
  options+=("-DOpenCL_INCLUDE_DIR=$OPENCL_HEADERS" "-DOPENCL_HPP_INCLUDE_DIR=$OPENCL_HEADERS")
tests=OFF
echo '#include <gtest/gtest.h>' | "${CXX:-c++}" -E -x c++ - >/dev/null 2>&1 && tests=ON
configure_and_build "${options[@]}" -DBUILD_TESTING=$tests

describe_machine
say "Propagation, bit for bit"
status=0
for option in "$@"; do
  case $option in --device=*) export CHAINMAIL_TEST_DEVICE=${option#--device=} ;; esac
done
"$build/Testing/Benchmarks/ChainMailChecksums" "$here/checksums.txt" || status=1
if [ $tests = ON ]; then
  ctest --test-dir "$build" --output-on-failure -R 'Unit\.(Propagat|Timestamp)|Benchmarks\.Baselines' || status=1
else
  say "GoogleTest was not found: the unit tests of propagation are left out"
fi
say "Measuring"
bash "$here/measure.sh" "$build" "$build/benchmarks" "$@" || status=1
device=$(sed -n 's/.*"device": "\([^"]*\)".*/\1/p' "$build/benchmarks/Machine.json" | head -n 1 | tr -cs 'A-Za-z0-9\n' '-')
merged=$build/benchmarks-$device-$(date -u +%Y-%m-%d).json
{
  separator='['
  for file in "$build"/benchmarks/*.json; do
    printf '%s\n' "$separator"
    cat "$file"
    separator=','
  done
  echo ']'
} >"$merged"
say "Results are in $merged"
exit $status
