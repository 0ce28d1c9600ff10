"""checkFirstLook.py write SCAN INTO hu|bytes: the scan as it is, or in 8 bits, (HU + 1024) / 16.
checkFirstLook.py check FOLDER hu|bytes LOOK: the states and the picture that TestFirstLook.sh saved."""

import json
import os
import sys
import xml.etree.ElementTree as ElementTree

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkIOImage import vtkPNGReader
from vtkmodules.vtkIOXML import vtkXMLImageDataReader, vtkXMLImageDataWriter


def read(reader, path):
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput()


def write(scan, into, scale):
    image = read(vtkXMLImageDataReader(), scan)
    if scale == "bytes":
        scalars = image.GetPointData().GetScalars()
        values = np.clip((vtk_to_numpy(scalars).astype(float) + 1024) / 16, 0, 255).astype(np.uint8)
        stored = numpy_to_vtk(values, deep=1)
        stored.SetName(scalars.GetName())
        image.GetPointData().SetScalars(stored)
    writer = vtkXMLImageDataWriter()
    writer.SetFileName(into)
    writer.SetInputData(image)
    writer.Write()


def numbers(proxy, name):
    found = proxy.find("Property[@name='%s']" % name)
    return [] if found is None else [float(element.get("value")) for element in found.findall("Element")]


def look(state):
    """Of the volume that a saved state shows: colours, opacities, shading, the array; and the camera."""
    proxies = list(ElementTree.parse(state).iter("Proxy"))
    by_id = {proxy.get("id"): proxy for proxy in proxies}
    for proxy in proxies:
        kind = proxy.find("Property[@name='Representation']/Element")
        visible = numbers(proxy, "Visibility")
        if kind is not None and kind.get("value") == "Volume" and visible == [1.0]:
            table, function = (
                by_id[proxy.find("Property[@name='%s']/Proxy" % name).get("value")]
                for name in ("LookupTable", "ScalarOpacityFunction")
            )
            shade = numbers(proxy, "Shade")
            shown = proxy.findall("Property[@name='ColorArrayName']/Element")[4].get("value")
    view = next(proxy for proxy in proxies if proxy.get("type") == "RenderView")
    way = np.subtract(numbers(view, "CameraFocalPoint"), numbers(view, "CameraPosition"))
    return table, function, shade, shown, way / np.linalg.norm(way), numbers(view, "CameraViewUp")


def check(folder, scale, chosen):
    def require(holds, *what):
        if not holds:
            sys.exit("FAILED: %s: %s" % (scale, " ".join(map(str, what))))

    here = os.path.dirname(os.path.abspath(__file__))
    with open(os.path.join(here, "../../Plugin/Presets.json"), encoding="utf-8") as file:
        presets = {preset["Name"]: preset for preset in json.load(file)}
    scan = vtk_to_numpy(read(vtkXMLImageDataReader(), os.path.join(folder, "scan.vti")).GetPointData().GetScalars())
    first = "CT skin" if scale == "hu" else "MR T1"
    for state, name in (("grabbed", first), ("chosen", chosen)):
        table, function, shade, shown, way, up = look(os.path.join(folder, state + ".pvsm"))
        for proxy, values in ((table, "RGBPoints"), (function, "Points")):
            points = np.reshape(numbers(proxy, values), (-1, 4))
            expected = np.reshape(presets[name][values], (-1, 4)).astype(float)
            require(points.shape == expected.shape and np.allclose(points[:, 1:], expected[:, 1:]), state, values, points)
            places = points[:, 0]
            if scale == "bytes":
                # From air, the darkest peak, to the brightest voxels but one in a thousand, each to a byte.
                ends = np.median(scan[scan < 15]), np.quantile(scan, 0.999)
                require(abs(places[0] - ends[0]) <= 2 and abs(places[-1] - ends[1]) <= 4, state, "ends", places, ends)
                places = (places - places[0]) / (places[-1] - places[0])
            require(np.allclose(places, expected[:, 0], atol=1e-6), state, values, places)
        require(numbers(table, "AutomaticRescaleRangeMode") == [-1.0], "the next scan would rescale the look")
        require(shade == [1.0], "not shaded")
        require(shown == "CT smooth", state, "shows", shown)
        require(abs(abs(way[1]) - 1) < 1e-6 and np.allclose(up, (0, 0, 1)), "seen from", way, up)
    pixels = vtk_to_numpy(read(vtkPNGReader(), os.path.join(folder, "grabbed.png")).GetPointData().GetScalars()).astype(int)
    skin = ((pixels[:, 0] > pixels[:, 1] + 10) & (pixels[:, 1] > pixels[:, 2] + 5)).mean()
    require(0.02 < skin < 0.9, "%.1f %% of the picture has the colour of skin" % (100 * skin))
    print("%s: %s, then %s, from the front; %.0f %% of the picture is skin" % (scale, first, chosen, 100 * skin))


{"write": write, "check": check}[sys.argv[1]](*sys.argv[2:])
