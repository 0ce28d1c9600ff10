"""A saved state brings the scene back in a ParaView of its own: the same properties, the same bits."""

import os
import sys

import numpy as np
from harness import OUTPUT, Reports, points_of, require, run_pvpython, same_bits, update
from paraview import servermanager
from paraview.simple import *

STATE = os.path.join(OUTPUT, "TestState.pvsm")
RESULT = os.path.join(OUTPUT, "TestState.npz")

CHANGED = {"MaterialPreset": "Function", "TissueThreshold": 60.0, "AnchorRigid": 1, "AnchoredFaces": [1, 0, 1, 0, 1, 1],
           "RelaxationIterations": 7, "RelaxationTolerance": 0.01, "Interpolation": "Nearest", "BackgroundValue": -5.0,
           "OutputPadding": 2, "BlockSize": [8, 4, 4], "LabelArrays": ["RTData"]}
POINTS = [60.0, 0.35, 0.5, 0.0, 150.0, 0.25, 0.5, 0.0, 277.0, 0.15, 0.5, 0.0]


def compare(deformation):
    for name, value in CHANGED.items():
        found = deformation.GetPropertyValue(name)
        found = list(found) if isinstance(value, list) else found
        require(found == value, "%s is %s, not %s", name, found, value)
    require(list(deformation.MaterialFunction.Points) == POINTS, "the function is %s", deformation.MaterialFunction.Points)
    require(len(deformation.Probes) == 2 and len(deformation.Cuts) == 1, "%d probes, %d cuts", len(deformation.Probes),
            len(deformation.Cuts))


if len(sys.argv) == 1:
    wavelet = Wavelet(WholeExtent=[0, 20, 0, 22, 0, 24])
    probes = [ChainMailProbe(Position=[8, 9, 10], Target=[8.5, 9.25, 9], Radius=1.5),
              ChainMailProbe(Position=[12, 13, 14], Anchor=1, Radius=2)]
    blade = Plane(Origin=[5, -1, 15.5], Point1=[25, -1, 15.5], Point2=[5, 30, 15.5])
    deformation = ChainMailDeformation(Input=wavelet, Probes=probes, Cuts=[blade], **CHANGED)
    deformation.MaterialFunction.Points = POINTS
    compare(deformation)
    volume, model = update(deformation, Reports(deformation))
    require(points_of(model, "Displacement").any(), "nothing moves")
    np.savez(RESULT, scalars=points_of(volume, "RTData"), displacement=points_of(model, "Displacement"))
    SaveState(STATE)

    status, text = run_pvpython(os.path.abspath(__file__), "load")
    require(status == 0, "the saved state:\n%s", text)
    print(text.strip().splitlines()[-1])
else:
    LoadState(STATE)
    deformation = next(proxy for proxy in GetSources().values() if proxy.GetXMLName() == "ChainMailDeformation")
    compare(deformation)
    volume, model = update(deformation, Reports(deformation))
    expected = np.load(RESULT)
    require(same_bits(points_of(volume, "RTData"), expected["scalars"]), "the volume is another")
    require(same_bits(points_of(model, "Displacement"), expected["displacement"]), "the displacements are others")
    print("the state came back, bit for bit")
