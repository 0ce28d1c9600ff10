"""checkInteractiveWindow.py FOLDER: does what TestInteractiveWindow.sh did in the window, in a script, and compares what was
saved."""

import os
import sys

import numpy as np
from paraview import servermanager
from paraview.simple import *
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOImage import vtkPNGReader
from vtkmodules.vtkIOLegacy import vtkStructuredPointsReader

folder = sys.argv[1]
scan = OpenDataFile(os.path.join(folder, "scan.vti"))
probe = ChainMailProbe(Position=[1, 28, 1.5], Target=[1, 31, 1.5], Radius=4)
deformation = ChainMailDeformation(Input=scan, Probes=[probe], RelaxationIterations=5)

def settle():
    deformation.MarkModified(deformation)
    deformation.UpdatePipeline()
    deformation.UpdatePropertyInformation()
    count = 1
    while deformation.NeedsUpdate:
        deformation.MarkModified(deformation)
        deformation.UpdatePipeline()
        deformation.UpdatePropertyInformation()
        count += 1
    if count > 50:
        sys.exit("FAILED: %d updates are more than the window had time for" % count)
    return count, servermanager.Fetch(deformation)


def compare(name, expected, count):
    reader = vtkStructuredPointsReader()
    reader.SetFileName(os.path.join(folder, name + ".vtk"))
    reader.Update()
    found = reader.GetOutput()
    a, b = (vtk_to_numpy(image.GetPointData().GetArray("CT")) for image in (found, expected))
    for field in ("Energy", "RelaxationIterationsUsed", "DisplacedElements"):
        here, there = (image.GetFieldData().GetArray(field).GetTuple1(0) for image in (found, expected))
        print("%s: %s %g, in the script %g" % (name, field, here, there))
    if len(a) != len(b) or (a != b).any():
        sys.exit("FAILED: %s: the window shows something else than a script's %d updates" % (name, count))
    return b


rest = vtk_to_numpy(servermanager.Fetch(scan).GetPointData().GetArray("CT"))
deformation.Mode = "Interactive"
count, volume = settle()
if count < 4:
    sys.exit("FAILED: settled after %d updates: nothing to watch" % count)
settled = compare("settled", volume, count)
deformation.InvokeCommand("Reset")
count, volume = settle()
if (compare("reset", volume, count) != rest).any():
    sys.exit("FAILED: Reset leaves something")
probe.Target = [1, 30, 1.5]
count, volume = settle()
dragged = compare("dragged", volume, count)
if not ((dragged != rest).any() and (dragged != settled).any()):
    sys.exit("FAILED: the dragged probe does nothing")

# The picture shows something: neither one colour nor only the background and a few letters.
picture = vtkPNGReader()
picture.SetFileName(os.path.join(folder, "settled.png"))
picture.Update()
pixels = vtk_to_numpy(picture.GetOutput().GetPointData().GetScalars()).astype(int)
drawn = (np.abs(pixels - pixels[0]).max(axis=1) > 8).mean()
if not 0.03 < drawn < 0.97:
    sys.exit("FAILED: %.1f %% of the picture differs from its background" % (100 * drawn))
print("the window settled, was reset and pulled again as the script, bit for bit")
