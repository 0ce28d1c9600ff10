#!/usr/bin/env bash
# Installs what is missing, builds and runs every test: bash Testing/run-all.sh [options for ctest, e.g. -L Unit].
set -u
. "$(dirname "${BASH_SOURCE[0]}")/prepare.sh"

install_packages "${build_packages[@]}" "${run_packages[@]}" "${test_packages[@]}"
configure_and_build -DBUILD_TESTING=ON -DCHAINMAIL_WARNINGS_AS_ERRORS="${CI:+ON}"
describe_machine
start_display
say "Running the tests"
ctest --test-dir "$build" --output-on-failure --no-tests=error --parallel "${CTEST_PARALLEL_LEVEL:-$(nproc)}" "$@"
