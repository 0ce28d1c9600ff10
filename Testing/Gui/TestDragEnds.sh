#!/usr/bin/env bash
# Drags that end in other ways than by letting go on tissue: where they began, off the tissue, while another source is
# selected, while the view is closed. Each time ParaView draws finely again, the drag is one step of Undo, and a mistake is
# reported when the drag has ended.
set -u
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
. "$here/window.sh"

output=$CHAINMAIL_OUTPUT/GuiDragEnds
rm -rf "$output" && mkdir -p "$output" || fail "cannot write to $output"
"$CHAINMAIL_PVPYTHON" "$here/../../Data/make_forearm.py" "$output/scan.vti" --size 40 36 44 || fail "no phantom"

wait=$(for ((n = 0; n < 12; ++n)); do printf '<pqevent object="pqClientMainWindow" command="pause" arguments="50" />'; done)
sed -e "s|@SCAN@|$output/scan.vti|; s|@OUTPUT@|$output|; s|@WAIT@|$wait|" "$here/DragEnds.xml.in" >"$output/events.xml"
CHAINMAIL_WATCHED=$output/watched.txt play "$output" --script="$here/watchDrag.py"
status=$?
if [ $status -ne 0 ] && grep -q "menuTissue" "$output/log.txt"; then
  ldd "$CHAINMAIL_PLUGIN" | grep -qi qt || { echo "SKIPPED: the plugin was built without Qt's development files"; exit 125; }
fi
[ $status -eq 0 ] || fail "ParaView ended with status $status: $(tail -n 30 "$output/log.txt")"
# Not for each picture of the drag, but once, when it has ended.
[ "$(errors "$output" | grep -c 'holds no tissue')" -eq 1 ] && [ "$(errors "$output" | wc -l)" -eq 1 ] ||
  fail "instead of the error at the end of the drag: $(errors "$output")"
python3 "$here/checkDragEnds.py" "$output" || fail "see above"
