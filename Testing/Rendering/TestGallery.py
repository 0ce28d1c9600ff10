"""The pictures of Data/Gallery.md that need no scan are drawn: each panel shows something, panels that are to differ do, and
the files are as small as a page wants them."""

import os
import sys

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pictures import require_display  # noqa: E402
from harness import DATA, OUTPUT, require  # noqa: E402

sys.path.insert(0, DATA)

require_display()
import make_gallery  # noqa: E402

gallery = os.path.join(OUTPUT, "Gallery")
names = [picture.__name__ for picture in make_gallery.pictures if picture.__name__ not in make_gallery.needs]
require(len(names) > 5, "pictures that need no scan: %s", names)
shown = {}


def keep(function):
    """The panels of a picture, before they become one."""
    def draw(volumes):
        shown[function.__name__] = function(volumes)
        return shown[function.__name__]
    draw.__name__ = function.__name__
    return draw


make_gallery.SCALE = 1  # pages have twice that, which takes four times as long
make_gallery.pictures = [keep(picture) for picture in make_gallery.pictures]
make_gallery.main(["--output", gallery, *names])
require(sorted(shown) == sorted(names), "drawn: %s of %s", sorted(shown), names)
for name, rows in shown.items():
    for row in rows:
        for number, panel in enumerate(row):
            background = panel[panel.shape[0] // 2, 2]
            share = (np.abs(panel - background).max(axis=2) > 20).mean()
            # Three balls and their labels cover 5 % of their panel.
            require(0.04 < share < 0.98, "%s, panel %d: %.1f %% of it is not background", name, number, 100 * share)
            if number and panel.shape == row[number - 1].shape:
                differs = (np.abs(panel - row[number - 1]).max(axis=2) > 10).mean()  # skin that has no grain changes gently
                require(differs > 0.01, "%s: panels %d and %d show the same", name, number - 1, number)
    size = os.path.getsize(os.path.join(gallery, make_gallery.file_of(name)))
    require(2000 < size < 200000, "%s has %d bytes", name, size)
print("%d pictures, %d panels" % (len(shown), sum(len(row) for rows in shown.values() for row in rows)))
