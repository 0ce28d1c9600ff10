#!/usr/bin/env bash
# The X beside ParaView's progress bar stops a deformation, while kernels are compiled and while tissue settles: the update
# ends early, says so, and the next Apply works.
. "$(dirname "${BASH_SOURCE[0]}")/window.sh"
needs_buttons xdotool
phantom GuiStop 64 56 72
mkdir "$output/kernels" || fail "cannot write to $output"
fill "$output" "s|@WAIT@|$(pauses 40)|" <"$here/StopUpdate.xml.in"
# With a cache of its own there are kernels to compile, in PoCL, too, unless that is done ahead.
CHAINMAIL_COMPILE_AHEAD=0 CHAINMAIL_CACHE_DIR=$output/kernels POCL_CACHE_DIR=$output/kernels \
  CHAINMAIL_WATCHED=$output/watched.txt play "$output" --script="$here/watchStop.py" &
player=$!
ended() { ! kill -0 $player 2>/dev/null; }

# The bar is at the right end of the window's last line; which pixels the X has depends on fonts. Clicks beside it do nothing.
click() {
  local WINDOW X Y WIDTH HEIGHT SCREEN from_right clicks=()
  eval "$(xdotool search --onlyvisible --name '^ParaView [0-9]' getwindowgeometry --shell 2>/dev/null)"
  [ -n "${HEIGHT-}" ] || return
  for ((from_right = 8; from_right < WIDTH; from_right += 12)); do
    clicks+=(mousemove $((X + WIDTH - from_right)) $((Y + HEIGHT - 12)) click 1)
  done
  xdotool "${clicks[@]}" 2>/dev/null
}
# stop TEXT: clicks while an update says TEXT, until it ends.
stop() {
  local ends
  ends=$(cat "$output/watched.txt" 2>/dev/null | grep -c "^ends")
  until tail -n 1 "$output/watched.txt" 2>/dev/null | grep -q "$1"; do
    ended && fail "no update came to '$1': $(cat "$output/watched.txt"; tail -n 20 "$output/log.txt")"
    sleep 0.2
  done
  until [ "$(grep -c '^ends' "$output/watched.txt")" -gt "$ends" ]; do
    ended && fail "nothing stops it: $(cat "$output/watched.txt"; tail -n 20 "$output/log.txt")"
    click
    sleep 1
  done
}
stop 'Compiling kernels'
stop 'ChainMail: settling'
wait $player
status=$?
cat "$output/watched.txt"
[ $status -eq 0 ] || fail "ParaView ended with status $status: $(tail -n 30 "$output/log.txt")"
if errors "$output" >/dev/null; then fail "ParaView reports: $(errors "$output")"; fi
[ "$(grep -c '^ends: The update was stopped' "$output/watched.txt")" -ge 2 ] || fail "the updates do not say that they were stopped"
tail -n 1 "$output/watched.txt" | grep -q 'ends: None; 5 iterations' || fail "the last update did not do what it should"
