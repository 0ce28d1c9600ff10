#!/usr/bin/env bash
# A preset of the plugin, chosen in ParaView's window: it stands on the list as soon as the plugin is loaded, and the saved
# state has its colours and opacities, in Hounsfield units.
set -u
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
. "$here/window.sh"

output=$CHAINMAIL_OUTPUT/GuiPreset
rm -rf "$output" && mkdir -p "$output" || fail "cannot write to $output"
"$CHAINMAIL_PVPYTHON" "$here/../../Data/make_forearm.py" "$output/scan.vti" --size 64 56 72 || fail "no phantom"
sed -e "s|@PLUGIN@|$CHAINMAIL_PLUGIN|; s|@SCAN@|$output/scan.vti|; s|@OUTPUT@|$output|" "$here/ChoosePreset.xml.in" >"$output/events.xml"
# No plugin but the one that the events load. With the variable ParaView does not ask whether a volume may take long.
(unset PV_PLUGIN_PATH && DASHBOARD_TEST_FROM_CTEST=1 play "$output")
status=$?
[ $status -eq 0 ] || fail "ParaView ended with status $status: $(tail -n 30 "$output/log.txt")"
if errors "$output" >/dev/null; then fail "ParaView reports: $(errors "$output")"; fi
"$CHAINMAIL_PVPYTHON" "$here/checkChoosePreset.py" "$output" || fail "see above"
