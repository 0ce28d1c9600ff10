"""The shared scans: the material is fitted, nothing changes at rest, and a probe pulls what is there."""

import time

import numpy as np
from harness import EVERY, Reports, field, points_of, require, same_bits, scan, skip, update
from paraview import servermanager
from paraview.simple import *

# Threshold and background.
SCANS = {
    "abdomen_ct": (-300.0, -993.0),
    "heart_cta": (-300.0, -893.0),
    "chest_lidc_ct": (-300.0, -986.0),
    "head_mr": (25.5, 0.0),
    "head_vhf_ct": (20.7, 4.0),  # 8 bits, not Hounsfield units
}
if not EVERY:
    del SCANS["chest_lidc_ct"], SCANS["head_mr"]  # the largest, and one like the head's CT


def sliding_minimum(values, reach):
    """The smallest value in the cube of (2 reach + 1)^3 around every voxel; minus infinity near the faces."""
    for axis in range(3):
        lines = np.moveaxis(values, axis, 0)
        result = np.full_like(lines, -np.inf)
        inner = result[reach:-reach]
        inner[...] = lines[reach:-reach]
        for step in range(2 * reach + 1):
            np.minimum(inner, lines[step:step + len(inner)], out=inner)
        values = np.moveaxis(result, 0, axis)
    return values


found = {name: scan(name) for name in SCANS if scan(name)}
if not found:
    skip("no scan found; name their folder in CHAINMAIL_VOLUMES")
if len(found) < len(SCANS):
    print("not there, so not tested:", ", ".join(sorted(set(SCANS) - set(found))))

for name, path in found.items():
    started = time.time()
    reader = OpenDataFile(path)
    deformation = ChainMailDeformation(Input=reader, ModelArrays=["Displacement", "Element", "Constraint"])
    reports = Reports(deformation)
    threshold, background = SCANS[name]
    require(abs(deformation.TissueThreshold - threshold) < 1e-9, "%s: the threshold is %g", name, deformation.TissueThreshold)
    require(deformation.BackgroundValue == background, "%s: the background is %g", name, deformation.BackgroundValue)

    image = servermanager.Fetch(reader, 0)
    before = points_of(image, "MetaImage")
    bounds = np.reshape(image.GetBounds(), (3, 2))
    low, size = bounds[:, 0], bounds[:, 1] - bounds[:, 0]

    # A closed cut through the middle, aslant.
    blade = Plane(Origin=low + size * [0, 0, 0.45], Point1=low + size * [1, 0, 0.5], Point2=low + size * [0, 1, 0.52])
    for cuts in ([], [blade]):
        deformation.Cuts = cuts
        volume, model = update(deformation, reports)
        require(same_bits(before, points_of(volume, "MetaImage")), "%s, %d cuts: a voxel changed", name, len(cuts))

    # Tissue near the middle is pulled: it has 5 voxels of soft tissue around it, each of which gives by a tenth of a
    # voxel at least, so it can go half a voxel whatever holds the rest.
    spacing = np.array(image.GetSpacing())
    n = np.array(image.GetDimensions())
    tissue = points_of(model, "Element").reshape(n[::-1]) > 0
    require(0.2 < tissue.mean() < 0.99, "%s: %.0f %% of the voxels are tissue", name, 100 * tissue.mean())
    soft = sliding_minimum(points_of(model, "Constraint").reshape(n[::-1]), 5) >= 0.1
    places = np.argwhere(soft)[:, ::-1] + np.array(image.GetExtent())[::2]
    middle = np.array(image.GetExtent())[::2] + 0.5 * (n - 1)
    index = places[((places - middle) ** 2).sum(axis=1).argmin()]
    place = np.array(image.GetOrigin()) + index * spacing
    pull = np.array([0.25, 0.5, -0.5]) * spacing
    deformation.Cuts = []
    deformation.RelaxationIterations = 5
    deformation.Probes = [ChainMailProbe(Position=place, Target=place + pull)]
    volume, model = update(deformation, reports)
    require(np.allclose(field(volume, "ProbeReached")[0], pull, atol=1e-4 * spacing.min()),
            "%s: the probe reached %s instead of %s", name, field(volume, "ProbeReached")[0], pull)
    first = np.array(image.GetExtent())[::2]
    moved = points_of(model, "Displacement").reshape(*n[::-1], 3)
    at = tuple((index - first)[::-1])
    require(np.allclose(moved[at], pull, atol=1e-4 * spacing.min()), "%s: the tissue that is held moved by %s", name, moved[at])
    require(not moved[~tissue].any(), "%s: air moved", name)
    require(field(volume, "MaxLinkExcess")[0, 0] <= 1e-5, "%s: a link is %g too long", name,
            field(volume, "MaxLinkExcess")[0, 0])
    require((points_of(volume, "MetaImage") != before).any(), "%s: the volume shows nothing of it", name)

    # A cut all through the image, across x and halfway between two layers of voxels next to the handle: nothing beyond
    # follows any more, and what is on this side does.
    far = (slice(None), slice(None), slice(at[2] + 2, None))
    require(moved[far].any(), "%s: the wave does not reach beyond the coming cut", name)
    x = (place + 1.5 * spacing)[0]
    edge = [x, *(low - 10 * spacing)[1:]]
    width = size + 20 * spacing
    deformation.Cuts = [Plane(Origin=edge, Point1=edge + width * [0, 1, 0], Point2=edge + width * [0, 0, 1])]
    _, model = update(deformation, reports)
    moved = points_of(model, "Displacement").reshape(*n[::-1], 3)
    require(np.allclose(moved[at], pull, atol=1e-4 * spacing.min()), "%s, cut: the tissue that is held moved by %s", name,
            moved[at])
    require(not moved[far].any(), "%s: tissue beyond the cut moved by up to %g", name, np.abs(moved[far]).max())
    print("%s: fitted, identical at rest, pulled, cut (%.1f s)" % (name, time.time() - started), flush=True)
    for proxy in (deformation, reader):
        Delete(proxy)
