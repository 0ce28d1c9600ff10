#!/usr/bin/env bash
# The unit tests on another driver than PoCL: rusticl, Mesa's OpenCL, on its processor llvmpipe, once as the processor that
# it is and once as a GPU. $1 is the program of the tests. New buffers are poisoned, as in all unit tests. Takes hours: to
# launch a kernel takes longer there than to run it, above all before Mesa 25. Without threads of its own (LP_NUM_THREADS)
# llvmpipe runs a kernel where it is launched, which is up to three times as fast for such small ones.
set -u
tests=$1
icd=$(ls /etc/OpenCL/vendors/rusticl*.icd 2>/dev/null | head -n 1)
[ -n "$icd" ] || { echo "rusticl was not found (on Debian the package mesa-opencl-icd)"; exit 125; }
export OCL_ICD_VENDORS=$icd RUSTICL_ENABLE=llvmpipe CHAINMAIL_TEST_DEVICE=llvmpipe LP_NUM_THREADS=0
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# Left out:
#   Memory.*           they limit PoCL's memory
#   *LargeGrids*, Extremes.*  llvmpipe says that it has 2 GiB, less than they need
#   Process.AFork*     since Mesa 26 exit() waits for ever in any forked child of a process with a command queue, ours or not
leave_out="Memory.*:LargeGrids.*:Extremes.*:Process.AFork*"

status=0
for type in cpu gpu; do
  export RUSTICL_DEVICE_TYPE=$type GTEST_TOTAL_SHARDS=24
  seq 0 $((GTEST_TOTAL_SHARDS - 1)) | xargs -P "$(nproc)" -I @ sh -c 'GTEST_SHARD_INDEX=@ "$1" --gtest_brief=1 \
    --gtest_filter="-$2" >"$3/@.log" 2>&1' sh "$tests" "$leave_out" "$work" || status=1
  echo "as $type: $(cat "$work"/*.log | awk '/^\[  PASSED  \]/ { sum += $4 } END { print sum + 0 }') passed"
  [ "$status" -eq 0 ] || { grep -h -A12 -e 'Failure$' -e FAILED "$work"/*.log; exit 1; }
done
