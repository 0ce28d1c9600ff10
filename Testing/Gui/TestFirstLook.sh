#!/usr/bin/env bash
# What one sees first of a scan whose scale nobody knows, CT in 8 bits: its surface in the colours of skin, from the front;
# and of a CT another preset of the plugin, chosen from the menu; both smoothed, and dragged. Before, the former was a blue fog seen
# from above.
. "$(dirname "${BASH_SOURCE[0]}")/window.sh"
needs_buttons
phantom GuiFirstLook 64 56 72
work=$output
for scale in hu bytes; do
  output=$work/$scale
  mkdir -p "$output" || fail "cannot write to $output"
  "$CHAINMAIL_PVPYTHON" "$here/checkFirstLook.py" write "$work/scan.vti" "$output/scan.vti" $scale || fail "no scan"
  [ $scale = hu ] && look="CT bone" || look="MR T1"
  fill "$output" "s|@WAIT@|$(pauses 12)|; s|@LOOK@|$look|" <"$here/FirstLook.xml.in"
  PARAVIEW_LOG_APPLICATION_VERBOSITY=INFO play "$output" "--log=$output/drag.log,INFO"
  status=$?
  [ $status -eq 0 ] || fail "ParaView ended with status $status: $(tail -n 30 "$output/log.txt")"
  if errors "$output" >/dev/null; then fail "ParaView reports: $(errors "$output")"; fi
  "$CHAINMAIL_PVPYTHON" "$here/checkFirstLook.py" check "$output" $scale "$look" || fail "see above"
  grep -q "Tissue followed in .*: preview of every" "$output/drag.log" || fail "no preview is shown of smoothed scalars"
done
