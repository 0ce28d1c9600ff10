#!/usr/bin/env bash
# One click each: grab the tissue of a scan that was just opened, cut it, drill into it; and a drag between. The volume that is saved then is
# deformed, cut and drilled, the saved state gives the same one to the bit, and nothing reports an error. While something is
# dragged the window shows sketches, and the pipeline stays as it is.
set -u
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
. "$here/window.sh"

output=$CHAINMAIL_OUTPUT/GuiGrab
rm -rf "$output" && mkdir -p "$output" || fail "cannot write to $output"
"$CHAINMAIL_PVPYTHON" "$here/../../Data/make_forearm.py" "$output/scan.vti" --size 64 56 72 || fail "no phantom"

wait=$(for ((n = 0; n < 12; ++n)); do printf '<pqevent object="pqClientMainWindow" command="pause" arguments="50" />'; done)
sed -e "s|@SCAN@|$output/scan.vti|; s|@OUTPUT@|$output|; s|@WAIT@|$wait|" "$here/GrabTissue.xml.in" >"$output/events.xml"
CHAINMAIL_WATCHED=$output/watched.txt PARAVIEW_LOG_APPLICATION_VERBOSITY=INFO \
  play "$output" --script="$here/watchDrag.py" "--log=$output/drag.log,INFO"
status=$?
if [ $status -ne 0 ] && grep -q "menuTissue" "$output/log.txt"; then
  ldd "$CHAINMAIL_PLUGIN" | grep -qi qt || { echo "SKIPPED: the plugin was built without Qt's development files"; exit 125; }
fi
[ $status -eq 0 ] || fail "ParaView ended with status $status: $(tail -n 30 "$output/log.txt")"
if errors "$output" >/dev/null; then fail "ParaView reports: $(errors "$output")"; fi
"$CHAINMAIL_PVPYTHON" "$here/checkGrabTissue.py" "$output" || fail "see above"
