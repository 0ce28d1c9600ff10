#!/usr/bin/env bash
# Opens a scan and its labels, presses Turn Bone, and drags the box: what the pose says is where the box is, to the digit, and
# the saved state moves that bone, and no other, by the box's matrix. Each drag and the button are one step of Undo.
. "$(dirname "${BASH_SOURCE[0]}")/window.sh"
needs_buttons
output=$CHAINMAIL_OUTPUT/GuiTurnBone
rm -rf "$output" && mkdir -p "$output" || fail "cannot write to $output"
"$CHAINMAIL_PVPYTHON" "$here/makeBones.py" "$output" || fail "no bones"
fill "$output" "s|@WAIT@|$(pauses 16)|; s|@BALL@|0.5,0.488|; s|@NEAR@|0.51,0.48|; s|@FAR@|0.53,0.46|" <"$here/TurnBone.xml.in"
CHAINMAIL_WATCHED=$output/watched.txt play "$output" --script="$here/watchBox.py"
status=$?
[ $status -eq 0 ] || fail "ParaView ended with status $status: $(tail -n 30 "$output/log.txt")"
if errors "$output" >/dev/null; then fail "ParaView reports: $(errors "$output")"; fi
"$CHAINMAIL_PVPYTHON" "$here/checkTurnBone.py" "$output" || fail "see above"
