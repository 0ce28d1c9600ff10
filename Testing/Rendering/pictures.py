"""Pictures of volumes, and whether two pictures show the same thing."""

import os
import sys

import numpy as np
import paraview.simple
from paraview.simple import *
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkIOImage import vtkPNGReader, vtkPNGWriter

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, os.pardir, "Python"))
from harness import DATA, require, skip  # noqa: E402

BASELINES = os.path.normpath(os.path.join(DATA, "Baselines"))
REGENERATE = bool(os.environ.get("CHAINMAIL_WRITE_BASELINES"))


def require_display():
    """A render without OpenGL would end the process; ask first."""
    from paraview.modules.vtkRemotingViews import vtkPVRenderingCapabilitiesInformation as Capabilities
    here = Capabilities()
    here.CopyFromObject(None)
    if not here.Supports(Capabilities.OPENGL):
        skip("pictures need an X server; run-all.sh starts one")


def make_view(size, position, focus, up, angle):
    """A view that depends on no settings of the user's."""
    paraview.simple._DisableFirstRenderCameraReset()  # the camera below is meant
    view = CreateView("RenderView")
    view.ViewSize = list(size)
    view.OrientationAxesVisibility = 0
    view.UseFXAA = 0
    view.MultiSamples = 1
    view.UseColorPaletteForBackground = 0
    view.Background = [0.62, 0.68, 0.76]
    view.KeyLightElevation, view.KeyLightAzimuth = 40, -25
    view.KeyLightIntensity, view.HeadLightKHRatio, view.FillLightKFRatio = 1.0, 5.0, 2.5
    view.CameraPosition, view.CameraFocalPoint, view.CameraViewUp = list(position), list(focus), list(up)
    view.CameraViewAngle = angle
    return view


def show_volume(source, view, name, colours, opacities):
    """Shows the source as a volume; its display."""
    display = Show(source, view, "UniformGridRepresentation")
    display.SetRepresentationType("Volume")
    ColorBy(display, ("POINTS", name))
    display.SetScalarBarVisibility(view, False)
    lookup, opacity = GetColorTransferFunction(name), GetOpacityTransferFunction(name)
    lookup.ColorSpace = "RGB"
    lookup.RGBPoints = [float(number) for point in colours for number in point]
    opacity.Points = [float(number) for value, alpha in opacities for number in (value, alpha, 0.5, 0.0)]
    display.Shade = 1
    display.Ambient, display.Diffuse, display.Specular, display.SpecularPower = 0.2, 0.9, 0.2, 20
    display.ScalarOpacityUnitDistance = 2.0
    display.VolumeRenderingMode = "GPU Based"
    return display


def capture(view):
    """What the view shows, brought up to date, as pixels [row from below, column, rgb], 0..255."""
    window = view.CaptureWindow(1)
    width, height, _ = window.GetDimensions()
    return vtk_to_numpy(window.GetPointData().GetScalars()).reshape(height, width, -1)[:, :, :3].copy()


def picture(source, view, name, colours, opacities):
    """The source's volume as pixels. Nothing else is shown meanwhile."""
    show_volume(source, view, name, colours, opacities)
    pixels = capture(view)
    Hide(source, view)
    return pixels


def write(pixels, path):
    image = vtkImageData()
    image.SetDimensions(pixels.shape[1], pixels.shape[0], 1)
    image.GetPointData().SetScalars(numpy_to_vtk(np.ascontiguousarray(pixels).reshape(-1, 3), deep=1))
    os.makedirs(os.path.dirname(path), exist_ok=True)
    writer = vtkPNGWriter()
    writer.SetFileName(path)
    writer.SetCompressionLevel(9)
    writer.SetInputData(image)
    writer.Write()
    require(writer.GetErrorCode() == 0, "could not write %s", path)


def read(path):
    reader = vtkPNGReader()
    reader.SetFileName(path)
    reader.Update()
    image = reader.GetOutput()
    width, height, _ = image.GetDimensions()
    return vtk_to_numpy(image.GetPointData().GetScalars()).reshape(height, width, -1)[:, :, :3]


# Two pictures are blurred, so that where a sample of a ray falls and how an edge is rounded hardly counts, and then
# compared as greys, which may differ by 8 levels of 255, in 40 pixels by more. Measured on the pictures of
# TestForearm.py, in pixels beyond: the picture moved by an eighth of a pixel 0, holes of one voxel in a
# two-hundredth of the tissue 300, a cut that stayed closed 900, tissue that did not move 3300, a lost border 10000. The
# limits hold for both signs: too bright is as wrong as too dark.
BLUR = 1.0  # standard deviation [pixels]
LEVELS = 8.0
PIXELS_BEYOND = 40


def blurred(pixels):
    reach = 4
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) / BLUR) ** 2)
    weights /= weights.sum()
    grey = pixels.astype(float).mean(axis=2)
    for axis in (0, 1):
        count = grey.shape[axis]
        padded = np.pad(grey, [(reach, reach) if a == axis else (0, 0) for a in (0, 1)], mode="edge")
        grey = sum(w * np.take(padded, np.arange(i, i + count), axis) for i, w in enumerate(weights))
    return grey


def pixels_beyond(pixels, expected):
    """How many pixels are too dark and how many too bright."""
    require(pixels.shape == expected.shape, "a picture of %s pixels where %s were expected", pixels.shape, expected.shape)
    difference = blurred(pixels) - blurred(expected)
    return int((difference < -LEVELS).sum()), int((difference > LEVELS).sum())


def same_picture(pixels, expected):
    return sum(pixels_beyond(pixels, expected)) <= PIXELS_BEYOND


def baseline(label, pixels):
    """The picture kept in Data/Baselines; with CHAINMAIL_WRITE_BASELINES=1 it is replaced first by the one given."""
    path = os.path.join(BASELINES, label + ".png")
    if REGENERATE:
        write(pixels, path)
        print("wrote", path)
    require(os.path.isfile(path), "there is no %s; CHAINMAIL_WRITE_BASELINES=1 writes it", path)
    return read(path)
