"""Displacements of the model at rest against the theory, on the forearm phantom without relaxation.

Every probe and every held element k reaches element i with the cone of slope 1 around its displacement t_k: per axis

    u(i) = clamp(0, max_k(t_k - d(k, i)), min_k(t_k + d(k, i)))

with d the length of the shortest path of links, a link of i and j being (D(i) + D(j)) / 2 long. Here d comes from
Dijkstra's algorithm on a heap, in double precision, and the material from numpy: no code is shared with the engine.
"""

import heapq
import sys

import numpy as np
from harness import DATA, Reports, add_array, field, points_of, produce, require, same_bits, update
from paraview.simple import *

sys.path.insert(0, DATA)
from make_forearm import make_forearm  # noqa: E402

TOLERANCE = 1e-4  # of the spacing: float32 sums of up to a hundred links of up to one voxel
THRESHOLD = -300.0
# Softer than any preset, so that the waves of this coarse phantom end inside it; bone is rigid.
NODES = np.array([[-300.0, 0.45], [-100.0, 0.6], [50.0, 0.35], [150.0, 0.2], [300.0, 0.0]])

# The phantom lies somewhere in the world, turned: displacements are compared along the world's axes.
image = make_forearm((44, 40, 52))
turn = np.array([[0.6, 0.0, 0.8], [0.0, -1.0, 0.0], [-0.8, 0.0, 0.6]])
image.SetDirectionMatrix(turn.ravel().tolist())
image.SetOrigin(-31.0, 12.5, 470.0)
size = np.array(image.GetDimensions())
first = np.array(image.GetExtent())[::2]
spacing = np.array(image.GetSpacing())
scalars = points_of(image, "CT").astype(float)
tissue = scalars >= THRESHOLD
count = len(scalars)
strides = np.array([1, size[0], size[0] * size[1]])
index = np.stack(np.unravel_index(np.arange(count), size[::-1]), axis=1)[:, ::-1]
require(0.1 < tissue.mean() < 0.6, "%.0f %% of the phantom is tissue", 100 * tissue.mean())

# What touches a face of the image is held; the limb does at both ends.
held = tissue & ((index == 0) | (index == size - 1)).any(axis=1)
require(held.sum() > 100, "only %d elements are held", held.sum())

neighbours = [[] for _ in range(count)]
for axis in range(3):
    low = np.flatnonzero(tissue & (index[:, axis] < size[axis] - 1))
    low = low[tissue[low + strides[axis]]]
    for i in low.tolist():
        neighbours[i].append(i + int(strides[axis]))
        neighbours[i + int(strides[axis])].append(i)


def distances(sources, constraint):
    """Length of the shortest path from any of the sources to every element, in units of the constraint."""
    constraint = constraint.tolist()
    result = [np.inf] * count
    heap = [(0.0, int(s)) for s in sources]
    for _, s in heap:
        result[s] = 0.0
    while heap:
        here, i = heapq.heappop(heap)
        if here > result[i]:
            continue
        for j in neighbours[i]:
            there = here + 0.5 * (constraint[i] + constraint[j])
            if there < result[j]:
                result[j] = there
                heapq.heappush(heap, (there, j))
    return np.array(result)


def place(i):
    """World position of voxel i."""
    return np.array(image.GetOrigin()) + turn @ ((index[i] + first) * spacing)


def check(fraction, pulled, deformation, reports, what):
    """fraction: constraint of every voxel and axis [count, 3]; pulled: the elements that are grabbed."""
    # Displacements that the tissue allows whatever the number of probes: a multiple of the distance from what is held
    # has a slope below 1 everywhere.
    anchored = np.stack([distances(np.flatnonzero(held), fraction[:, a]) for a in range(3)], axis=1)
    require(np.isfinite(anchored[pulled]).all(), "%s: a probe is on tissue that nothing holds", what)
    wanted = anchored[pulled] * [0.95, -0.6, 0.3]  # in voxels, along the image's axes
    require((np.abs(wanted[:, 0]) > 0.5).all(), "%s: the probes hardly pull: %s", what, wanted)

    deformation.Probes = [
        ChainMailProbe(Position=place(i), Target=place(i) + turn @ (t * spacing)) for i, t in zip(pulled, wanted)]
    volume, model = update(deformation, reports)

    found = points_of(model, "Displacement").astype(float) @ turn / spacing  # back to voxels along the image's axes
    lower = np.zeros((count, 3))
    upper = np.zeros((count, 3))
    lower[:], upper[:] = -np.inf, np.inf
    for a in range(3):
        for sources, t in [(np.flatnonzero(held), 0.0)] + [([i], w[a]) for i, w in zip(pulled, wanted)]:
            d = anchored[:, a] if t == 0.0 and len(sources) > 1 else distances(sources, fraction[:, a])
            lower[:, a] = np.maximum(lower[:, a], t - d)
            upper[:, a] = np.minimum(upper[:, a], t + d)
    expected = np.where(tissue[:, None], np.clip(0.0, lower, upper), 0.0)

    error = np.abs(found - expected).max()
    moved = (np.abs(expected) > 1e-6).any(axis=1).sum()
    excess = field(volume, "MaxLinkExcess")[0, 0]
    reached = field(volume, "ProbeReached") @ turn / spacing
    print("%s: %d of %d elements move, by up to %.2f voxels; error %.1e of the spacing, link excess %.1e" % (
        what, moved, tissue.sum(), np.abs(expected).max(), error, excess), flush=True)
    require(error <= TOLERANCE, "%s: the error is %g of the spacing", what, error)
    require(0 <= excess <= 1e-5, "%s: a link is %g of the spacing too long", what, excess)
    require(moved > 50 * len(pulled) and np.abs(expected).max() > 1.0, "%s: only %d elements move", what, moved)
    require(np.allclose(reached, wanted, atol=TOLERANCE), "%s: the probes reached %s, not %s", what, reached, wanted)
    return points_of(model, "Displacement")


# Soft elements in the middle of the limb, well apart.
constraint = np.interp(scalars, NODES[:, 0], NODES[:, 1])
rng = np.random.default_rng(3)
candidates = np.flatnonzero(tissue & (constraint > 0.2) & (np.abs(index[:, 2] - size[2] / 2) < size[2] / 4))
pulled = [int(rng.choice(candidates))]
while len(pulled) < 5:
    i = int(rng.choice(candidates))
    if min(np.abs(index[i] - index[j]).max() for j in pulled) >= 6:
        pulled.append(i)

anisotropic = np.stack([constraint, 0.5 * constraint, np.minimum(1.4 * constraint, 0.9)], axis=1)
add_array(image, anisotropic.reshape(*size[::-1], 3), "Fractions")
image.GetPointData().SetActiveScalars("CT")

source = produce(image)
deformation = ChainMailDeformation(Input=source, RelaxationIterations=0, TissueThreshold=THRESHOLD,
                                    ModelArrays=["Displacement", "Element", "Cluster"])
deformation.MaterialFunction.Points = [number for x, y in NODES for number in (x, y, 0.5, 0.0)]
reports = Reports(deformation)
isotropic = np.repeat(constraint[:, None], 3, axis=1)
check(isotropic, pulled[:1], deformation, reports, "one probe")
five = check(isotropic, pulled, deformation, reports, "five probes")

# The same bits, not only the same numbers, whatever the size of the blocks and the order of the probes.
for block in ([4, 4, 4], [8, 8, 8], [32, 4, 2]):
    deformation.BrickSize = block
    _, model = update(deformation, reports)
    require(same_bits(points_of(model, "Displacement"), five), "blocks of %s change a bit", block)
deformation.BrickSize = [0, 0, 0]
deformation.Probes = list(reversed(deformation.Probes))
_, model = update(deformation, reports)
require(same_bits(points_of(model, "Displacement"), five), "the order of the probes changes a bit")

# The rigid bone, wherever it went: all of a cluster by the same bits.
cluster = points_of(model, "Cluster")
require(cluster.max() >= 0, "the phantom's bones are no rigid clusters")
for number in range(cluster.max() + 1):
    rows = np.unique(five[cluster == number], axis=0)
    require(len(rows) == 1, "cluster %d moves by %d different vectors", number, len(rows))

deformation.ConstraintArray = "Fractions"
check(anisotropic, pulled, deformation, reports, "five probes, a constraint for each axis")
