"""checkPullTissue.py SCAN FOLDER: the volume and the picture that TestPullTissue.sh saved."""

import os
import sys

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOImage import vtkPNGReader
from vtkmodules.vtkIOLegacy import vtkStructuredPointsReader
from vtkmodules.vtkIOXML import vtkXMLImageDataReader

scan, folder = sys.argv[1:]


def read(path, reader):
    if not os.path.isfile(path):
        sys.exit("FAILED: there is no " + path)
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput()


before = read(scan, vtkXMLImageDataReader())
# As .vtk: with a new expat VTK 9.2 cannot read the .vti that ParaView writes by default, see Data/make_forearm.py.
after = read(os.path.join(folder, "deformed.vtk"), vtkStructuredPointsReader())
if before.GetDimensions() != after.GetDimensions():
    sys.exit("FAILED: %s became %s voxels" % (before.GetDimensions(), after.GetDimensions()))
a, b = (vtk_to_numpy(image.GetPointData().GetArray("CT")) for image in (before, after))
changed = (a != b).mean()
# The pull moves a few centimetres of skin, not nothing and not the whole limb.
if not 1e-4 < changed < 0.3:
    sys.exit("FAILED: %.3f %% of the voxels changed" % (100 * changed))
reached = np.array(after.GetFieldData().GetArray("ProbeReached").GetTuple3(0))
if not np.allclose(reached, [0, 3, 0], atol=1e-3):
    sys.exit("FAILED: the probe reached %s instead of (0, 3, 0)" % reached)

# The picture shows something: neither one colour nor only the background and a few letters.
picture = read(os.path.join(folder, "view.png"), vtkPNGReader())
pixels = vtk_to_numpy(picture.GetPointData().GetScalars()).astype(int)
background = pixels[0]
drawn = (np.abs(pixels - background).max(axis=1) > 8).mean()
if not 0.03 < drawn < 0.97:
    sys.exit("FAILED: %.1f %% of the picture differs from its background" % (100 * drawn))
print("%.2f %% of the voxels changed, %.0f %% of the picture is drawn" % (100 * changed, 100 * drawn))
