#!/usr/bin/env bash
# Turn Bone with tissue that is grabbed already: a scan without bones gets a message and stays as it is, one with bones lets them
# turn and gets a pose, in one step of Undo. Over the other bone the key P takes the pose there.
. "$(dirname "${BASH_SOURCE[0]}")/window.sh"
needs_buttons xdotool
output=$CHAINMAIL_OUTPUT/GuiHoldBone
rm -rf "$output" && mkdir -p "$output/soft" || fail "cannot write to $output"
"$CHAINMAIL_PVPYTHON" "$here/makeBones.py" "$output" || fail "no bones"

# What was seen in a FOLDER, without repetition.
seen() { uniq "$1/watched.txt"; }

fill "$output/soft" "s|$output/scan.vti|$output/soft.vti|; s|@WAIT@|$(pauses 16)|; /Undo and Redo/,/@LONG@/d" <"$here/HoldBone.xml.in"
CHAINMAIL_WATCHED=$output/soft/watched.txt play "$output/soft" --script="$here/watchPose.py"
[ "$(grep -c '^critical: There is no bone in the middle of the view. Turn the view' "$output/soft/log.txt")" -eq 1 ] ||
  fail "without bones ParaView says: $(tail -n 30 "$output/soft/log.txt")"
others=$(errors "$output/soft" | grep -v '^critical:') # the message itself is critical
[ -z "$others" ] || fail "without bones ParaView reports: $others"
[ "$(seen "$output/soft" | tail -n 1)" = "0 1 - -" ] || fail "without bones there are Rotations, probes and pose: $(seen "$output/soft")"

fill "$output" "s|@WAIT@|$(pauses 16)|; s|@LONG@|$(pauses 120 2500)|" <"$here/HoldBone.xml.in"
CHAINMAIL_WATCHED=$output/watched.txt play "$output" --script="$here/watchPose.py" &
player=$!
give_up() { kill "$(window_process $player)" 2>/dev/null; fail "$@"; }
ended() { ! kill -0 $player 2>/dev/null; }
until [ -s "$output/ready.png" ] || ended; do sleep 0.2; done
# The first bone is from -11 to 11 along z, the other one from -37 to -15; a pose is at the voxel nearest to the middle.
undone=$(seen "$output" | tr '\n' ';')
expected='^0 1 - -;1 2 -?1\.0 -?1\.0;0 1 - -;1 2 -?1\.0 -?1\.0;$'
[[ $undone =~ $expected ]] || give_up "Turn Bone, Undo and Redo give $undone"
until seen "$output" | tail -n 1 | grep -qE '^1 2 -2[57]\.0 -2[57]\.0$'; do
  ended && fail "the key P did nothing: $(seen "$output"; tail -n 20 "$output/log.txt")"
  window=$(xdotool search --onlyvisible --name '^ParaView [0-9]' 2>/dev/null | tail -n 1)
  [ -z "$window" ] || xdotool windowfocus "$window" key p 2>/dev/null
  sleep 1
done
kill "$(window_process $player)" 2>/dev/null # it would go on waiting
wait $player
if errors "$output" >/dev/null; then fail "ParaView reports: $(errors "$output")"; fi
echo "Turn Bone, Undo, Redo and P: $undone $(seen "$output" | tail -n 1)"
