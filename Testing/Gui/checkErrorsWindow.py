"""checkErrorsWindow.py FOLDER: the pictures that TestErrorsWindow.sh took."""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir, "Rendering"))
from pictures import *  # noqa: E402, F403

names = ("first", "settled", "error", "corrected", "moved", "reset")
shown = {name: read(os.path.join(sys.argv[1], name + ".png")) for name in names}
for name, pixels in shown.items():
    drawn = (np.abs(pixels.astype(int) - pixels[0, 0]).max(axis=2) > 8).mean()
    require(0.03 < drawn < 0.97, "%s: %.1f %% of the picture differs from its background", name, 100 * drawn)
for one, other, alike in (("first", "reset", True), ("settled", "error", True), ("corrected", "settled", True),
                          ("settled", "first", False), ("moved", "settled", False), ("moved", "first", False)):
    require(same_picture(shown[one], shown[other]) == alike, "%s and %s %s: %d pixels too dark, %d too bright", one, other,
            "differ" if alike else "are the same", *pixels_beyond(shown[one], shown[other]))
print("the window shows the scan, the last good result, and goes on")
