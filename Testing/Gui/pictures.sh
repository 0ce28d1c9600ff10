#!/usr/bin/env bash
# Makes the README's pictures of ParaView's window, Data/Images/window-*.png:
#     xvfb-run -a -s "-screen 0 1200x900x24" bash Testing/Gui/pictures.sh
# with the environment that ctest gives tests of the label Gui, see Testing/README.md.
. "$(dirname "${BASH_SOURCE[0]}")/window.sh"
needs_buttons xdotool
command -v import >/dev/null || fail "ImageMagick is not there, to take pictures of the screen with"
output=$CHAINMAIL_OUTPUT/GuiPictures
rm -rf "$output" && mkdir -p "$output" || fail "cannot write to $output"
event() { printf '<pqevent object="pqClientMainWindow%s" command="%s" arguments="%s" />\n' "$@"; }
tissue() { event /menubar activate menuTissue; event /menubar/menuTissue activate "action$1"; pauses 40; }
# ready NAME: the window waits until its picture has been taken.
ready() {
  event /menubar activate menu_File
  event /menubar/menu_File activate actionFileSaveServerState
  event /FileSaveServerStateDialog filesSelected "$output/$1.pvsm"
  pauses 200
}
{
  echo '<?xml version="1.0" ?><pqevents>'
  pauses 20
  tissue OpenExample
  ready probe
  tissue AddProbe
  tissue AddBlade
  event /pipelineBrowserDock/pipelineBrowser mousePress 1,1,0,54,11,/0:0/2:0
  event /pipelineBrowserDock/pipelineBrowser mouseRelease 1,0,0,54,11,/0:0/2:0
  pauses 40
  ready filter
  echo '</pqevents>'
} >"$output/events.xml"
play "$output" &
player=$!
# until_there COMMAND: until it succeeds.
until_there() {
  until "$@"; do
    kill -0 $player 2>/dev/null || fail "ParaView has ended: $(tail -n 30 "$output/log.txt")"
    sleep 1
  done
}
fill_screen() {
  local window
  window=$(xdotool search --onlyvisible --name '^ParaView [0-9]' 2>/dev/null | tail -n 1)
  [ -n "$window" ] && xdotool windowmove "$window" 0 0 windowsize "$window" 1200 900
}
until_there fill_screen
for name in probe filter; do
  until_there [ -s "$output/$name.pvsm" ]
  sleep 5
  import -window root "$here/../../Data/Images/window-$name.png" || fail "no picture"
done
wait $player
