"""A finger bends at its joints: five bones that touch are led along an arc by the tip, step by step, until the last one has
turned by some 30 degrees; the bone that a face of the scan holds stays, and every bone keeps its shape."""

import numpy as np
from harness import Reports, add_array, field, make_image, points_of, produce, require, skip, update
from paraview.simple import *

ANGLE = np.radians(42.0)  # of an even arc; the tip is held as by a ball joint, so the joints near the palm turn more
STEPS = 15
LENGTH = 12  # of a bone with its gap, in voxels
WIDTH = 9


def phantom():
    """The finger lies along x, in skin; air is above it. A bridge of 3 x 3 voxels joins each bone to the next."""
    z, y, x = np.mgrid[0:36, 0:17, 0:64]
    n, along = x // LENGTH, x % LENGTH
    off = np.maximum(abs(y - 8), abs(z - 8))
    bone = np.where(along < LENGTH - 1, (off <= WIDTH // 2) & (n < 5), (off <= 1) & (n < 4))
    scan = np.where(bone, 1200, np.where((z < 17) & (x < 62), 50, -1000)).astype(np.int16)
    image = make_image(scan)
    add_array(image, np.where(bone, n + 1, 0).astype(np.uint8), "Bones")
    return image, np.where(bone, n, -1).ravel()


def led(angle):
    """Where the middle of the last bone goes when all four joints turn by a quarter of `angle`."""
    place = np.array([LENGTH - 0.5, 8.0])  # the first joint, x and z
    for joint in range(1, 4):
        turned = joint * angle / 4
        place += LENGTH * np.array([np.cos(turned), np.sin(turned)])
    place += 5.5 * np.array([np.cos(angle), np.sin(angle)])
    return np.array([place[0], 8.0, place[1]])


def turned(places, moved):
    """The angle about y of the rotation that is nearest to what a bone did (Kabsch), and how far it is from rigid."""
    a, b = places - places.mean(axis=0), moved - moved.mean(axis=0)
    u, _, v = np.linalg.svd(a.T @ b)
    rotation = (u @ np.diag([1, 1, np.sign(np.linalg.det(u @ v))]) @ v).T
    rest = np.sqrt(((b - a @ rotation.T) ** 2).sum(axis=1).max())
    return np.degrees(np.arctan2(rotation[2, 0] - rotation[0, 2], rotation[0, 0] + rotation[2, 2])), rest


image, bone = phantom()
deformation = ChainMailDeformation(Input=produce(image), MaterialPreset="CT (Hounsfield units)", BodyArray="Bones",
                                   JointConstraint=0.9, AnchoredFaces=[1, 0, 0, 0, 0, 0], Mode="Interactive",
                                   RelaxationIterations=100, ModelArrays=["Displacement", "Cluster"])
if deformation.GetProperty("Rotations") is None:
    skip("the filter has no Rotations")
deformation.Rotations = 1
reports = Reports(deformation)
start = led(0.0)
probe = ChainMailProbe(Position=start, Target=start)
deformation.Probes = [probe]
for step in range(1, STEPS + 1):
    probe.Target = led(ANGLE * step / STEPS)
    volume, model = update(deformation, reports)
places = np.argwhere(np.ones((36, 17, 64), bool))[:, ::-1].astype(float)
moved = places + points_of(model, "Displacement")
cluster = points_of(model, "Cluster")
angles = []
for n in range(5):
    number = cluster[bone == n].max()
    own = cluster == number
    angle, rest = turned(places[own], moved[own])
    angles.append(angle)
    require(rest < 1e-3, "bone %d is bent by %g voxels", n, rest)
print("the bones turned by %s degrees; the tip came %s of %s voxels" % (
    ", ".join("%.1f" % angle for angle in angles), field(volume, "ProbeReached")[0], led(ANGLE) - start))
require(not (moved - places)[(cluster == cluster[bone == 0].max())].any(), "the bone that is held moved")
require(abs(angles[0]) < 1e-3 and all(np.diff(angles) > 0), "the bones do not turn one after the other")
require(29 < angles[4] < 36, "the tip turned by %.1f degrees", angles[4])
