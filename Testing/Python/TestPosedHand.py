"""A finger of a generated hand, bent by 30 degrees at each of two joints in one update: its bones are at their poses, the palm's
bones and the other fingers stay, and so does their skin."""

import numpy as np
from paper import Result, Reports, field, require, scenes
from scenes import values_of

FINGER = 3
scene = scenes.posed_hand(FINGER)
scene.properties.update(OutputPadding=0)
source, deformation = scenes.open_scene(scene)
result = Result(scene, deformation, Reports(deformation))
require(not result.reports.warnings, "warnings: %s", result.reports.warnings)
turned, reached = field(result.volume, "ProbeTurned"), result.reached
for n, probe in enumerate(scene.probes):
    require(np.allclose(turned[n], probe["Rotation"], atol=1e-6), "probe %d turned by %s of %s", n, turned[n], probe["Rotation"])
    way = np.subtract(probe["Target"], probe["Position"])
    require(np.allclose(reached[n], way, atol=1e-6), "probe %d went %s of %s", n, reached[n], way)

labels = values_of(scene.image, "Bones").ravel()
places = np.array(scene.image.GetOrigin()) + np.stack(np.unravel_index(np.arange(labels.size), result.shape)[::-1], axis=1)
for probe in scene.probes:
    own = np.flatnonzero(labels == probe["Body"])
    require(own.size > 100, "%d voxels of bone %d", own.size, probe["Body"])
    angle = np.radians(np.linalg.norm(probe["Rotation"]))
    arms = places[own] - probe["Position"]
    # The finger lies along x, so it turns about y.
    along, up = arms[:, 0], arms[:, 2]
    sense = np.sign(probe["Rotation"][1]) * np.sin(angle)
    moved = np.stack([np.cos(angle) * along + sense * up, arms[:, 1], np.cos(angle) * up - sense * along], axis=1)
    off = np.abs(places[own] + result.displacement[own] - probe["Target"] - moved).max()
    require(off < 1e-4, "bone %d is %g mm off its pose", probe["Body"], off)

palm = np.isin(labels, [10 * n + 1 for n in range(1, 6)])
require(palm.sum() > 15000 and not result.displacement[palm].any(), "the palm's bones move")
# All of the hand up to the middle of the palm, and the other fingers from where the palm ends: skin and all.
others = (np.abs(places[:, 1] - scenes.FINGERS[FINGER - 1][0][1]) > 16.0) & (places[:, 0] > 95.0)
for name, part in (("palm", places[:, 0] < 30.0), ("other fingers", others)):
    most = np.abs(result.displacement[part]).max()
    require(most < 0.5, "the %s moves by %g mm", name, most)
    print("the %s moves by %.3f mm" % (name, most))
tip = np.abs(result.displacement).max()
require(60.0 < tip < 80.0, "the tip goes %g mm", tip)
print("the finger bent in %.1f s" % (field(result.volume, "Milliseconds").sum() / 1000))
