#!/usr/bin/env bash
# Dragging by mouse in ParaView's window as users have it, without a test script: since 6.1 ParaView then handles events
# within updates, too. A drag, which the tissue follows; its undo; two drags, the second one while the tissue of the first
# one settles; then an update that would go on for hours, stopped by the X beside the progress bar; and one that goes on
# to its end and gives what another deformation gives.
. "$(dirname "${BASH_SOURCE[0]}")/window.sh"
needs_buttons xdotool
phantom GuiMouse 64 56 72
watched=$output/watched.txt
mkdir -m 700 "$output/home" && touch "$watched" || fail "cannot write to $output"
HOME=$output/home XDG_RUNTIME_DIR=$output/home CHAINMAIL_WATCHED=$watched timeout 1800 \
  "$CHAINMAIL_PARAVIEW" --dr --script="$here/watchMouse.py" >"$output/log.txt" 2>&1 &
player=$!
trap 'kill "$player" 2>/dev/null; wait "$player" 2>/dev/null' EXIT

# wait_for WHAT COMMAND...: until COMMAND succeeds.
wait_for() {
  until "${@:2}"; do
    kill -0 $player 2>/dev/null || fail "ParaView ended while waiting for $1: $(tail "$watched" "$output/log.txt")"
    sleep 0.2
  done
}
count() { grep -c "$1" "$watched"; }
more() { [ "$(count "$1")" -gt "$2" ]; }
geometry() { WINDOW=; eval "$(xdotool search --onlyvisible --name '^ParaView [0-9]' getwindowgeometry --shell 2>/dev/null)"; [ -n "$WINDOW" ]; }
# Of the last picture: 2 how it was drawn, 3 and 4 the pixel of the probe's target, 5 to 7 its position, 8 to 10 its target.
picture() { grep '^picture' "$watched" | tail -n 1 | cut -d' ' -f"$1"; }
# Whether the last thing that happened, for a second, is a fine picture with another target than $1.
at_rest() {
  local size
  size=$(stat -c %s "$watched")
  sleep 1
  [ "$(stat -c %s "$watched")" -eq "$size" ] && tail -n 1 "$watched" | grep -q '^picture fine' && [ "$(picture 8-10)" != "$1" ]
}
# Above its pixel in the last picture, by $1 (default: 0).
hold_target() { hold_x=$((origin_x + $(picture 3))) hold_y=$((origin_y - $(picture 4) - ${1-0})); }
# drag PIXELS [MOVED]: what is held, upwards. MOVED is called while the button is down.
drag() {
  local step
  xdotool mousemove $((hold_x + 9)) $((hold_y + 9)) mousemove "$hold_x" "$hold_y" sleep 0.3 mousedown 1
  for step in 1 2 3 4 5 6 7 8; do
    xdotool mousemove "$hold_x" $((hold_y - step * $1 / 8)) sleep 0.2
  done
  "${2-true}"
  xdotool mouseup 1
}
# The tissue follows while the button is down.
follows() { wait_for "the tissue to follow" more '^frame' $((frames + 1)); }

wait_for "the scene" grep -q '^ready' "$watched"
wait_for "the window" geometry
# Where the view is: pixels of the screen against those of the view, which count from its lower edge.
find_view() {
  xdotool mousemove $((X + WIDTH * 6 / 10 + RANDOM % 9)) $((Y + HEIGHT / 2))
  sleep 0.5
  grep -q '^mouse' "$watched"
}
wait_for "the view" find_view
eval "$(xdotool getmouselocation --shell | sed 's/^\(.\)=/mouse_\1=/')"
read -r _ x y < <(grep '^mouse' "$watched" | tail -n 1)
origin_x=$((mouse_X - x)) origin_y=$((mouse_Y + y))
# The toolbar, which is too wide for its row, moves to one of its own when the window is there already: all in the view moves.
laid_out() { at_rest "" && at_rest "" && at_rest ""; }
wait_for "the window to be laid out" laid_out

before=$(picture 8-10) frames=$(count '^frame')
hold_target
drag 40 follows
wait_for "the end of a drag" at_rest "$before"
once=$(picture 8-10)

xdotool windowfocus "$WINDOW" key ctrl+z
wait_for "undo" at_rest "$once"
[ "$(picture 8-10)" = "$before" ] || fail "after Undo the target is at $(picture 8-10) and was at $before"

hold_target
begun=$(count '^begins')
drag 40
wait_for "the tissue to settle" more '^begins' "$begun"
hold_y=$((hold_y - 40))
drag 40
# Where one drag has brought the target from $before to $once, two bring it twice as far.
twice() {
  at_rest "$before" &&
    printf '%s\n' "$before" "$once" "$(picture 8-10)" | awk '{ y[NR] = $2 } END { exit !((y[3] - y[1]) > 1.8 * (y[2] - y[1])) }'
}
wait_for "the second of two drags" twice

xdotool windowfocus "$WINDOW" key j
clicks=()
for ((from_right = 8; from_right < WIDTH; from_right += 12)); do # which pixels the X has depends on fonts
  clicks+=(mousemove $((X + WIDTH - from_right)) $((Y + HEIGHT - 12)) click 1)
done
stopped() {
  xdotool "${clicks[@]}"
  sleep 0.5
  grep -q '^ends: The update was stopped' "$watched"
}
wait_for "the X" stopped
sleep 1
xdotool mousemove $((origin_x + 20)) $((origin_y - 20)) windowfocus "$WINDOW" key k
wait_for "the last update" grep -q '^compared' "$watched"
grep -q '^ends: None after 5 iterations' "$watched" || fail "the last update did not do what it should: $(cat "$watched")"
grep -q '^compared: the same' "$watched" || fail "the last update gives another state: $(cat "$watched")"
if errors "$output" >/dev/null; then fail "ParaView reports: $(errors "$output")"; fi
echo "dragged, undone, dragged while it settled, stopped, and settled"
