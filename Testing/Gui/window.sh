# What the tests of ParaView's window share; they source this file.

fail() { printf 'FAILED: %s\n' "$*" >&2; exit 1; }

[ -n "${DISPLAY:-}" ] || { echo "SKIPPED: there is no X display; Testing/run-all.sh starts one"; exit 125; }

# The dialog that the manager of plugins opens, which lost its name after ParaView 5.11.
dialog=1pqFileDialog0
case $CHAINMAIL_PLUGIN in */paraview-5.11/*) dialog=pqFileDialog ;; esac

# play FOLDER [options of ParaView]: plays FOLDER/events.xml, with nothing of the user's settings; @DIALOG@ is the one
# above. The result is the status, and FOLDER/log.txt.
play() {
  sed -i "s|@DIALOG@|$dialog|" "$1/events.xml"
  mkdir -p -m 700 "$1/home"
  HOME="$1/home" XDG_RUNTIME_DIR="$1/home" timeout 840 \
    "$CHAINMAIL_PARAVIEW" --dr "${@:2}" --test-directory="$1" --test-script="$1/events.xml" --exit >"$1/log.txt" 2>&1
}

# The errors that ParaView reported in a FOLDER; fails where there are none.
errors() { grep -E 'ERR\||ERROR:|error:' "$1/log.txt"; }

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
