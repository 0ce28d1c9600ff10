"""The paper's hand, cut and opened (figure 11), on the forearm phantom and, where all scenes are played, on a scan of
a head: the skin opens by what the hooks ask for, whole skin does not, bones do not deform, and the picture loses no tissue."""

import os

import numpy as np
from harness import EVERY, field, points_of, require, scan
from paper import check_rigid, growth, run, scenes
from paraview.simple import *


def opened_by(result, name, place, across, out, threshold):
    """The widest gap [mm] in the picture: a run without tissue, along lines across the incision from 6 mm below the
    hooks to 4 mm above, in the section through them."""
    image = result.scene.image
    values = points_of(result.volume, name).reshape(result.shape)
    spacing, origin = np.array(image.GetSpacing()), np.array(image.GetOrigin())
    step = 0.25 * spacing.min()
    widest = 0.0
    for depth in np.arange(-6.0, 4.0, step):
        points = place + depth * out + np.arange(-30.0, 30.0, step)[:, None] * across
        index = np.rint((points - origin) / spacing).astype(int)
        index = index[((index >= 0) & (index < image.GetDimensions())).all(axis=1)]
        tissue = np.flatnonzero(values[index[:, 2], index[:, 1], index[:, 0]] >= threshold)
        if tissue.size > 1:
            widest = max(widest, (np.diff(tissue).max() - 1) * step)
    return widest


def check(make, name, threshold, across, out, bone, least_gap):
    """make: the scene, cut or whole. across, out: the incision's directions in the section through the hooks. bone: elements
    that the skeleton's parts have at least."""
    results = {}
    for label in ("whole", "cut"):
        scene = make(label == "cut")
        image = scene.image
        spacing = np.array(image.GetSpacing())
        place = np.mean([probe["Position"] for probe in scene.probes], axis=0)
        axis = int(np.argmax(np.abs(across)))
        tissue = scenes.values_of(image, name) >= threshold
        scenes.add_array(image, tissue.astype(np.uint8), "Tissue")
        result = run(scene, LabelArrays=["Tissue"])
        went = check_rigid(result, bone)
        short = [float(np.linalg.norm(reached - np.subtract(probe["Target"], probe["Position"])))
                 for reached, probe in zip(result.reached, scene.probes)]
        gap = opened_by(result, name, place, np.array(across, float), np.array(out, float), threshold)

        # The tissue in the picture takes the room that its elements have now. A side of the cut is a part of its own.
        side = 1 + (scenes.coordinates(image)[axis] > place[axis]) if label == "cut" else 1
        factor = growth(result, np.where(tissue, side, 0)).reshape(result.shape)
        before = tissue.sum() * np.prod(spacing) / 1000
        now = factor[tissue].sum() * np.prod(spacing) / 1000
        seen = (points_of(result.volume, "Tissue") > 0).sum() * np.prod(spacing) / 1000
        results[label] = gap, short
        print("%s, %s: the hooks are %s mm short, the gap is %.1f mm; %d large bones moved by up to %.2f mm; %d elements move; "
              "%.2f ml, now %.2f, in the picture %.2f; %.0f ms" % (
                  name, label, " and ".join("%.1f" % s for s in short), gap, went.size, went.max(),
                  field(result.volume, "DisplacedElements")[0, 0], before, now, seen,
                  field(result.volume, "Milliseconds").sum()), flush=True)
        require(abs(seen - now) <= 0.001 * before, "%s, %s: %g ml are lost", name, label, now - seen)
    (closed, held), (open_, free) = results["whole"], results["cut"]
    require(closed <= 3.0, "%s: whole skin opens by %g mm", name, closed)
    require(open_ >= least_gap, "%s: the skin opens by %g mm only", name, open_)
    require(max(free) < 2.5 and max(held) > 5.0, "%s: the hooks are %s mm short, and %s mm where the skin is whole", name, free, held)


check(lambda cut: scenes.opened_limb((88, 80, 104), cut), "CT", scenes.AIR, (1, 0, 0), (0, 1, 0), 1000, 10.0)
if EVERY and scan("head_vhf_ct"):
    check(lambda cut: scenes.opened_cheek(os.environ["CHAINMAIL_VOLUMES"], cut), "MetaImage", 35, (0, 1, 0), (1, 0, 0), 5000, 9.0)
elif EVERY:
    print("there is no head_vhf_ct.mhd, so it is not tested")
