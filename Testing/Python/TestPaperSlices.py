"""The paper's scenes in a slice: compressed (figure 6), pulled before and after a cut (figure 7), and an incision opened
from both sides (figure 8); displacements and times of arrival against Dijkstra's algorithm."""

import numpy as np
from harness import points_of, require
from paper import METHODS, check_rigid, run, scenes, growth
from paraview.simple import *

# float32 sums of up to two hundred links around displacements of 10 mm; links are 0.1 to 0.3 mm.
TOLERANCE = 1e-5  # [mm]
# The skirt of half a voxel along a side's border, 200 mm long, is stretched by some tenths in one direction or both.
AREA_TOLERANCE = 0.01
# Whole pixels are counted in some twenty rows: the mean's deviation is a pixel of 0.75 mm / sqrt(12) / sqrt(20), twice
# for two lips. A lip that lost half a voxel would be 0.38 mm off.
GAP_TOLERANCE = 0.2


def check_propagation(result, oracle, what):
    """Displacements against (P*) and times of the last probe's wave against Dijkstra, with both methods. Returns what the
    oracle has: displacements and distances [mm]."""
    handles = result.handles(oracle)
    expected = oracle.pulled(handles)
    arrival = oracle.distances(handles[-1][0]) * oracle.spacing[0]
    moved = (np.abs(expected) > TOLERANCE).any(axis=1)
    require(moved.sum() > 2000, "%s: only %d elements move", what, moved.sum())
    for method, number in METHODS.items():
        result.again(PropagationMethod=number, RelaxationIterations=0)
        error = np.abs(result.displacement - expected).max()
        late = np.abs(result.time - arrival)[moved].max()
        print("%s, %s: %d elements move by up to %.1f mm; displacements off by %.1e mm, times by %.1e mm" % (
            what, method, moved.sum(), np.abs(expected).max(), error, late), flush=True)
        require(error <= TOLERANCE, "%s, %s: displacements are off by %g mm", what, method, error)
        require(late <= TOLERANCE, "%s, %s: times are off by %g mm", what, method, late)
        require(not result.displacement[oracle.tissue & (expected == 0).all(axis=1)].any(),
                "%s, %s: what nothing reaches moves", what, method)
    return expected, arrival, moved


# Figure 6: compressed, homogeneous against heterogeneous.
slices = {}
for heterogeneous in (False, True):
    what = "figure 6, heterogeneous" if heterogeneous else "figure 6, homogeneous"
    result = run(scenes.compressed_slice(heterogeneous))
    pressed = result.displacement
    bones = scenes.values_of(result.scene.image, "CT").ravel() >= scenes.BONE
    slices[heterogeneous] = result
    oracle = result.oracle()
    tissue = result.tissue.reshape(result.shape)[0]
    require(not tissue[[0, -1]].any() and not tissue[:, [0, -1]].any(), "%s: the slice touches its border", what)
    require(np.allclose(result.reached[1], [0, -scenes.PRESS, 0], atol=TOLERANCE), "%s: pressed by %s", what, result.reached)
    if heterogeneous:
        went = check_rigid(result, 200)
        require(went.min() > 1.0, "%s: bones went by %s mm", what, went)
    else:
        # Without stiff tissue the places of the bones are squeezed.
        squeezed = np.ptp(pressed[bones, 1])
        require(squeezed > 1.0, "%s: the bones' places are squeezed by %g mm", what, squeezed)
    _, arrival, moved = check_propagation(result, oracle, what)
    if heterogeneous:
        for number in np.unique(result.cluster[bones & moved & (result.cluster >= 0)]):
            times = np.unique(result.time[result.cluster == number])
            require(times.size == 1, "%s: the wave comes to a bone %g mm apart", what, np.ptp(times))
    else:
        links = result.time[moved] / (0.25 * result.model.GetSpacing()[0])
        require((links == np.rint(links)).all(), "%s: times are not whole numbers of links", what)
    slices[heterogeneous] = arrival, moved, bones
# Rigid bone is no way at all: the wave is ahead behind it, and in front of it behind, as fat and skin are softer.
(plain, _, _), (mixed, moved, bones) = slices[False], slices[True]
require((mixed[bones & moved] < plain[bones & moved]).all(), "figure 6: bones do not hasten the wave")

# Figure 7: the same pull, whole and after a cut.
shapes = {}
for cut in (False, True):
    what = "figure 7, cut" if cut else "figure 7, whole"
    result = run(scenes.pulled_slice(cut))
    n = result.shape[2]
    x, y, _ = scenes.coordinates(result.scene.image)
    x, y = x.ravel(), y.ravel()
    severed = []
    if cut:
        j = np.flatnonzero(y < scenes.CUT_Y).max()
        severed = [(j * n + i, (j + 1) * n + i) for i in np.flatnonzero(x < scenes.CUT_END)]
    shapes[cut] = check_propagation(result, result.oracle(severed), what)
(whole, before, _), (parted, after, moved) = shapes[False], shapes[True]
x, y = (v.ravel() for v in np.meshgrid(x, y))
beyond = result.tissue & (y > scenes.CUT_Y) & (x < scenes.CUT_END)
still = beyond & (np.abs(whole) > 0.5).any(axis=1) & (parted == 0).all(axis=1)
require(still.sum() > 500, "figure 7: only %d elements beyond the cut stay put", still.sum())
require(not result.displacement[still].any(), "figure 7: beyond the cut tissue moves")
around = beyond & moved & (after > before + 2.0)
require(around.sum() > 100, "figure 7: the wave does not go around the cut: %d elements", around.sum())
require((after[result.tissue] >= before[result.tissue]).all(), "figure 7: a cut hastens the wave")
print("figure 7: beyond the cut %d elements stay put, to %d the wave comes around it, by up to %.1f mm later" % (
    still.sum(), around.sum(), (after[around] - before[around]).max()))

# Figure 8: both lips of an incision.
for name in ("whole", "cut"):
    opened = run(scenes.opened_slice(name == "cut"))
    image = opened.scene.image
    xs, ys, _ = (v.ravel() for v in scenes.coordinates(image))
    step = image.GetSpacing()[0]
    rest = scenes.values_of(image, "Side")[0]
    side = points_of(opened.volume, "Side").reshape(opened.shape)[0]
    shown = points_of(opened.volume, "CT").reshape(opened.shape)[0]
    require(set(np.unique(side)) == {0, 1, 2}, "figure 8, %s: labels %s", name, np.unique(side))
    check_rigid(opened, 200)

    # Tissue takes the room that its elements have now: it does not vanish, and is not shown twice.
    part = np.where(opened.tissue, rest.ravel() if name == "cut" else 1, 0)
    factor = growth(opened, part).reshape(rest.shape)
    for label in (1, 2):
        before, seen = (float((labels == label).sum()) * step * image.GetSpacing()[1] for labels in (rest, side))
        now = factor[rest == label].sum() * step * image.GetSpacing()[1]
        print("figure 8, %s, side %d: from %.1f to %.1f mm2, in the picture %.1f mm2" % (name, label, before, now, seen), flush=True)
        require(now > before + 20.0, "figure 8, %s, side %d: hardly stretched, %g to %g mm2", name, label, before, now)
        require(abs(seen - now) <= AREA_TOLERANCE * before, "figure 8, %s, side %d: %g mm2 are lost", name, label, now - seen)

    # The gap, row by row, between the last pixel of the left and the first of the right side.
    top = scenes.surface(image, scenes.INCISION_X, 1)
    rows = [j for j in range(len(ys)) if top - scenes.INCISION_DEPTH + 3.0 < ys[j] < top - 1.0]
    left = np.array([np.flatnonzero(side[j] == 1).max() for j in rows])
    right = np.array([np.flatnonzero(side[j] == 2).min() for j in rows])
    gap = (right - left - 1) * step
    if name == "whole":
        require((gap == 0).all(), "figure 8: whole tissue has gaps of %s mm", gap)
        continue
    asked = [np.subtract(probe["Target"], probe["Position"]) for probe in opened.scene.probes]
    require(np.allclose(opened.reached, asked, atol=TOLERANCE), "figure 8: the hooks reach %s", opened.reached)
    require(gap.max() >= 9.0, "figure 8: the incision opens by %g mm only", gap.max())
    for j, l, r in zip(rows, left, right):
        require((shown[j, l + 1:r] == opened.deformation.BackgroundValue).all(), "figure 8: the gap shows %s", shown[j, l + 1:r])
    # A side ends half a voxel beyond its last elements.
    place = opened.displacement.reshape(*rest.shape, 3)[..., :2].astype(float) + np.stack(np.meshgrid(xs, ys), axis=-1)
    lips = np.flatnonzero(xs < scenes.INCISION_X).max()
    tissue = np.flatnonzero(rest[:, lips] * rest[:, lips + 1] > 0)
    edges = []
    for last, beyond in ((lips, 0.5), (lips + 1, -0.5)):
        edge = place[tissue, last] + [beyond * step, 0.0]
        edges.append(np.interp(ys[rows], edge[:, 1], edge[:, 0]))
    wide = np.subtract(edges[1], edges[0])
    print("figure 8: the gap is %.1f mm wide at most, in %d rows %.3f mm narrower in the picture than between the lips" % (
        gap.max(), len(rows), (wide - gap).mean()))
    require(np.abs(wide - gap).max() <= step + 0.1, "figure 8: in a row the gap is %g mm off", np.abs(wide - gap).max())
    require(abs((wide - gap).mean()) <= GAP_TOLERANCE, "figure 8: the gap is %g mm off", (wide - gap).mean())
