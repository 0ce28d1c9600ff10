#!/usr/bin/env bash
# Installs what is missing, builds and runs the main job: bash Data/main-job.sh [SCAN] [options of main_job.py]. It pulls
# and cuts the scan (any volume that ParaView reads; without one a generated forearm) and leaves pictures and the
# deformed volume in output/.
set -u
. "$(dirname "${BASH_SOURCE[0]}")/../Testing/prepare.sh"

case ${1-} in
  "" | -*) ;;
  *) [ -r "$1" ] || fail "There is no scan $1 that can be read." ;;
esac
install_packages "${build_packages[@]}" "${run_packages[@]}"
configure_and_build -DBUILD_TESTING=OFF
describe_machine
start_display
say "Running the main job"
PV_PLUGIN_PATH=$(sed -n 's/^CHAINMAIL_PLUGIN_FOLDER:INTERNAL=//p' "$build/CMakeCache.txt")
export PV_PLUGIN_PATH
pvbatch "$root/Data/main_job.py" --output "$root/output" "$@"
