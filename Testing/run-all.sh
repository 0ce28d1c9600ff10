#!/usr/bin/env bash
# Installs what is missing, builds and runs the tests: bash Testing/run-all.sh [--all] [options for ctest, e.g. -L Unit]. With
# --all the long ones, too.
set -u
. "$(dirname "${BASH_SOURCE[0]}")/prepare.sh"

checks=OFF
if [ "${1-}" = --all ]; then
  checks=ON
  test_packages+=("${check_packages[@]}")
  shift
fi

install_packages "${build_packages[@]}" "${run_packages[@]}" "${test_packages[@]}"
configure_and_build -DBUILD_TESTING=ON -DCHAINMAIL_CHECKS="$checks" -DCHAINMAIL_WARNINGS_AS_ERRORS="${CI:+ON}"
describe_machine
start_display
say "Running the tests"
ctest --test-dir "$build" --output-on-failure --no-tests=error --parallel "${CTEST_PARALLEL_LEVEL:-$(nproc)}" "$@"
