"""What a new filter and a new probe start with: the defaults that the C++ classes document, fitted to the data."""

import numpy as np
from chainmail.ChainMailFilters import vtkChainMailDeformation
from harness import Reports, make_image, produce, require, settable, update
from paraview.simple import *

# The defaults of these depend on the data.
FITTED = {"Scalars", "TissueThreshold", "MaterialFunction", "BackgroundValue", "OutputBounds"}
# These are lists, which no single function of the class gives.
LISTS = {"ModelArrays", "LabelArrays"}
# What the class has besides properties of the deformation: the processes that compute, and warnings of the whole process.
NO_PROPERTIES = {"Controller", "GlobalProbeWarnings"}


def nodes(function):
    """The points (scalar, constraint) of a piecewise function's proxy."""
    points = np.reshape(function.Points, (-1, 4))
    require((points[:, 2] == 0.5).all() and (points[:, 3] == 0.0).all(), "a node is not linear: %s", points)
    return points[:, :2]


rng = np.random.default_rng(1)


def ramp(low, high, kind):
    values = rng.uniform(low, high, (6, 7, 8))
    values.flat[0], values.flat[-1] = low, high
    return make_image(values.astype(kind))


def like_ct(kind):
    """Air and noise on the left, then fat and muscle, with a little bone and one dead voxel."""
    values = np.empty((6, 7, 8))
    values[..., :3] = rng.uniform(-1020, -980, (6, 7, 3))
    values[..., 3:5] = rng.uniform(-120, -80, (6, 7, 2))
    values[..., 5:] = rng.uniform(20, 60, (6, 7, 3))
    values[2:4, 2:4, 6:] = rng.uniform(300, 1500, (2, 2, 2))
    values.flat[:3] = -1000  # the median of air then, whatever the noise
    air = values[..., :3]
    values[..., :3] += -1000 - np.median(air)
    values.flat[-1] = -3000
    return make_image(np.rint(values).astype(kind))


# A fresh VTK object and a fresh ParaView proxy agree on everything that does not depend on the data.
image = like_ct(np.int16)
deformation = ChainMailDeformation(Input=produce(image))
plain = vtkChainMailDeformation()
properties = set(settable(deformation))
require(FITTED | LISTS <= properties, "the filter no longer has %s", (FITTED | LISTS) - properties)
for name in sorted(properties - FITTED - LISTS):
    ours, theirs = (getattr(filter, "Get" + name)() for filter in (plain, deformation.GetClientSideObject()))
    require(ours == theirs, "%s of the class is %s, of the proxy %s", name, ours, theirs)
members = vars(vtkChainMailDeformation)
of_class = {name[3:] for name in members if name.startswith("Set") and "Get" + name[3:] in members}
require(of_class - NO_PROPERTIES <= properties, "the proxy lacks %s", of_class - NO_PROPERTIES - properties)
require(list(deformation.ModelArrays) == ["Displacement", "Element"], "the model's arrays are %s", deformation.ModelArrays)
for filter in (plain, deformation.GetClientSideObject()):
    chosen = filter.GetModelArraySelection()
    require([name for name in ("Displacement", "Element", "Constraint", "Cluster") if chosen.ArrayIsEnabled(name)] ==
            ["Displacement", "Element"], "the model has other arrays")
require(deformation.GetClientSideObject().GetNumberOfLabelArrays() == 0, "there are label arrays from the start")

# A CT: Hounsfield units of air, fat and muscle, bone and metal. These numbers are the presets' documentation, so they are written out.
require(list(deformation.Scalars) == ["POINTS", "scalars"], "Scalars is %s", deformation.Scalars)
require(deformation.TissueThreshold == -300, "a CT's threshold is %g", deformation.TissueThreshold)
require(abs(deformation.BackgroundValue + 1000) <= 1, "a CT's background is %g", deformation.BackgroundValue)
ct = nodes(deformation.MaterialFunction)
require(ct[0][0] == -300 and ct[-1][0] == 600 and ct[-1][1] == 0, "a CT's function is %s", ct)
require((ct[:-1, 1] > 0).all() and (ct[:, 1] < 1).all(), "a CT's function leaves (0, 1): %s", ct)

# Any other range: air is below a tenth of it, nothing is rigid, what is brighter is stiffer.
for low, high, kind in ((0, 255, np.uint8), (0, 4000, np.uint16), (-1.0, 1.0, np.float32), (2.5, 7.5, np.float64)):
    other = ChainMailDeformation(Input=produce(ramp(low, high, kind)))
    expected = low + 0.1 * (high - low)
    # The range of a float array and a tenth of it are rounded, the result is not otherwise changed.
    require(abs(other.TissueThreshold - expected) <= 1e-6 * (high - low),
            "range %g..%g: the threshold is %g", low, high, other.TissueThreshold)
    require(other.BackgroundValue == low, "range %g..%g: the background is %g", low, high, other.BackgroundValue)
    function = nodes(other.MaterialFunction)
    require(abs(function[0][0] - expected) <= 1e-6 * (high - low) and function[-1][0] == high,
            "range %g..%g: the function is %s", low, high, function)
    require((np.diff(function[:, 1]) < 0).all() and function[-1][1] > 0 and function[0][1] < 1,
            "range %g..%g: the function is %s", low, high, function)

# Infinite scalars are air: they do not stretch the range.
broken = like_ct(np.float32)
broken.GetPointData().GetScalars().SetTuple1(5, np.inf)
broken.GetPointData().GetScalars().SetTuple1(6, np.nan)
broken.GetPointData().GetScalars().SetTuple1(7, -np.inf)
fitted = ChainMailDeformation(Input=produce(broken))
require(fitted.TissueThreshold == -300 and abs(fitted.BackgroundValue + 1000) <= 1,
        "with infinite scalars: threshold %g, background %g", fitted.TissueThreshold, fitted.BackgroundValue)

# What the caller says is left alone; the rest is fitted.
given = ChainMailDeformation(Input=produce(image), TissueThreshold=12.5, Device="")
require(given.TissueThreshold == 12.5 and abs(given.BackgroundValue + 1000) <= 1, "a given threshold became %g",
        given.TissueThreshold)
given = ChainMailDeformation(Input=produce(image), TissueThreshold=0, BackgroundValue=0)
require(given.TissueThreshold == 0 and given.BackgroundValue == 0, "a given 0 became %g and %g", given.TissueThreshold,
        given.BackgroundValue)

# With another array the defaults can be fitted anew, as the panel's reset button does.
values = make_image(rng.uniform(0, 100, (6, 7, 8)), "other").GetPointData().GetArray("other")
values.SetTuple1(0, 0.0)
values.SetTuple1(1, 100.0)
image.GetPointData().AddArray(values)
two = ChainMailDeformation(Input=produce(image))
require(two.TissueThreshold == -300, "two arrays: the threshold of the active scalars is %g", two.TissueThreshold)
two.Scalars = ["POINTS", "other"]
for name in ("TissueThreshold", "MaterialFunction", "BackgroundValue"):
    two.SMProxy.GetProperty(name).ResetToDomainDefaults()
two.SMProxy.UpdateVTKObjects()
require(two.TissueThreshold == 10.0 and two.BackgroundValue == 0.0 and nodes(two.MaterialFunction)[-1][0] == 100.0,
        "after a change of array: threshold %g, background %g, function %s", two.TissueThreshold, two.BackgroundValue,
        nodes(two.MaterialFunction))

# The machine's devices are offered; the best is the default, and it is the one that was used.
devices = list(deformation.GetProperty("AvailableDevices"))
require(len(devices) > 0, "no device is offered")
reports = Reports(deformation)
volume, _ = update(deformation, reports)
used = volume.GetFieldData().GetAbstractArray("DeviceName").GetValue(0)
require(used == devices[0], "'%s' was used, not the best of %s", used, devices)

# A probe starts in the data that is active; without any at the origin.
SetActiveSource(deformation)
probe = ChainMailProbe()
require(np.allclose(probe.Position, [3.5, 3.0, 2.5]), "the probe starts at %s", probe.Position)
require(np.allclose(probe.Target, [3.5, 3.0, 3.0]), "the probe's target is %s", probe.Target)
require(probe.Radius == 0.0 and probe.Anchor == 0, "the probe has radius %g, anchor %d", probe.Radius, probe.Anchor)
require(probe.Tolerance == 0.0, "the probe has tolerance %g", probe.Tolerance)
SetActiveSource(None)
probe = ChainMailProbe()
require(list(probe.Position) == [0, 0, 0] and list(probe.Target) == [0, 0, 0], "a probe without data is at %s",
        probe.Position)
print("defaults fit")
