#!/usr/bin/env bash
# Drags that end in other ways than by letting go on tissue: where they began, off the tissue, while another source is
# selected, while the view is closed. Each time ParaView draws finely again, the drag is one step of Undo, and none
# ends in an error.
. "$(dirname "${BASH_SOURCE[0]}")/window.sh"
needs_buttons
phantom GuiDragEnds 40 36 44
fill "$output" "s|@WAIT@|$(pauses 12)|" <"$here/DragEnds.xml.in"
CHAINMAIL_WATCHED=$output/watched.txt play "$output" --script="$here/watchDrag.py"
status=$?
[ $status -eq 0 ] || fail "ParaView ended with status $status: $(tail -n 30 "$output/log.txt")"
if errors "$output" >/dev/null; then fail "ParaView reports: $(errors "$output")"; fi
python3 "$here/checkDragEnds.py" "$output" || fail "see above"
