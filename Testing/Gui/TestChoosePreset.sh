#!/usr/bin/env bash
# A preset of the plugin, chosen in ParaView's window: it stands on the list as soon as the plugin is loaded, and the saved
# state has its colours and opacities, in Hounsfield units.
. "$(dirname "${BASH_SOURCE[0]}")/window.sh"
phantom GuiPreset 64 56 72
fill "$output" <"$here/ChoosePreset.xml.in"
# No plugin but the one that the events load. With the variable ParaView does not ask whether a volume may take long.
(unset PV_PLUGIN_PATH && DASHBOARD_TEST_FROM_CTEST=1 play "$output")
status=$?
[ $status -eq 0 ] || fail "ParaView ended with status $status: $(tail -n 30 "$output/log.txt")"
if errors "$output" >/dev/null; then fail "ParaView reports: $(errors "$output")"; fi
"$CHAINMAIL_PVPYTHON" "$here/checkChoosePreset.py" "$output" || fail "see above"
