"""Smoothed for a picture. ChainMail Smooth: the values are those of a Gaussian, in whole and in part. The scalars that a
deformation smooths: the same values, and skin that is drawn has no grain."""

import os
import sys

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pictures import *  # noqa: E402, F403  (puts the harness on the path)
from harness import make_image, produce  # noqa: E402

sys.path.insert(0, DATA)

require_display()
import scenes  # noqa: E402

# --- Values, against sums over a voxel's surroundings

values = np.random.default_rng(5).integers(-1000, 1500, (9, 11, 13)).astype(np.int16)  # [z, y, x]
smooth = ChainMailSmooth(Input=produce(make_image(values, "CT", (1.0, 2.0, 3.0), (5.0, 6.0, 7.0))))
require(smooth.StandardDeviation == 0.75, "the default is %s", smooth.StandardDeviation)
smooth.UpdatePipeline()
output = smooth.GetClientSideObject().GetOutputDataObject(0)
array = output.GetPointData().GetScalars()
require(output.GetPointData().GetNumberOfArrays() == 1 and array.GetName() == "CT" and array.GetDataTypeAsString() == "float",
        "arrays: %s", array)
expected = values.astype(float)
for axis in range(3):
    before, total, weights = expected, np.zeros_like(expected), np.zeros_like(expected)
    for step in (-2, -1, 0, 1, 2):  # up to three standard deviations
        weight = np.exp(-0.5 * (step / 0.75) ** 2)
        here, there = [slice(None)] * 3, [slice(None)] * 3
        here[axis] = slice(max(0, -step), before.shape[axis] - max(0, step))
        there[axis] = slice(max(0, step), before.shape[axis] + min(0, step))
        total[tuple(here)] += weight * before[tuple(there)]
        weights[tuple(here)] += weight
    expected = total / weights
found = vtk_to_numpy(array).reshape(values.shape).copy()
# Floats of up to 1500 after three sums: each is rounded by some 1e-4.
require(np.abs(found - expected).max() < 2e-3, "off by up to %g", np.abs(found - expected).max())
smooth.GetClientSideObject().Modified()  # or the whole would do
smooth.GetClientSideObject().UpdateExtent([3, 7, 0, 4, 2, 8])
part = smooth.GetClientSideObject().GetOutputDataObject(0)  # which may have more around it
low, high = part.GetExtent()[::2], part.GetExtent()[1::2]
require(all(a <= b for a, b in zip(low, (3, 0, 2))) and all(a >= b for a, b in zip(high, (7, 4, 8))), "the part is %s", part)
box = tuple(slice(a, b + 1) for a, b in zip(low[::-1], high[::-1]))
wanted = tuple(slice(a - c, b - c) for a, b, c in zip((2, 0, 3), (9, 5, 8), low[::-1]))
require((vtk_to_numpy(part.GetPointData().GetScalars()).reshape(found[box].shape)[wanted] == found[2:9, 0:5, 3:8]).all(), "a part differs")


def smoothed_by(deviation):
    smooth.StandardDeviation = deviation
    smooth.UpdatePipeline()
    scalars = smooth.GetClientSideObject().GetOutputDataObject(0).GetPointData().GetScalars()
    return vtk_to_numpy(scalars).reshape(values.shape).copy()


for nothing in (0, -3, float("nan")):
    require((smoothed_by(nothing) == values).all(), "%s smooths something", nothing)
most = smoothed_by(4)
require((smoothed_by(1e9) == most).all() and 0 < most.std() < smoothed_by(1.5).std() < found.std(), "1e9 is not taken for 4")

# --- Grain: what is finer than 8 pixels on the skin of the example in Gallery.md, in ParaView's own light

scene = scenes.opened_limb()
_, deformation = scenes.open_scene(scene)
paraview.simple._DisableFirstRenderCameraReset()
view = CreateView("RenderView")
view.ViewSize, view.OrientationAxesVisibility = [1100, 800], 0
view.UseColorPaletteForBackground, view.Background = 0, [0.2, 0.22, 0.25]
focus = np.array(scene.cuts[0][0]) + [0, 14, 34]
view.CameraPosition, view.CameraFocalPoint, view.CameraViewUp = list(focus + [90.0, 330.0, 90.0]), list(focus), [1, 0, 0]
view.CameraViewAngle = 21.0


def grain_of(array):
    display = Show(deformation, view, "UniformGridRepresentation")
    display.SetRepresentationType("Volume")
    ColorBy(display, ("POINTS", array))
    for function in (GetColorTransferFunction(array), GetOpacityTransferFunction(array)):
        function.ApplyPreset("CT skin", False)
    display.Shade = 1
    display.SetScalarBarVisibility(view, False)
    pixels = capture(view)
    grey = pixels[..., :3].astype(float).mean(axis=2)[420:640, 250:800]
    sums = np.cumsum(np.cumsum(np.pad(grey, ((1, 0), (1, 0))), axis=0), axis=1)
    means = (sums[8:, 8:] - sums[:-8, 8:] - sums[8:, :-8] + sums[:-8, :-8]) / 64
    return (grey[4:-3, 4:-3] - means).std() / grey.mean()


deformation.ScalarSmoothing = 0.75  # as the window does
plain, without = grain_of("CT"), grain_of("CT smooth")
print("grain: %.4f of the brightness, smoothed %.4f" % (plain, without))
# 0.027 and 0.016; more than 0.02 is seen.
require(plain > 0.022, "there is no grain to take away: %.4f", plain)
require(0.005 < without < 0.02, "there is grain of %.4f", without)

smooth = ChainMailSmooth(Input=deformation)
smooth.UpdatePipeline()
one = vtk_to_numpy(smooth.GetClientSideObject().GetOutputDataObject(0).GetPointData().GetScalars())
other = vtk_to_numpy(deformation.GetClientSideObject().GetOutputDataObject(0).GetPointData().GetArray("CT smooth"))
require(np.abs(one - other).max() < 2e-3, "filter and deformation differ by %g", np.abs(one - other).max())
