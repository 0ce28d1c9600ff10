"""What a hand waits for in ParaView's window: to open a scan, grab it, drag, let go, cut, carve and save; and the frames of a
drag. Each step is done by a script as the buttons do it, with a view of 800 x 600: the probe, blade and drill are where and as
large as Add makes them, the probe's target goes around a circle with the preset Fast, and a drag whose elements take most of a
slow frame goes on with ModelReduction 2. That is what the window does where it cannot show a preview; where it can, its log tells
what a frame of a drag takes (Results.md).

    xvfb-run -a -s "-screen 0 1600x1200x24" pvpython Testing/Benchmarks/frames.py forearm SCAN.mhd ...

`forearm` is the phantom, 176 x 160 x 208, from a file. PV_PLUGIN_PATH names the plugin's folder. Prints medians with the
lowest and the highest, and the load of the machine.
"""

import math
import os
import statistics
import sys
import tempfile
import time

import numpy as np
from paraview.simple import *

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir, os.pardir, "Data"))
import make_forearm  # noqa: E402

FRAMES = 24


class Clock:
    """Seconds of the steps, in order."""

    def __init__(self):
        self.steps, self.last = [], time.perf_counter()

    def step(self, name):
        now = time.perf_counter()
        self.steps.append("%s %.2f" % (name, now - self.last))
        self.last = time.perf_counter()


def milliseconds(values):
    return "%.0f (%.0f to %.0f) ms" % (statistics.median(values), min(values), max(values))


def show_as_skin(source, view):
    """As Grab Tissue shows a scan that is not a volume yet."""
    display = Show(source, view)
    name = display.ColorArrayName[1]
    if source.PointData[name].GetRange(0)[0] < -200:
        for function in (GetColorTransferFunction(name), GetOpacityTransferFunction(name)):
            function.ApplyPreset("CT skin", False)
        display.Shade = 1


def drag(deformation, probe, view):
    """Frames around a circle: prints what they take."""
    start, radius = np.array(probe.Target), np.linalg.norm(np.subtract(probe.Target, probe.Position))
    deformation.RelaxationPreset = "Fast"
    frames, tissue, processor, reduced = [], [], [], None
    for n in range(FRAMES):
        angle = 2 * math.pi * n / FRAMES
        before, used = time.perf_counter(), time.process_time()
        probe.Target = start + radius * np.array([math.sin(angle), 0, math.cos(angle) - 1])
        view.SMProxy.InteractiveRender()
        frames.append(1e3 * (time.perf_counter() - before))
        processor.append(1e3 * (time.process_time() - used))
        steps = [deformation.FieldData["Milliseconds"].GetRange(step)[0] for step in range(5)]
        tissue.append(sum(steps))
        if reduced is None and frames[-1] >= 150 and steps[1] + steps[2] > 0.4 * frames[-1]:
            deformation.ModelReduction, reduced = "2", n
    first = 1 if reduced is None else reduced + 2  # another model is built once
    note = "" if reduced is None else "; from frame %d on with ModelReduction 2" % (reduced + 2)
    print("  a frame %s, of it deformation %s; processor time of all threads %s: %.1f frames a second%s" % (
        milliseconds(frames[first:]), milliseconds(tissue[first:]), milliseconds(processor[first:]),
        1e3 / statistics.median(frames[first:]), note))
    deformation.RelaxationPreset, deformation.ModelReduction = "Custom", "1"


def measure(path, folder):
    clock = Clock()
    scan = OpenDataFile(path)
    if not scan:
        sys.exit("There is no %s." % path)
    scan.UpdatePipeline()
    SetActiveSource(scan)
    view = CreateView("RenderView")
    view.ViewSize = [800, 600]
    Show(scan, view)
    ResetCamera(view)  # and to the front, as Grab Tissue turns to it
    focus = np.array(view.CameraFocalPoint)
    view.CameraPosition = list(focus - [0, np.linalg.norm(np.subtract(view.CameraPosition, focus)), 0])
    view.CameraViewUp = [0, 0, 1]
    Render(view)
    clock.step("open")

    probe = ChainMailProbe()
    deformation = ChainMailDeformation(Input=scan, Probes=[probe])
    show_as_skin(deformation, view)
    Hide(scan, view)
    Render(view)
    clock.step("grab")
    extent = scan.GetDataInformation().GetExtent()
    print("%s, %d x %d x %d voxels, grip of %.3g mm:" % (
        os.path.basename(path), extent[1] + 1 - extent[0], extent[3] + 1 - extent[2], extent[5] + 1 - extent[4], probe.Radius))
    drag(deformation, probe, view)
    clock.last = time.perf_counter()
    Render(view)
    clock.step("let go")

    for name, source in (("Cuts", ChainMailBlade), ("Carves", ChainMailDrill)):
        SetActiveSource(deformation)
        setattr(deformation, name, [source()])
        Render(view)
        clock.step("cut" if name == "Cuts" else "carve")
    SaveData(os.path.join(folder, "deformed.vti"), proxy=OutputPort(deformation, 0), DataMode="Binary")
    clock.step("save")
    print("  seconds: " + ", ".join(clock.steps), flush=True)


with tempfile.TemporaryDirectory() as folder:
    for path in sys.argv[1:] or ["forearm"]:
        if path == "forearm":
            path = os.path.join(folder, "forearm.vti")
            make_forearm.write(make_forearm.make_forearm(), path)
        measure(path, folder)
        ResetSession()
print("load %.1f" % os.getloadavg()[0])
