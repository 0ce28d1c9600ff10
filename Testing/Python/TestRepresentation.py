"""The filter's output is shown at once as what it is: a volume as a volume, in the input's colours, a slice as a slice.
Nothing is rendered."""

import numpy as np
from harness import make_image, produce, require
from paraview.simple import *

rng = np.random.default_rng(5)
view = CreateView("RenderView")


def shown(shape):
    source = produce(make_image(rng.uniform(0, 100, shape)))
    deformation = ChainMailDeformation(Input=source)
    Show(source, view)
    return Show(deformation, view)


after = shown((6, 7, 8))
require(after.Representation == "Volume", "a volume is shown as %s", after.Representation)
require(list(after.ColorArrayName) == ["POINTS", "scalars"], "coloured by %s", after.ColorArrayName)
colours, opacities = GetColorTransferFunction("scalars"), GetOpacityTransferFunction("scalars")
require(after.LookupTable == colours, "other colours than the input's")
require(after.ScalarOpacityFunction == opacities, "other opacities than the input's")

for axis in range(3):
    shape = [6, 7, 8]
    shape[axis] = 1
    after = shown(shape)
    require(after.Representation == "Slice", "a slice across %s is shown as %s", "zyx"[axis], after.Representation)
print("volumes as volumes, slices as slices")
