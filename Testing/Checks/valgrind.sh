#!/usr/bin/env bash
# Runs the scenes of SmallScenes under valgrind's memcheck, with the kernels as C++: kernels that PoCL compiles use
# instructions that valgrind does not know, and PoCL and the compiler inside it make thousands of reports of their own.
# So all code is the project's, and nothing of it is suppressed. The engine is built anew in the folder $2 from the
# sources $1.
set -u
source=$1
build=$2
command -v valgrind >/dev/null || { echo "valgrind was not found"; exit 125; }
cmake -S "$source" -B "$build" -DCHAINMAIL_ENGINE_ONLY=ON -DCHAINMAIL_HOST_KERNELS=ON -DCHAINMAIL_CHECKS=ON \
  -DCMAKE_BUILD_TYPE=Debug &&
  cmake --build "$build" --parallel "${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}" --target ChainMailSmallScenes || exit 1
program=$build/Testing/Checks/ChainMailSmallScenes

# First without valgrind: that compiles the kernels, in which undefined behaviour is found by their compiler.
export HOST_OPENCL_FLAGS="-O1 -fsanitize=undefined -fno-sanitize-recover=all"
rm -f "$build/kernels"
HOST_OPENCL_TRACE=$build/kernels "$program" >"$build/undefined.out" 2>&1 ||
  { echo "FAILED: undefined behaviour"; tail -n 40 "$build/undefined.out"; exit 1; }
# relaxBatch and turnClusters are for CPUs, and the device of kernels as C++ is a GPU.
all=$(sed -n 's/^kernel void \([A-Za-z0-9_]*\).*/\1/p' "$source"/Kernels/*/*.cl | grep -vx -e relaxBatch -e turnClusters | sort -u)
[ -n "$all" ] || { echo "FAILED: no kernels were found"; exit 1; }
missing=$(comm -23 <(echo "$all") <(sort -u "$build/kernels"))
[ -z "$missing" ] || { echo "FAILED: the scenes do not use these kernels:" $missing; exit 1; }

# What the process still points to when it ends is no leak: the libraries of kernels stay open.
scenes=$("$program" --count) || exit 1
seq 0 $((scenes - 1)) | xargs -P "$(nproc)" -I @ sh -c 'valgrind --quiet --error-exitcode=9 --leak-check=full \
  --errors-for-leak-kinds=definite,indirect,possible --track-origins=yes --suppressions="$3" "$1" @ \
  >"$2/valgrind-@.log" 2>&1' sh "$program" "$build" "$source/Testing/Checks/valgrind.supp"
status=$?
grep -l '^==' "$build"/valgrind-*.log | xargs -r cat
for ((scene = 0; scene < scenes; ++scene)); do
  grep -q '^all played' "$build/valgrind-$scene.log" ||
    { echo "FAILED: scene $scene"; tail -n 20 "$build/valgrind-$scene.log"; status=1; }
done
[ "$status" -eq 0 ] && echo "$scenes scenes, nothing found"
exit "$status"
