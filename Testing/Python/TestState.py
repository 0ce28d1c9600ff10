"""A saved state brings the scene back in a ParaView of its own: the same properties, the same bits. So does one that is a
script, a trace, and one that was saved before the filter had all its properties: they have their defaults then. Properties that are
copied and pasted give the same bits, too, and share nothing; a name changes nothing."""

import os
import sys
import xml.etree.ElementTree as ElementTree

import numpy as np
from harness import OUTPUT, Reports, points_of, require, run_pvpython, same_bits, update
from paraview import smstate, smtrace
from paraview.modules.vtkRemotingMisc import vtkSMProxyClipboard
from paraview.simple import *

STATE = os.path.join(OUTPUT, "TestState.pvsm")
SCRIPT = os.path.join(OUTPUT, "TestState-script.py")
TRACE = os.path.join(OUTPUT, "TestState-trace.py")
RESULT = os.path.join(OUTPUT, "TestState.npz")

CHANGED = {"MaterialPreset": "Function", "TissueThreshold": 60.0, "AnchorRigid": 1, "AnchoredFaces": [1, 0, 1, 0, 1, 1],
           "RelaxationIterations": 7, "RelaxationTolerance": 0.01, "Interpolation": "Nearest", "BackgroundValue": -5.0,
           "Mode": "Interactive", "PropagationMethod": "Timestamp", "PropagationIterations": 500,
           "ConflictPolicy": "Latest", "PropagationTimes": 1, "RelaxationMethod": "Paper",
           "RelaxationPreset": "Accurate", "CoarseToFine": 1,
           "ElasticRecovery": 0.75, "BodyArray": "RTData", "JointSize": 3, "JointConstraint": 0.0, "JointMargin": 5,
           "ModelArrays": ["Displacement", "Cluster"], "OutputPadding": 2, "OutputMagnification": 2, "UseOutputBounds": 1,
           "OutputBounds": [-6.0, 5.0, -4.0, 6.5, -5.0, 4.0], "SmoothCuts": 0, "PullBack": 1, "ScalarSmoothing": 1.5, "BrickSize": [8, 4, 4], "ModelReduction": "2", "LabelArrays": ["RTData"]}
# What the filter did not have at first.
LATER = {"Mode": "FromRest", "PropagationMethod": "Envelope", "PropagationIterations": 0, "ConflictPolicy": "Limit",
         "PropagationTimes": 0, "RelaxationMethod": "Projected", "RelaxationPreset": "Custom",
         "CoarseToFine": 0, "ElasticRecovery": 1.0, "Rotations": 0, "PoissonRatio": 0.0, "BodyArray": "", "JointSize": 0, "JointConstraint": 0.5, "JointMargin": 4,
         "ModelReduction": "1", "ModelArrays": ["Displacement", "Element"], "SmoothCuts": 1, "PullBack": 0, "ScalarSmoothing": 0.0}
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


def results(deformation):
    """The scalars of the volume and the displacements of the model."""
    volume, model = update(deformation, Reports(deformation))
    return points_of(volume, "RTData"), points_of(model, "Displacement")


def paste(source, target):
    """What Copy and Paste in the menu Edit do."""
    clipboard = vtkSMProxyClipboard()
    clipboard.Copy(source.SMProxy)
    require(clipboard.Paste(target.SMProxy), "%s cannot be pasted", source.GetXMLName())


if len(sys.argv) == 1:
    smtrace.start_trace()
    wavelet = Wavelet(WholeExtent=[0, 20, 0, 22, 0, 24])
    probes = [ChainMailProbe(Position=[8, 9, 10], Target=[8.5, 9.25, 9], Radius=1.5),
              ChainMailProbe(Position=[12, 13, 14], Anchor=1, Radius=2, Tolerance=0.5, Rotation=[0, 4, 0])]
    blade = Plane(Origin=[5, -1, 15.5], Point1=[25, -1, 15.5], Point2=[5, 30, 15.5])
    ball = Sphere(Center=[5, 16, 6], Radius=3.3)
    deformation = ChainMailDeformation(Input=wavelet, Probes=probes, Cuts=[blade], Carves=[ball], **CHANGED)
    with open(TRACE, "w") as file:
        file.write(smtrace.stop_trace())
    traced = results(deformation)
    np.savez(TRACE + ".npz", scalars=traced[0], displacement=traced[1])

    deformation.MaterialFunction.Points = POINTS  # which a script's trace does not hold
    compare(deformation, CHANGED)
    volume, model = update(deformation, Reports(deformation))
    require(points_of(model, "Displacement").any(), "nothing moves")
    expected = points_of(volume, "RTData"), points_of(model, "Displacement")
    np.savez(RESULT, scalars=expected[0], displacement=expected[1])
    SaveState(STATE)
    with open(SCRIPT, "w") as file:
        file.write(smstate.get_state())

    # Another filter on the same inputs, with other probes, takes the properties of these, and keeps its inputs.
    others = [ChainMailProbe(Position=[8, 9, 10], Target=[8, 9, 10]), ChainMailProbe(Position=[3, 4, 5], Target=[3, 4, 5])]
    another = ChainMailDeformation(Input=wavelet, Probes=others, Cuts=[blade], Carves=[ball])
    require(not same_bits(results(another)[1], expected[1]), "the other filter does the same before anything is pasted")
    another.Carves = []
    paste(deformation, another)
    for one, other in zip(probes, others):
        paste(one, other)
        for name in ("Position", "Target", "Radius", "Anchor", "Tolerance", "Turns", "Rotation", "Body"):
            found = other.GetPropertyValue(name), one.GetPropertyValue(name)
            require(found[0] == found[1], "pasted, %s is %s, not %s", name, *found)
    require([probe.SMProxy for probe in another.Probes] == [probe.SMProxy for probe in others], "other probes were pasted")
    another.Carves = [ball]
    compare(another, CHANGED)
    another.Mode = "FromRest"
    deformation.Mode = "FromRest"
    for one, other in zip(results(another), results(deformation)):
        require(same_bits(one, other), "pasted, the same properties give something else")
    another.MaterialFunction.Points = [0, 0.1, 0.5, 0, 300, 0.1, 0.5, 0]
    require(list(deformation.MaterialFunction.Points) == POINTS, "what was pasted shares its material function")
    deformation.Mode = "Interactive"

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

    RenameSource("lip", probes[0])
    RenameSource("limb", deformation)
    for one, name in zip(results(deformation), ("scalars", "displacement")):
        require(same_bits(one, np.load(OLD_STATE + ".npz")[name]), "another name gives other %s", name)

    for path, result in ((STATE, RESULT), (SCRIPT, RESULT), (TRACE, TRACE + ".npz"), (OLD_STATE, OLD_STATE + ".npz")):
        status, text = run_pvpython(os.path.abspath(__file__), path, result)
        require(status == 0, "%s:\n%s", path, text)
        print(text.strip().splitlines()[-1])
else:
    if sys.argv[1].endswith(".py"):
        with open(sys.argv[1]) as file:
            exec(compile(file.read(), sys.argv[1], "exec"))
    else:
        LoadState(sys.argv[1])
    deformation = next(proxy for proxy in GetSources().values() if proxy.GetXMLName() == "ChainMailDeformation")
    if sys.argv[1] != TRACE:
        compare(deformation, {**CHANGED, **LATER} if sys.argv[1] == OLD_STATE else CHANGED)
    volume, model = update(deformation, Reports(deformation))
    expected = np.load(sys.argv[2])
    require(same_bits(points_of(volume, "RTData"), expected["scalars"]), "the volume is another")
    require(same_bits(points_of(model, "Displacement"), expected["displacement"]), "the displacements are others")
    print("the state came back, bit for bit")
