"""The source ChainMailForearm makes the voxels that Data/make_forearm.py writes, also where less than all of them is asked for,
and leaves the names of the script that asks for it alone. What the script writes can be read, and it says so where it cannot
write."""

import os
import sys
import tempfile

from harness import DATA, points_of, require, same_bits
from paraview import servermanager
from paraview.simple import *

sys.path.insert(0, DATA)
from make_forearm import make_forearm, write  # noqa: E402

before = set(globals())
for size in ((40, 36, 44), (33, 40, 32)):
    expected = make_forearm(size)
    forearm = ChainMailForearm(Size=size)
    made = servermanager.Fetch(forearm)
    require(made.GetDimensions() == size and made.GetSpacing() == expected.GetSpacing() and
            made.GetOrigin() == expected.GetOrigin(), "the geometry is another:\n%s", made)
    require(same_bits(points_of(made, "CT"), points_of(expected, "CT")), "the voxels are others")
    require(made.GetPointData().GetScalars().GetName() == "CT", "the scalars are %s", made.GetPointData().GetScalars())

with tempfile.TemporaryDirectory() as folder:
    for ending in (".vti", ".mhd"):
        path = os.path.join(folder, "forearm" + ending)
        write(expected, path)
        scan = servermanager.Fetch(OpenDataFile(path))
        require(same_bits(points_of(scan, scan.GetPointData().GetScalars().GetName()), points_of(expected, "CT")),
                "%s holds other voxels", path)
        try:
            write(expected, os.path.join(folder, "none", "forearm" + ending))
        except OSError:
            continue
        require(False, "a %s that cannot be written is no error", ending)

part = (3, 20, 5, 30, 0, 10)
source = ChainMailForearm(Size=size).GetClientSideObject()
source.UpdateExtent(part)
piece = source.GetOutput()
require(piece.GetExtent() == part, "the extent is %s", piece.GetExtent())
expected.Crop(part)
require(same_bits(points_of(piece, "CT"), points_of(expected, "CT")), "a piece has other voxels")

deformation = ChainMailDeformation(Input=forearm)
deformation.UpdatePipeline()
require(deformation.TissueThreshold == -300, "the threshold is %g", deformation.TissueThreshold)
added = set(globals()) - before
require(added <= {"before", "size", "folder", "ending", "path", "scan", "forearm", "expected", "made", "part", "source", "piece",
                  "deformation"} and min(3, 2) == 2,
        "there are new names: %s", added)
print("the forearm of the source is that of the file")
