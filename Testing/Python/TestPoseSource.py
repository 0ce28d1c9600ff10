"""The source ChainMail Pose: the bone goes where vtkTransform says, with Euler angles, about its centre; a state and a saved
script give the same; key frames move it in time; a deformation without Rotations says what to do."""

import os
import sys

import numpy as np
from harness import OUTPUT, Reports, add_array, expect_error, field, make_image, points_of, produce, require, run_pvpython
from harness import same_bits, update
from paraview.simple import *
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonTransforms import vtkTransform

STATE = os.path.join(OUTPUT, "pose.pvsm")
RESULT = os.path.join(OUTPUT, "pose.npy")
SIZE = np.array([40, 36, 32])
SPACING = np.array([1.5, 1.5, 2.0])
LABEL = 7


def bone():
    """A block of bone in soft tissue in air, and its label."""
    values = np.full(SIZE[::-1], -1000.0)
    values[2:-2, 2:-2, 2:-2] = 0.0
    labels = np.zeros(values.shape, np.uint8)
    block = (slice(12, 20), slice(14, 22), slice(14, 28))
    values[block] = 1000.0
    labels[block] = LABEL
    return values, labels


def matrix_of(position, target, rotation):
    """What ParaView's box has: Target, RotateZ, RotateX, RotateY, and back from Position."""
    transform = vtkTransform()
    transform.Translate(target)
    transform.RotateZ(rotation[2])
    transform.RotateX(rotation[0])
    transform.RotateY(rotation[1])
    transform.Translate(*[-x for x in position])
    return transform


def moved(deformation):
    volume, model = update(deformation, Reports(deformation))
    return points_of(model, "Displacement").reshape(*SIZE[::-1], 3), volume


def check(deformation, pose, labels, what):
    displacement, volume = moved(deformation)
    transform = matrix_of(pose.Position, pose.Target, pose.Rotation)
    places = np.argwhere(labels == LABEL)
    at = places[:, ::-1] * SPACING
    expected = np.array([transform.TransformPoint(place) for place in at]) - at
    found = displacement[tuple(places.T)]
    # float32 of displacements of some 10 mm, and what the engine promises of a posed bone
    off = np.abs(found - expected).max()
    require(off < 1e-4, "%s: the bone is up to %g mm off vtkTransform's matrix", what, off)
    require(np.abs(expected).max() > 0.5, "%s: nothing was asked for", what)
    return displacement, volume


if len(sys.argv) > 1:  # in another process
    LoadState(STATE)
    np.save(RESULT, moved(FindSource("ChainMailDeformation1"))[0])
    sys.exit(0)

values, labels = bone()
image = make_image(values, "CT", spacing=SPACING)
add_array(image, labels, "Labels")
path = os.path.join(OUTPUT, "pose.vti")
SaveData(path, proxy=produce(image))
scan = OpenDataFile(path)
centre = [float(x) for x in (np.argwhere(labels == LABEL).mean(axis=0)[::-1] * SPACING)]
pose = ChainMailPose(Position=centre, Target=centre, Body=LABEL)
require(list(pose.Rotation) == [0, 0, 0], "a pose begins turned by %s", pose.Rotation)
require(ChainMailPose().Body == -1, "a new pose holds a label")
deformation = ChainMailDeformation(Input=scan, Scalars=["POINTS", "CT"], MaterialPreset="CT (Hounsfield units)", BodyArray="Labels", Rotations=1,
                                   Probes=[pose], ModelArrays=["Displacement"])
for rotation, shift in (([0, 0, 10], [0, 0, 0]), ([4, -6, 9], [0.5, 1.0, -0.75]), ([-12, 0, 3], [0, 0, 1.5])):
    pose.Rotation = rotation
    pose.Target = [c + s for c, s in zip(centre, shift)]
    check(deformation, pose, labels, "angles %s" % rotation)

# About one axis it is the probe's vector to the bit, also beyond half a turn.
for axis in range(3):
    pose.Rotation = [270.0 if a == axis else 0.0 for a in range(3)]
    pose.UpdatePipeline()
    vector = vtk_to_numpy(pose.GetClientSideObject().GetOutput().GetPointData().GetArray("Rotation"))[0]
    require(list(vector) == list(pose.Rotation), "angles %s are the vector %s", list(pose.Rotation), vector)

# Elsewhere than at the middle, and of the bone that is there, without labels.
deformation.BodyArray = ""
pose.Body = -1
pose.Position = [c + d for c, d in zip(centre, (6.0, 0.0, 4.0))]
pose.Target = list(pose.Position)
pose.Rotation = [0, 8, 5]
expected, _ = check(deformation, pose, labels, "without labels")

SaveState(STATE)
run_pvpython(__file__, "load")
require(same_bits(np.load(RESULT), expected), "the loaded state moves the bone otherwise")

# Key frames: half way in time is half way in angle.
scene = GetAnimationScene()
scene.EndTime = 1.0
track = GetAnimationTrack("Rotation", 1, pose)
first, last = CompositeKeyFrame(KeyTime=0.0, KeyValues=[0.0]), CompositeKeyFrame(KeyTime=1.0, KeyValues=[8.0])
track.KeyFrames = [first, last]
scene.AnimationTime = 0.5
require(abs(pose.Rotation[1] - 4.0) < 1e-9, "half way the angle is %g", pose.Rotation[1])
check(deformation, pose, labels, "half way through the key frames")

reports = Reports(deformation)
deformation.Rotations = 0
expect_error(deformation, reports, "Switch Rotations on")
print("poses go where vtkTransform says")
