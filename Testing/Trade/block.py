"""A block of tissue with a stiff bar in it, held from below and grabbed on top, as ChainMail and as finite elements.

Nodes of the mesh and elements of the model are at the same places, 1 mm apart; held and grabbed ones are the same, too, and
get the same displacement. What cannot be the same is the material: a constraint is a limit, a modulus a slope."""

import calculix
import numpy as np

SOFT = 0.4  # constraint of the tissue around: what is below the handle can be pulled 7.6 mm out
CONTRAST = 100.0  # how many times stiffer the bar is


class Block:
    def __init__(self, size=25):
        self.size = size
        n, middle = size, size // 2
        self.shape = (n, n, n)  # [z, y, x]
        z, y, x = np.indices(self.shape)
        self.held = z == 0
        self.axis = (slice(None), middle, middle)  # the elements below the handle, from the table up
        self.top = (middle, middle, n - 1)
        self.radius = n / 8
        self.grabbed = (z == n - 1) & (np.hypot(x - middle, y - middle) <= self.radius)
        # Off to one side, so that a pull turns it.
        self.bar = ((abs(x - middle - n // 6) <= n // 4) & (abs(y - middle) <= n // 8) & (abs(z - n // 2) <= n // 12))

    def constraint(self, contrast=CONTRAST):
        """The constraint of every element; a contrast of infinity makes the bar rigid."""
        return np.where(self.bar, SOFT / contrast, SOFT).astype(np.float32)

    def finite_elements(self, folder, displacement, poisson, finite):
        """The displacement of every node [z, y, x, axis]."""
        prescribed = [(int(node), axis, 0.0) for node in np.flatnonzero(self.held) for axis in range(3)]
        prescribed += [(int(node), axis, float(displacement[axis])) for node in np.flatnonzero(self.grabbed) for axis in range(3)]
        laws = [calculix.Material(modulus, poisson, finite) for modulus in (1.0, CONTRAST)]
        return calculix.solve(folder, self.shape[::-1], laws, filled(self.bar).astype(int), prescribed)[0]


def filled(nodes):
    """The cubes all of whose eight nodes are among these."""
    cubes = np.ones([n - 1 for n in nodes.shape], bool)
    for corner in np.ndindex(2, 2, 2):
        cubes &= nodes[tuple(slice(c, c + n - 1) for c, n in zip(corner, nodes.shape))]
    return cubes


def rigid_part(places, displacement):
    """How a body moves as a whole: the angle it turns by [degrees], and what is left of each node's displacement without
    the best turn and shift (Kabsch)."""
    here, there = places - places.mean(0), places + displacement
    there = there - there.mean(0)
    left, _, right = np.linalg.svd(here.T @ there)
    turn = right.T @ np.diag([1, 1, np.sign(np.linalg.det(right.T @ left.T))]) @ left.T
    angle = np.degrees(np.arccos(np.clip((np.trace(turn) - 1) / 2, -1, 1)))
    return float(angle), there - here @ turn.T


def compare(block, displacement, u, exact):
    """Figures of a field u against finite elements, both [z, y, x, axis] and with the same nodes given. `pull`: the length of
    the handle's displacement, which all lengths are shares of."""
    pull = float(np.linalg.norm(displacement))
    towards = np.asarray(displacement, float) / pull
    free = ~(block.held | block.grabbed)
    along = [field @ towards for field in (u, exact)]
    figures = {
        "correlation": float(np.corrcoef(along[0][free], along[1][free])[0, 1]),
        "rms": float(np.sqrt(((u - exact)[free] ** 2).sum(-1).mean())) / pull,
        "rmsAxis": float(np.sqrt(((along[0] - along[1])[block.axis][1:-1] ** 2).mean())) / pull,
    }
    return figures


def describe(block, displacement, u):
    """Figures of one field: how deep the pull reaches, what goes aside, and what the bar does."""
    pull = float(np.linalg.norm(displacement))
    towards = np.asarray(displacement, float) / pull
    profile = (u @ towards)[block.axis] / pull
    heights = np.arange(block.size, dtype=float)
    below = int(np.flatnonzero(profile < 0.5).max())
    half = heights[below] + (0.5 - profile[below]) / (profile[below + 1] - profile[below])
    free = ~(block.held | block.grabbed)
    aside = (u - (u @ towards)[..., None] * towards)[free]
    z, y, x = np.nonzero(block.bar)
    bar = u[block.bar]
    angle, rest = rigid_part(np.stack([x, y, z], -1).astype(float), bar)
    return {
        "halfDepth": block.size - 1 - half,
        "aside": float(np.sqrt((aside**2).sum(-1).mean())) / pull,
        "barMoved": float(np.linalg.norm(bar.mean(0))) / pull,
        "barSpread": float(np.ptp(bar, axis=0).max()) / pull,
        "barAngle": angle,
        "barStrain": float(np.linalg.norm(rest, axis=1).max()) / pull,
        "profile": profile.tolist(),
    }
