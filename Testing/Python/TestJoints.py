"""Joints on real scans: bone that was one body with what a face of the scan holds comes free, a vertebra by its label, and by
its thickness the skull from the spine and a rib from its vertebra."""

import numpy as np
from harness import EVERY, Reports, field, points_of, produce, require, scan, skip, update
from paraview import servermanager
from paraview.simple import *

BY_FACE = 1


def bodies(volume):
    """The numbers of voxels of all bodies, largest first, and whether a face holds them."""
    voxels, holders = field(volume, "BodyVoxels").ravel(), field(volume, "BodyHeldBy").ravel()
    order = np.argsort(voxels)[::-1]
    return order, voxels[order], holders[order]


def middle_of(deformation, model, body):
    """A voxel of a body, the one nearest to its middle, in world axes."""
    n = np.array(model.GetDimensions())
    places = np.argwhere(points_of(model, "Cluster").reshape(n[::-1]) == body)[:, ::-1]
    nearest = places[((places - places.mean(axis=0)) ** 2).sum(axis=1).argmin()]
    return np.array(model.GetOrigin()) + (nearest + np.array(model.GetExtent())[::2]) * np.array(model.GetSpacing())


def check(name, settings, size, most):
    """With joints of `size` voxels there are at most `most` more bodies of 500 voxels, and one that could not move
    does."""
    reader = OpenDataFile(scan(name))
    deformation = ChainMailDeformation(Input=reader, ModelArrays=["Displacement", "Cluster"], RelaxationIterations=0, **settings)
    reports = Reports(deformation)
    deformation.JointSize = 1  # no bridge is thinner, so these are the bodies without joints
    volume, model = update(deformation, reports)
    before = points_of(model, "Cluster").copy()
    order, voxels, holders = bodies(volume)
    large = (voxels >= 500).sum()
    held = set(order[holders == BY_FACE])
    deformation.JointSize = size
    volume, model = update(deformation, reports)
    order, voxels, holders = bodies(volume)
    more = (voxels >= 500).sum() - large
    require(1 <= more <= most, "%s: %d bodies more of 500 voxels", name, more)
    after = points_of(model, "Cluster")
    require((after[before < 0] < 0).all(), "%s: tissue became rigid", name)
    joints = (after < 0) & (before >= 0)
    require(0 < joints.sum() < 0.02 * (before >= 0).sum(), "%s: %d of %d rigid voxels are joints", name, joints.sum(),
            (before >= 0).sum())

    # The largest body that is free now and was part of a held one.
    free = next(body for body, holder in zip(order, holders) if holder == 0 and before[after == body][0] in held)
    place = middle_of(deformation, model, free)
    pull = np.array([0.0, 1.0, 0.0]) * np.array(model.GetSpacing())
    deformation.Probes = [ChainMailProbe(Position=place, Target=place + pull)]
    reached = {}
    for bridge in (1, size):
        deformation.JointSize = bridge
        volume, model = update(deformation, reports)
        reached[bridge] = np.linalg.norm(field(volume, "ProbeReached")[0])
    require(reached[1] < 1e-6, "%s: without joints the bone came %g mm", name, reached[1])
    require(reached[size] > 0.2, "%s: with joints the bone came %g mm", name, reached[size])
    moved = points_of(model, "Displacement")[after == free]
    require((moved == moved[0]).all() and moved[0].any(), "%s: the bone does not move as one", name)
    deformation.UpdatePropertyInformation()
    report = str(deformation.GetPropertyValue("Report"))
    require("bodies of bone" in report and "by the face" in report, "%s: the report says\n%s", name, report)
    print("%s: %d bodies of 500 voxels and more, %d without joints; one of %d voxels came %.2f mm instead of 0" %
          (name, large + more, large, (after == free).sum(), reached[size]))
    Delete(deformation)
    Delete(reader)


def check_labels():
    """With a segmentation the vertebrae that are all in the scan are free; without they are one with the hips, which a face
    holds."""
    scans = [servermanager.Fetch(OpenDataFile(scan(name)), 0) for name in ("abdomen_ct", "abdomen_labels")]
    labels = scans[1].GetPointData().GetArray(0)
    labels.SetName("Labels")
    scans[0].GetPointData().AddArray(labels)
    # Spongy bone counts as bone here, since voxels of 3 mm leave little of the compact one.
    material = CreatePiecewiseFunction(Points=[-300, 0.35, 0.5, 0, 249, 0.1, 0.5, 0, 250, 0, 0.5, 0])
    deformation = ChainMailDeformation(Input=produce(scans[0]), TissueThreshold=-300.0, MaterialFunction=material,
                                       RelaxationIterations=0, ModelArrays=["Displacement", "Cluster"])
    reports = Reports(deformation)
    deformation.BodyArray = "Labels"
    volume, model = update(deformation, reports)
    order, voxels, holders = bodies(volume)
    names = field(volume, "BodyLabel").ravel()[order]
    vertebrae = range(26, 32)
    for vertebra in vertebrae:
        n = list(names).index(vertebra)  # the largest part of it
        require(voxels[n] > 300 and holders[n] == 0, "vertebra %d: %d voxels, held by %d", vertebra, voxels[n], holders[n])
    body = order[list(names).index(28)]
    place = middle_of(deformation, model, body)
    own = points_of(model, "Cluster") == body
    deformation.Probes = [ChainMailProbe(Position=place, Target=place + [0, 1.2, 0])]
    came = {}
    for array in ("", "Labels"):
        deformation.BodyArray = array
        volume, model = update(deformation, reports)
        came[array] = field(volume, "ProbeReached")[0, 1]
    require(came[""] == 0.0 and came["Labels"] > 0.5, "the vertebra came %s mm", came)
    moved = points_of(model, "Displacement")[own]
    require((moved == moved[0]).all(), "the vertebra does not move as one")
    print("abdomen_ct: %d vertebrae are free; one of %d voxels came %.2f mm instead of 0" %
          (len(vertebrae), own.sum(), came["Labels"]))


found = [name for name in ("head_vhf_ct", "chest_lidc_ct") if EVERY and scan(name)]
if not scan("abdomen_labels"):
    skip("no scan found; name their folder in CHAINMAIL_VOLUMES")
check_labels()
if "head_vhf_ct" in found:
    # 8 bits: 101 is 592 Hounsfield units.
    material = CreatePiecewiseFunction(Points=[25, 0.35, 0.5, 0, 100, 0.08, 0.5, 0, 101, 0, 0.5, 0, 255, 0, 0.5, 0])
    check("head_vhf_ct", {"TissueThreshold": 25.0, "MaterialFunction": material}, 2, 20)
if "chest_lidc_ct" in found:
    check("chest_lidc_ct", {"MaterialPreset": "CT (Hounsfield units)"}, 2, 40)
