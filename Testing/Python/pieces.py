"""Scenes that are computed whole, in pieces and by several processes, for TestPieces.py and TestRanks.py.

Under mpiexec this file is the program: `pvbatch --sym pieces.py PLAN FOLDER`. Each process then updates its own piece of
every scene of the plan and writes what it got to the folder, for the test to compare with the whole."""

import json
import os
import sys

import chainmail.ChainMailFilters  # noqa: F401, so that GetClientSideObject() knows the class
import numpy as np
from harness import DATA, EVERY, scan
from paraview import servermanager
from paraview.simple import *
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.util.vtkConstants import VTK_FLOAT, VTK_SHORT, VTK_UNSIGNED_CHAR
from vtkmodules.vtkCommonDataModel import vtkDataObject
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline as pipeline
from vtkmodules.vtkIOImage import vtkMetaImageReader
from vtkmodules.vtkIOXML import vtkXMLImageDataReader
from vtkmodules.vtkParallelCore import vtkMultiProcessController

# What is measured, and so differs from update to update.
MEASURED = ("Milliseconds", "PeakDeviceMemory")
# Scans that are played in fewer formats.
LARGE = ("chest_lidc_ct", "head_vhf_ct")


def processes():
    """The number of this process, and how many there are."""
    controller = vtkMultiProcessController.GetGlobalController()
    return (controller.GetLocalProcessId(), controller.GetNumberOfProcesses()) if controller else (0, 1)


def write_formats(image, folder, name):
    """The image in all formats whose readers differ in what they give to a process; returns their paths. .vti and .pvti
    (here in parts of uneven size) can be read in pieces, .mhd and .nrrd only whole."""
    from vtkmodules.vtkIOImage import vtkMetaImageWriter
    from vtkmodules.vtkIOParallelXML import vtkXMLPImageDataWriter
    from vtkmodules.vtkIOXML import vtkXMLImageDataWriter
    paths = {kind: os.path.join(folder, "%s.%s" % (name, kind)) for kind in ("vti", "pvti", "mhd", "nrrd")}
    whole, parts, meta = vtkXMLImageDataWriter(), vtkXMLPImageDataWriter(), vtkMetaImageWriter()
    parts.SetNumberOfPieces(3)
    parts.SetEndPiece(2)
    for writer in (whole, parts):
        writer.SetDataModeToBinary()
    meta.SetRAWFileName(os.path.join(folder, name + ".raw"))
    meta.SetCompression(False)
    for writer, kind in ((whole, "vti"), (parts, "pvti"), (meta, "mhd")):
        writer.SetFileName(paths[kind])
        writer.SetInputDataObject(image)
        writer.Write()
    scalars = vtk_to_numpy(image.GetPointData().GetScalars())
    with open(paths["nrrd"], "wb") as file:
        lines = ["NRRD0004", "type: " + {"int16": "short", "uint8": "uchar", "float32": "float"}[scalars.dtype.name],
                 "dimension: 3", "sizes: %d %d %d" % image.GetDimensions(), "encoding: raw", "endian: little",
                 "space: left-posterior-superior",
                 "space directions: " + " ".join(str(tuple(np.eye(3)[a] * image.GetSpacing()[a])).replace(" ", "")
                                                 for a in range(3)),
                 "space origin: " + str(tuple(image.GetOrigin())).replace(" ", "")]
        file.write(("\n".join(lines) + "\n\n").encode() + scalars.tobytes())
    return paths


def scenes(folder):
    """Names and arguments of Scene: the forearm and a scan in some formats; with EVERY these and other scans in all."""
    sys.path.insert(0, DATA)
    from make_forearm import make_forearm
    images = {"forearm": make_forearm((66, 60, 78))}
    for name in ("abdomen_ct", "heart_cta") + LARGE if EVERY else ("abdomen_ct",):
        if scan(name):
            reader = OpenDataFile(scan(name))
            images[name] = servermanager.Fetch(reader)
            Delete(reader)
        else:
            print("not there, so not tested:", name)
    result = {}
    for name, image in images.items():
        paths = write_formats(image, folder, name)
        paths["raw"] = "raw of " + paths["mhd"]
        some = ("vti", "mhd") if name == "forearm" else ("pvti",)
        for kind in ("pvti", "raw") if name in LARGE else paths if EVERY else some:
            result["%s.%s" % (name, kind)] = [paths[kind], "CT (Hounsfield units)", -300.0, -1000.0]
    result["forearm in parts"] = ["parts of " + result["forearm.vti"][0], *result["forearm.vti"][1:]]
    return result


# Data of a process of its own: what a simulation, or a reader that looks at the process's number itself, gives.
PROBE_OF_LAST = """
import vtk
from vtkmodules.vtkParallelCore import vtkMultiProcessController
controller = vtkMultiProcessController.GetGlobalController()
last = not controller or controller.GetLocalProcessId() == controller.GetNumberOfProcesses() - 1
points, pull, radius = vtk.vtkPoints(), vtk.vtkDoubleArray(), vtk.vtkDoubleArray()
pull.SetName("Displacement")
pull.SetNumberOfComponents(3)
radius.SetName("Radius")
if last:
    points.InsertNextPoint(%s)
    pull.InsertNextTuple3(%s)
    radius.InsertNextValue(%r)
self.GetPolyDataOutput().SetPoints(points)
self.GetPolyDataOutput().GetPointData().AddArray(pull)
self.GetPolyDataOutput().GetPointData().AddArray(radius)
"""
# A closed surface, or a blade, of which each process has some of the triangles.
SURFACE_OF_ALL = """
import vtk
from vtkmodules.vtkParallelCore import vtkMultiProcessController
controller = vtkMultiProcessController.GetGlobalController()
rank, size = (controller.GetLocalProcessId(), controller.GetNumberOfProcesses()) if controller else (0, 1)
corners, triangles = %r, %r
points, cells = vtk.vtkPoints(), vtk.vtkCellArray()
points.SetDataTypeToDouble()
for p in corners:
    points.InsertNextPoint(p)
for t in triangles[rank::size]:
    cells.InsertNextCell(3)
    for p in t:
        cells.InsertCellPoint(p)
self.GetPolyDataOutput().SetPoints(points)
self.GetPolyDataOutput().SetPolys(cells)
"""


def part_of(path):
    """A source that has a part of the image in each process and nothing more, whatever is asked for: what a simulation
    gives that runs on all of them. The parts share a plane of voxels, and the last process has most."""
    reader = vtkXMLImageDataReader()
    reader.SetFileName(path)
    reader.Update()
    image = reader.GetOutput()
    whole = image.GetExtent()
    rank, size = processes()
    planes = [whole[4] + (whole[5] - whole[4]) * n * n // (size * size) for n in range(size + 1)]
    image.Crop(whole[:4] + tuple(planes[rank:rank + 2]))
    source = TrivialProducer()
    source.GetClientSideObject().SetOutput(image)
    source.GetClientSideObject().SetWholeExtent(whole)
    source.MarkModified(source)
    return source


def raw_of(path):
    """A reader of the raw file that a .mhd file describes, which reads the piece that it is asked for."""
    meta = vtkMetaImageReader()
    meta.SetFileName(path)
    meta.UpdateInformation()
    kind = {VTK_SHORT: "short", VTK_UNSIGNED_CHAR: "unsigned char", VTK_FLOAT: "float"}[meta.GetDataScalarType()]
    return ImageReader(FileNames=[os.path.splitext(path)[0] + ".raw"], DataScalarType=kind, DataByteOrder="LittleEndian",
                       DataExtent=meta.GetDataExtent(), DataSpacing=meta.GetDataSpacing(), DataOrigin=meta.GetDataOrigin())


def numbers(values):
    return ", ".join(repr(float(v)) for v in values)


def box(low, high):
    """A script for the surface of a box."""
    corners = [[(low, high)[n >> a & 1][a] for a in range(3)] for n in range(8)]
    faces = [(0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5)]
    return SURFACE_OF_ALL % (corners, [t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))])


def blade(low, high):
    """A script for a rectangle across x, in eight triangles."""
    y, z = (np.linspace(low[a], high[a], 3) for a in (1, 2))
    corners = [[low[0] + (high[0] - low[0]) * (j + k) / 4, y[j], z[k]] for k in range(3) for j in range(3)]
    squares = [(j + 3 * k, j + 1 + 3 * k, j + 4 + 3 * k, j + 3 + 3 * k) for k in range(2) for j in range(2)]
    return SURFACE_OF_ALL % (corners, [t for a, b, c, d in squares for t in ((a, b, c), (a, c, d))])


class Scene:
    """A pull with two probes, cuts and carves, of the tissue that is found in the middle of an image. The steps of a
    scene are updates of one filter; `show(name, filter)` is called after each."""

    def __init__(self, path, material, threshold, background):
        special = {"parts of ": part_of, "raw of ": raw_of}
        open_it = next((f for words, f in special.items() if path.startswith(words)), OpenDataFile)
        self.reader = open_it(path.split(" of ")[-1])
        self.reader.UpdatePipeline()
        bounds = np.reshape(self.place(), (2, 3))
        self.low, self.size = bounds[0], bounds[1] - bounds[0]
        unit = self.size.min()
        self.probe = ChainMailProbe(Position=self.at(0.5, 0.45, 0.5), Radius=0.06 * unit, Target=[
            float(p) for p in np.add(self.at(0.5, 0.45, 0.5), [0.07 * unit, -0.05 * unit, 0.04 * unit])])
        other = ProgrammableSource(Script=PROBE_OF_LAST % (
            numbers(self.at(0.38, 0.55, 0.45)), numbers([-0.05 * unit, 0.03 * unit, 0.0]), float(0.04 * unit)))
        ball = Sphere(Center=self.at(0.62, 0.52, 0.55), Radius=0.05 * unit, ThetaResolution=12, PhiResolution=9)
        hole = ProgrammableSource(Script=box(self.at(0.42, 0.42, 0.33), self.at(0.47, 0.48, 0.38)))
        slit = Plane(Origin=self.at(0.56, 0.2, 0.3), Point1=self.at(0.57, 0.6, 0.31), Point2=self.at(0.55, 0.21, 0.7))
        knife = ProgrammableSource(Script=blade(self.at(0.45, 0.3, 0.42), self.at(0.46, 0.58, 0.6)))
        self.filter = ChainMailDeformation(Input=self.reader, Probes=[self.probe, other], Cuts=[slit, knife],
                                           Carves=[ball, hole])
        # In every process as in one alone: those of --sym do not fit properties to the data.
        self.filter.MaterialPreset = material
        self.filter.TissueThreshold = threshold
        self.filter.BackgroundValue = background
        self.filter.MaterialFunction.Points = [threshold, 0.35, 0.5, 0, 10 * abs(threshold), 0.1, 0.5, 0]

    def place(self):
        """The corners of the whole image: a process may have a part of it."""
        info = self.reader.GetClientSideObject().GetOutputInformation(0)
        extent = np.reshape(info.Get(pipeline.WHOLE_EXTENT()), (3, 2))
        origin, spacing = np.array(info.Get(vtkDataObject.ORIGIN())), np.array(info.Get(vtkDataObject.SPACING()))
        return np.concatenate([origin + spacing * extent[:, 0], origin + spacing * extent[:, 1]])

    def at(self, x, y, z):
        return [float(p) for p in self.low + self.size * [x, y, z]]

    def play(self, show):
        filter, probe = self.filter, self.probe
        filter.CoarseToFine = 1
        filter.RelaxationIterations = 10
        show("from rest", filter)
        filter.OutputPadding = 3
        filter.CoarseToFine = 0
        filter.Mode = "Interactive"
        show("interactive", filter)
        filter.OutputMagnification = 2
        filter.UseOutputBounds = 1
        filter.OutputBounds = [b for pair in zip(self.at(0.2, 0.3, 0.1), self.at(0.7, 1.2, 0.6)) for b in pair]
        filter.ScalarSmoothing = 0.75
        show("finer, in part, smoothed", filter)
        filter.OutputMagnification = 1
        filter.UseOutputBounds = 0
        probe.Target = [2 * t - p for t, p in zip(probe.Target, probe.Position)]
        show("dragged", filter)
        filter.GetClientSideObject().Modified()
        filter.MarkModified(filter)
        show("settled on", filter)
        probe.Position = [float(p) for p in self.low - 10 * self.size]
        show("error", filter)
        probe.Position = self.at(0.5, 0.45, 0.5)
        show("mended", filter)
        filter.ModelArrays = ["Displacement", "Element", "Constraint", "Cluster"]
        filter.PullBack = 1
        filter.PropagationTimes = 1
        show("with all arrays", filter)
        filter.Mode = "FromRest"
        filter.ModelReduction = 2
        show("reduced", filter)
        filter.ModelReduction = 8
        show("reduced by 8", filter)


def content(image):
    """What has to be equal: a dict of numpy arrays."""
    result = {"extent": np.array(image.GetExtent()), "origin": np.array(image.GetOrigin()),
              "spacing": np.array(image.GetSpacing())}
    for a in range(image.GetPointData().GetNumberOfArrays()):
        array = image.GetPointData().GetArray(a)
        result["point %d %s" % (a, array.GetName())] = vtk_to_numpy(array)
    active = [image.GetPointData().GetAbstractAttribute(n) for n in range(2)]
    result["active"] = np.array([a.GetName() if a else "" for a in active])
    fields = image.GetFieldData()
    for a in range(fields.GetNumberOfArrays()):
        array = fields.GetAbstractArray(a)
        if array.GetName() in MEASURED:
            continue
        values = vtk_to_numpy(array) if fields.GetArray(a) else [array.GetValue(n) for n in range(array.GetNumberOfValues())]
        result["field %d %s" % (a, array.GetName())] = np.array(values)
    return result


def differs(part, whole):
    """Why a piece is not that of the whole, or None: its place, arrays, their order and types, bits, field data."""
    if list(part) != list(whole):
        return "it has %s, the whole %s" % (list(part), list(whole))
    low, high = np.reshape(part["extent"], (3, 2)).T
    first, last = np.reshape(whole["extent"], (3, 2)).T
    if (low > high).any():
        return None  # nothing for this process
    if (low < first).any() or (high > last).any():
        return "its extent is %s of %s" % (part["extent"], whole["extent"])
    cut = tuple(slice(a - f, b - f + 1) for a, b, f in zip(low, high, first))[::-1]
    for name, values in whole.items():
        if name.startswith("point"):
            values = values.reshape(tuple(last - first + 1)[::-1] + values.shape[1:])[cut]
            values = np.ascontiguousarray(values).reshape((-1,) + values.shape[3:])
        if name != "extent" and (values.dtype != part[name].dtype or values.tobytes() != part[name].tobytes()):
            return "%s differs" % name
    return None


def covers(parts, whole):
    """Whether the pieces are the whole image, each voxel's cell in one of them alone: planes of points are shared."""
    first, last = np.reshape(whole["extent"], (3, 2)).T
    count = np.zeros(last - first, int)
    for part in parts:
        low, high = np.reshape(part["extent"], (3, 2)).T
        if (low <= high).all():
            count[tuple(slice(a, b) for a, b in zip(low - first, high - first))] += 1
    return (count == 1).all()


def main(plan, folder):
    """One process of several."""
    rank, size = processes()
    with open(plan) as file:
        for name, arguments in json.load(file).items():
            def save(step, filter):
                filter.UpdatePipeline()
                for port in range(2):
                    output = filter.GetClientSideObject().GetOutputDataObject(port)
                    np.savez(os.path.join(folder, "%s %s %d %d of %d.npz" % (name, step, port, rank, size)),
                             **content(output))

            Scene(*arguments).play(save)
    # Whoever ends first must not take the others with it.
    vtkMultiProcessController.GetGlobalController().Barrier()


if __name__ == "__main__":
    main(*sys.argv[1:3])
