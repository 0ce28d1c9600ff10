"""ChainMail Carry takes points, images and labels along as the deformation itself does: on a phantom with and without a cut,
in an image that is turned and flipped, too. Held against numpy, which interpolates between elements on their own side, and
against what the deformation shows of arrays that it has itself."""

import os

import numpy as np
from harness import (DATA, OUTPUT, Reports, add_array, expect_error, make_image, make_points, points_of, produce, require,  # noqa: F401
                     run_pvpython, same_bits, update)
from paraview.simple import *
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet
import sys
sys.path.insert(0, DATA)
from make_forearm import make_forearm  # noqa: E402

AIR = -300
phantom = make_forearm((66, 62, 64))
n = np.array(phantom.GetDimensions())
spacing = np.array(phantom.GetSpacing())
ct = points_of(phantom, "CT").reshape(n[::-1])
# What another examination would bring: labels and a smooth image, where there is tissue.
z, y, x = np.meshgrid(*(np.arange(size) for size in ct.shape), indexing="ij")
labels = np.where(ct >= AIR, 1 + (x // 9 + y // 9 + z // 9) % 5, 0).astype(np.uint8)
smooth = np.where(ct >= AIR, 200 + 50 * np.sin(x / 7) + 40 * np.cos(y / 6) + 30 * np.sin(z / 9), 0).astype(np.float32)


def places_of(proxy):
    return vtk_to_numpy(servermanager.Fetch(proxy).GetPoints().GetData())


def carried(data, deformation, **properties):
    """The output of ChainMail Carry, which may report nothing."""
    proxy = ChainMailCarry(Input=data if hasattr(data, "SMProxy") else produce(data),
                           Deformation=OutputPort(deformation, 1), **properties)
    reports = Reports(proxy)
    proxy.UpdatePipeline()
    require(not reports.errors and not reports.warnings, "ChainMail Carry reports %s", reports.errors + reports.warnings)
    return proxy


def moved(places, deformation, **properties):
    return places_of(carried(make_points(places), deformation, **properties))


def largest(difference):
    return float(np.abs(difference).max())


def play(what, direction, origin, first, cut):
    turn = np.asarray(direction, float)
    world = lambda index: origin + (turn @ ((np.asarray(index) + first) * spacing).T).T
    image = make_image(ct, "CT", spacing, origin, first, turn)
    add_array(image, labels, "Labels")
    add_array(image, smooth, "Smooth")
    # Skin and fat of the upper side, pulled along the limb and outwards; a blade across the limb beside them.
    k, i = 30, 33
    j = int(np.flatnonzero(ct[k, :, i] >= AIR).max()) - 3
    position = world(np.array([i, j, k]))
    probe = ChainMailProbe(Position=position, Target=position + turn @ [2.0, 2.0, 5.0], Radius=5.0)
    corner, right, down = (world(np.array(at)) for at in ([i - 12, j + 6, k + 5.5], [i + 12, j + 6, k + 5.5], [i - 12, j - 7, k + 5.5]))
    blade = Plane(Origin=corner, Point1=right, Point2=down)
    deformation = ChainMailDeformation(Input=produce(image), Probes=[probe], Cuts=[blade] if cut else [],
                                       MaterialPreset="CT (Hounsfield units)", LabelArrays=["Labels"], RelaxationPreset="Balanced")
    volume, model = update(deformation, Reports(deformation))
    displacement = points_of(model, "Displacement")
    tissue = points_of(model, "Element") > 0
    far = np.linalg.norm(displacement, axis=1)
    require(far.max() > 4 and (far[tissue] > 1).mean() > 0.005, "%s: tissue moved by up to %g mm", what, far.max())
    require(bool(model.GetPointData().HasArray("Links")) == cut, "%s: Links", what)

    # At its elements the map is the displacement, and between them trilinear, on the side of the nearest element.
    index = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    rest = world(index)[tissue]
    there = moved(rest, deformation)
    require(largest(there - rest - displacement[tissue]) < 1e-5, "%s: an element is off by %g mm", what,
            largest(there - rest - displacement[tissue]))
    full = tissue.reshape(ct.shape)
    cells = np.all([full[c:n[2] - 1 + c, b:n[1] - 1 + b, a:n[0] - 1 + a] for a in (0, 1) for b in (0, 1) for c in (0, 1)], axis=0)
    if cut:  # of which all links between corners are there
        links = points_of(model, "Links").reshape(ct.shape)
        for axis, bit in ((2, 2), (1, 8), (0, 32)):
            there_ = (links & bit) > 0
            for p in (0, 1):
                for q in (0, 1):
                    ranges = [slice(p, n[2] - 1 + p), slice(q, n[1] - 1 + q), slice(0, n[0] - 1)] if axis == 2 else \
                        [slice(p, n[2] - 1 + p), slice(0, n[1] - 1), slice(q, n[0] - 1 + q)] if axis == 1 else \
                        [slice(0, n[2] - 1), slice(p, n[1] - 1 + p), slice(q, n[0] - 1 + q)]
                    cells &= there_[tuple(ranges)]
    random = np.random.default_rng(1)
    base = np.argwhere(cells)[:, ::-1]
    base = base[random.integers(len(base), size=100000)]
    share = random.uniform(0, 1, base.shape)
    field = displacement.reshape(*ct.shape, 3)
    expected = np.zeros(base.shape)
    for a in (0, 1):
        for b in (0, 1):
            for c in (0, 1):
                weight = np.prod(np.where([a, b, c], share, 1 - share), axis=1)
                expected += weight[:, None] * field[base[:, 2] + c, base[:, 1] + b, base[:, 0] + a]
    places = world(base + share)
    now = moved(places, deformation)
    require(largest(now - places - expected) < 1e-5, "%s: between elements off by %g mm", what, largest(now - places - expected))
    # And back: 100,000 places within a thousandth of a voxel. Where the sides of the cut, or a fold, lie over each other
    # several places are there now; then it is another of them.
    back = moved(now, deformation, Direction="Backward")
    off = np.abs((back - places) @ turn / spacing).max(axis=1)
    several = off > 1e-3
    again = moved(back[several], deformation) if several.any() else now[several]
    require(largest((again - now[several]) @ turn / spacing) < 1e-5 if several.any() else True,
            "%s: places come back to where nothing came from", what)
    require(several.mean() < (0.01 if cut else 1e-9), "%s: %d places are up to %g voxels off, there and back", what,
            several.sum(), off.max())
    off = off[~several]
    # A place in the air goes along with the skin that it is next to.
    outside = world(np.array([[i, j + 5, k]]))
    require(np.linalg.norm(moved(outside, deformation) - outside) > 2, "%s: air beside the skin stays", what)

    # The two lips of the cut part: places just below and above it go as the elements there do.
    if cut:
        at = np.array([[a, b, k + 5 + c] for a in range(i - 5, i + 6) for b in range(j - 5, j + 2) for c in (0, 1)])
        side = at + np.array([0, 0, 0.49]) * np.where(at[:, 2:] == k + 5, 1, -1)
        both = full[k + 5, at[:, 1], at[:, 0]] & full[k + 6, at[:, 1], at[:, 0]]
        own, other = field[at[:, 2], at[:, 1], at[:, 0]], field[2 * k + 11 - at[:, 2], at[:, 1], at[:, 0]]
        apart = np.linalg.norm(own - other, axis=1)
        wide = both & (apart > 0.5 * apart[both].max())
        lips = moved(world(side), deformation) - world(side)
        require(apart[both].max() > 1 and wide.sum() > 10, "%s: the cut opens by %g mm only", what, apart[both].max())
        require((np.linalg.norm(lips - own, axis=1) < 0.3 * apart)[wide].all(), "%s: a lip is drawn to the other", what)

    # Images: as the deformation shows its own arrays, but for the border of tissue.
    inside = points_of(volume, "CT") >= AIR
    print("%s: up to %.1f mm; there and back %.1e voxels, %d places under others" % (
        what, far.max(), off.max(), several.sum()), end="")
    for name, most in (("Smooth", 3.0), ("Labels", 0.0)):
        alone = make_image(points_of(image, name).reshape(ct.shape), name, spacing, origin, first, turn)
        result = points_of(servermanager.Fetch(carried(alone, deformation)), name).astype(float)
        own = points_of(volume, name).astype(float)
        stayed = points_of(image, name).astype(float)
        changed = inside & (np.abs(own - stayed) > most)
        differ = np.abs(result - own) > most
        require(changed.sum() > (300 if name == "Smooth" else 60), "%s, %s: too little changed to tell", what, name)
        print("; %s: of %d voxels that changed %d differ, of the others %d" % (
            name, changed.sum(), differ[changed].sum(), differ[inside & ~changed].sum()), end="")
        require(differ[changed].mean() < 0.01 and differ[inside & ~changed].mean() < 0.001,
                "%s, %s: %.2f %% of what changed differs from the deformation's", what, name, 100 * differ[changed].mean())
        # The wrong way round would not do.
        if name == "Labels":
            wrong = points_of(servermanager.Fetch(carried(alone, deformation, Direction="Backward")), name)
            require((wrong != own)[changed].mean() > 0.2, "%s: the inverse does as well", what)
    print()
    return deformation, volume, rest, there


deformation, volume, rest, there = play("straight", np.eye(3), np.array(phantom.GetOrigin()), (0, 0, 0), False)

# Labels from a file of their own, whose array has the name of the scan's: the filter takes them along as it does its own.
scan, other = (produce(make_image(values, "CT", spacing, phantom.GetOrigin())) for values in (ct, labels))
resampled = ResampleWithDataset(SourceDataArrays=other, DestinationMesh=scan, CategoricalData=1)
deformation.Input = AppendAttributes(Input=[scan, resampled])
deformation.LabelArrays = ["CT_input_1"]
both, _ = update(deformation, Reports(deformation))
require(same_bits(points_of(both, "CT_input_1"), points_of(volume, "Labels")), "labels from a file of their own differ")

c, s = np.cos(0.5), np.sin(0.5)
deformation, volume, rest, there = play(
    "turned, with a cut", np.array([[c, s, 0], [0, 0, 1], [-s, c, 0]]), np.array([31.0, -7.0, 12.0]), (3, -2, 5), True)

# The model from a file does as well as the filter: landmarks of the deformed scan, back to rest. They are in blocks.
path = os.path.join(OUTPUT, "Carry-model.vti")
SaveData(path, proxy=OutputPort(deformation, 1), DataMode="Binary")
blocks = vtkMultiBlockDataSet()
blocks.SetBlock(0, make_points(there[::997]))
blocks.SetBlock(1, make_points(there[5::997]))
back = ChainMailCarry(Input=produce(blocks), Deformation=OpenDataFile(path), Direction="Backward")
reports = Reports(back)
back.UpdatePipeline()
require(not reports.take(), "the model from a file")
result = servermanager.Fetch(back)
for number, expected in enumerate((rest[::997], rest[5::997])):
    places = vtk_to_numpy(result.GetBlock(number).GetPoints().GetData())
    far = np.abs(places - expected).max(axis=1) > 1e-3 * spacing.min()  # some lie under others
    require(len(places) > 50 and far.mean() < 0.02, "%d of %d landmarks do not come back from a file's model", far.sum(), len(far))

# The first output in place of the second one is an error that says so, and the update after it works.
carry = ChainMailCarry(Input=produce(make_points(rest[::997])), Deformation=OutputPort(deformation, 0))
expect_error(carry, Reports(carry), "Connect the second output of ChainMail Deformation, the model at rest")
carry.Deformation = OutputPort(deformation, 1)
reports = Reports(carry)
carry.UpdatePipeline()
require(not reports.take() and largest(places_of(carry) - there[::997]) < 1e-6, "no update after an error")

# A change of the deformation comes through, as in a film.
deformation.Probes = []
carry.UpdatePipeline()
require(largest(places_of(carry) - rest[::997]) == 0, "the landmarks do not follow the deformation")

# A saved state has all of it.
carry.Direction, carry.Interpolation, carry.LabelArrays = "Backward", "Nearest", ["RTData"]
carry.FitBackground, carry.BackgroundValue = 0, -7.0
RenameSource("Carried", carry)
state = os.path.join(OUTPUT, "Carry.pvsm")
SaveState(state)
ResetSession()
LoadState(state)
carry = FindSource("Carried")
require(carry is not None and carry.Direction == "Backward" and carry.Interpolation == "Nearest" and
        list(carry.LabelArrays) == ["RTData"] and carry.FitBackground == 0 and carry.BackgroundValue == -7.0 and
        carry.Deformation.Port == 1, "the state is not what was saved")
