"""checkChoosePreset.py FOLDER: the state and the picture that TestChoosePreset.sh saved."""

import json
import os
import sys
import xml.etree.ElementTree as ElementTree

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOImage import vtkPNGReader

folder = sys.argv[1]
with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../Plugin/Presets.json"), encoding="utf-8") as file:
    preset = next(entry for entry in json.load(file) if entry["Name"] == "CT skin, muscle and bone")


def saved(kind, name):
    """The values of a property of every proxy of this kind in the state."""
    for proxy in ElementTree.parse(os.path.join(folder, "state.pvsm")).iter("Proxy"):
        if proxy.get("type") == kind:
            for values in proxy.findall("Property[@name='%s']" % name):
                yield [float(element.get("value")) for element in values.findall("Element")]


for kind, name in (("PVLookupTable", "RGBPoints"), ("PiecewiseFunction", "Points")):
    if not any(len(values) == len(preset[name]) and np.allclose(values, preset[name]) for values in saved(kind, name)):
        sys.exit("FAILED: no %s of the state has the %s of the preset: %s" % (kind, name, list(saved(kind, name))))
if [-1.0] not in saved("PVLookupTable", "AutomaticRescaleRangeMode"):
    sys.exit("FAILED: the next scan would rescale the preset")

reader = vtkPNGReader()
reader.SetFileName(os.path.join(folder, "view.png"))
reader.Update()
pixels = vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars()).astype(int)
skin = ((pixels[:, 0] > pixels[:, 1] + 10) & (pixels[:, 1] > pixels[:, 2] + 5)).mean()
if not 0.02 < skin < 0.9:
    sys.exit("FAILED: %.1f %% of the picture has the colour of skin" % (100 * skin))
print("the preset is chosen; %.0f %% of the picture is skin" % (100 * skin))
