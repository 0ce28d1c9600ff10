"""A finger of two bones in soft tissue, held at one end and lifted near the other, as ChainMail and as finite elements.

As in block.py, nodes of the mesh and elements of the model are at the same places, 1 mm apart. Bone is 10,000 times stiffer than
tissue: at 100 times a solid of this shape bends as much as it turns. Around the finger are cubes that weigh next to nothing,
so that every node belongs to something."""

import block
import calculix
import numpy as np

SOFT = 0.4  # constraint of the tissue
CONTRAST = 1e4
NOTHING = 1e-6


class Finger:
    def __init__(self):
        self.shape = (17, 17, 49)  # [z, y, x]
        z, y, x = np.indices(self.shape)
        off = np.hypot(y - 8, z - 8)
        self.tissue = off <= 8.2
        self.bone = (off <= 3.2) & (x < 46) & (abs(x - 24) > 2)  # two, with a joint between
        self.tip = self.bone & (x > 24)
        self.held = x == 0
        # (place, radius) of a handle: on the skin above the tip, and on one voxel of its bone, which may turn about it.
        self.handles = {"skin": ((44, 8, 16), 2.0), "bone": ((44, 8, 8), 0.0)}

    def grabbed(self, handle):
        (x, y, z), radius = self.handles[handle]
        k, j, i = np.indices(self.shape)
        return self.tissue & ((i - x) ** 2 + (j - y) ** 2 + (k - z) ** 2 <= radius**2)

    def constraint(self):
        return np.where(self.bone, 0.0, SOFT).astype(np.float32)

    def finite_elements(self, folder, handle, lift):
        """The displacement of every node [z, y, x, axis], by Hooke's law with Poisson's ratio 0."""
        cubes = np.where(block.filled(self.bone), 1, np.where(block.filled(self.tissue), 0, 2))
        prescribed = [(int(node), axis, 0.0) for node in np.flatnonzero(self.held) for axis in range(3)]
        prescribed += [(int(node), axis, value) for node in np.flatnonzero(self.grabbed(handle))
                       for axis, value in enumerate((0.0, 0.0, lift))]
        laws = [calculix.Material(modulus, 0.0) for modulus in (1.0, CONTRAST, NOTHING)]
        return calculix.solve(folder, self.shape[::-1], laws, cubes, prescribed)[0]

    def angle(self, u):
        """How far the bone of the tip turns [degrees]."""
        z, y, x = np.nonzero(self.tip)
        return block.rigid_part(np.stack([x, y, z], -1).astype(float), u[self.tip])[0]

    def distance(self, lift, u, exact):
        """Of two fields, rms over the tissue as a share of the lift."""
        free = self.tissue & ~self.held
        return float(np.sqrt(((u - exact)[free] ** 2).sum(-1).mean())) / lift
