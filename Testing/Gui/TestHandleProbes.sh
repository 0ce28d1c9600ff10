#!/usr/bin/env bash
# What a hand does with probes: the yellow end stays on tissue wherever it is dragged, and takes the other end along. New probes
# are where no other is, and their tissue follows. One that it does not follow so far is no message, but a mark in the view.
. "$(dirname "${BASH_SOURCE[0]}")/window.sh"
needs_buttons
phantom GuiHandle 40 36 44
error='ChainMailProbe3 at (500, 0, 0): the probe holds no tissue: no voxel within its radius of 7.142308 mm is tissue. Move the probe onto tissue, enlarge its radius, or lower TissueThreshold.'
fill "$output" "s|@WAIT@|$(pauses 12)|; s|@ERROR@|$error|" <"$here/HandleProbes.xml.in"
CHAINMAIL_WATCHED=$output/watched.txt play "$output" --script="$here/watchProbes.py"
status=$?
[ $status -eq 0 ] || fail "ParaView ended with status $status: $(tail -n 30 "$output/log.txt")"
[ "$(errors "$output" | wc -l)" -eq 1 ] || fail "instead of one error, of the probe in the air: $(errors "$output")"
# What a driver's compiler of shaders says of ParaView's own is not about us.
warnings=$(grep -i 'warn' "$output/log.txt" | grep -v 'GL Message')
[ -z "$warnings" ] || fail "ParaView warns: $warnings"
"$CHAINMAIL_PVPYTHON" "$here/checkHandleProbes.py" "$output" || fail "see above"
