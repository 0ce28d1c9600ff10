#!/usr/bin/env bash
# Runs scenes of SmallScenes ($1) under oclgrind, which simulates an OpenCL device: any access out of bounds, race
# between work-items, use of what nothing was written to, or OpenCL call that the standard does not allow is an error.
#
# What oclgrind 21.10 says is judged by its log alone: when a program ends that has built OpenCL programs, it often
# aborts while it frees its own memory. It takes the place of the whole OpenCL library, by LD_PRELOAD, so no other device
# is there to choose.
set -u
program=$1
command -v oclgrind >/dev/null || { echo "oclgrind was not found"; exit 125; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
unset CHAINMAIL_TEST_DEVICE
export CHAINMAIL_CACHE_DIR= # options that oclgrind adds to a program's own are not in the key of the engine's cache

# Uninitialised values are looked for without optimisation: of what the optimiser makes, that part of oclgrind does not
# know the instruction `freeze`, and it takes the first half of a vector's store for a store of nothing. That is slow, so
# two scenes have to do; valgrind.sh looks for the same in all. Races are looked for with it. What
# is inlined in any case (CHAINMAIL_INLINE) comes out with another instruction that oclgrind does not know.
#
# Scenes run as on a GPU, element by element with many work-items; two of them again as on a processor, with vectors and
# a single work-item for a brick (WholeBuffers.cpp). Those are not optimised either: what the optimiser makes of vectors
# of two, halves of larger ones among them, comes out wrong in oclgrind, so that displaced tissue looks to be at rest.
check() {
  local name=$1 scene=$2
  shift 2
  oclgrind --num-threads 1 "$@" --log "$folder/$name.log" "$program" "$scene" >"$folder/$name.out" 2>&1
  if ! grep -q "^all played" "$folder/$name.out" || [ -s "$folder/$name.log" ]; then
    { echo "FAILED: $name"; tail -n 20 "$folder/$name.out"; head -n 100 "$folder/$name.log"; } >"$folder/$name.failed"
  fi
}

scenes=$("$program" --count) || exit 1
running=0
for run in uninitialised-1 uninitialised-2 vectors-1 vectors-5 $(seq -f 'races-%g' 0 $((scenes - 1))); do
  if [ "$running" -ge "$(nproc)" ]; then
    wait -n
    running=$((running - 1))
  fi
  case $run in
    uninitialised-*)
      check "$run" "${run#*-}" --uninitialized --build-options "-DCHAINMAIL_INLINE=inline -cl-opt-disable" 2>/dev/null & ;;
    vectors-*)
      SMALL_SCENES_PROCESSOR=1 check "$run" "${run#*-}" --data-races --build-options "-DCHAINMAIL_INLINE=inline -cl-opt-disable" \
        2>/dev/null & ;;
    *)
      check "$run" "${run#*-}" --data-races --check-api --build-options -DCHAINMAIL_INLINE=inline 2>/dev/null & ;;
  esac
  running=$((running + 1))
done
wait
if cat "$folder"/*.failed 2>/dev/null; then
  exit 1
fi
echo "$scenes scenes, nothing found"
