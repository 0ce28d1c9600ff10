"""Draws the pictures of Gallery.md: the scenes of scenes.py, deformed by the plugin and shown by ParaView.

    export PV_PLUGIN_PATH=build/lib/paraview-5.11/plugins
    xvfb-run -a pvpython Data/make_gallery.py [--output Data/Images] [--volumes FOLDER] [NAME ...]

NAME: one or more of the functions that `pictures` below lists; default all. Pictures of scans are left out where
FOLDER (default: CHAINMAIL_VOLUMES) does not hold them.
"""

import argparse
import json
import math
import os
import struct
import sys
import zlib

import numpy as np
import paraview.simple as pv

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE)
import scenes  # noqa: E402
from paraview import servermanager  # noqa: E402
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy  # noqa: E402
from vtkmodules.vtkCommonCore import vtkPoints  # noqa: E402
from vtkmodules.vtkCommonDataModel import vtkPolyData  # noqa: E402

SCALE = 2  # pixels of a picture for each of a view: most are 1700 to 2600 pixels wide

WHITE, INK, SLATE = (1.0, 1.0, 1.0), (0.10, 0.12, 0.15), (0.93, 0.94, 0.96)
BLUE, GREEN = (0.05, 0.35, 0.75), (0.10, 0.60, 0.35)
# Perceptually even, dark to bright (Viridis); what no wave reached is grey.
TIMES = [(0.0, 0.267, 0.005, 0.329), (0.25, 0.229, 0.322, 0.546), (0.5, 0.128, 0.567, 0.551), (0.75, 0.369, 0.789, 0.383),
         (1.0, 0.993, 0.906, 0.144)]


def preset(name):
    """(value, red, green, blue) and (value, opacity) of one of the plugin's presets."""
    with open(os.path.join(HERE, os.pardir, "Plugin", "Presets.json"), encoding="utf-8") as file:
        found = next(entry for entry in json.load(file) if entry["Name"] == name)
    colours, opacities = (np.reshape(found.get(key, []), (-1, 4)).tolist() for key in ("RGBPoints", "Points"))
    return colours, [point[:2] for point in opacities]


SKIN_COLOURS, SKIN_OPACITIES = preset("CT skin")  # hides what is below it, so that a wound is seen
GREYS = preset("CT grey")[0]


# ----------------------------------------------------------------------------------------------------------------------
# Views and pixels


def shift(display, by):
    """Shows a thing elsewhere. ParaView calls that Translation from 5.13 on, and Position before."""
    setattr(display, "Translation" if "Translation" in display.ListProperties() else "Position", by)


class Panel:
    """One view, its things, and its pixels."""

    def __init__(self, width, height, background=SLATE):
        self.view = pv.CreateView("RenderView")
        self.view.ViewSize = [width, height]
        self.view.OrientationAxesVisibility = 0
        self.view.UseColorPaletteForBackground = 0
        self.view.Background = list(background)
        self.width, self.height = width, height

    def look(self, position, focus, up, angle=24.0):
        view = self.view
        view.KeyLightElevation, view.KeyLightAzimuth, view.KeyLightIntensity = 45, -22, 0.85
        view.FillLightKFRatio, view.BackLightKBRatio, view.HeadLightKHRatio = 2.2, 4.0, 6.0
        view.CameraPosition, view.CameraFocalPoint, view.CameraViewUp = list(position), list(focus), list(up)
        view.CameraViewAngle = angle
        return self

    def face(self, centre, height, side=1):
        """Straight at a slice, `height` [mm] from its lower to its upper edge: from z+ with y up, or, for scans whose y
        axis points backwards, from z- with y down."""
        view = self.view
        view.CameraParallelProjection, view.CameraParallelScale = 1, 0.5 * height
        view.CameraPosition, view.CameraFocalPoint = [centre[0], centre[1], centre[2] + 500.0 * side], list(centre)
        view.CameraViewUp = [0.0, float(side), 0.0]
        return self

    def show(self, source, kind=None, colour=None, **properties):
        display = pv.Show(source, self.view)
        if kind:
            display.SetRepresentationType(kind)
        if colour is not None:
            pv.ColorBy(display, ("POINTS", None))
            display.DiffuseColor = display.AmbientColor = list(colour)
        for name, value in properties.items():
            setattr(display, name, value)
        return display

    def coloured(self, source, name, colours, kind="Surface", **properties):
        """Shown in the colours of an array; `colours` as (value, red, green, blue)."""
        display = self.show(source, kind, **properties)
        pv.ColorBy(display, ("POINTS", name), True)  # with a table of its own
        table = pv.GetColorTransferFunction(name, display, True)
        table.ColorSpace = "RGB"
        table.RGBPoints = [float(number) for point in colours for number in point]
        display.SetScalarBarVisibility(self.view, False)
        return display, table

    def volume(self, source, name, colours, opacities, step, finer=1):
        """Drawn with shading, and without the grain that the edge of the skin has in a scan. `finer`: voxels for one of the
        scan along each axis."""
        smooth = pv.ChainMailSmooth(Input=source, StandardDeviation=0.6 * finer)
        display = pv.Show(smooth, self.view, "UniformGridRepresentation")
        display.SetRepresentationType("Volume")
        pv.ColorBy(display, ("POINTS", name))
        table, opacity = pv.GetColorTransferFunction(name), pv.GetOpacityTransferFunction(name)
        table.ColorSpace = "RGB"
        table.RGBPoints = [float(number) for point in colours for number in point]
        opacity.Points = [float(number) for value, alpha in opacities for number in (value, alpha, 0.5, 0.0)]
        display.Shade = 1
        display.Ambient, display.Diffuse, display.Specular, display.SpecularPower = 0.2, 0.9, 0.3, 30
        display.ScalarOpacityUnitDistance = step
        display.SetScalarBarVisibility(self.view, False)
        return display

    def title(self, text, colour=INK, place=(0.03, 0.91), size=15):
        display = pv.Show(pv.Text(Text=text), self.view)
        display.WindowLocation, display.Position = "Any Location", list(place)
        display.FontSize, display.Color, display.FontFamily = size, list(colour), "Arial"
        return self

    def bar(self, table, title, colour=INK, place=(0.86, 0.12), length=0.5, form="%.0f"):
        bar = pv.GetScalarBar(table, self.view)
        bar.Title, bar.ComponentTitle, bar.Visibility = title, "", 1
        bar.WindowLocation, bar.Position, bar.ScalarBarLength, bar.ScalarBarThickness = "Any Location", list(place), length, 10
        bar.TitleFontSize = bar.LabelFontSize = 12
        bar.TitleColor = bar.LabelColor = list(colour)
        if pv.GetParaViewVersion() >= (6, 1):
            form = form.replace("%", "{:") + "}"  # as std::format has it
        bar.AutomaticLabelFormat, bar.LabelFormat, bar.RangeLabelFormat = 0, form, form
        bar.HorizontalTitle = 1
        return self

    def pixels(self):
        """[row from above, column, rgb], averaged from twice the size, which is smoother and quieter."""
        pv.Render(self.view)
        window = self.view.CaptureWindow(2 * SCALE)
        columns, rows, _ = window.GetDimensions()
        fine = vtk_to_numpy(window.GetPointData().GetScalars()).reshape(rows, columns, -1)[::-1, :, :3].astype(float)
        pv.Delete(self.view)
        return fine.reshape(rows // 2, 2, columns // 2, 2, 3).mean(axis=(1, 3))


def palette(pixels, count=256):
    """The median cut (Heckbert 1982): colours [n, 3] and the index of each pixel."""
    keys, inverse, numbers = np.unique(
        (pixels.reshape(-1, 3) // 4).astype(np.int32) @ [4096, 64, 1], return_inverse=True, return_counts=True)
    colours = np.stack([keys // 4096, keys // 64 % 64, keys % 64], axis=1) * 4.0 + 2.0
    boxes = [np.arange(len(keys))]
    spread = [np.ptp(colours, axis=0).max() * numbers.sum() ** 0.3]
    while len(boxes) < min(count, len(keys)):
        number = int(np.argmax(spread))
        box = boxes.pop(number)
        spread.pop(number)
        box = box[np.argsort(colours[box, np.ptp(colours[box], axis=0).argmax()], kind="stable")]
        middle = np.searchsorted(np.cumsum(numbers[box]), 0.5 * numbers[box].sum())
        middle = min(max(1, middle), len(box) - 1)
        for part in (box[:middle], box[middle:]):
            boxes.append(part)
            spread.append(np.ptp(colours[part], axis=0).max() * numbers[part].sum() ** 0.3 if len(part) > 1 else -1.0)
    table, index = np.empty((len(boxes), 3)), np.empty(len(keys), np.uint8)
    for number, box in enumerate(boxes):
        table[number] = np.average(colours[box], axis=0, weights=numbers[box])
        index[box] = number
    return np.clip(np.rint(table), 0, 255).astype(np.uint8), index[inverse.ravel()].reshape(pixels.shape[:2])


def write(pixels, path):
    """A PNG of at most 256 colours: a third of the size, and nobody sees it."""
    table, index = palette(pixels)
    rows = b"".join(b"\0" + row.tobytes() for row in index)
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n")
        for kind, data in ((b"IHDR", struct.pack(">IIBBBBB", index.shape[1], index.shape[0], 8, 3, 0, 0, 0)),
                           (b"PLTE", table.tobytes()), (b"IDAT", zlib.compress(rows, 9)), (b"IEND", b"")):
            file.write(struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)))


def arrange(rows, gap=6 * SCALE):
    """Rows of panels, with white between them."""
    lines = []
    for panels in rows:
        line = [panels[0]]
        for panel in panels[1:]:
            line += [np.full((panel.shape[0], gap, 3), 255.0), panel]
        lines += [np.hstack(line), np.full((gap, sum(part.shape[1] for part in line), 3), 255.0)]
    return np.vstack(lines[:-1])


# ----------------------------------------------------------------------------------------------------------------------
# What the pictures share


def stretched(points, low, high):
    return [(low + t * (high - low), *colour) for t, *colour in points]


def grey_slice(panel, source, colours=GREYS, name="CT"):
    return panel.coloured(source, name, colours, "Slice")[0]


def time_map(panel, deformation, largest, title=None):
    """When the wave reached the elements, drawn at rest; tissue it did not reach is grey."""
    model = pv.OutputPort(deformation, 1)
    tissue = pv.Threshold(Input=model, Scalars=["POINTS", "Element"], LowerThreshold=0.5, UpperThreshold=1.5)
    panel.show(tissue, "Surface", (0.72, 0.74, 0.77), Ambient=1.0, Diffuse=0.0)
    reached = pv.Threshold(Input=model, Scalars=["POINTS", "PropagationTime"], LowerThreshold=-0.5,
                           UpperThreshold=1e30)
    display, table = panel.coloured(reached, "PropagationTime", stretched(TIMES, 0.0, largest), Ambient=1.0, Diffuse=0.0)
    shift(display, [0, 0, 1])
    if title:
        panel.bar(table, title)
    return panel


def line(panel, points, colour, radius):
    tube = pv.Tube(Input=pv.PolyLineSource(Points=[float(v) for p in points for v in p]), Radius=radius, NumberofSides=16,
                   Capping=1)
    panel.show(tube, "Surface", colour, Ambient=0.6, Diffuse=0.5)


def arrow(panel, start, drag, colour=BLUE, radius=0.8):
    start, drag = np.array(start, float), np.array(drag, float)
    length = np.linalg.norm(drag)
    end = start + drag
    tip = end - drag / length * 3.0 * radius
    line(panel, (start, tip), colour, radius)
    panel.show(pv.Sphere(Center=list(start), Radius=1.8 * radius, ThetaResolution=24, PhiResolution=24), "Surface", colour)
    panel.show(pv.Cone(Center=list(0.5 * (tip + end)), Direction=list(drag / length), Radius=2.4 * radius, Height=5 * radius,
                       Resolution=32), "Surface", colour)


def above(place, height=20.0):
    return np.array([place[0], place[1], place[2] + height])


def plan(panel, scene, radius=0.8):
    """What is going to happen in a slice: arrows, and the edge of the blade."""
    for probe in scene.probes:
        start, drag = np.array(probe["Position"]), np.subtract(probe["Target"], probe["Position"])
        if np.linalg.norm(drag) > 0:
            arrow(panel, above(start), drag, radius=radius)
    for a, b, _ in scene.cuts:
        line(panel, (above(a), above(b)), GREEN, 0.6 * radius)


def middle(image):
    bounds = np.reshape(image.GetBounds(), (3, 2))
    return bounds.mean(axis=1)


def update(scene):
    source, deformation = scenes.open_scene(scene)
    deformation.UpdatePipeline()
    return source, deformation


# ----------------------------------------------------------------------------------------------------------------------
# The pictures


def figure4(volumes):
    scene = scenes.three_elements()
    _, deformation = update(scene)
    panel = Panel(640, 230, WHITE).face((16, 0, 0), 34.0)
    model = pv.OutputPort(deformation, 1)
    colours = stretched(TIMES, -0.5, 5.0)
    for height, source in ((8.0, model), (-8.0, pv.WarpByVector(Input=model, Vectors=["POINTS", "Displacement"]))):
        balls = pv.Glyph(Input=source, GlyphType="Sphere", ScaleFactor=6.5, GlyphMode="All Points")
        balls.GlyphType.ThetaResolution = balls.GlyphType.PhiResolution = 48
        if height > 0:
            shift(panel.show(balls, "Surface", (0.70, 0.73, 0.78)), [0, height, 0])
        else:
            shift(panel.coloured(balls, "PropagationTime", colours)[0], [0, height, 0])
    for y, first, last in ((8, 0, 32), (-8, 8, 35.5)):
        line(panel, ((first, y, -6), (last, y, -6)), (0.45, 0.48, 0.52), 0.25)
    arrow(panel, (0, -8, 0), (4.4, 0, 0), radius=0.35)
    across = 34.0 * 640 / 230
    spot = lambda x, y: (0.5 + (x - 16) / across, 0.5 + y / 34.0)
    for x, text in ((5.2, "1.5 mm"), (22, "3 mm")):
        panel.title(text, place=spot(x, 9.2), size=13)
    for x, text in ((6.2, "0"), (21.3, "1.5"), (34.3, "4.5")):
        panel.title(text, place=spot(x, -14.6), size=13)
    panel.title("at rest", place=spot(-27, 7), size=13).title("moved by 8 mm", place=spot(-27, -9), size=13)
    panel.title("times of arrival", place=spot(-27, -14.6), size=13)
    return [[panel.pixels()]]


def elements(deformation, moved):
    """The elements as points with the model's arrays, where they are or where they were."""
    model = servermanager.Fetch(deformation, 0, idx=1)
    arrays = {model.GetPointData().GetArrayName(i): vtk_to_numpy(model.GetPointData().GetArray(i))
              for i in range(model.GetPointData().GetNumberOfArrays())}
    tissue = np.flatnonzero(arrays["Element"])
    places = np.array([model.GetPoint(i) for i in tissue])
    points = vtkPoints()
    points.SetData(numpy_to_vtk(places + arrays["Displacement"][tissue] if moved else places, deep=1))
    cloud = vtkPolyData()
    cloud.SetPoints(points)
    for name in ("Constraint", "PropagationTime"):
        scenes.add_array(cloud, arrays[name][tissue], name)
    scenes.add_array(cloud, np.linalg.norm(arrays["Displacement"][tissue], axis=1), "Moved")
    source = pv.TrivialProducer()
    source.GetClientSideObject().SetOutput(cloud)
    source.UpdatePipeline()
    return source


def boxes(source, size):
    return pv.Glyph(Input=source, GlyphType="Box", ScaleFactor=size, GlyphMode="All Points",
                    OrientationArray=["POINTS", "No orientation array"], ScaleArray=["POINTS", "No scale array"])


def figure5(volumes):
    scene = scenes.heterogeneous_ring()
    _, deformation = update(scene)
    centre, height = (11.0, 10.8, 0.0), 22.0
    panels = []
    for title in ("constraint", "time of arrival"):
        panel = Panel(420, 340, WHITE).face(centre, height)
        moved = title != "constraint"
        ghosts = panel.show(boxes(elements(deformation, False), 0.9), "Surface", (0.86, 0.87, 0.90), Ambient=1.0, Diffuse=0.0)
        shift(ghosts, [0, 0, -5])
        if moved:
            _, table = panel.coloured(boxes(elements(deformation, True), 0.86), "PropagationTime", stretched(TIMES, 0.0, 2.0),
                                      Ambient=1.0, Diffuse=0.0)
            panel.bar(table, "mm", place=(0.48, 0.25), length=0.4, form="%.1f")
            arrow(panel, (2, 18, 5), (2.5, 1.75, 0), radius=0.18)
        else:
            stiff = [(0.0, 0.25, 0.28, 0.33), (0.25, 0.93, 0.66, 0.36)]
            panel.coloured(boxes(elements(deformation, False), 0.86), "Constraint", stiff, Ambient=1.0, Diffuse=0.0)
            panel.title("elastic", place=(0.44, 0.72), size=13).title("rigid", place=(0.46, 0.19), size=13)
        panels.append(panel.title("material, at rest" if not moved else "time of arrival, moved", place=(0.03, 0.93),
                                  size=13).pixels())
    return [panels]


def figure6(volumes):
    size, height = (330, 280), 106.0
    top, bottom = [], []
    for label in ("rest", "homogeneous", "heterogeneous"):
        scene = scenes.compressed_slice(label != "homogeneous")
        source, deformation = update(scene)
        centre = middle(scene.image)
        centre[1] -= 2
        panel = Panel(*size, (0, 0, 0)).face(centre, height).title(label, WHITE, size=13)
        grey_slice(panel, source if label == "rest" else pv.OutputPort(deformation, 0))
        for probe in scene.probes:
            if label != "rest" and "Anchor" not in probe:
                probe = dict(probe, Position=probe["Target"])
            place, radius = np.array(probe["Position"]), probe["Radius"]
            side = math.copysign(1.0, place[1] - centre[1])
            angles = np.linspace(-0.55, 0.55, 41)
            arc = [above(place + [radius * math.sin(t), -side * (radius - 1) * math.cos(t), 0]) for t in angles]
            line(panel, arc, (0.35, 0.65, 1.0) if side > 0 else (0.6, 0.62, 0.66), 0.8)
        top.append(panel.pixels())
        panel = Panel(*size).face(centre, height)
        if label == "rest":
            tissue = pv.Threshold(Input=pv.OutputPort(deformation, 1), Scalars=["POINTS", "Element"], LowerThreshold=0.5,
                                  UpperThreshold=1.5)
            stiff = [(0.0, 0.25, 0.28, 0.33), (0.12, 0.62, 0.24, 0.20), (0.2, 0.85, 0.45, 0.30), (0.35, 0.98, 0.85, 0.55)]
            _, table = panel.coloured(tissue, "Constraint", stiff, Ambient=1.0, Diffuse=0.0)
            panel.title("constraint", size=13)
        else:
            time_map(panel, deformation, 9.0, "mm" if label == "heterogeneous" else None)
            panel.title("time of arrival", size=13)
        bottom.append(panel.pixels())
    return [top, bottom]


def figure7(volumes):
    size, height = (400, 330), 98.0
    top, bottom = [], []
    for cut in (False, True):
        scene = scenes.pulled_slice(cut)
        source, deformation = update(scene)
        centre = middle(scene.image)
        centre[:2] += (3, -5)
        panel = Panel(*size, (0, 0, 0)).face(centre, height).title("after a cut" if cut else "whole", WHITE, size=13)
        grey_slice(panel, pv.OutputPort(deformation, 0))
        probe = scene.probes[0]
        arrow(panel, above(probe["Position"]), np.subtract(probe["Target"], probe["Position"]), (0.35, 0.65, 1.0))
        top.append(panel.pixels())
        panel = Panel(*size).face(centre, height)
        time_map(panel, deformation, 9.0, "mm" if cut else None)
        for a, b, _ in scene.cuts:
            line(panel, (above(a), above(b)), GREEN, 0.5)
        bottom.append(panel.title("time of arrival", size=13).pixels())
    return [top, bottom]


def figure8(volumes):
    size, height = (330, 290), 100.0
    panels = []
    for label in ("two hooks and a blade", "pulled, whole", "pulled, cut"):
        scene = scenes.opened_slice(label != "pulled, whole")
        source, deformation = update(scene)
        centre = middle(scene.image)
        centre[:2] += (3, 6)
        panel = Panel(*size, (0, 0, 0)).face(centre, height).title(label, WHITE, size=13)
        resting = label.startswith("two")
        grey_slice(panel, source if resting else pv.OutputPort(deformation, 0))
        if resting:
            for probe in scene.probes:
                arrow(panel, above(probe["Position"]), np.subtract(probe["Target"], probe["Position"]), (0.35, 0.65, 1.0))
            for a, b, _ in scene.cuts:
                line(panel, (above(a), above(b)), (0.3, 0.9, 0.5), 0.5)
        panels.append(panel.pixels())
    return [panels]


def figure9(volumes):
    scene = scenes.probed_heart(volumes)
    source, deformation = update(scene)
    image, name = scene.image, "MetaImage"
    wall = scenes.place_of(image, scenes.HEART_WALL)
    colours = [(-1000, 0.4, 0.2, 0.2), (-300, 0.80, 0.55, 0.45), (-80, 0.98, 0.86, 0.58), (40, 0.80, 0.33, 0.28),
               (130, 0.72, 0.18, 0.16), (250, 0.90, 0.45, 0.38), (450, 0.98, 0.80, 0.72), (1200, 1.0, 1.0, 1.0)]
    # Blood is not shown: one looks into the chambers.
    opacities = [(-1000, 0.0), (-350, 0.0), (-100, 0.35), (20, 0.7), (130, 0.9), (180, 0.9), (250, 0.0), (3000, 0.0)]
    k = scenes.HEART_WALL[2]
    top, bottom = [], []
    for label, shown in (("at rest", source), ("probed from inside", pv.OutputPort(deformation, 0))):
        # The part of the heart below the probe's level, seen from above and from its left.
        extent = list(image.GetExtent())
        half = pv.ExtractSubset(Input=shown, VOI=[0, 84, 44, 107, 42, k])
        panel = Panel(440, 360, (0.90, 0.92, 0.95))
        focus = scenes.place_of(image, (42, 76, k - 6))
        panel.look(focus + np.array([-60.0, -120.0, 330.0]), focus, (0, 1, 0), 20.0)
        panel.volume(half, name, colours, opacities, 1.5)
        arrow(panel, np.array(scene.probes[0]["Position"]) + [0, 0, 2], np.subtract(scene.probes[0]["Target"],
              scene.probes[0]["Position"]), radius=1.2)
        top.append(panel.title(label, size=13).pixels())
        panel = Panel(440, 330, (0, 0, 0)).face(above(scenes.place_of(image, (46, 74, k)), 0), 140.0)
        flat = pv.ExtractSubset(Input=shown, VOI=extent[:4] + [k, k])
        grey = [(-1024, 0, 0, 0), (-300, 0.05, 0.05, 0.06), (0, 0.3, 0.3, 0.3), (120, 0.45, 0.44, 0.43), (500, 0.95, 0.94, 0.92)]
        grey_slice(panel, flat, grey, name)
        bottom.append(panel.pixels())
    return [top, bottom]


def figure10(volumes):
    scene = scenes.thin_ring()
    _, deformation = update(scene)
    panels = []
    for moved in (False, True):
        panel = Panel(360, 340, WHITE).face((-2, 0, 0), 94.0)
        if moved:
            ghost = panel.show(boxes(elements(deformation, False), 0.9), "Surface", (0.84, 0.86, 0.90), Ambient=1.0, Diffuse=0.0)
            shift(ghost, [0, 0, -5])
        colours = [(0.0, 0.25, 0.28, 0.33), (0.01, 0.25, 0.35, 0.60), (7.5, 0.90, 0.55, 0.30), (15.0, 0.80, 0.10, 0.15)]
        _, table = panel.coloured(boxes(elements(deformation, moved), 0.9), "Moved", colours, Ambient=1.0, Diffuse=0.0)
        if moved:
            panel.bar(table, "mm", place=(0.45, 0.28), length=0.42)
        else:
            arrow(panel, above(scene.probes[0]["Position"]), (15, 0, 0), radius=0.9)
        panels.append(panel.title("dented" if moved else "at rest", place=(0.03, 0.93), size=13).pixels())
    return [panels]


def opened(scene, name, colours, opacities, camera, flat, greys, out):
    """At rest with what is planned, opened, and a section of it."""
    source, deformation = update(scene)
    whole = pv.OutputPort(deformation, 0)
    panels = []
    for label, shown in (("two hooks and a blade", source), ("cut and opened", whole)):
        panel = Panel(400, 330, (0.86, 0.89, 0.93)).look(*camera)
        panel.volume(shown, name, colours, opacities, 1.0)
        if shown is source:
            for probe in scene.probes:
                # Above the skin, or they would not be seen.
                arrow(panel, np.add(probe["Position"], out), np.subtract(probe["Target"], probe["Position"]), radius=1.0)
            for a, b, c in scene.cuts:
                panel.show(pv.Plane(Origin=list(a), Point1=list(b), Point2=list(c)), "Surface", GREEN, Opacity=0.6, Ambient=0.4)
        panels.append(panel.title(label, place=(0.03, 0.04), size=13).pixels())
    voi, focus, height, side = flat
    panel = Panel(330, 330, (0, 0, 0)).face(focus, height, side)
    grey_slice(panel, pv.ExtractSubset(Input=whole, VOI=voi), greys, name)
    panels.append(panel.title("section", WHITE, place=(0.80, 0.04), size=13).pixels())
    return [panels]


def figure11(volumes):
    scene = scenes.opened_limb()
    image = scene.image
    focus = np.array(scene.cuts[0][0]) + [0, 14, 34]
    camera = focus + np.array([90.0, 330.0, 90.0]), focus, (1, 0, 0), 21.0
    k = int(np.abs(scenes.coordinates(image)[2].ravel() - scene.probes[0]["Position"][2]).argmin())
    flat = [0, 175, 0, 159, k, k], above(middle(image), 0) + np.array([2, 3, 0]), 96.0, 1
    return opened(scene, "CT", SKIN_COLOURS, SKIN_OPACITIES, camera, flat, GREYS, (0, 7, 0))


def figure11head(volumes):
    scene = scenes.opened_cheek(volumes)
    image = scene.image
    eight = lambda points: [((v + 1024) / 16.0, *rest) for v, *rest in points]  # as the scan's 8 bits
    focus = np.array(scene.cuts[0][0]) + [0, 0, 28]
    camera = focus + np.array([420.0, -60.0, 60.0]), focus, (0, 0, 1), 17.0
    k = scenes.CHEEK[1]
    flat = [0, 199, 0, 219, k, k], above(scenes.place_of(image, (135, 85, k)), 0), 130.0, -1
    return opened(scene, "MetaImage", eight(SKIN_COLOURS), eight(SKIN_OPACITIES), camera, flat, eight(GREYS), (10, 0, 0))


def wound(volumes):
    """The incision of figure 11 at close quarters, with the scan's voxels and with finer ones where it is."""
    scene = scenes.opened_limb()
    focus = np.array(scene.cuts[0][0]) + [0, 14, 34]
    source, deformation = scenes.open_scene(scene)
    deformation.UseOutputBounds = 1
    deformation.OutputBounds = [bound for place in focus for bound in (place - 30.0, place + 30.0)]
    panels = []
    for finer, label in ((1, "voxels of the scan"), (3, "OutputMagnification = 3")):
        deformation.OutputMagnification = finer
        panel = Panel(440, 300, (0.86, 0.89, 0.93)).look(focus + np.array([30.0, 330.0, 60.0]), focus, (1, 0, 0), 6.0)
        panel.volume(pv.OutputPort(deformation, 0), "CT", SKIN_COLOURS, SKIN_OPACITIES, 1.0, finer)
        panels.append(panel.title(label, place=(0.03, 0.04), size=13).pixels())
    return [panels]


def finger(volumes):
    """The same probe on the bone of a fingertip, with bones that slide and with bones that turn."""
    rows = [], []
    for rotations, label in ((None, "at rest"), (0, "Rotations off"), (1, "Rotations on")):
        scene = scenes.bent_finger(rotations or 0)
        source, deformation = update(scene)
        shown = source if rotations is None else pv.OutputPort(deformation, 0)
        focus = middle(scene.image) + np.array([-4, 0, 2])
        panel = Panel(330, 190, (0.86, 0.89, 0.93)).look(focus + np.array([30.0, -260.0, 60.0]), focus, (0, 0, 1), 13.0)
        panel.volume(shown, "CT", SKIN_COLOURS, SKIN_OPACITIES, 1.0)
        rows[0].append(panel.title(label, place=(0.03, 0.04), size=13).pixels())
        flat = Panel(330, 150, (0, 0, 0))
        j = scene.image.GetDimensions()[1] // 2
        flat.view.CameraParallelProjection, flat.view.CameraParallelScale = 1, 26.0
        flat.view.CameraPosition, flat.view.CameraFocalPoint = list(focus + np.array([0, -500.0, 0])), list(focus)
        flat.view.CameraViewUp = [0.0, 0.0, 1.0]
        dims = scene.image.GetDimensions()
        grey_slice(flat, pv.ExtractSubset(Input=shown, VOI=[0, dims[0] - 1, j, j, 0, dims[2] - 1]))
        rows[1].append(flat.pixels())
    return list(rows)


def before_and_after(scene, name, looks, camera, size):
    """A scene at rest and deformed, in a row for each look: colours and opacities."""
    source, deformation = update(scene)
    rows = [[] for _ in looks]
    for shown, label in ((source, "at rest"), (pv.OutputPort(deformation, 0), "posed")):
        for row, (colours, opacities) in zip(rows, looks):
            panel = Panel(*size, (0.86, 0.89, 0.93)).look(*camera)
            panel.volume(shown, name, colours, opacities, 1.0)
            row.append(panel.title(label, place=(0.03, 0.04), size=13).pixels())
    return rows


def hand(volumes):
    """A finger that two poses bend: the skin, and the bones alone."""
    scene = scenes.posed_hand()
    focus = middle(scene.image) + np.array([2.0, 0.0, -12.0])
    camera = focus + np.array([260.0, -330.0, 250.0]), focus, (0, 0, 1), 20.0
    return before_and_after(scene, "CT", [(SKIN_COLOURS, SKIN_OPACITIES), preset("CT bone")], camera, (430, 300))


def jaw(volumes):
    """A jaw that a pose opens: the skin, and the bones alone."""
    eight = lambda points: [((v + 1024) / 16.0, *rest) for v, *rest in points]  # as the scan's 8 bits
    scene = scenes.posed_jaw(volumes)
    focus = middle(scene.image) + np.array([0, 0, -12])
    camera = focus + np.array([600.0, -520.0, 40.0]), focus, (0, 0, 1), 19.0
    looks = [[eight(points) for points in preset(name)] for name in ("CT skin", "CT bone")]
    return before_and_after(scene, "MetaImage", looks, camera, (430, 430))


def chin(volumes):
    """A chin that a saw has freed and a pose moves forward: the skin, the bones alone, and a section."""
    eight = lambda points: [((v + 1024) / 16.0, *rest) for v, *rest in points]  # as the scan's 8 bits
    scene = scenes.advanced_chin(volumes)
    focus = middle(scene.image) + np.array([0, -40, -60])
    camera = focus + np.array([430.0, -520.0, 40.0]), focus, (0, 0, 1), 13.0
    looks = [[eight(points) for points in preset(name)] for name in ("CT skin", "CT bone")]
    return before_and_after(scene, "MetaImage", looks, camera, (430, 380))


def spine(volumes):
    """Vertebrae that bend to the side, each by a pose of its own: the bones alone, and a section."""
    colours, opacities = preset("CT bone")
    scene = scenes.bent_spine(volumes)
    source, deformation = update(scene)
    rows = [], []
    for shown, label in ((source, "at rest"), (pv.OutputPort(deformation, 0), "posed")):
        focus = middle(scene.image) + np.array([0, 0, 20])
        panel = Panel(430, 400, (0.86, 0.89, 0.93)).look(focus + np.array([0.0, 1100.0, 80.0]), focus, (0, 0, 1), 18.0)
        panel.volume(shown, "MetaImage", colours, opacities, 3.0)
        rows[0].append(panel.title(label, place=(0.03, 0.04), size=13).pixels())
        flat = Panel(430, 330, (0, 0, 0))
        flat.view.CameraParallelProjection, flat.view.CameraParallelScale = 1, 165.0
        flat.view.CameraPosition, flat.view.CameraFocalPoint = list(focus + np.array([0, 900.0, 0])), list(focus)
        flat.view.CameraViewUp = [0.0, 0.0, 1.0]
        dims, j = scene.image.GetDimensions(), 38
        grey_slice(flat, pv.ExtractSubset(Input=shown, VOI=[0, dims[0] - 1, j, j, 0, dims[2] - 1]), name="MetaImage")
        rows[1].append(flat.pixels())
    return list(rows)


def breathing(volumes):
    """Lungs at two breaths. At the first, landmarks with the way that each goes; at the second, those that were not given,
    where they are predicted, in the colour of how far that is off: by tissue, and by a radial basis."""
    import lungs

    lung = lungs.Lung(os.path.join(volumes, "lung"))
    given, others = lungs.half(1)
    predicted = lung.predict(given, **lungs.CHOICE)
    basis = lungs.by_radial_basis(lung.rest, lung.there, given)
    carried = lung.carry(lung.now)
    scale = [(0.0, 0.2, 0.55, 0.3), (2.0, 0.95, 0.8, 0.25), (5.0, 0.75, 0.1, 0.1)]
    panels = []
    for title, surface, places in (("first breath", lung.now, None), ("second, by tissue", carried, predicted),
                                   ("second, by a radial basis", lung.then, basis)):
        focus = (lung.rest if places is None else lung.there).mean(axis=0)
        panel = Panel(430, 400, (0.94, 0.95, 0.97)).look(focus + np.array([0.0, -900.0, 60.0]), focus, (0, 0, 1), 20.0)
        panel.show(surface, "Surface", (0.85, 0.6, 0.55), Opacity=0.18)
        if places is None:
            for n, (start, end) in enumerate(zip(lung.rest, lung.there)):
                arrow(panel, start, end - start, BLUE if n in given else (0.35, 0.35, 0.38), 1.6)
        else:
            off = np.linalg.norm(places - lung.there, axis=1)[others]
            dots = pv.Glyph(Input=lungs.points(places[others], off=off), GlyphType="Sphere", ScaleArray=["POINTS", "No scale array"],
                            ScaleFactor=9.0, GlyphMode="All Points")
            table = panel.coloured(dots, "off", scale)[1]
            panel.bar(table, "off [mm]")
            title += ": %.1f mm" % off.mean()
        panels.append(panel.title(title, place=(0.03, 0.03), size=13).pixels())
    return [panels]


def strip(scene, focus, camera, size, angle):
    """An animation: key frames of the probes' targets, and a frame of the result at each quarter of the way."""
    source, deformation = scenes.open_scene(scene)
    for probe in deformation.Probes:
        for axis in range(3):
            ends = probe.Position[axis], probe.Target[axis]
            track = pv.GetAnimationTrack("Target", index=axis, proxy=probe)
            track.KeyFrames = [pv.CompositeKeyFrame(KeyTime=time, KeyValues=[end], Interpolation="Ramp")
                               for time, end in enumerate(ends)]
    animation = pv.GetAnimationScene()
    animation.PlayMode, animation.StartTime, animation.EndTime = "Sequence", 0.0, 1.0
    panels = []
    for time in (0.0, 0.25, 0.5, 0.75, 1.0):
        animation.AnimationTime = time
        panel = Panel(*size, (0.86, 0.89, 0.93)).look(focus + np.array(camera), focus, (0, 0, 1), angle)
        panel.volume(pv.OutputPort(deformation, 0), "CT", SKIN_COLOURS, SKIN_OPACITIES, 1.0)
        panels.append(panel.title("%.2f" % time, place=(0.05, 0.03), size=13).pixels())
    return [panels]


def film(volumes):
    """The hooks of figure 11."""
    scene = scenes.opened_limb()
    return strip(scene, np.array(scene.cuts[0][0]) + [0, 14, 34], (60.0, 330.0, 60.0), (210, 250), 19.0)


def bend(volumes):
    """The finger, whose bones turn."""
    scene = scenes.bent_finger(1)
    return strip(scene, middle(scene.image) + np.array([-4, 0, 2]), (30.0, -260.0, 60.0), (210, 150), 15.5)


pictures = [figure4, figure5, figure6, figure7, figure8, figure9, figure10, figure11, figure11head, wound, finger, bend, hand, jaw, chin, spine, breathing, film]
needs = {"figure9": "heart_cta.mhd", "figure11head": "head_vhf_ct.mhd", "jaw": "head_vhf_ct.mhd", "chin": "head_vhf_ct.mhd", "spine": "abdomen_labels.mhd", "breathing": "lung/3DCT_lung_baseline_mask.mha"}


def file_of(name):
    return ("paper-%s.png" if name.startswith("figure") else "%s.png") % name


def main(arguments):
    parser = argparse.ArgumentParser(description="Draws the pictures of Data/Gallery.md.")
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(p.__name__ for p in pictures))
    parser.add_argument("--output", default=os.path.join(HERE, "Images"), metavar="DIR", help="default: Data/Images")
    parser.add_argument("--volumes", default=os.environ.get("CHAINMAIL_VOLUMES", ""), metavar="DIR", help="folder of the scans")
    options = parser.parse_args(arguments)
    pv._DisableFirstRenderCameraReset()
    os.makedirs(options.output, exist_ok=True)
    for picture in pictures:
        name = picture.__name__
        if options.names and name not in options.names:
            continue
        if name in needs and not os.path.isfile(os.path.join(options.volumes, needs[name])):
            print("%s: there is no %s in '%s'" % (name, needs[name], options.volumes))
            continue
        path = os.path.join(options.output, file_of(name))
        write(arrange(picture(options.volumes)), path)
        print("%s: %d kB" % (path, os.path.getsize(path) // 1000), flush=True)
        for proxy in reversed(list(pv.GetSources().values())):
            pv.Delete(proxy)


if __name__ == "__main__":
    main(sys.argv[1:])
