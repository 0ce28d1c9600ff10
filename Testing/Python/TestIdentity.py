"""Nothing pulls: every output array equals its input bit for bit, whatever its type, with and without a cut."""

import numpy as np
from harness import Reports, add_array, make_image, points_of, produce, require, same_bits, update
from paraview.simple import *

TYPES = (np.int8, np.uint8, np.int16, np.uint16, np.int32, np.uint32, np.int64, np.uint64, np.float32, np.float64)
rng = np.random.default_rng(2)
SHAPE = (9, 11, 13)  # z, y, x


def everything(kind):
    """Values over the type's whole range, NaN and infinity among the floats."""
    if np.issubdtype(kind, np.integer):
        limits = np.iinfo(kind)
        values = rng.integers(limits.min, limits.max, SHAPE, dtype=kind, endpoint=True)
        values.flat[:2] = limits.min, limits.max
        return values
    values = rng.normal(0, 1000, SHAPE).astype(kind)
    values.flat[:4] = np.nan, np.inf, -np.inf, -0.0
    return values


def check(image, what, **settings):
    source = produce(image)
    for cuts in ([], [Plane(Origin=[-5, -5, 4.4], Point1=[30, -5, 4.7], Point2=[-5, 30, 5.1])]):
        deformation = ChainMailDeformation(Input=source, Cuts=cuts, **settings)
        volume, model = update(deformation, Reports(deformation))
        before, after = image.GetPointData(), volume.GetPointData()
        require(after.GetNumberOfArrays() == before.GetNumberOfArrays(), "%s: %d arrays became %d", what,
                before.GetNumberOfArrays(), after.GetNumberOfArrays())
        for i in range(before.GetNumberOfArrays()):
            name = before.GetArrayName(i)
            require(same_bits(points_of(image, name), points_of(volume, name)), "%s, %d cuts: '%s' changed", what,
                    len(cuts), name)
        require(volume.GetExtent() == image.GetExtent() and volume.GetSpacing() == image.GetSpacing() and
                volume.GetOrigin() == image.GetOrigin(), "%s: the geometry changed", what)
        require(not points_of(model, "Displacement").any(), "%s: something moved", what)


for kind in TYPES:
    # The material of a full 64-bit range spans 1e19: it is fitted like any other.
    check(make_image(everything(kind), first=(3, -2, 5), spacing=(0.7, 1.0, 1.3), origin=(-4.0, 2.0, 8.5)), kind.__name__)
    print(kind.__name__, "identical")

# Several arrays at once, of all types, with 1 to 3 components; the scalars are one of them.
image = make_image(everything(np.int16))
for number, kind in enumerate(TYPES):
    add_array(image, everything(kind), "one %d" % number)
    add_array(image, np.stack([everything(kind)] * (2 + number % 2), axis=3), "several %d" % number)
check(image, "many arrays", LabelArrays=["one 1"])
check(image, "nearest", Interpolation="Nearest")

# A single slice, across each axis.
for axis in range(3):
    shape = list(SHAPE)
    shape[axis] = 1
    check(make_image(rng.normal(0, 500, shape).astype(np.float32)), "slice across %s" % "zyx"[axis])
print("identical: several arrays, single slices")
