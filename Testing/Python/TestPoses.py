"""Poses on a real scan: every vertebra of a CT rotates about its own centre by its own matrix, exactly; tissue between stays
within its limits, the rest of the scan at rest; the inverse poses bring all back."""

import time

import numpy as np
from harness import Reports, expect_error, field, make_points, points_of, produce, require, scan, skip, update
from paraview import servermanager
from paraview.simple import *

VERTEBRAE = range(25, 34)
DEGREES = 5.0


def matrix_of(vector):
    """The rotation by a rotation vector [degrees], by Rodrigues' formula."""
    angle = np.radians(np.linalg.norm(vector))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = np.asarray(vector) / np.linalg.norm(vector)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


if not scan("abdomen_labels"):
    skip("no scan found; name their folder in CHAINMAIL_VOLUMES")
images = [servermanager.Fetch(OpenDataFile(scan(name)), 0) for name in ("abdomen_ct", "abdomen_labels")]
labels = images[1].GetPointData().GetArray(0)
labels.SetName("Labels")
images[0].GetPointData().AddArray(labels)
image = images[0]
size = np.array(image.GetDimensions())
spacing, origin = np.array(image.GetSpacing()), np.array(image.GetOrigin())
label = points_of(image, "Labels").reshape(size[::-1])
# Spongy bone counts as bone here, since voxels of 3 mm leave little of the compact one.
material = CreatePiecewiseFunction(Points=[-300, 0.35, 0.5, 0, 249, 0.1, 0.5, 0, 250, 0, 0.5, 0])
deformation = ChainMailDeformation(Input=produce(image), TissueThreshold=-300.0, MaterialFunction=material,
                                   BodyArray="Labels", JointConstraint=1.0, Rotations=1,
                                   AnchoredFaces=[1, 1, 1, 1, 1, 0],  # the scan ends within the uppermost one
                                   ModelArrays=["Displacement", "Cluster", "Element"])
reports = Reports(deformation)


def places_of(mask):
    return origin + np.argwhere(mask)[:, ::-1] * spacing


centres = np.array([places_of(label == n).mean(axis=0) for n in VERTEBRAE])
axes = np.array([[DEGREES, 0, 0] if n % 2 else [0, 0, -DEGREES] for n in VERTEBRAE])
source = produce(make_points(centres, Displacement=0 * centres, Rotation=axes, Body=list(VERTEBRAE)))
deformation.Probes = [source]
began = time.time()
volume, model = update(deformation, reports)
seconds = time.time() - began
require(not reports.warnings, "warnings: %s", reports.warnings)
turned = field(volume, "ProbeTurned")
print("turned by", np.round(np.linalg.norm(turned, axis=1), 3))
require(np.allclose(turned, axes, atol=1e-9), "turned by %s", turned)
require(np.allclose(field(volume, "ProbeReached"), 0, atol=1e-9), "reached %s", field(volume, "ProbeReached"))
moved = points_of(model, "Displacement").reshape(*size[::-1], 3)
element = points_of(model, "Element").reshape(size[::-1]) > 0
for n, vertebra in enumerate(VERTEBRAE):
    own = (label == vertebra) & element
    arm = places_of(own) - centres[n]
    off = np.abs(moved[own] - (arm @ matrix_of(axes[n]).T - arm)).max()
    require(off < 1e-4, "vertebra %d is up to %g mm off its matrix", vertebra, off)
require(field(volume, "MaxLinkExcess")[0, 0] < 2e-5, "links are %g too long", field(volume, "MaxLinkExcess")[0, 0])
far = np.linalg.norm(moved, axis=-1)
require((np.linalg.norm(field(volume, "ProbeTorque"), axis=1) > 0).all(), "no torque")

# The same by one pull of the same tissue, for its time.
pull = produce(make_points(centres, Displacement=0 * centres + [0.0, 1.5, 0.0], Body=list(VERTEBRAE)))
deformation.Probes = [pull]
began = time.time()
update(deformation, reports)
print("poses %.2f s, pulls of the same bodies %.2f s; %d elements moved, furthest %.2f mm" %
      (seconds, time.time() - began, (far > 0).sum(), far.max()))

# Back by the inverse poses, from the present state.
deformation.Mode = "Interactive"
deformation.Probes = [source]
update(deformation, reports)
for step in range(2):
    source.GetClientSideObject().SetOutput(make_points(centres, Displacement=0 * centres, Rotation=(1 - step) * 0.5 * axes,
                                                  Body=list(VERTEBRAE)))
    source.MarkModified(source)
    volume, model = update(deformation, reports)
    require(np.allclose(field(volume, "ProbeTurned"), (1 - step) * 0.5 * axes, atol=1e-9), "step %d: turned by %s", step,
            field(volume, "ProbeTurned"))
bone = np.isin(label, list(VERTEBRAE)) & element
back = points_of(model, "Displacement").reshape(*size[::-1], 3)
require((back[bone] == 0).all(), "the vertebrae are not back: %g mm", np.abs(back[bone]).max())
deformation.Mode = "FromRest"

# What cannot be is said.
deformation.BodyArray = ""
expect_error(deformation, reports, "BodyArray", "Labels")
deformation.BodyArray = "Labels"
for body, part in ((200, "label 200"), (0, "from 1 on"), (2.5, "2.5")):
    deformation.Probes = [produce(make_points(centres[:1], Displacement=0 * centres[:1], Rotation=axes[:1], Body=[body]))]
    expect_error(deformation, reports, part)
deformation.Probes = [produce(make_points(centres[:1], Displacement=0 * centres[:1], Rotation=axes[:1] * np.nan))]
expect_error(deformation, reports, "Rotation", "finite")
deformation.Probes = [source]
source.GetClientSideObject().SetOutput(make_points(centres, Displacement=0 * centres, Rotation=axes, Body=list(VERTEBRAE)))
source.MarkModified(source)
deformation.Rotations = 0
expect_error(deformation, reports, "Switch Rotations on")
deformation.Rotations = 1
deformation.PropagationIterations = 5
expect_error(deformation, reports, "PropagationIterations")
