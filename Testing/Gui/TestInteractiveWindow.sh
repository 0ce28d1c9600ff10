#!/usr/bin/env bash
# Interactive mode in ParaView's window: the tissue settles while nobody touches anything, and that ends by itself; the
# button Reset brings it back; a probe that is dragged then pulls anew. The volumes saved on the way have to be those of
# a script that updates for as long as the filter asks for it, to the bit: so the window made every update that was
# asked for, and no other.
. "$(dirname "${BASH_SOURCE[0]}")/window.sh"
phantom GuiInteractive 64 56 72
# While the test waits, the window's timers run.
{ sed '/<!-- The panel/,$d' "$here/PullTissue.xml.in" && cat "$here/InteractiveWindow.xml.in"; } |
  fill "$output" "s|@X@|1|; s|@WAIT@|$(pauses 60)|"
(unset PV_PLUGIN_PATH && play "$output") & # no plugin but the one that the events load
player=$!

# Once the tissue has settled the window takes no processor time. The file is there before the window has closed its dialog, and
# other processes may delay that, so the quietest second counts.
until [ -s "$output/settled.vtk" ] || ! kill -0 $player 2>/dev/null; do sleep 0.1; done
quietest=
for second in 1 2 3 4 5 6; do
  before=$(processor_time $player) && sleep 1 && after=$(processor_time $player) || break
  [ -n "$quietest" ] && [ "$quietest" -le $((after - before)) ] || quietest=$((after - before))
done
wait $player
status=$?
[ $status -eq 0 ] || fail "ParaView ended with status $status: $(tail -n 30 "$output/log.txt")"
if errors "$output" >/dev/null; then fail "ParaView reports: $(errors "$output")"; fi
echo "hundredths of a second of processor time in a second at rest: $quietest"
[ "${quietest:-100}" -le 2 ] || fail "the window does not come to rest"
"$CHAINMAIL_PVPYTHON" "$here/checkInteractiveWindow.py" "$output" || fail "see above"
