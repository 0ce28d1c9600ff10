"""checkGrabTissue.py FOLDER: the volume, the state and the pictures that TestGrabTissue.sh saved."""

import os
import re
import sys
import xml.etree.ElementTree as ElementTree

import numpy as np
from paraview import servermanager
from paraview.simple import *
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOImage import vtkPNGReader

folder = sys.argv[1]


def values(source):
    return vtk_to_numpy(servermanager.Fetch(source).GetPointData().GetArray("CT"))


before = values(OpenDataFile(os.path.join(folder, "scan.vti")))
saved = values(OpenDataFile(os.path.join(folder, "deformed.vtk")))
dragged = values(OpenDataFile(os.path.join(folder, "dragged.vtk")))


def state(name):
    """The properties of the proxies of a saved state, by type and registered name."""
    tree = ElementTree.parse(os.path.join(folder, name))
    names = {item.get("id"): item.get("name") for items in tree.iter("ProxyCollection") if items.get("name") == "sources"
             for item in items.findall("Item")}
    return {(proxy.get("type"), names[proxy.get("id")]): {
        p.get("name"): [e.get("value") for e in p.findall("Element") + p.findall("Proxy")] for p in proxy.findall("Property")}
        for proxy in tree.iter("Proxy") if proxy.get("id") in names}


# What was pasted, deleted, brought back and deleted again.
pasted, undone, last, example = (state(name + ".pvsm") for name in ("pasted", "undone", "state", "example"))
first, second = ("ChainMailProbe", "ChainMailProbe1"), ("ChainMailProbe", "ChainMailProbe2")
for name in ("Position", "Target", "Radius"):
    if pasted[second][name] != pasted[first][name] or undone[second][name] != pasted[first][name]:
        sys.exit("FAILED: pasted, %s is %s, not %s" % (name, pasted[second][name], pasted[first][name]))
filter_ = "ChainMailDeformation", "ChainMailDeformation1"
if len(undone[filter_]["Probes"]) != 2 or second in last or len(last[filter_]["Probes"]) != 1:
    sys.exit("FAILED: the filter has the probes %s after Undo, and %s after Redo" % (
        undone[filter_]["Probes"], last[filter_]["Probes"]))
if ("ChainMailForearm", "ChainMailForearm1") not in example or len(example["ChainMailDeformation", "ChainMailDeformation2"]["Probes"]) != 1:
    sys.exit("FAILED: the example has %s" % sorted(example))

# Dragging, buttons and Apply leave what is not theirs as it is in a script. The button smooths what it shows.
scripted = ChainMailDeformation(Input=OpenDataFile(os.path.join(folder, "scan.vti")), ScalarSmoothing=0.75)
SaveState(os.path.join(folder, "scripted.pvsm"))
theirs = {"Input", "Probes", "Cuts", "Carves", "MaterialFunction", "Report", "ProbeReached", "NeedsUpdate"}
for name, found in pasted[filter_].items():
    expected = state("scripted.pvsm")[filter_][name]
    if name not in theirs and found != expected:
        sys.exit("FAILED: after drag and buttons %s is %s, in a script %s" % (name, found, expected))
if last[filter_]["LabelArrays"] != ["CT"]:
    sys.exit("FAILED: chosen in the panel, LabelArrays is %s" % last[filter_]["LabelArrays"])

ResetSession()
LoadState(os.path.join(folder, "state.pvsm"))
deformation = FindSource("ChainMailDeformation1")
if sorted(deformation.ModelArrays) != ["Cluster", "Displacement", "Element"]:
    sys.exit("FAILED: chosen in the panel, ModelArrays is %s" % list(deformation.ModelArrays))
model = servermanager.Fetch(deformation, idx=1).GetPointData()
if [model.GetArray(name) is not None for name in ("Cluster", "Constraint", "Displacement", "Element")] != [True, False, True, True]:
    sys.exit("FAILED: the model at rest has %s" % [model.GetArrayName(n) for n in range(model.GetNumberOfArrays())])
if [len(getattr(deformation, name)) for name in ("Probes", "Cuts", "Carves")] != [1, 1, 1]:
    sys.exit("FAILED: the filter has %d probes, %d cuts, %d carves" % (
        len(deformation.Probes), len(deformation.Cuts), len(deformation.Carves)))
if list(deformation.AnchoredFaces) != [1, 1, 1, 1, 0, 1]:
    sys.exit("FAILED: the faces held are %s" % list(deformation.AnchoredFaces))
if (values(OutputPort(deformation, 0)) != saved).any():
    sys.exit("FAILED: the saved state gives another volume")
changed = (saved != before).mean()
if not 1e-3 < changed < 0.5:
    sys.exit("FAILED: %.3f %% of the voxels changed" % (100 * changed))

deformation.UpdatePropertyInformation()
if "Probe 1 reached" not in deformation.Report:
    sys.exit("FAILED: the report is " + deformation.Report)
reached = np.linalg.norm(servermanager.Fetch(deformation).GetFieldData().GetArray("ProbeReached").GetTuple3(0))
probe = deformation.Probes[0]
asked = np.linalg.norm(np.subtract(probe.Target, probe.Position))
if not (asked > 5 and reached > 0.9 * asked):
    sys.exit("FAILED: the first pull reached %g of %g mm" % (reached, asked))

# The drag left the filter as it was set: from rest, without blade and drill, it gives what was saved then.
if probe.Position[2] < 10:
    sys.exit("FAILED: the probe is at %s after the drag" % list(probe.Position))
deformation.Cuts, deformation.Carves, deformation.AnchoredFaces, deformation.LabelArrays = [], [], [1] * 6, []
if (values(OutputPort(deformation, 0)) != dragged).any() or not (dragged != before).any():
    sys.exit("FAILED: after the drag the window shows something else than a script")

# While it was dragged the window drew previews, of the example with every second voxel or fewer along each axis. The
# deformation learned of it when the drag had ended.
with open(os.path.join(folder, "drag.log"), encoding="utf-8", errors="replace") as log:
    steps = [int(step) for step in re.findall(r"Tissue followed in \d+ ms: preview of every (\d+)\. voxel", log.read())]
if len(steps) < 2 or steps[0] != 1 or steps[-1] < 2:
    sys.exit("FAILED: the previews of the drags have every n-th voxel, n = %s" % steps)
with open(os.path.join(folder, "watched.txt"), encoding="utf-8") as watched:
    pictures = [line.split() for line in watched]
for count in ("1", "2"):
    quick = [n for n, (sources, _, kind) in enumerate(pictures) if (sources, kind) == (count, "quick")]
    states = {pictures[n][1] for n in quick}
    if len(states) != 1:
        sys.exit("FAILED: in the drag with %s deformations these had %d states" % (count, len(states)))
    # When the hand lets go, what it waits for is drawn finely.
    last = pictures[quick[-1] + 1]
    if last[2] != "fine" or last[1] in states:
        sys.exit("FAILED: after the drag with %s deformations the picture is %s" % (count, last))


def picture(name):
    reader = vtkPNGReader()
    reader.SetFileName(os.path.join(folder, name))
    reader.Update()
    return vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars()).astype(int)


grabbed, cut = picture("grabbed.png"), picture("cut.png")
drawn = (np.abs(grabbed - grabbed[0]).max(axis=1) > 8).mean()
if not 0.03 < drawn < 0.97:
    sys.exit("FAILED: %.1f %% of the picture differs from its background" % (100 * drawn))
opened = (np.abs(grabbed - cut).max(axis=1) > 8).mean()
if not 1e-3 < opened < 0.3:
    sys.exit("FAILED: blade and drill changed %.2f %% of the picture" % (100 * opened))
print("grabbed, cut and drilled: %.1f %% of the voxels changed, %.1f of %.1f mm reached" % (100 * changed, reached, asked))
