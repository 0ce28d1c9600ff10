#!/usr/bin/env bash
# The keys 1 and 2 put the ends of the selected probe on the tissue under the mouse, in ParaView's window; and the button ? opens
# the page of the filter.
set -u
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
. "$here/window.sh"

command -v xdotool >/dev/null || { echo "SKIPPED: xdotool is not there, to press keys with"; exit 125; }
ldd "$CHAINMAIL_PLUGIN" | grep -qi qt || { echo "SKIPPED: the plugin was built without Qt's development files"; exit 125; }
output=$CHAINMAIL_OUTPUT/GuiPick
rm -rf "$output" && mkdir -p "$output" || fail "cannot write to $output"
"$CHAINMAIL_PVPYTHON" "$here/../../Data/make_forearm.py" "$output/scan.vti" --size 40 36 44 || fail "no phantom"

# pauses NUMBER MILLISECONDS
pauses() { local n; for ((n = 0; n < $1; ++n)); do printf '<pqevent object="pqClientMainWindow" command="pause" arguments="%s" />' "$2"; done; }
sed -e "s|@SCAN@|$output/scan.vti|; s|@OUTPUT@|$output|; s|@WAIT@|$(pauses 12 50)|; s|@LONG@|$(pauses 120 2500)|" \
  "$here/PickTissue.xml.in" >"$output/events.xml"
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
press 2 '$4 == $1 && $5 == $2 && $6 == $3'
# It would go on waiting.
kill "$(window_process $player)" 2>/dev/null
wait $player
if errors "$output" >/dev/null; then fail "ParaView reports: $(errors "$output")"; fi
echo "the keys put the probe's ends at $(tail -n 1 "$output/places.txt")"
