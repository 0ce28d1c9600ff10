"""The arrays PropagationTime and Wavefront, by both methods, against Dijkstra's algorithm.

A wave passes from element to element where it moves them. Its time at an element that it moved, or at a neighbour of
one, is the length of the shortest path from the probe through elements that it moved; no wave came to the others. With a
constraint for each axis, each axis has a wave of its own. No code is shared with the engine."""

import heapq

import numpy as np
from harness import Reports, add_array, field, make_image, points_of, produce, require, update
from paraview.simple import *

SHAPE = (11, 12, 13)  # z, y, x
SPACING = np.array([1.5, 0.5, 2.0])
rng = np.random.default_rng(8)
values = rng.uniform(20, 100, SHAPE)
values[2:9, 6, 4:9] = 0  # a slab of air that the wave has to go around
image = make_image(values, spacing=SPACING)
isotropic = rng.uniform(0.1, 0.45, SHAPE)
anisotropic = np.stack([isotropic, 0.5 * isotropic, rng.uniform(0.1, 0.45, SHAPE)], axis=3)
add_array(image, isotropic, "One")
add_array(image, anisotropic, "Three")
image.GetPointData().SetActiveScalars("scalars")
tissue = values > 10


def neighbours(i):
    for axis in range(3):
        for step in (-1, 1):
            j = list(i)
            j[axis] += step
            j = tuple(j)
            if 0 <= j[axis] < SHAPE[axis] and tissue[j]:
                yield j


def arrival(source, limits, moved):
    """Times from `source` on; infinity where the wave does not come."""
    result = np.full(SHAPE, np.inf)
    result[source] = 0
    heap = [(0.0, source)]
    while heap:
        here, i = heapq.heappop(heap)
        if here > result[i] or not moved[i]:
            continue
        for j in neighbours(i):
            there = here + 0.5 * (limits[i] + limits[j])
            if there < result[j]:
                result[j] = there
                heapq.heappush(heap, (there, j))
    return result


SOURCE = (5, 4, 6)  # z, y, x
place = SPACING * SOURCE[::-1]
pull = np.array([1.3, -0.5, 0.9])  # of the spacing
deformation = ChainMailDeformation(
    Input=produce(image), TissueThreshold=10, AnchoredFaces=[0] * 6, RelaxationIterations=0, PropagationTimes=1,
    Probes=[ChainMailProbe(Position=place, Target=place + pull * SPACING)])
reports = Reports(deformation)
times = {}
for array, limits in (("One", isotropic[..., None]), ("Three", anisotropic)):
    deformation.ConstraintArray = array
    for method in ("Envelope", "Timestamp"):
        deformation.PropagationMethod = method
        volume, model = update(deformation, reports)
        components = limits.shape[3]
        time = points_of(model, "PropagationTime").reshape(SHAPE + (components,)).astype(float)
        front = points_of(model, "Wavefront").reshape(SHAPE + (components,))
        u = points_of(model, "Displacement").reshape(SHAPE + (3,))
        require(np.allclose(field(volume, "ProbeReached")[0], pull * SPACING, atol=1e-5), "reached %s",
                field(volume, "ProbeReached"))
        require(field(volume, "PropagationIterationsUsed")[0, 0] > 0, "no iterations")
        for c in range(components):
            what = "%s, %s, component %d" % (array, method, c)
            moved = (u != 0).any(axis=3) if components == 1 else u[..., c] != 0
            expected = arrival(SOURCE, limits[..., c], moved)
            came = np.isfinite(expected)
            require(50 < came.sum() < 0.95 * tissue.sum(), "%s: the wave comes to %d elements", what, came.sum())
            # In millimetres; with one component, along the image's x axis. Sums of up to 20 floats.
            error = np.abs(time[came][:, c] - expected[came] * SPACING[c]).max()
            require(error < 1e-5, "%s: wrong by %g mm", what, error)
            require((time[~came][:, c] == -1).all(), "%s: times where no wave came", what)
            require((front[..., c] == np.where(came, 1, 0)).all(), "%s: wavefronts %s", what, np.unique(front[..., c]))
            print("%s: %d elements, up to %.2f mm, error %.1e mm" % (what, came.sum(), expected[came].max() * SPACING[c], error),
                  flush=True)

# A second wave, in Interactive mode, has the next number; where it does not come the first one's times stay.
for method in ("Envelope", "Timestamp"):
    first = {"Mode": "Interactive", "PropagationMethod": method, "ConstraintArray": "One"}
    probe = ChainMailProbe(Position=place, Target=place + pull * SPACING)
    stepwise = ChainMailDeformation(Input=produce(image), TissueThreshold=10, AnchoredFaces=[0] * 6, Probes=[probe],
                                    RelaxationIterations=0, PropagationTimes=1, **first)
    reports = Reports(stepwise)
    _, one = update(stepwise, reports)
    probe.Target = place + 0.6 * pull * SPACING
    _, two = update(stepwise, reports)
    front = points_of(two, "Wavefront")
    require(set(front) == {0, 1, 2}, "%s: wavefronts %s", method, set(front))
    old = front != 2
    require((points_of(two, "PropagationTime")[old] == points_of(one, "PropagationTime")[old]).all(),
            "%s: a wave changed times where it did not come", method)

# Off: the arrays are not there, nothing else changes.
expected = points_of(model, "Displacement")
deformation.PropagationTimes = 0
_, without = update(deformation, reports)
require(without.GetPointData().GetArray("PropagationTime") is None and
        without.GetPointData().GetArray("Wavefront") is None, "the arrays are still there")
require((points_of(without, "Displacement") == expected).all(), "without times the displacements are others")
deformation.PropagationTimes = 1
_, back = update(deformation, reports)
require((points_of(back, "PropagationTime") == points_of(model, "PropagationTime")).all(), "times do not come back")
