"""checkTurnBone.py FOLDER: the boxes and the states that TestTurnBone.sh has seen."""

import json
import os
import sys
import xml.etree.ElementTree as ElementTree

import numpy as np
from paraview import servermanager
from paraview.simple import *
from vtkmodules.util.numpy_support import vtk_to_numpy

folder = sys.argv[1]
with open(os.path.join(folder, "watched.txt"), encoding="utf-8") as watched:
    boxes = [json.loads(line) for line in watched]


def state(name):
    """The properties of the proxies of a saved state, by type."""
    found = {}
    for proxy in ElementTree.parse(os.path.join(folder, name + ".pvsm")).iter("Proxy"):
        if proxy.get("group") in ("sources", "filters"):
            found.setdefault(proxy.get("type"), []).append({
                p.get("name"): [e.get("value") for e in p.findall("Element") + p.findall("Proxy")]
                for p in proxy.findall("Property")})
    return found


def pose(name):
    return {key: np.array([float(x) for x in values])
            for key, values in state(name)["ChainMailPose"][0].items() if key in ("Position", "Target", "Rotation", "Body")}


def turn(axis, degrees):
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    matrix = np.eye(3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix[i, i], matrix[i, j], matrix[j, i], matrix[j, j] = c, -s, s, c
    return matrix


def rotation_of(angles):
    return turn(2, angles[2]) @ turn(0, angles[0]) @ turn(1, angles[1])


# The button took the labels, let bones turn, and put the box around the bone in the middle.
made = state("made")
deformation = made["ChainMailDeformation"][0]
if deformation["Rotations"] != ["1"] or deformation["BodyArray"] != ["values_input_1"] or deformation["JointConstraint"] != ["1"]:
    sys.exit("FAILED: the deformation has Rotations %s, BodyArray %s, JointConstraint %s" % tuple(
        deformation[name] for name in ("Rotations", "BodyArray", "JointConstraint")))
length = np.linalg.norm
start, turned, moved, undone = (pose(name) for name in ("made", "turned", "moved", "undone"))
label = int(start["Body"][0])
labels = servermanager.Fetch(XMLImageDataReader(FileName=[os.path.join(folder, "labels.vti")]))
of_voxels = vtk_to_numpy(labels.GetPointData().GetScalars())
places = np.array([labels.GetPoint(v) for v in np.flatnonzero(of_voxels == label)])
if not len(places):
    sys.exit("FAILED: the pose holds the label %d" % label)
low, high = places.min(axis=0) - 1, places.max(axis=0) + 1  # half a voxel
bounds = np.array(boxes[0]["bounds"])
if not (np.allclose(bounds[::2], low) and np.allclose(bounds[1::2], high) and np.allclose(start["Position"], (low + high) / 2)):
    sys.exit("FAILED: the box is %s around a bone from %s to %s" % (bounds, low, high))

# Of its handles only the ball in the middle is there.
for box in boxes:
    if len(box["handles"]) != 1 or box["handles"][0] > 1e-6 * length(high - low):
        sys.exit("FAILED: the box has handles %s mm from its middle" % box["handles"])

# Turned it has not moved, moved it has not turned; and it did both.
if not (length(turned["Rotation"]) > 1 and length(turned["Target"] - start["Target"]) < 1e-9):
    sys.exit("FAILED: turned, the pose is %s" % turned)
if not (length(moved["Target"] - turned["Target"]) > 1 and length(moved["Rotation"] - turned["Rotation"]) < 1e-9):
    sys.exit("FAILED: moved, the pose is %s after %s; the ball was at %s" % (moved, turned, boxes[-1]["screen"]))
if any(length(undone[key] - turned[key]) > 1e-12 for key in turned):
    sys.exit("FAILED: after Undo the pose is %s, not %s" % (undone, turned))
counts = [(len(state(name)["ChainMailPose"]), len(state(name)["ChainMailDeformation"][0]["Probes"])) for name in ("another", "again")]
if counts != [(2, 2), (1, 1)]:
    sys.exit("FAILED: poses and probes with another one, and after Undo: %s" % counts)

# The last box before that of the other pose is where the pose is.
ofPose = np.eye(4)
ofPose[:3, :3], ofPose[:3, 3] = rotation_of(moved["Rotation"]), moved["Target"]
off = min(np.abs(np.array(box["matrix"]).reshape(4, 4) - ofPose).max() for box in boxes)
if off > 1e-9:
    sys.exit("FAILED: no box is where the pose is, by %g" % off)

# That matrix is what the bone does.
LoadState(os.path.join(folder, "moved.pvsm"))
deformation = FindSource("ChainMailDeformation1")
deformation.UpdatePipeline()
figures = servermanager.Fetch(OutputPort(deformation, 0)).GetFieldData()
if figures.GetAbstractArray("Error"):
    sys.exit("FAILED: the saved state: " + figures.GetAbstractArray("Error").GetValue(0))
model = servermanager.Fetch(deformation, 0, idx=1)
displacement = vtk_to_numpy(model.GetPointData().GetArray("Displacement"))
expected = (places - moved["Position"]) @ ofPose[:3, :3].T + moved["Target"] - places
off = np.abs(displacement[of_voxels == label] - expected).max()
if off > 1e-4:
    sys.exit("FAILED: the bone is up to %g mm off the box's matrix; it turned by %s" % (off, figures.GetArray("ProbeTurned").GetTuple(0)))
print("label %d turned by %s and moved by %s, up to %.1f mm, as the box did" % (
    label, moved["Rotation"], moved["Target"] - start["Target"], np.abs(expected).max()))
