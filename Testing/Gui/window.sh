# What the tests of ParaView's window share; they source this file.
set -u
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)

fail() { printf 'FAILED: %s\n' "$*" >&2; exit 1; }

[ -n "${DISPLAY:-}" ] || { echo "SKIPPED: there is no X display; Testing/run-all.sh starts one"; exit 125; }

# The widgets that events name often: the render view, the panel of the source's properties, its button Apply, the pipeline browser.
main=pqClientMainWindow
view=$main/centralwidget/MultiViewWidget/CoreWidget/qt_tabwidget_stackedwidget/MultiViewWidget1/Container/Frame.0/CentralWidgetFrame/Viewport
panel=$main/propertiesDock/propertiesPanel/scrollArea/qt_scrollarea_viewport/scrollAreaWidgetContents/PropertiesFrame/ProxyPanel
apply=$main/propertiesDock/propertiesPanel/Accept
browser=$main/pipelineBrowserDock/pipelineBrowser
# The dialog that the manager of plugins opens. After ParaView 5.11 it has no name of its own.
dialog=1pqFileDialog0
case $CHAINMAIL_PLUGIN in */paraview-5.11/*) dialog=pqFileDialog ;; esac

# needs_buttons [PROGRAM]: ends the test where the plugin has no buttons, or where a program that presses them is missing.
needs_buttons() {
  ldd "$CHAINMAIL_PLUGIN" | grep -qi qt || { echo "SKIPPED: the plugin was built without Qt's development files"; exit 125; }
  [ $# -eq 0 ] || command -v "$1" >/dev/null || { echo "SKIPPED: $1 is not there, to press keys and buttons with"; exit 125; }
}

# phantom NAME X Y Z: makes the folder $output anew, with a forearm of so many voxels, scan.vti.
phantom() {
  output=$CHAINMAIL_OUTPUT/$1
  rm -rf "$output" && mkdir -p "$output" || fail "cannot write to $output"
  "$CHAINMAIL_PVPYTHON" "$here/../../Data/make_forearm.py" "$output/scan.vti" --size "${@:2}" || fail "no phantom"
}

# pauses NUMBER [MILLISECONDS]: events of 50 ms each by default, for @WAIT@. While a test waits, the window's timers run.
pauses() {
  local n
  for ((n = 0; n < $1; ++n)); do printf '<pqevent object="pqClientMainWindow" command="pause" arguments="%s" />' "${2-50}"; done
}

# fill FOLDER [edits by sed]: makes FOLDER/events.xml of the standard input, with the files that every test has.
fill() {
  sed -e "s|@PLUGIN@|$CHAINMAIL_PLUGIN|; s|@SCAN@|$output/scan.vti|; s|@OUTPUT@|$1|" -e "${2-}" >"$1/events.xml"
}

# play FOLDER [options of ParaView]: fills in the widgets above (@VIEW@, ...) and plays FOLDER/events.xml, without the user's
# settings. The result is the status, and FOLDER/log.txt.
play() {
  sed -i "s|@VIEW@|$view|; s|@PANEL@|$panel|; s|@APPLY@|$apply|; s|@BROWSER@|$browser|; s|@DIALOG@|$dialog|" "$1/events.xml"
  mkdir -p -m 700 "$1/home"
  HOME="$1/home" XDG_RUNTIME_DIR="$1/home" timeout 840 \
    "$CHAINMAIL_PARAVIEW" --dr "${@:2}" --test-directory="$1" --test-script="$1/events.xml" --exit >"$1/log.txt" 2>&1
}

# The errors that ParaView and the plugin (critical:) reported in a FOLDER; fails where there are none.
errors() { grep -E 'ERR\||ERROR:|error:|critical:' "$1/log.txt"; }

# The process of the window that the background job PLAYER plays in.
window_process() {
  local window
  window=$(for child in $(cat /proc/"$1"/task/*/children); do cat "/proc/$child/task/$child/children"; done)
  [ -n "${window// /}" ] && echo "${window// /}"
}

# The processor time of all threads of the window that the background job PLAYER plays in, in hundredths of a second.
processor_time() {
  local window
  window=$(window_process "$1") || return 1
  sed 's/.*) //' "/proc/$window/stat" | { read -ra stat && echo $((stat[11] + stat[12])); }
}
