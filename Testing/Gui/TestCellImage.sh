#!/usr/bin/env bash
# Grab Tissue on an image with cell data alone: the window shows a message that says what to do, and makes nothing.
. "$(dirname "${BASH_SOURCE[0]}")/window.sh"
needs_buttons
output=$CHAINMAIL_OUTPUT/GuiCellImage
rm -rf "$output" && mkdir -p "$output" || fail "cannot write to $output"
"$CHAINMAIL_PVPYTHON" - "$output/scan.vti" <<'END' || fail "no image of cells"
import sys
from paraview.simple import PointDatatoCellData, SaveData, Wavelet
SaveData(sys.argv[1], proxy=PointDatatoCellData(Input=Wavelet()), DataMode="Binary")
END
fill "$output" "s|@WAIT@|$(pauses 12)|" <"$here/CellImage.xml.in"
play "$output"
status=$?
[ $status -eq 0 ] || fail "ParaView ended with status $status: $(tail -n 30 "$output/log.txt")"
grep -q 'Cell Data to Point Data' "$output/log.txt" || fail "no message says what to do: $(cat "$output/log.txt")"
[ -s "$output/state.pvsm" ] || fail "no state was saved"
grep -q ChainMail "$output/state.pvsm" && fail "something was made of an image without points"
exit 0
