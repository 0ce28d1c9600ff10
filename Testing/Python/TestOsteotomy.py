"""A jaw's chin is cut free by two blades and moved by a given matrix; fat and skin follow. Held against finite elements of
Neo-Hooke's material, on the same voxels, with the same bones moved."""

import os
import sys

import numpy as np
from harness import Reports, add_array, make_image, make_points, points_of, produce, require, skip, update
from paraview.simple import *
from vtkmodules.vtkCommonDataModel import vtkCellArray

try:
    import scipy.sparse.linalg  # noqa: F401
except ImportError:
    skip("scipy was not found (on Debian the package python3-scipy)")
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir, "Oracles"))
import neo_hookean  # noqa: E402

SPACING = np.array([2.0, 2.0, 2.0])
SIZE = np.array([42, 34, 32])
POISSON = 0.3
BONE, FAT, MUSCLE, SKIN = 3, 1, 2, 4
CONSTRAINTS = {BONE: 0.0, FAT: 0.35, MUSCLE: 0.2, SKIN: 0.25}
# The chin goes 3 mm forward and 1 mm down, and turns by 4 degrees about its middle.
SHIFT, TURN = np.array([0.0, -3.0, -1.0]), 4.0


def phantom():
    """Labels [x, y, z]: a face that looks along -y, whose back and upper end go on beyond the scan."""
    x, y, z = np.meshgrid(*(np.arange(n, dtype=float) for n in SIZE), indexing="ij")
    # Columns along z, shorter in front below: the chin.
    def inside(depth):
        return ((x - 20.5) / (19.0 - depth)) ** 2 + ((y - 33.0) / (31.0 - depth)) ** 2 + (np.maximum(19.0 - z, 0) / (18.0 - depth)) ** 2 < 1.0
    labels = np.zeros(SIZE, np.uint8)
    labels[inside(0.0)] = SKIN
    labels[inside(1.0)] = FAT
    labels[inside(4.0)] = MUSCLE
    labels[inside(8.0)] = BONE
    return labels


def rotation(degrees):
    """About the axis x."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def check_oracle():
    """It turns a block whose sides turn, and stretches one as its formula says."""
    tissue = np.ones((5, 5, 5), bool)
    places = np.moveaxis(np.indices(tissue.shape), 0, -1) * 1.5
    held = np.ones(tissue.shape, bool)
    held[1:4, 1:4, 1:4] = False
    for matrix in (rotation(25.0), np.diag([1.2, 0.9, 1.05]) @ rotation(-10.0)):
        goal = places @ matrix.T - places
        found = neo_hookean.solve(tissue, np.ones(tissue.shape), POISSON, np.full(3, 1.5), held, goal)
        require(np.abs(found - goal).max() < 1e-5, "finite elements miss a homogeneous strain by %g", np.abs(found - goal).max())
    # Pulled along x with free sides: their stress is 0, so mu (b - 1 / b) + lambda ln(J) / b = 0 for the stretch b aside.
    mu, bulk = 1 / (2 * (1 + POISSON)), POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
    long = np.ones((25, 3, 3), bool)
    places = np.moveaxis(np.indices(long.shape), 0, -1) * 1.0
    held = np.zeros(long.shape, bool)
    held[[0, -1]] = True
    goal = places * [0.2, 0.0, 0.0]
    found = neo_hookean.solve(long, np.ones(long.shape), POISSON, np.ones(3), held, goal)
    aside = np.linspace(0.8, 1.0, 200001)
    aside = aside[np.argmin(np.abs(mu * (aside ** 2 - 1) + bulk * np.log(1.2 * aside ** 2)))]
    middle = 1.0 + (found[12, 2, 1, 1] - found[12, 0, 1, 1]) / 2.0
    require(abs(middle - aside) < 1e-3, "a bar thins to %g instead of %g", middle, aside)


check_oracle()
labels = phantom()
constraint = np.vectorize(lambda n: CONSTRAINTS.get(n, 0.0))(labels).astype(np.float32)
image = make_image(np.ascontiguousarray(labels.T), "labels", SPACING)
add_array(image, np.ascontiguousarray(constraint.T), "constraint")

# The chin is what lies before an upright blade and below a level one. They go through bone and what lies within three voxels
# of it: tissue that hangs on both parts beside the saw would have to stretch without bound, so surgeons free it first.
bone = labels == BONE
index = np.moveaxis(np.indices(SIZE), 0, -1)
before = (index[..., 1] < 20) & (index[..., 2] < 18)
chin = bone & before
print("%d voxels of tissue, %d of bone, %d of the chin" % ((labels > 0).sum(), bone.sum(), chin.sum()))
require(chin.sum() > 300 and (bone & ~chin).sum() > 1000, "the phantom has no chin")


def data_of(points, squares=None, **arrays):
    data = make_points(points, **arrays)
    if squares:
        polygons = vtkCellArray()
        for n in range(squares):
            polygons.InsertNextCell(4, [4 * n, 4 * n + 1, 4 * n + 2, 4 * n + 3])
        data.SetPolys(polygons)
    return data


reach = bone.copy()
for _ in range(3):
    grown = reach.copy()
    for axis in range(3):
        for step in (-1, 1):
            grown |= np.roll(reach, step, axis)  # bone does not come near the faces that matter
    reach = grown & (labels > 0)
gaps = np.zeros(SIZE - 1, bool)


def blade(axis):
    """The squares between what lies on both sides of the blade across an axis; also notes the elements that it parts."""
    first = [slice(None)] * 3
    second = list(first)
    first[axis], second[axis] = slice(None, -1), slice(1, None)
    cut = (reach & before)[tuple(first)] & (reach & ~before)[tuple(second)]
    other = [a for a in range(3) if a != axis]
    through = cut
    for a in other:
        low, high = [slice(None)] * 3, [slice(None)] * 3
        low[a], high[a] = slice(None, -1), slice(1, None)
        through = through[tuple(low)] & through[tuple(high)]
    gaps[through] = True
    pairs = np.argwhere(cut)
    corners = np.repeat(pairs[:, None].astype(float), 4, axis=1)
    corners[:, :, axis] += 0.5
    corners[:, :, other] += np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
    return produce(data_of(corners.reshape(-1, 3) * SPACING, len(pairs)))


grip = index[chin][np.argmin(((index[chin] - index[chin].mean(axis=0)) ** 2).sum(axis=1))] * SPACING
pose = produce(data_of([grip], Displacement=[SHIFT], Rotation=[[TURN, 0, 0]]))
blades = [blade(1), blade(2)]
deformation = ChainMailDeformation(Input=produce(image), Probes=[pose], Cuts=blades, TissueThreshold=0.5,
                                   MaterialPreset="Function", ConstraintArray="constraint", Rotations=1,
                                   PoissonRatio=POISSON, RelaxationPreset="Accurate")
deformation.Scalars = ["POINTS", "labels"]
reports = Reports(deformation)
volume, model = update(deformation, reports)
require(not reports.warnings, "warnings: %s", reports.warnings)
found = points_of(model, "Displacement").reshape(*SIZE[::-1], 3).transpose(2, 1, 0, 3).astype(float)

# The bones are where they are told to be.
arm = index * SPACING - grip
goal = arm @ rotation(TURN).T - arm + SHIFT
off = np.abs(found[chin] - goal[chin]).max()
require(off < 1e-4, "the chin is up to %g mm off its matrix", off)
require((found[bone & ~chin] == 0).all(), "the jaw moved by %g mm", np.abs(found[bone & ~chin]).max())

# The same by finite elements. The modulus is as 1 / D, which is what a constraint means for small strains.
held = bone.copy()
held[:, -1], held[:, :, -1] = True, True
held &= labels > 0
places = np.where(chin[..., None], goal, 0.0)
young = np.divide(1.0, constraint, out=np.zeros(SIZE), where=constraint > 0)
expected = neo_hookean.solve(labels > 0, young, POISSON, SPACING, held, places, gaps)
skin = np.zeros(SIZE, bool)
inner = (labels > 0)[1:-1, 1:-1, 1:-1]
skin[1:-1, 1:-1, 1:-1] = inner & ~((labels > 0)[2:, 1:-1, 1:-1] & (labels > 0)[:-2, 1:-1, 1:-1] & (labels > 0)[1:-1, 2:, 1:-1] &
                                   (labels > 0)[1:-1, :-2, 1:-1] & (labels > 0)[1:-1, 1:-1, 2:] & (labels > 0)[1:-1, 1:-1, :-2])
way = np.linalg.norm(SHIFT)
difference = np.linalg.norm(found - expected, axis=-1)[skin] / way
lengths = np.linalg.norm(expected, axis=-1)[skin] / way
moves = lengths > 0.1
half = lengths > 0.5
print("skin of %d voxels goes up to %.2f of the chin's shift of %.2f mm; ChainMail differs from finite elements by %.4f of it "
      "(median), %.4f (median of %d voxels that go a tenth as far), %.4f (of %d that go half as far), %.4f (most)" % (
          skin.sum(), lengths.max(), way, np.median(difference), np.median(difference[moves]), moves.sum(),
          np.median(difference[half]), half.sum(), difference.max()))
# The two differ (which matters most was not measured) in what strains of a tenth and more cost (Hooke's law in turned axes here, Neo-Hooke's there), in the modulus
# between two tissues (the mean of constraints here, of moduli there), in the outer half of skin's voxels, which finite elements
# between voxels leave out, and by limits of links, which reach some tissue beside the saw. Measured 0.0088, 0.060 and 0.103.
require(skin.sum() > 1000 and half.sum() > 50 and lengths.max() < 1.2, "skin does not follow as it should")
require(0.003 < np.median(difference) < 0.015, "skin differs by %g (median)", np.median(difference))
require(0.02 < np.median(difference[half]) < 0.08, "skin before the chin differs by %g (median)", np.median(difference[half]))
require(0.04 < difference.max() < 0.13, "skin differs by up to %g", difference.max())
