"""Where a surgeon might go in: finds, in a volume of unknown content, a place for an incision and two probes.

A good place is a flat, central piece of the tissue's surface with nothing but air before it, far from bone and from the
faces of the image box, which hold still. Across it the incision is laid, where the surface is straightest, and on either
side of it a probe that pulls its lip outwards and away. numpy only; indices are [x, y, z].
"""

import math

import numpy as np


class SceneError(Exception):
    """There is no such place; the message says what to do."""


class Volume:
    """The scalars of a vtkImageData as a numpy array, with the way from its axes to the world's."""

    def __init__(self, image, name):
        from vtkmodules.util.numpy_support import vtk_to_numpy
        self.size = np.array(image.GetDimensions())
        self.spacing = np.array(image.GetSpacing())
        values = vtk_to_numpy(image.GetPointData().GetArray(name))
        values = values if values.ndim == 1 else values[:, 0]
        finite = values[np.isfinite(values)]
        if not finite.size:
            raise SceneError("The array '%s' has no finite value." % name)
        self.range = float(finite.min()), float(finite.max())
        self.values = values.reshape(self.size[::-1]).transpose(2, 1, 0)
        matrix = image.GetDirectionMatrix()
        self.direction = np.array([[matrix.GetElement(i, j) for j in range(3)] for i in range(3)])
        first = np.array(image.GetExtent()[::2]) * self.spacing
        self.corner = np.array(image.GetOrigin()) + self.direction @ first

    def place(self, lengths):
        """World place of lengths [mm] along the image's axes from its first voxel."""
        return self.corner + self.direction @ lengths

    def centre(self):
        return self.place(0.5 * (self.size - 1) * self.spacing)

    def voxels(self, place):
        """Where a world place is, in voxels from the first."""
        return self.direction.T @ (np.asarray(place) - self.corner) / self.spacing


class Scene:
    """probes: lists of 7 numbers, place, drag and radius; cut: 9 numbers, the origin and two corners of a Plane. Unit
    vectors: along the cut, across it, and the normal out of the tissue. centre: what to look at. step: a length that
    suits the volume. All in world axes [mm]."""

    def __init__(self, probes, cut, centre, along, across, normal, step):
        self.probes, self.cut, self.centre, self.step = probes, cut, centre, step
        self.along, self.across, self.normal = along, across, normal


# Sizes of the scene in steps; a step is a voxel in a volume of 160, more voxels in a larger one.
PROBE_RADIUS, PROBE_OFFSET, PROBE_DEPTH = 8, 20, 2
PULL_OUT, PULL_APART = 15, 10
CUT_HALF_LENGTH, CUT_ABOVE, CUT_BELOW = 34, 10, 22
PATCH_REACH, PATCH_SOLID, SLACK = 22, 14, 40


def sliding(function, field, reach):
    """function (np.maximum or np.minimum) over the square of (2 reach + 1)^2 around every place."""
    for axis in (0, 1):
        result = field.copy()
        for step in range(1, reach + 1):
            ahead, behind = [slice(None)] * 2, [slice(None)] * 2
            ahead[axis], behind[axis] = slice(step, None), slice(None, -step)
            result[tuple(behind)] = function(result[tuple(behind)], field[tuple(ahead)])
            result[tuple(ahead)] = function(result[tuple(ahead)], field[tuple(behind)])
        field = result
    return field


def share(mask, reach):
    """Part of the square of (2 reach + 1)^2 around every place that the mask fills; beyond the edges it is empty."""
    total = np.pad(mask.astype(float), reach)
    for axis in (0, 1):
        total = np.cumsum(np.insert(total, 0, 0.0, axis=axis), axis=axis)
    width = 2 * reach + 1
    total = total[width:] - total[:-width]
    total = total[:, width:] - total[:, :-width]
    return total / width**2


def surface_below(tissue, solid):
    """Depth along the first axis of the first `solid` tissue voxels in a row; -1 where there are none, or where
    something else lies before them (a table, vessels in the lung)."""
    count = np.cumsum(tissue, axis=0, dtype=np.int32)
    full = np.zeros(tissue.shape, bool)
    full[:-solid] = count[solid:] - count[:-solid] == solid  # voxels d + 1 to d + solid
    depth = full.argmax(axis=0) + 1
    before = np.take_along_axis(count, depth[None] - 1, axis=0)[0]
    depth[~full.any(axis=0) | (before > 2)] = -1
    return depth


def slack(tissue, stiff, limit):
    """Links from every voxel to the nearest that cannot give way (bone, or tissue at a face of the box), at most
    `limit`: how far tissue can be pulled grows with it. On a grid of half the resolution."""
    held = stiff.copy()
    for axis in range(3):
        for face in (0, -1):
            index = [slice(None)] * 3
            index[axis] = face
            held[tuple(index)] |= tissue[tuple(index)]
    shape = [(n + 1) // 2 for n in held.shape]
    even = np.zeros([2 * n for n in shape], bool)
    even[tuple(slice(0, n) for n in held.shape)] = held
    near = even.reshape(shape[0], 2, shape[1], 2, shape[2], 2).any(axis=(1, 3, 5))
    links = np.full(shape, limit, np.int32)
    for distance in range(0, limit, 2):
        links[near & (links == limit)] = distance
        grown = near.copy()
        for axis in range(3):
            ahead, behind = [slice(None)] * 3, [slice(None)] * 3
            ahead[axis], behind[axis] = slice(1, None), slice(None, -1)
            grown[tuple(ahead)] |= near[tuple(behind)]
            grown[tuple(behind)] |= near[tuple(ahead)]
        near = grown
    return links


def straight_line(depth, at, which, reach):
    """Slope, and the largest deviation from it [voxels], of the surface through `at` along one of the two axes."""
    first, last = max(0, at[which] - reach), min(depth.shape[which] - 1, at[which] + reach)
    steps = np.arange(first, last + 1)
    line = depth[steps, at[1]] if which == 0 else depth[at[0], steps]
    steps, line = steps[line >= 0], line[line >= 0]
    fit = np.polyfit(steps, line, 1) if steps.size > 2 else (0.0, depth[at])
    return fit[0], np.abs(np.polyval(fit, steps) - line).max()


def find_patch(volume, threshold, bone, unit):
    """(point, along, across, normal, room): the best patch of surface over the six views of the volume, in lengths
    along the image's axes, and the slack there [links]."""
    with np.errstate(invalid="ignore"):
        tissue = volume.values >= threshold
        stiff = volume.values >= bone
    reach, solid = max(3, round(PATCH_REACH * unit)), max(2, round(PATCH_SOLID * unit))
    limit = max(4, round(SLACK * unit))
    free = slack(tissue, stiff, limit)
    best_score = -math.inf
    for axis in range(3):
        n = volume.size[axis]
        if n <= 2 * solid:
            continue
        for sign in (1, -1):  # the way out of the tissue
            looking = slice(None, None, -sign)
            depth = surface_below(np.moveaxis(tissue, axis, 0)[looking], solid)
            open_air = depth >= 4
            if open_air.mean() < 0.02:
                continue
            high = sliding(np.maximum, np.where(open_air, depth, -np.inf), reach)
            low = sliding(np.minimum, np.where(open_air, depth, np.inf), reach)
            rough = (high - low) / reach + 3.0 * (1.0 - share(open_air, reach))

            u, v = np.meshgrid(*(np.arange(m) for m in depth.shape), indexing="ij")
            off = np.hypot(*((w - w[open_air].mean()) / m for w, m in zip((u, v), depth.shape)))

            height = np.where(open_air, n - 1 - depth if sign > 0 else depth, 0)
            room = np.moveaxis(free, axis, 0)[height // 2, u // 2, v // 2]
            room = sliding(np.minimum, np.where(open_air, room, limit), reach // 2)

            score = np.where(open_air, 0.6 * open_air.mean() - rough - 1.5 * off + 1.5 * room / limit, -np.inf)
            at = np.unravel_index(score.argmax(), score.shape)
            if score[at] > best_score:
                best_score = score[at]
                best = axis, sign, depth, at, height[at], room[at]
    if best_score == -math.inf:
        raise SceneError("No part of the surface is large enough with air in front of it for the probes and the cut.\n"
                         "Set their places with --probe and --cut (see --help), or try another --threshold (it was %g)."
                         % threshold)

    axis, sign, depth, at, height, room = best
    others = [a for a in range(3) if a != axis]
    tangents, bends = np.zeros((2, 3)), []
    for which, other in enumerate(others):
        slope, bend = straight_line(depth, at, which, reach)
        tangents[which, other] = 1.0
        tangents[which, axis] = -sign * slope * volume.spacing[axis] / volume.spacing[other]
        bends.append(bend)
    first = int(bends[1] < bends[0])
    along = tangents[first] / np.linalg.norm(tangents[first])
    across = tangents[1 - first] - along * (tangents[1 - first] @ along)
    across = across / np.linalg.norm(across)
    normal = np.cross(along, across)
    normal = normal * (np.sign(normal[axis]) * sign)
    index = np.zeros(3)
    index[others[0]], index[others[1]], index[axis] = at[0], at[1], height
    return index * volume.spacing, along, across, normal, room


def surface_near(volume, threshold, start, normal, step):
    """The first tissue on the way inwards through `start`, as lengths along the image's axes."""
    for distance in np.arange(20 * step, -30 * step, -0.5 * step):
        place = start + distance * normal
        index = np.rint(place / volume.spacing).astype(int)
        if (index >= 0).all() and (index < volume.size).all() and volume.values[tuple(index)] >= threshold:
            return place
    return start


def given_scene(volume, probes, cut, step):
    """A scene where both are given: only the directions, for the camera, are to be found."""
    origin, a, b = (np.array(cut[i:i + 3]) for i in (0, 3, 6))
    long, short = sorted((a - origin, b - origin), key=np.linalg.norm, reverse=True)
    along = long / (np.linalg.norm(long) or 1.0)
    centre = 0.5 * (a + b)
    outwards = np.mean([np.array(probe[3:6]) for probe in probes], axis=0)
    if np.linalg.norm(outwards) < step:
        outwards = centre - volume.centre()
    normal = short - along * (short @ along)
    normal = normal / (np.linalg.norm(normal) or 1.0)
    normal = normal * (np.sign(normal @ outwards) or 1.0)
    return Scene(probes, cut, centre, along, np.cross(normal, along), normal, step)


def plan_scene(volume, threshold, bone, probes=None, cut=None):
    """An incision in the middle of a patch of skin and a hand on each of its lips; what is given stays as it is.
    threshold: air is below; bone: rigid from here on (inf: nothing is)."""
    unit = min(1.5, max(0.4, np.sort(volume.size)[:2].mean() / 160.0))
    step = unit * np.prod(volume.spacing) ** (1.0 / 3.0)
    if probes and cut:
        return given_scene(volume, probes, cut, step)

    point, along, across, normal, room = find_patch(volume, threshold, bone, unit)
    world = volume.direction
    centre = volume.place(point)
    if not probes:
        out = min(PULL_OUT, max(0.3 * PULL_OUT, 0.45 * room / unit))  # what soft tissue lets through
        probes = []
        for side in (-1.0, 1.0):
            lip = surface_near(volume, threshold, point + side * PROBE_OFFSET * step * across, normal, step)
            drag = world @ (side * PULL_APART * across + out * normal) * step
            probes.append([*volume.place(lip - PROBE_DEPTH * step * normal), *drag, PROBE_RADIUS * step])
    if not cut:
        # From above the skin, so that it is parted all along, to below it.
        start = point + step * (CUT_ABOVE * normal - CUT_HALF_LENGTH * along)
        cut = [*volume.place(start), *volume.place(start + 2 * CUT_HALF_LENGTH * step * along),
               *volume.place(start - (CUT_ABOVE + CUT_BELOW) * step * normal)]
    return Scene(probes, cut, centre, world @ along, world @ across, world @ normal, step)
