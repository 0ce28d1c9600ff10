"""A saved state brings the scene back in a ParaView of its own: the same properties, the same bits. So does one that was
saved before the filter had all its properties: they have their defaults then."""

import os
import sys
import xml.etree.ElementTree as ElementTree

import numpy as np
from harness import OUTPUT, Reports, points_of, require, run_pvpython, same_bits, update
from paraview import servermanager
from paraview.simple import *

STATE = os.path.join(OUTPUT, "TestState.pvsm")
RESULT = os.path.join(OUTPUT, "TestState.npz")

CHANGED = {"MaterialPreset": "Function", "TissueThreshold": 60.0, "AnchorRigid": 1, "AnchoredFaces": [1, 0, 1, 0, 1, 1],
           "RelaxationIterations": 7, "RelaxationTolerance": 0.01, "Interpolation": "Nearest", "BackgroundValue": -5.0,
           "Mode": "Interactive", "PropagationMethod": "Timestamp", "PropagationIterations": 500,
           "ConflictPolicy": "Latest", "PropagationTimes": 1, "RelaxationMethod": "Paper",
           "RelaxationPreset": "Accurate", "CoarseToFine": 1,
           "ElasticRecovery": 0.75, "BodyArray": "RTData", "JointSize": 3, "JointConstraint": 0.0,
           "ModelArrays": ["Displacement", "Cluster"], "OutputPadding": 2, "BrickSize": [8, 4, 4], "ModelReduction": "2", "LabelArrays": ["RTData"]}
# What the filter did not have at first.
LATER = {"Mode": "FromRest", "PropagationMethod": "Envelope", "PropagationIterations": 0, "ConflictPolicy": "Limit",
         "PropagationTimes": 0, "RelaxationMethod": "Projected", "RelaxationPreset": "Custom",
         "CoarseToFine": 0, "ElasticRecovery": 1.0, "BodyArray": "", "JointSize": 0, "JointConstraint": 0.5, "ModelReduction": "1", "ModelArrays": ["Displacement", "Element"]}
OLD_STATE = os.path.join(OUTPUT, "TestState-old.pvsm")
POINTS = [60.0, 0.35, 0.5, 0.0, 150.0, 0.25, 0.5, 0.0, 277.0, 0.15, 0.5, 0.0]


def compare(deformation, values):
    for name, value in values.items():
        found = deformation.GetPropertyValue(name)
        found = list(found) if isinstance(value, list) else found
        require(found == value, "%s is %s, not %s", name, found, value)
    require(list(deformation.MaterialFunction.Points) == POINTS, "the function is %s", deformation.MaterialFunction.Points)
    carves = 1 if values["Mode"] == "Interactive" else 0
    counts = [len(deformation.Probes), len(deformation.Cuts), len(deformation.Carves)]
    require(counts == [2, 1, carves], "probes, cuts and carves: %s", counts)


if len(sys.argv) == 1:
    wavelet = Wavelet(WholeExtent=[0, 20, 0, 22, 0, 24])
    probes = [ChainMailProbe(Position=[8, 9, 10], Target=[8.5, 9.25, 9], Radius=1.5),
              ChainMailProbe(Position=[12, 13, 14], Anchor=1, Radius=2)]
    blade = Plane(Origin=[5, -1, 15.5], Point1=[25, -1, 15.5], Point2=[5, 30, 15.5])
    ball = Sphere(Center=[5, 16, 6], Radius=3.3)
    deformation = ChainMailDeformation(Input=wavelet, Probes=probes, Cuts=[blade], Carves=[ball], **CHANGED)
    deformation.MaterialFunction.Points = POINTS
    compare(deformation, CHANGED)
    volume, model = update(deformation, Reports(deformation))
    require(points_of(model, "Displacement").any(), "nothing moves")
    np.savez(RESULT, scalars=points_of(volume, "RTData"), displacement=points_of(model, "Displacement"))
    SaveState(STATE)

    tree = ElementTree.parse(STATE)
    for proxy in tree.iter("Proxy"):
        if proxy.get("type") == "ChainMailDeformation":
            for item in [p for p in proxy.findall("Property") if p.get("name") in {*LATER, "Carves", "Reset"}]:
                proxy.remove(item)
    tree.write(OLD_STATE)
    deformation.Carves = []
    for name, value in LATER.items():
        setattr(deformation, name, value)
    volume, model = update(deformation, Reports(deformation))
    np.savez(OLD_STATE + ".npz", scalars=points_of(volume, "RTData"), displacement=points_of(model, "Displacement"))

    for path, result in ((STATE, RESULT), (OLD_STATE, OLD_STATE + ".npz")):
        status, text = run_pvpython(os.path.abspath(__file__), path, result)
        require(status == 0, "%s:\n%s", path, text)
        print(text.strip().splitlines()[-1])
else:
    LoadState(sys.argv[1])
    deformation = next(proxy for proxy in GetSources().values() if proxy.GetXMLName() == "ChainMailDeformation")
    compare(deformation, {**CHANGED, **LATER} if sys.argv[1] == OLD_STATE else CHANGED)
    volume, model = update(deformation, Reports(deformation))
    expected = np.load(sys.argv[2])
    require(same_bits(points_of(volume, "RTData"), expected["scalars"]), "the volume is another")
    require(same_bits(points_of(model, "Displacement"), expected["displacement"]), "the displacements are others")
    print("the state came back, bit for bit")
