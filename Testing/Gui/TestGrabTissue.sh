#!/usr/bin/env bash
# One click each: grab the tissue of a scan that was just opened, cut it, drill into it; and a drag between. The volume that is saved then is
# deformed, cut and drilled, the saved state gives the same one to the bit, and nothing reports an error. While something is
# dragged the window shows previews, and the pipeline stays as it is.
. "$(dirname "${BASH_SOURCE[0]}")/window.sh"
needs_buttons
phantom GuiGrab 64 56 72
fill "$output" "s|@WAIT@|$(pauses 12)|" <"$here/GrabTissue.xml.in"
CHAINMAIL_WATCHED=$output/watched.txt PARAVIEW_LOG_APPLICATION_VERBOSITY=INFO \
  play "$output" --script="$here/watchDrag.py" "--log=$output/drag.log,INFO"
status=$?
[ $status -eq 0 ] || fail "ParaView ended with status $status: $(tail -n 30 "$output/log.txt")"
if errors "$output" >/dev/null; then fail "ParaView reports: $(errors "$output")"; fi
"$CHAINMAIL_PVPYTHON" "$here/checkGrabTissue.py" "$output" || fail "see above"
