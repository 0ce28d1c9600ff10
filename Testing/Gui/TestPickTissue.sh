#!/usr/bin/env bash
# The keys 1 and 2 put the ends of the selected probe on the tissue under the mouse, in ParaView's window, 1 with the pull as it was;
# and the button ? opens the page of the filter.
. "$(dirname "${BASH_SOURCE[0]}")/window.sh"
needs_buttons xdotool
phantom GuiPick 40 36 44
fill "$output" "s|@WAIT@|$(pauses 12)|; s|@LONG@|$(pauses 120 2500)|" <"$here/PickTissue.xml.in"
CHAINMAIL_WATCHED=$output/places.txt play "$output" --script="$here/watchProbe.py" &
player=$!
ended() { ! kill -0 $player 2>/dev/null; }

until [ -s "$output/ready.png" ] || ended; do sleep 0.2; done
# press KEY CONDITION: until the last line of the places (position and target, x y z each) fulfils it.
press() {
  until tail -n 1 "$output/places.txt" | awk "BEGIN { status = 1 } { status = !($2) } END { exit status }"; do
    ended && fail "the key $1 did nothing, the probe is at $(tail -n 1 "$output/places.txt"): $(tail -n 20 "$output/log.txt")"
    window=$(xdotool search --onlyvisible --name '^ParaView [0-9]' 2>/dev/null | tail -n 1)
    [ -z "$window" ] || xdotool windowfocus "$window" key "$1" 2>/dev/null
    sleep 1
  done
}
press 1 '$3 > 20'
# The pull goes along.
awk '{ x = $4 - $1; y = $5 - $2; z = $6 - $3 } NR == 1 { a = x; b = y; c = z }
     END { exit !((x - a) ^ 2 + (y - b) ^ 2 + (z - c) ^ 2 < 1e-9) }' "$output/places.txt" ||
  fail "the key 1 left the target behind: $(sed -n '1p;$p' "$output/places.txt")"
press 2 '$4 == $1 && $5 == $2 && $6 == $3'
# It would go on waiting.
kill "$(window_process $player)" 2>/dev/null
wait $player
if errors "$output" >/dev/null; then fail "ParaView reports: $(errors "$output")"; fi
echo "the keys put the probe's ends at $(tail -n 1 "$output/places.txt")"
