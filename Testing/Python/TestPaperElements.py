"""The paper's smallest scenes, exactly: three elements (figure 4), the heterogeneous ring (figure 5), and a thin ring of
which one side is dented (figure 10)."""

import itertools

import numpy as np
from harness import EVERY, require
from paper import METHODS, check_rigid, run, scenes
from paraview.simple import *

# Figure 4. All numbers are sums of powers of two, so float32 holds them exactly.
for method, number in METHODS.items():
    result = run(scenes.three_elements(), PropagationMethod=number)
    require(result.time.tolist() == [0.0, 1.5, 4.5], "figure 4, %s: times %s", method, result.time)
    require(result.displacement[:, 0].tolist() == [8.0, 6.5, 3.5] and not result.displacement[:, 1:].any(),
            "figure 4, %s: displacements %s", method, result.displacement)
print("figure 4: times 0, 1.5, 4.5 with both methods")

# Figure 5. Over the top the wave needs 3.75 mm, longer than the pull of 2.5 mm: an algorithm that takes this branch
# leaves the lower right corner where it is.
scene = scenes.heterogeneous_ring()
n = scene.image.GetDimensions()[0]
result = run(scene)
oracle = result.oracle()
(grabbed, pull), = result.handles(oracle)
corner = 2 * n + n - 3
top = np.flatnonzero(result.tissue.reshape(n, n)[-3]) + (n - 3) * n
over_the_top = oracle.fraction[top[:-1]].sum() / 2 + oracle.fraction[top[1:]].sum() / 2
require(over_the_top > np.abs(pull).max(), "figure 5: the top is no way to lose")

# A second probe, on the elastic part, that goes with the first.
middle = (n - 3) * n + 6
second = scenes.grab((6, n - 3, 0), (pull[0] + 0.5, pull[1] - 0.25, 0))
for probes in (scene.probes, scene.probes + [second], [second] + scene.probes):
    scene.probes = probes
    result = run(scene)
    handles = result.handles(oracle)
    expected = oracle.pulled(handles).astype(np.float32)
    last = oracle.distances(handles[-1][0])
    bricks = [[0, 0, 0], [4, 2, 2], [64, 32, 2]] + ([[4, 4, 4], [8, 2, 4], [16, 16, 2]] if EVERY else [])
    for (method, number), brick in itertools.product(METHODS.items(), bricks):
        result.again(PropagationMethod=number, BrickSize=brick)
        what = "figure 5, %d probes, %s, bricks of %s" % (len(probes), method, brick)
        require((result.displacement == expected).all(), "%s: off by up to %g mm", what,
                np.abs(result.displacement - expected).max())
        require((result.displacement[corner] == pull).all(), "%s: the lower right corner moves by %s", what,
                result.displacement[corner])
        check_rigid(result, 3 * scenes.RING_SIZE - 2)
        if len(probes) == 1:
            moved = result.displacement.any(axis=1)
            require((result.time[moved] == last[moved]).all(), "%s: times are off", what)
            require(result.time[corner] == 0.0, "%s: the corner is reached after %g", what, result.time[corner])
print("figure 5: the corner follows the rigid branch in every order of probes, brick size and method")

# A block of links of 0.25 mm: of a pull by 0.25 n mm the wave moves what is fewer than n links away and comes to what is n
# links away, whatever block that is in; no wave comes to the rest.
n = 24
links = np.indices((n, n, n)).sum(axis=0).ravel()
image = scenes.make_image(np.full((n, n, n), 0.25, np.float32), "Fraction")
for reach in range(1, 26):
    scene = scenes.Scene(image, [scenes.grab((0, 0, 0), (0.25 * reach, 0, 0))], ConstraintArray="Fraction", TissueThreshold=0.0,
                         AnchoredFaces=[0] * 6, RelaxationIterations=0, BrickSize=[4, 2, 2])
    result = run(scene)
    for method, number in METHODS.items():
        result.again(PropagationMethod=number)
        require((result.displacement[:, 0] == np.maximum(0.25 * (reach - links), 0)).all(), "block, %d links, %s: displacements",
                reach, method)
        wrong = result.time != np.where(links <= reach, 0.25 * links, -1)
        require(not wrong.any(), "block, %d links, %s: the times of %d elements are wrong, those of %d links up", reach, method,
                wrong.sum(), links[wrong].min() if wrong.any() else 0)
print("in a block, waves end where they end")

# Figure 10.
scene = scenes.thin_ring()
x = np.broadcast_to(scenes.coordinates(scene.image)[0], scenes.values_of(scene.image, "Tissue").shape).ravel()
for method, number in METHODS.items():
    result = run(scene, PropagationMethod=number, RelaxationIterations=0)
    oracle = result.oracle()
    handles = result.handles(oracle)
    require(np.isfinite(oracle.distances(handles[0][0])[result.tissue]).all(), "figure 10: the ring is broken")
    expected = oracle.pulled(handles)
    error = np.abs(result.displacement - expected).max()
    require(error <= 1e-5, "figure 10, %s: off by up to %g mm", method, error)
    still = result.tissue & (expected == 0).all(axis=1)
    require(not result.displacement[still].any(), "figure 10, %s: what the wave cannot reach moves", method)
    require(still[result.tissue & (x > 0)].all(), "figure 10: the wave reaches the other half")
    # Red, then black, then groups: a sweep carries a change over few links, so that ten leave the other side alone.
    result.again(RelaxationIterations=10)
    far = result.tissue & (x > 20)
    require(far.sum() > 50 and not result.displacement[far].any(), "figure 10, %s: the other side moves by %g mm", method,
            np.abs(result.displacement[far]).max())
    near = result.displacement[result.tissue & (x < -scenes.THIN_RADIUS + 2), 0]
    require(near.max() == 15.0 and near.min() > 8.0, "figure 10, %s: the dent is %g to %g mm deep", method, near.min(), near.max())
print("figure 10: a dent of 15 mm on one side, exactly nothing on the other")
