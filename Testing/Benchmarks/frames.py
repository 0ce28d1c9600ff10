"""Frames of a drag as ParaView's window makes them, on scans: a probe where Grab Tissue puts it, dragged around a circle with
the preset Fast, and drawn as skin. As in the window, a drag whose elements take most of a slow frame goes on with
ModelReduction 2.

    xvfb-run -a -s "-screen 0 1600x1200x24" pvpython Testing/Benchmarks/frames.py forearm SCAN.mhd ...

`forearm` is the plugin's phantom, 176 x 160 x 208. PV_PLUGIN_PATH names the plugin's folder. Prints medians [ms] with the
lowest and the highest, and the load of the machine.
"""

import math
import os
import statistics
import sys
import time

import numpy as np
from paraview.simple import *

SIZE = [800, 600]
FRAMES = 24


def look(source, view):
    """As Grab Tissue shows a scan that is not a volume yet."""
    display = Show(source, view)
    name = display.ColorArrayName[1]
    if source.PointData[name].GetRange(0)[0] < -200:
        for function in (GetColorTransferFunction(name), GetOpacityTransferFunction(name)):
            function.ApplyPreset("CT skin", False)
        display.Shade = 1
    return display


def times_of(values):
    return "%.0f (%.0f to %.0f)" % (statistics.median(values), min(values), max(values))


def measure(path):
    scan = ChainMailForearm(Size=[176, 160, 208]) if path == "forearm" else OpenDataFile(path)
    if not scan:
        sys.exit("There is no %s." % path)
    scan.UpdatePipeline()
    SetActiveSource(scan)
    view = CreateView("RenderView")
    view.ViewSize = SIZE
    Show(scan, view)
    ResetCamera(view)  # and to the front, as Grab Tissue turns to it
    focus, away = np.array(view.CameraFocalPoint), np.linalg.norm(np.subtract(view.CameraPosition, view.CameraFocalPoint))
    view.CameraPosition, view.CameraViewUp = list(focus - [0, away, 0]), [0, 0, 1]
    probe = ChainMailProbe()
    deformation = ChainMailDeformation(Input=scan, Probes=[probe])
    look(deformation, view)
    Hide(scan, view)
    Render(view)
    print("%s: %s voxels, grip %.3g mm" % (os.path.basename(path), " x ".join(map(str, size_of(scan))), probe.Radius))

    start, radius = np.array(probe.Target), np.linalg.norm(np.subtract(probe.Target, probe.Position))
    deformation.RelaxationPreset = "Fast"
    frames, tissue, reduced = [], [], None
    for n in range(FRAMES):
        angle = 2 * math.pi * n / FRAMES
        before = time.perf_counter()
        probe.Target = start + radius * np.array([math.sin(angle), 0, math.cos(angle) - 1])
        Render(view)
        frames.append(1e3 * (time.perf_counter() - before))
        steps = [deformation.FieldData["Milliseconds"].GetRange(step)[0] for step in range(5)]
        tissue.append(sum(steps))
        if reduced is None and frames[-1] >= 150 and steps[1] + steps[2] > 0.4 * frames[-1]:
            deformation.ModelReduction, reduced = "2", n
    first = 1 if reduced is None else reduced + 2  # another model is built once
    print("  a frame: %s, of it deformation %s; %.1f frames a second%s" % (
        times_of(frames[first:]), times_of(tissue[first:]), 1e3 / statistics.median(frames[first:]),
        "" if reduced is None else "; from frame %d on with ModelReduction 2, before it %s" % (
            reduced + 1, times_of(frames[:reduced + 1]))))

    deformation.RelaxationPreset, deformation.ModelReduction = "Custom", "1"
    before = time.perf_counter()
    Render(view)
    print("  let go: %.0f ms until it is drawn as set" % (1e3 * (time.perf_counter() - before)), flush=True)
    Delete(view)


def size_of(source):
    extent = source.GetDataInformation().GetExtent()
    return [extent[2 * axis + 1] - extent[2 * axis] + 1 for axis in range(3)]


for path in sys.argv[1:] or ["forearm"]:
    measure(path)
    ResetSession()
print("load: %.1f %.1f %.1f" % os.getloadavg())
