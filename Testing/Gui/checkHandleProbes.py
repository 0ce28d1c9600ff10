"""checkHandleProbes.py FOLDER: where the probes were, in the pictures that TestHandleProbes.sh has seen."""

import json
import os
import sys

import numpy as np

from paraview.simple import *
from paraview import servermanager
from paraview.vtk.util.numpy_support import vtk_to_numpy

folder = sys.argv[1]
with open(os.path.join(folder, "watched.txt"), encoding="utf-8") as watched:
    pictures = [json.loads(line) for line in watched]

scan = servermanager.Fetch(XMLImageDataReader(FileName=[os.path.join(folder, "scan.vti")]))
diagonal = scan.GetLength()
spacing = np.array(scan.GetSpacing())
values = vtk_to_numpy(scan.GetPointData().GetScalars())


def is_tissue(place):
    point = scan.FindPoint(place)
    return point >= 0 and values[point] >= -300


# The drags of the first probe. The view looks along y.
drags = [np.array(picture["probes"]["ChainMailProbe1"]) for picture in pictures if len(picture["probes"]) == 1]
start = drags[0]
for position, target in drags:
    if not is_tissue(position) or is_tissue(position - [0, 4 * spacing[1], 0]):  # the skin shines through
        sys.exit("FAILED: dragged, the probe is at %s, which is not on the skin" % position)
    if np.abs((target - position) - (start[1] - start[0])).max() > 1e-6:
        sys.exit("FAILED: dragged, the pull is %s, not %s" % (target - position, start[1] - start[0]))
position = drags[-1][0]
if not (position[0] - start[0][0] > 15 and position[1] - start[0][1] > 2 * spacing[1]):
    sys.exit("FAILED: the probe did not go around the limb, from %s to %s" % (start[0], position))

# New probes.
added = [picture for picture in pictures if len(picture["probes"]) == 3]
places = [np.array(added[0]["probes"]["ChainMailProbe%d" % n]) for n in (1, 2, 3)]
for n in range(3):
    for m in range(n):
        apart = np.linalg.norm(places[n][0] - places[m][0])
        if apart < 0.12 * diagonal:
            sys.exit("FAILED: probes %d and %d are %g mm apart, the diagonal is %g mm" % (m + 1, n + 1, apart, diagonal))
    asked = np.linalg.norm(places[n][1] - places[n][0])
    reached = np.linalg.norm(added[0]["reached"][3 * n : 3 * n + 3])
    # The first was dragged, with the pull that suited where it began.
    if n > 0 and not (asked > 0.01 * diagonal and reached > 0.9 * asked):
        sys.exit("FAILED: the new probe %d reached %g of %g mm" % (n + 1, reached, asked))

# The one that pulls too far.
short = next(picture for picture in pictures if len(picture["probes"]) == 3 and picture["probes"]["ChainMailProbe3"][1][0] == 200)
asked = np.linalg.norm(np.subtract(*short["probes"]["ChainMailProbe3"]))
reached = np.linalg.norm(short["reached"][6:9])
if short["written"] != ["%.3g of %.3g mm" % (reached, asked)] or not reached < 0.5 * asked:
    sys.exit("FAILED: beside the line is written %s, where the probe reached %g of %g mm" % (short["written"], reached, asked))
if pictures[0]["written"]:
    sys.exit("FAILED: at first %s is written beside the line" % pictures[0]["written"])
print("the probe went around the limb to %s; new probes are at %s and %s; %s" % (position, places[1][0], places[2][0], short["written"]))
