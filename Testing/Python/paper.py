"""What the tests of the paper's scenes (Data/scenes.py) share."""

import sys

import numpy as np
from harness import DATA, Reports, field, points_of, require, update

sys.path.insert(0, DATA)
import scenes  # noqa: E402
from paths import Tissue  # noqa: E402

METHODS = {"Envelope": 0, "Timestamp": 1}


class Result:
    """A scene after an update, as numpy arrays [voxel] or [voxel, 3]."""

    def __init__(self, scene, deformation, reports):
        self.scene, self.deformation, self.reports = scene, deformation, reports
        self.take()

    def take(self):
        self.volume, self.model = update(self.deformation, self.reports)
        self.shape = self.model.GetDimensions()[::-1]
        self.tissue = points_of(self.model, "Element") > 0
        self.displacement = points_of(self.model, "Displacement")
        self.cluster = points_of(self.model, "Cluster")
        self.reached = field(self.volume, "ProbeReached")
        require(field(self.volume, "MaxLinkExcess")[0, 0] <= 1e-5, "a link is %g of the spacing too long",
                field(self.volume, "MaxLinkExcess")[0, 0])
        return self

    def again(self, **properties):
        for name, value in properties.items():
            setattr(self.deformation, name, value)
        return self.take()

    @property
    def time(self):
        return points_of(self.model, "PropagationTime")

    def oracle(self, severed=()):
        return Tissue(self.tissue.reshape(self.shape), points_of(self.model, "Constraint").reshape(self.shape),
                      self.model.GetSpacing(), severed)

    def handles(self, oracle):
        """The scene's probes for the oracle: elements and displacement."""
        image = self.scene.image
        origin = np.array(image.GetOrigin()) + np.array(image.GetExtent()[::2]) * image.GetSpacing()
        found = []
        for probe in self.scene.probes:
            place = np.array(probe["Position"])
            elements = oracle.grabbed(origin, place, probe["Radius"])
            if not elements.size:
                index = np.rint((place - origin) / image.GetSpacing()).astype(int)[::-1]
                elements = [int(np.ravel_multi_index(tuple(index), self.shape))]
            found.append((elements, np.subtract(probe["Target"], place)))
        return found


def run(scene, **properties):
    _, deformation = scenes.open_scene(scene)
    for name, value in properties.items():
        setattr(deformation, name, value)
    return Result(scene, deformation, Reports(deformation))


def check_rigid(result, least):
    """Every rigid cluster moves by one vector, to the bit. One that a face of the box holds may be off by rounding where
    a probe pulls as far as the tissue between them stretches: the sum of the links between is not the same from both
    ends. Returns how far each cluster of at least so many elements went [mm]."""
    faces = np.zeros(result.shape, bool)
    for number, wanted in enumerate(result.deformation.AnchoredFaces):
        axis = 2 - number // 2
        if wanted and result.shape[axis] > 1:
            np.moveaxis(faces, axis, 0)[-1 if number % 2 else 0] = True
    inside = np.flatnonzero(result.cluster >= 0)
    inside = inside[np.argsort(result.cluster[inside], kind="stable")]
    number, moved = result.cluster[inside], result.displacement[inside]
    number = np.unique(number, return_inverse=True)[1].ravel()
    count = np.bincount(number)
    start = np.concatenate([[0], np.cumsum(count)[:-1]])
    off = np.abs(moved - moved[start][number]).max(axis=1)
    held = np.bincount(number, faces.ravel()[inside]) > 0
    worst = max(off[~held[number]], default=0.0)
    require(worst == 0.0, "the elements of a rigid cluster move by vectors %g mm apart", worst)
    worst = max(off[held[number]], default=0.0)
    require(worst <= 1e-6 * min(result.model.GetSpacing()), "a rigid cluster that is held is torn by %g mm", worst)
    require(count.max() >= least, "no rigid cluster has %d elements; the largest has %d", least, count.max())
    return np.linalg.norm(moved[start][count >= least], axis=1)


def growth(result, part):
    """How much more room each element takes than at rest: the mean, over the cells it is a corner of and whose corners
    all belong to the same part as it, of the determinant of the deformation. A cell has the mean of its edges along each
    axis. 1 for an element without such a cell. part: a number for every voxel, 0 for none."""
    shape, spacing = result.shape, result.model.GetSpacing()
    axes = [a for a in range(3) if shape[2 - a] > 1]
    part = part.reshape(shape)

    def halves(field, axis):
        d = 2 - axis
        return np.take(field, range(field.shape[d] - 1), d), np.take(field, range(1, field.shape[d]), d)

    number, same = part, part > 0
    gradient = []
    for a in axes:
        (low, high), (left, right) = halves(number, a), halves(same, a)
        number, same = low, left & right & (low == high)
        edge = result.displacement.reshape(*shape, 3).astype(float)
        for b in axes:
            low, high = halves(edge, b)
            edge = high - low if a == b else 0.5 * (high + low)
        gradient.append(edge[..., axes])
    gradient = np.stack(gradient, axis=-2)
    for row, a in enumerate(axes):
        gradient[..., row, :] /= spacing[a]
        gradient[..., row, row] += 1.0
    determinant = np.where(same, np.linalg.det(gradient), 0.0)

    total, count = np.zeros(shape), np.zeros(shape)
    for corner in np.ndindex(*(2 if 2 - d in axes else 1 for d in range(3))):
        at = tuple(slice(c, c + n) for c, n in zip(corner, same.shape))
        total[at] += determinant
        count[at] += same
    return np.where(count > 0, total / np.maximum(count, 1), 1.0).ravel()
