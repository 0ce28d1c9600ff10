"""Grab a scan, cut it, see it deformed: the ChainMail plugin from a script.

    bash Data/main-job.sh                            builds what is missing, then runs this on a forearm phantom
    bash Data/main-job.sh scan.mhd --output there    on any file with a volume that ParaView reads
    xvfb-run -a pvbatch Data/main_job.py scan.mhd    the same with a plugin that is built and found by ParaView

Into the output folder go input.png (the scan, with the probes and the blade that are about to act on it), deformed.png
(pulled by the probes), cut.png (the same pull after an incision between the probes), all three with the same camera,
and the two deformed volumes, deformed.vti and cut.vti.

Read main() as the tutorial: each step is what one does in ParaView's window. The functions above it choose what a
person would choose by eye: where to pull, where to cut, and how to show it. Where the scan is not to your liking, say
it yourself; all lengths in the scan's units (mm), in world axes:

    --probe  x y z  dx dy dz  radius        grab around (x, y, z) and drag by (dx, dy, dz); may be given several times
    --cut    ox oy oz  ax ay az  bx by bz   a blade: origin and the two neighbouring corners of ParaView's Plane
"""

import argparse
import glob
import math
import os
import re
import sys
import time

import numpy as np
from paraview import servermanager
from paraview.simple import *
from vtkmodules.util.misc import calldata_type
from vtkmodules.util.vtkConstants import VTK_STRING

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE)
import make_forearm  # noqa: E402
from find_scene import SceneError, Volume, plan_scene  # noqa: E402


class JobError(Exception):
    """Something the person at the keyboard can put right; the message says how."""


def say(text, *values):
    print(text % values if values else text, flush=True)


# ----------------------------------------------------------------------------------------------------------------------
# What has to be there


def read_arguments(arguments):
    parser = argparse.ArgumentParser(
        prog="main_job.py", formatter_class=argparse.RawDescriptionHelpFormatter, description=__doc__)
    parser.add_argument("scan", nargs="?", help="a volume in a file that ParaView reads; default: a forearm phantom")
    parser.add_argument("--output", default="output", metavar="DIR", help="folder for the results (default: output)")
    parser.add_argument("--array", help="point array of the scalars (default: the active scalars)")
    parser.add_argument("--threshold", type=float, help="smaller values are air (default: fitted to the scan)")
    parser.add_argument("--softness", type=float, default=1.7, metavar="F",
                        help="factor on the fitted material's constraints (default: 1.7)")
    parser.add_argument("--bone", type=float, metavar="VALUE",
                        help="tissue is rigid from this scalar on (default: as fitted, for CT 600)")
    parser.add_argument("--probe", type=float, nargs=7, action="append", metavar=("X", "Y", "Z", "DX", "DY", "DZ", "RADIUS"))
    parser.add_argument("--cut", type=float, nargs=9, metavar=("OX", "OY", "OZ", "AX", "AY", "AZ", "BX", "BY", "BZ"))
    parser.add_argument("--iterations", type=int, default=40, help="most iterations of relaxation (default: 40; 0: none)")
    parser.add_argument("--device", default="", help="part of an OpenCL device's name (default: the best one)")
    parser.add_argument("--size", type=int, nargs=3, metavar=("NX", "NY", "NZ"), help="voxels of the phantom")
    parser.add_argument("--image", type=int, nargs=2, default=(1200, 800), metavar=("W", "H"), help="pixels (default: 1200 800)")
    # pvbatch takes "-300" for a long option of the old style and hands it on as "--300".
    options = parser.parse_args([re.sub(r"^--(?=[\d.])", "-", argument) for argument in arguments])
    if not 0.0 < options.softness <= 2.8:
        raise JobError("--softness must be above 0 and at most 2.8. At 2.8 soft tissue stretches by nearly a voxel.")
    if options.iterations < 0:
        raise JobError("--iterations must not be negative.")
    if options.size and options.scan:
        raise JobError("--size is for the phantom; it does not apply to '%s'." % options.scan)
    if options.size and min(options.size) < 64:
        raise JobError("--size: the phantom needs at least 64 voxels along every axis to show anything.")
    if options.scan and not os.path.isfile(options.scan):
        raise JobError("There is no file '%s'." % options.scan)
    if options.threshold is not None and not math.isfinite(options.threshold):
        raise JobError("--threshold must be a finite number.")
    for numbers in (options.probe or []) + ([options.cut] if options.cut else []):
        if not all(math.isfinite(number) for number in numbers):
            raise JobError("--probe and --cut take finite numbers only.")
    return options


def require_display():
    """A render without OpenGL would end the process; ask first."""
    from paraview.modules.vtkRemotingViews import vtkPVRenderingCapabilitiesInformation as Capabilities
    here = Capabilities()
    here.CopyFromObject(None)
    if not here.Supports(Capabilities.OPENGL):
        raise JobError("Pictures need an X display, but DISPLAY ('%s') does not work. Run\n"
                       "    bash Data/main-job.sh\n"
                       "which starts a virtual display, or put xvfb-run before the command:\n"
                       "    xvfb-run -a pvbatch Data/main_job.py" % os.environ.get("DISPLAY", ""))


def load_plugin():
    """Makes ChainMailDeformation and ChainMailProbe known to this script."""
    if "ChainMailDeformation" in globals():
        return  # PV_PLUGIN_PATH is set, so ParaView has loaded it
    folders = [folder for folder in os.environ.get("PV_PLUGIN_PATH", "").split(os.pathsep) if folder]
    folders += [os.path.join(folder, "plugins") for folder in glob.glob(os.path.join(HERE, "../build/lib*/paraview-*"))]
    for folder in folders:
        path = os.path.normpath(os.path.join(folder, "ChainMail", "ChainMail.so"))
        if os.path.isfile(path):
            LoadPlugin(path, remote=False, ns=globals())
            return
    raise JobError("The ChainMail plugin was not found. Looked in: %s.\nBuild it with bash Testing/prepare.sh, or name the "
                   "folder that holds ChainMail/ChainMail.so in PV_PLUGIN_PATH." % (", ".join(folders) or "no folder at all"))


class Errors:
    """Collects what a filter reports: without it, a failed update would leave pvbatch at exit status 0."""

    def __init__(self):
        self.messages = []

    def watch(self, proxy):
        @calldata_type(VTK_STRING)
        def note(caller, event, text):
            text = re.sub(r"ERROR: In .*\n\S+ \(0x\w+\): ", "", text).strip()
            if text not in self.messages:
                self.messages.append(text)
        proxy.GetClientSideObject().AddObserver("ErrorEvent", note)

    def check(self, doing):
        if self.messages:
            text, self.messages = "\n".join(self.messages), []
            raise JobError("%s failed:\n%s" % (doing, text))


# ----------------------------------------------------------------------------------------------------------------------
# How to show it

def transfer_functions(volume, threshold, is_ct):
    """For CT numbers the name of a preset of the plugin: skin as glass, muscle as thin red glass, and bone. For any other
    range (value, r, g, b) and (value, opacity), from the tissue threshold on."""
    low, high = volume.range
    if is_ct:
        return "CT skin, muscle and bone"
    # No unit known: the lowest tissue is the skin, the brightest hundredth is shown solid.
    values = volume.values[volume.values >= threshold]
    values = values[np.isfinite(values)].astype(float)
    middle, dense = np.percentile(values, (50, 99)) if values.size else (0.5 * (low + high), high)
    middle = min(max(middle, threshold + 0.2 * (high - threshold)), high)
    dense = max(dense, middle + 0.1 * (high - middle))
    foot = threshold - 0.5 * max(threshold - low, 1e-6)
    colours = [(low, 0.35, 0.20, 0.15), (threshold, 0.85, 0.60, 0.47), (0.5 * (threshold + middle), 0.93, 0.70, 0.55),
               (middle, 0.78, 0.34, 0.27), (dense, 0.97, 0.90, 0.80), (high, 1.0, 0.98, 0.95)]
    opacities = [(low, 0.0), (foot, 0.0), (threshold, 0.45), (0.5 * (threshold + middle), 0.15), (middle, 0.04),
                 (dense, 0.4), (high, 0.9)]
    order = lambda points: [p for i, p in enumerate(points) if i == 0 or p[0] > points[i - 1][0]]
    return order(colours), order(opacities)


def make_view(volume, scene, size):
    """A view from above the incision and from its side, so that what is pulled out stands out."""
    view = CreateView("RenderView")
    view.ViewSize = list(size)
    view.OrientationAxesVisibility = 0
    view.UseColorPaletteForBackground = 0
    view.BackgroundColorMode = "Gradient"
    # A key light from the side, little else: relief is what shows a deformation.
    view.KeyLightElevation, view.KeyLightAzimuth = 45, -22
    view.KeyLightIntensity, view.KeyLightWarmth = 1.0, 0.5
    view.FillLightKFRatio, view.BackLightKBRatio, view.HeadLightKHRatio = 2.2, 4.0, 6.0
    view.Background, view.Background2 = [0.90, 0.92, 0.95], [0.48, 0.56, 0.66]
    extent = volume.size * volume.spacing
    # Long things lie in the picture; others stand on the image's lowest slice.
    length = [float(np.abs(volume.direction.T @ v) @ extent) for v in (scene.along, scene.across)]
    lying = max(length) > 1.6 * min(length)
    # From the end of the volume that is nearer, so that its section is seen.
    end = np.sign((scene.centre - volume.centre()) @ scene.along) or 1.0
    towards = scene.normal + 0.5 * scene.across + (0.75 if lying else 0.35) * end * scene.along
    towards = towards / np.linalg.norm(towards)
    up = volume.direction[:, 2]
    if lying or abs(up @ towards) > 0.9:
        up = scene.across if length[0] > length[1] else scene.along
    # The frame: about two thirds of the box as seen from there, around the incision.
    up = up - towards * (up @ towards)
    up = up / np.linalg.norm(up)
    right = np.cross(up, towards)
    half = [0.5 * float(np.abs(volume.direction.T @ v) @ extent) for v in (right, up)]
    angle = 24.0
    tangent = math.tan(math.radians(angle / 2))
    distance = 0.62 * max(half[0] * size[1] / size[0], half[1]) / tangent + 0.2 * extent.max()
    focus = volume.centre() + 0.7 * (scene.centre - volume.centre())
    view.CameraViewAngle = angle
    view.CameraFocalPoint = list(focus)
    view.CameraPosition = list(focus + distance * towards)
    view.CameraViewUp = list(up)
    return view


def show_volume(source, name, functions, step, view):
    display = Show(source, view, "UniformGridRepresentation")
    display.SetRepresentationType("Volume")
    ColorBy(display, ("POINTS", name))
    lookup, opacity = GetColorTransferFunction(name), GetOpacityTransferFunction(name)
    if isinstance(functions, str):
        for function in (lookup, opacity):
            function.ApplyPreset(functions, False)  # False: in Hounsfield units, not rescaled to the scan's range
    else:
        colours, opacities = functions
        lookup.ColorSpace = "RGB"
        lookup.RGBPoints = [float(number) for point in colours for number in point]
        opacity.Points = [float(number) for value, alpha in opacities for number in (value, alpha, 0.5, 0.0)]
    display.Shade = 1
    display.Ambient, display.Diffuse, display.Specular, display.SpecularPower = 0.2, 0.9, 0.3, 30
    display.ScalarOpacityUnitDistance = step
    display.SetScalarBarVisibility(view, False)
    return display


def show_plan(probes, blade, step, view):
    """The probes as arrows and the blade as a sheet of glass."""
    shown = []
    for probe in probes:
        start, end = np.array(probe.Position), np.array(probe.Target)
        drag = np.linalg.norm(end - start)
        if drag == 0:
            continue
        line = Line(Point1=list(start), Point2=list(end))
        tube = Tube(Input=line, Radius=0.9 * step, NumberofSides=16, Capping=1)
        ball = Sphere(Center=list(start), Radius=2.0 * step, ThetaResolution=24, PhiResolution=24)
        tip = Cone(Center=list(end), Direction=list((end - start) / drag), Radius=2.6 * step, Height=7.0 * step,
                   Resolution=32)
        for part in (tube, ball, tip):
            display = Show(part, view)
            ColorBy(display, ("POINTS", None))
            display.DiffuseColor = display.AmbientColor = [0.05, 0.35, 0.75]
            shown.append(part)
    display = Show(blade, view)
    ColorBy(display, ("POINTS", None))
    display.DiffuseColor = display.AmbientColor = [0.1, 0.6, 0.35]
    display.Opacity, display.Ambient = 0.55, 0.4
    shown.append(blade)
    return shown


# ----------------------------------------------------------------------------------------------------------------------
# The figures a filter gives with its output


def figures(proxy):
    fields = servermanager.Fetch(proxy).GetFieldData()

    def row(name):
        array = fields.GetAbstractArray(name)
        return [array.GetVariantValue(i) for i in range(array.GetNumberOfValues())] if array else []

    def numbers(name):
        return [value.ToDouble() for value in row(name)]
    return numbers, [value.ToString() for value in row("DeviceName")]


def report(proxy, probes, seconds, step, softness):
    numbers, device = figures(proxy)
    reached = np.array(numbers("ProbeReached")).reshape(-1, 3)
    for number, (probe, got) in enumerate(zip(probes, reached)):
        asked = np.array(probe.Target) - np.array(probe.Position)
        note = "" if np.linalg.norm(asked - got) < 1e-3 * step else ": the tissue stretches no further"
        far = np.linalg.norm(got) < 0.5 * np.linalg.norm(asked)
        say("    probe %d: asked for %s mm, reached %s mm%s", number + 1,
            " ".join("%.1f" % v for v in asked), " ".join("%.1f" % v for v in got), note)
        if far:
            say("        (held by another probe, by bone or by a face of the image; --softness %.1f lets it move further)",
                min(2.8, 1.5 * softness))
    say("    elements moved %d, energy %.5g mm, largest link excess %.2g, relaxation iterations %d",
        numbers("DisplacedElements")[0], numbers("Energy")[0], numbers("MaxLinkExcess")[0],
        numbers("RelaxationIterationsUsed")[0])
    say("    milliseconds: upload %.0f, propagate %.0f, relax %.0f, resample %.0f, download %.0f; with all else %.0f",
        *numbers("Milliseconds"), 1000 * seconds)
    say("    device: %s", ", ".join(device))


# ----------------------------------------------------------------------------------------------------------------------


def main(arguments):
    options = read_arguments(arguments)
    require_display()
    load_plugin()
    os.makedirs(options.output, exist_ok=True)
    path = lambda name: os.path.join(options.output, name)
    errors = Errors()
    start = time.time()

    # File > Open. Without a scan of your own: a phantom.
    if not options.scan:
        options.scan = path("forearm.vti")
        say("Making a forearm phantom: %s", options.scan)
        make_forearm.write(make_forearm.make_forearm(options.size or make_forearm.DEFAULT_SIZE), options.scan)
    try:
        scan = OpenDataFile(options.scan)
    except RuntimeError:
        scan = None
    if scan is None:
        raise JobError("ParaView has no reader for '%s'. Convert the scan to another format, such as .mhd or .vti." % options.scan)
    errors.watch(scan)
    scan.UpdatePipeline()
    errors.check("Reading '%s'" % options.scan)
    image = servermanager.Fetch(scan)
    if not image or not image.IsA("vtkImageData") or min(image.GetDimensions()) < 2:
        raise JobError("'%s' has no volume (it is %s). Give an image of three dimensions."
                       % (options.scan, image.GetClassName() if image else "empty"))
    points = image.GetPointData()
    scalars = points.GetScalars() or points.GetArray(0)
    name = options.array or (scalars.GetName() if scalars else None)
    if not name or not points.GetArray(name):
        names = [points.GetArrayName(i) for i in range(points.GetNumberOfArrays())]
        raise JobError("'%s' has no point array%s; it has: %s." % (
            options.scan, " '%s'" % name if name else "", ", ".join(names) or "none"))
    volume = Volume(image, name)
    say("%s: %s voxels of %s mm, '%s' from %g to %g", os.path.basename(options.scan),
        " x ".join("%d" % n for n in volume.size), " x ".join("%.3g" % s for s in volume.spacing), name, *volume.range)

    # Filters > ChainMail > ChainMail Deformation. The panel fits material and threshold to the scan; for CT numbers
    # there is a preset.
    deformation = ChainMailDeformation(Input=scan)
    errors.watch(deformation)
    deformation.Scalars = ["POINTS", name]
    deformation.RelaxationIterations = options.iterations
    deformation.Device = options.device
    if options.threshold is not None:
        deformation.TissueThreshold = options.threshold
    threshold = deformation.TissueThreshold
    # A point is scalar, constraint, midpoint, sharpness. The constraint is how far an element gives, as a fraction of
    # the spacing; 0 is rigid. The fitted ones are below 1/3, where nothing can fold; skin that is to be drawn wide
    # open has to give more.
    material = np.array(deformation.MaterialFunction.Points).reshape(-1, 4)
    material[:, 1] *= options.softness
    rigid = material[:, 1] == 0
    is_ct = rigid.any()  # in any other scan bone cannot be told, and nothing fitted is rigid
    if options.bone is not None:
        material = np.append(material[~rigid & (material[:, 0] < options.bone)], [[options.bone, 0.0, 0.5, 0.0]], axis=0)
        rigid = material[:, 1] == 0
    bone = material[rigid, 0].min() if rigid.any() else math.inf
    deformation.MaterialFunction.Points = material.ravel().tolist()
    say("Material: air below %g; constraint %s", threshold,
        ", ".join("%.2f at %g" % (point[1], point[0]) for point in material))

    # Sources > ChainMail > ChainMail Probe, twice, and a Plane for the blade.
    scene = plan_scene(volume, threshold, bone, options.probe, options.cut)
    probes = []
    for numbers in scene.probes:
        position, drag, radius = np.array(numbers[0:3]), np.array(numbers[3:6]), numbers[6]
        probes.append(ChainMailProbe(Position=list(position), Target=list(position + drag), Radius=radius))
        say("Probe %d: grabs %.1f mm around (%s), drags by (%s)", len(probes), radius,
            ", ".join("%.1f" % v for v in position), ", ".join("%.1f" % v for v in drag))
    blade = Plane(Origin=scene.cut[0:3], Point1=scene.cut[3:6], Point2=scene.cut[6:9])
    say("Blade: %s", ", ".join("(%s)" % ", ".join("%.1f" % v for v in scene.cut[i:i + 3]) for i in (0, 3, 6)))

    # Tissue that is pulled out of the image's box needs room in the output, on the sides where it leaves.
    ends = np.array([volume.voxels(np.array(n[0:3]) + n[3:6]) for n in scene.probes])
    margin = 5 * scene.step / volume.spacing
    below = np.ceil(np.maximum((margin - ends).max(axis=0), 0)).astype(int)
    above = np.ceil(np.maximum((ends + margin - volume.size + 1).max(axis=0), 0)).astype(int)
    deformation.OutputPadding = int(max(below.max(), above.max()))
    extent = np.array(image.GetExtent()).reshape(3, 2) + np.stack([-below, above], axis=1)
    result = ExtractSubset(Input=OutputPort(deformation, 0), VOI=extent.ravel().tolist())

    # The scan with what is going to happen to it.
    view = make_view(volume, scene, options.image)
    functions = transfer_functions(volume, threshold, is_ct)
    drawn = ChainMailSmooth(Input=scan)  # the pictures alone: files have the values as they are
    show_volume(drawn, name, functions, scene.step, view)
    plan = show_plan(probes, blade, scene.step, view)
    SaveScreenshot(path("input.png"), view, ImageResolution=list(options.image))
    say("Wrote %s", path("input.png"))
    for source in [drawn] + plan:
        Hide(source, view)
    drawn = ChainMailSmooth(Input=result)

    # Pull without the cut, then with it: the same filter, one input more.
    for label, cuts in (("deformed", []), ("cut", [blade])):
        deformation.Probes = probes
        deformation.Cuts = cuts
        begin = time.time()
        deformation.UpdatePipeline()
        errors.check("The deformation")
        say("Deformed %s:", "with the cut" if cuts else "without the cut")
        report(deformation, probes, time.time() - begin, scene.step, options.softness)
        show_volume(drawn, name, functions, scene.step, view)
        SaveScreenshot(path(label + ".png"), view, ImageResolution=list(options.image))
        SaveData(path(label + ".vti"), proxy=result, DataMode="Binary")  # readable also with a new expat
        say("Wrote %s and %s", path(label + ".png"), path(label + ".vti"))
    say("Done in %.1f s.", time.time() - start)


def explain(kind, error, trace):
    if issubclass(kind, (JobError, SceneError)):
        sys.stderr.write("main_job.py: %s\n" % error)
    else:
        sys.__excepthook__(kind, error, trace)


if __name__ == "__main__":
    # A JobError is left to pvbatch, which then ends with a non-zero status after it has shut down properly, also under
    # MPI, where sys.exit() would leave the other ranks waiting. Only the traceback is kept from the reader.
    sys.excepthook = explain
    main(sys.argv[1:])
