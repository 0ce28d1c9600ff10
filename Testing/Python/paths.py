"""An oracle for propagation: Dijkstra's algorithm in plain Python, and formula (P*). No code is shared with the engine."""

import heapq

import numpy as np


class Tissue:
    """Elements of an image and their links. tissue: bool [z, y, x]; fraction: the constraint of every voxel; spacing [mm];
    severed: pairs (voxel, next voxel along an axis) without a link, as flat indices."""

    def __init__(self, tissue, fraction, spacing, severed=()):
        self.shape = tissue.shape
        self.tissue = tissue.ravel()
        self.fraction = np.broadcast_to(fraction, tissue.shape).astype(float).ravel()
        self.spacing = np.array(spacing, float)
        steps = (1, self.shape[2], self.shape[1] * self.shape[2])
        severed = set(severed)
        index = np.unravel_index(np.arange(self.tissue.size), self.shape)[::-1]
        self.neighbours = [[] for _ in range(self.tissue.size)]
        for axis in range(3):
            low = np.flatnonzero(self.tissue & (index[axis] < self.shape[2 - axis] - 1))
            low = low[self.tissue[low + steps[axis]]]
            for i in low.tolist():
                j = i + steps[axis]
                if (i, j) not in severed:
                    limit = 0.5 * (self.fraction[i] + self.fraction[j])
                    self.neighbours[i].append((j, limit))
                    self.neighbours[j].append((i, limit))

    def distances(self, sources, reach=np.inf):
        """Length of the shortest path of links from any of the sources [fractions of the spacing], the same on all axes;
        infinity beyond `reach`."""
        result = np.full(self.tissue.size, np.inf)
        heap = [(0.0, int(i)) for i in sources]
        result[[i for _, i in heap]] = 0.0
        while heap:
            here, i = heapq.heappop(heap)
            if here > result[i]:
                continue
            for j, limit in self.neighbours[i]:
                if here + limit < result[j] and here + limit <= reach:
                    result[j] = here + limit
                    heapq.heappush(heap, (here + limit, j))
        return result

    def grabbed(self, origin, position, radius):
        """The elements within `radius` of a place, for an image that is not turned; origin: of its first voxel."""
        z, y, x = np.meshgrid(*(np.arange(n) for n in self.shape), indexing="ij")
        place = np.stack([x, y, z], axis=-1).reshape(-1, 3) * self.spacing + origin
        return np.flatnonzero(self.tissue & (((place - position) ** 2).sum(axis=1) <= radius**2 * (1 + 1e-12)))

    def pulled(self, handles, start=0.0):
        """(P*): `start` clamped between the cones of all handles, each (elements, displacement [mm]); in mm [voxel, 3]."""
        lower = np.full((self.tissue.size, 3), -np.inf)
        upper = np.full((self.tissue.size, 3), np.inf)
        for elements, displacement in handles:
            distance = self.distances(elements)[:, None] * self.spacing
            lower = np.maximum(lower, np.asarray(displacement) - distance)
            upper = np.minimum(upper, np.asarray(displacement) + distance)
        return np.where(self.tissue[:, None], np.clip(start, lower, upper), 0.0)
