#!/usr/bin/env bash
# Builds, measures the trade of speed for accuracy and reports it: bash Testing/Trade/run.sh [options of measure.py].
#
# Replaces the tables in Data/Choosing.md and the plots in Data/Images. The numbers are left in trade.json in trade/ of the
# build folder, with the solutions by finite elements, which are not computed again.
set -u
. "$(dirname "${BASH_SOURCE[0]}")/../prepare.sh"

install_packages "${build_packages[@]}" "${run_packages[@]}" "${test_packages[@]}" "${benchmark_packages[@]}"
configure_and_build -DBUILD_TESTING=ON -DCMAKE_BUILD_TYPE=Release
describe_machine
export CHAINMAIL_VOLUMES=${CHAINMAIL_VOLUMES:-$root/../shared/volumes}
export CHAINMAIL_OPTIMUM=$build/Testing/Trade/ChainMailOptimum
packages=$(dirname "$(find "$build" -path "$build/Testing" -prune -o -path '*/chainmail/ChainMailFilters*.so' -print -quit)")
export PYTHONPATH=$(dirname "$packages")${PYTHONPATH:+:$PYTHONPATH}
say "Measuring"
pvpython "$root/Testing/Trade/measure.py" "$build/trade" "$@" || fail "The measurement stopped, see above."
say "Reporting"
/usr/bin/python3 "$root/Testing/Trade/report.py" "$build/trade" "$root/Data" "$root/Data/Images" ||
  fail "The report could not be written."
