"""The paper's heart, probed from inside (figure 9): a scan's left ventricle is grabbed at its wall and pushed outwards; the
wall goes along, the chamber grows by as much as its elements do, and what the wave does not reach stays."""

import os

import numpy as np
from harness import field, points_of, require, scan, skip
from paper import METHODS, check_rigid, growth, run, scenes
from paraview.simple import *

if not scan("heart_cta"):
    skip("there is no heart_cta.mhd; name the folder of scans in CHAINMAIL_VOLUMES")

BLOOD, MYOCARDIUM = (250.0, 550.0), (40.0, 180.0)  # [HU]
scene = scenes.probed_heart(os.environ["CHAINMAIL_VOLUMES"])
image, probe = scene.image, scene.probes[0]
hu = scenes.values_of(image, "MetaImage").astype(float)
asked = np.subtract(probe["Target"], probe["Position"])
spacing = image.GetSpacing()[0]


def blood_around(values, index):
    """Voxels of blood in the cube of 15^3 voxels around a place: contrast mixes with blood, so single voxels vary."""
    x, y, z = index
    part = values[z - 7:z + 8, y - 7:y + 8, x - 7:x + 8]
    return ((part >= BLOOD[0]) & (part <= BLOOD[1])).sum()


# In the chamber, and at its wall: the sphere that is grabbed holds blood and muscle.
require(blood_around(hu, scenes.HEART_CHAMBER) > 0.9 * 15**3, "the chamber is not full of blood")
require(BLOOD[0] <= hu[tuple(reversed(scenes.HEART_WALL))] <= BLOOD[1], "the probe is not in the blood")
x, y, z = np.meshgrid(*(np.arange(n) for n in image.GetDimensions()), indexing="ij")
away = np.sqrt(sum((axis - at) ** 2 for axis, at in zip((x, y, z), scenes.HEART_WALL))).transpose(2, 1, 0) * spacing
grabbed = away <= probe["Radius"]
muscle = (hu >= MYOCARDIUM[0]) & (hu <= MYOCARDIUM[1])
require((grabbed & muscle).sum() > 100, "the probe holds %d voxels of muscle", (grabbed & muscle).sum())

blood = (hu >= BLOOD[0]) & (hu <= BLOOD[1]) & (away <= 60.0)
scenes.add_array(image, blood.astype(np.uint8), "Blood")

states = {}
for method, number in METHODS.items():
    result = run(scene, PropagationMethod=number, RelaxationIterations=0)
    states[method] = result.displacement
    require(np.allclose(result.reached[0], asked, atol=1e-4), "%s: the probe reached %s", method, result.reached[0])
    require((result.displacement[(grabbed & (hu >= -300)).ravel()] == result.displacement[np.argmin(away)]).all(),
            "%s: the tissue that is held does not move as one", method)
    # No link gives by less than a third of a voxel but rigid ones, and of these there are few: the wave ends.
    far = result.tissue & (away > 60.0).ravel()
    require(far.sum() > 100000 and not result.displacement[far].any(), "%s: the wave gets too far", method)
difference = np.abs(states["Envelope"] - states["Timestamp"]).max() / spacing
require(difference <= 1e-5, "the methods differ by %g of the spacing", difference)

# Times are lengths of paths: no two neighbours are further apart in time than their link is long, and what moves moves by
# what is left of the pull when the wave comes.
time = result.time.reshape(result.shape)
constraint = points_of(result.model, "Constraint").reshape(result.shape)
reached = time >= 0
for axis in range(3):
    pairs = np.take(reached, range(1, reached.shape[axis]), axis) & np.take(reached, range(reached.shape[axis] - 1), axis)
    moved = [np.take(result.displacement.any(axis=1).reshape(result.shape), r, axis)
             for r in (range(1, reached.shape[axis]), range(reached.shape[axis] - 1))]
    apart = np.abs(np.diff(time, axis=axis))[pairs & moved[0] & moved[1]]
    link = 0.5 * spacing * (np.take(constraint, range(1, reached.shape[axis]), axis) +
                            np.take(constraint, range(reached.shape[axis] - 1), axis))[pairs & moved[0] & moved[1]]
    require((apart <= link + 1e-4).all(), "times of neighbours are %g mm further apart than their link", (apart - link).max())
held = np.zeros(result.shape, bool)
for face in (0, -1):
    held[face], held[:, face], held[:, :, face] = True, True, True
free = result.displacement.any(axis=1) & ~held.ravel()
left_over = np.clip(np.abs(asked).max() - result.time[free], 0.0, None)
require((np.abs(result.displacement[free]).max(axis=1) <= left_over + 1e-4).all(), "tissue moves by more than the wave brings")
require(free.sum() > 50000, "only %d elements move", free.sum())

# Settled.
result = run(scene, LabelArrays=["Blood"])
check_rigid(result, 10)
went = np.linalg.norm(result.displacement, axis=1).reshape(result.shape)
wall = muscle & (away <= 1.5 * probe["Radius"]) & (x.transpose(2, 1, 0) < scenes.HEART_WALL[0])
require(wall.sum() > 500 and np.median(went[wall]) > 8.0, "%d voxels of the wall went by %.1f mm", wall.sum(), np.median(went[wall]))
require(not went[held].any(), "a face of the box moves")
require(went[away > 120.0].max() < 0.05, "tissue far away moves by %g mm", went[away > 120.0].max())

# The blood needs more room, and the picture shows it.
factor = growth(result, result.tissue.astype(int)).reshape(result.shape)
before = blood.sum() * spacing**3 / 1000
now = factor[blood].sum() * spacing**3 / 1000
seen = (points_of(result.volume, "Blood") > 0).sum() * spacing**3 / 1000
print("figure 9: %d elements move, the wall by %.1f mm; the blood within 60 mm takes %.1f ml, %.1f at rest, %.1f in the "
      "picture; %.0f ms" % (field(result.volume, "DisplacedElements")[0, 0], np.median(went[wall]), now, before, seen,
                            field(result.volume, "Milliseconds").sum()))
require(now > before + 15.0, "the chamber does not grow: from %g to %g ml", before, now)
require(abs(seen - now) < 0.01 * before, "in the picture the chamber has %g ml, not %g", seen, now)
