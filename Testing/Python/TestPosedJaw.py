"""The jaw of a scan without labels, turned by 20 degrees about its joints in one update: it is at its pose, the skull stays, and
tissue between keeps to its limits."""

import os

import numpy as np
from harness import scan, skip
from paper import Result, Reports, field, require, scenes

if not scan("head_vhf_ct"):
    skip("no scan found; name their folder in CHAINMAIL_VOLUMES")
scene = scenes.posed_jaw(os.environ["CHAINMAIL_VOLUMES"])
scene.properties.update(RelaxationPreset="Fast", OutputPadding=0)
source, deformation = scenes.open_scene(scene)
result = Result(scene, deformation, Reports(deformation))
require(not result.reports.warnings, "warnings: %s", result.reports.warnings)
turned, reached = field(result.volume, "ProbeTurned"), result.reached
pose, skull = scene.probes
require(np.allclose(turned[0], pose["Rotation"], atol=1e-9), "turned by %s of %s", turned[0], pose["Rotation"])
require(np.allclose(reached[0], np.subtract(pose["Target"], pose["Position"]), atol=1e-9), "reached %s", reached[0])

# Every voxel of both bones is where the rotation has it, here by the matrix exponential's series.
spacing = np.array(result.model.GetSpacing())
origin = np.array(result.model.GetOrigin()) + np.array(result.model.GetExtent()[::2]) * spacing
cross = np.cross(np.eye(3), np.radians(pose["Rotation"]))
matrix, term = np.eye(3), np.eye(3)
for n in range(1, 30):
    term = term @ cross / n
    matrix += term
voxel = lambda place: int(np.ravel_multi_index(tuple(np.rint((np.array(place) - origin) / spacing).astype(int)[::-1]), result.shape))
for probe, motion, least in ((pose, matrix, 20000), (skull, np.eye(3), 300000)):
    own = np.flatnonzero(result.cluster == result.cluster[voxel(probe["Position"])])
    require(own.size > least, "%d voxels of a bone", own.size)
    place = origin + np.stack(np.unravel_index(own, result.shape)[::-1], axis=1) * spacing
    wanted = np.array(probe["Target"]) + (place - probe["Position"]) @ motion.T
    off = np.abs(place + result.displacement[own] - wanted).max()
    require(off < 1e-4, "a bone is %g mm off its pose", off)
require(np.abs(result.displacement).max() > 20, "no more than %g mm anywhere", np.abs(result.displacement).max())
print("jaw turned by %s degrees in %.1f s" % (turned[0].round(3), field(result.volume, "Milliseconds").sum() / 1000))
