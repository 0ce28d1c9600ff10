#!/usr/bin/env bash
# Builds, measures and reports: bash Testing/Benchmarks/run.sh [options of the programs]. Takes 75 to 90 minutes
# on two cores.
#
# Leaves the table and all results in Testing/Benchmarks/Results.md, the numbers in Results.json beside it and the plots in
# Data/Images. With --small, which only shows that everything runs, they go to benchmarks/ in the build folder.
set -u
. "$(dirname "${BASH_SOURCE[0]}")/../prepare.sh"

install_packages "${build_packages[@]}" "${run_packages[@]}" "${test_packages[@]}" "${benchmark_packages[@]}"
configure_and_build -DBUILD_TESTING=ON -DCMAKE_BUILD_TYPE=Release
describe_machine
results=$build/benchmarks
here=$root/Testing/Benchmarks
say "Measuring"
"$build/Testing/Benchmarks/ChainMailChecksums" "$here/checksums.txt" || fail "Propagation gives other bits here."
status=0
bash "$here/measure.sh" "$build" "$results" "$@" || status=1
say "Reporting"
case " $* " in
  *" --small "*) into=("$results" "$results") ;;
  *) into=("$here" "$root/Data/Images") ;;
esac
/usr/bin/python3 "$here/report.py" "$results" "${into[@]}" || fail "The report could not be written."
exit $status
