#!/usr/bin/env bash
# ParaView's window, driven: load the plugin, open a scan, add a probe and the filter, Apply, save. Fails when an event
# cannot be played, when a filter reports an error (ParaView itself would go on), or when the saved result is not what
# the scene must give. That an error is noticed is tested as well, by a second run with the probe in the air.
. "$(dirname "${BASH_SOURCE[0]}")/window.sh"
phantom Gui 64 56 72

# pull NAME X: runs the events with the probe at x = X.
pull() {
  mkdir -p "$output/$1"
  fill "$output/$1" "s|@X@|$2|" <"$here/PullTissue.xml.in"
  # No plugin but the one that the events load.
  (unset PV_PLUGIN_PATH && play "$output/$1")
}

pull good 1
status=$?
[ $status -eq 0 ] || fail "ParaView ended with status $status: $(tail -n 30 "$output/good/log.txt")"
if errors "$output/good" >/dev/null; then fail "ParaView reports: $(errors "$output/good")"; fi
"$CHAINMAIL_PVPYTHON" "$here/checkPullTissue.py" "$output/scan.vti" "$output/good" || fail "see above"

pull bad 61
errors "$output/bad" | grep -q . || fail "a probe in the air went unnoticed: $(tail -n 30 "$output/bad/log.txt")"
grep -q 'holds no tissue' "$output/bad/log.txt" || fail "the message about a probe in the air is not in the log"
echo "the window works, and its errors are noticed"
