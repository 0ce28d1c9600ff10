#!/usr/bin/env bash
# Runs every benchmark of a build and leaves a JSON file of each: bash Testing/Benchmarks/measure.sh BUILD RESULTS [options
# of the programs, e.g. --small --repeats=3 --device=NAME]. Ends with 1 where one refused to report, having run the others,
# and where BUILD has none.
#
# CHAINMAIL_BEFORE, the build of an earlier version: its frames of scans and drags are measured after this one's, for B11.
set -u
build=$1
results=$2
shift 2

export CHAINMAIL_VOLUMES=${CHAINMAIL_VOLUMES:-$(cd "$(dirname "${BASH_SOURCE[0]}")/../../.." && pwd)/shared/volumes}
mkdir -p "$results"
failed=()
measured=0
for program in "$build"/Testing/Benchmarks/ChainMailBench[A-Z]*; do
  [ -f "$program" ] && [ -x "$program" ] || continue
  name=${program##*/ChainMailBench}
  measured=$((measured + 1))
  rm -f "$results/$name.json"
  "$program" --json="$results/$name.json" "$@"
  status=$?
  [ $status -eq 0 ] || [ $status -eq 125 ] || failed+=("$name")
  before=${CHAINMAIL_BEFORE-}/Testing/Benchmarks/${program##*/}
  if [ -n "${CHAINMAIL_BEFORE-}" ] && [[ $name == @(Scan|Drag) ]]; then
    mkdir -p "$results/before"
    "$before" --json="$results/before/$name.json" "$@" || failed+=("$name before")
  fi
done
if [ $measured -eq 0 ]; then
  printf 'ERROR: %s has no benchmarks. Name a folder that was configured with -DBUILD_TESTING=ON and built.\n' "$build" >&2
  exit 1
fi
if [ ${#failed[@]} -gt 0 ]; then
  printf 'ERROR: no results of %s\n' "${failed[*]}" >&2
  exit 1
fi
