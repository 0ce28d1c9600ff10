#!/usr/bin/env bash
# Errors in ParaView's window, in Interactive mode: the view goes on showing the scan, or the last good result, the message
# comes once, the process comes to rest, and after the correction the probe pulls as before.
. "$(dirname "${BASH_SOURCE[0]}")/window.sh"
phantom GuiErrors 40 36 44
# While the test waits, the window's timers run.
{ sed '/<!-- The panel/,$d' "$here/PullTissue.xml.in" && cat "$here/ErrorsWindow.xml.in"; } |
  fill "$output" "s|@X@|61|; s|@WAIT@|$(pauses 30)|"
(unset PV_PLUGIN_PATH && play "$output") & # no plugin but the one that the events load
player=$!

# What it takes to wait and to save a picture: with tissue that has settled, and with an error.
declare -A at
for picture in settled settled-later error error-later; do
  until [ -s "$output/$picture.png" ] || ! kill -0 $player 2>/dev/null; do sleep 0.1; done
  at[$picture]=$(processor_time $player) || break
done
wait $player
status=$?
[ $status -eq 0 ] || fail "ParaView ended with status $status: $(tail -n 30 "$output/log.txt")"
[ -n "${at[error-later]-}" ] || fail "the processor time of the window was not found"
settled=$((at[settled-later] - at[settled])) error=$((at[error-later] - at[error]))
echo "hundredths of a second: $settled with settled tissue, $error with an error"
[ $settled -gt 0 ] || fail "the window draws in no time: it is another process that was looked at"
# 30 pictures more take several times as long.
[ $error -lt $((3 * settled / 2 + 100)) ] || fail "the window does not come to rest after an error"
[ "$(errors "$output" | grep -c 'holds no tissue')" -eq 2 ] && [ "$(errors "$output" | wc -l)" -eq 2 ] ||
  fail "instead of the two errors: $(errors "$output")"
"$CHAINMAIL_PVPYTHON" "$here/checkErrorsWindow.py" "$output" || fail "see above"
