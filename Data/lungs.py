"""A lung at two breaths, as a scene: masks of the lung and 51 pairs of landmarks in it, of elastix.

The landmarks that are given and the lung's surface pull by soft probes; the other landmarks go along. make_gallery.py draws it,
Testing/Python/TestLungs.py measures it and says what was chosen how.
"""

import os
import random
import zlib

import numpy as np
import paraview.simple as pv
from paraview import servermanager
from scenes import make_image
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkImagingCore import vtkImageCast
from vtkmodules.vtkImagingGeneral import vtkImageGaussianSmooth

GIVEN = 25
CHOICE = dict(rotations=1, poisson=0.0, landmarks=(20.0, 20.0), surface=(8.0, 0.3), rounds=3)


def half(seed):
    """The landmarks that are given, and those that are predicted."""
    given = sorted(random.Random(seed).sample(range(51), GIVEN))
    return given, [n for n in range(51) if n not in given]


def by_radial_basis(rest, there, given):
    """Where the linear radial basis through the given landmarks, and a shift, takes all of them."""
    distance = np.linalg.norm(rest[:, None] - rest[given], axis=2)
    count = len(given)
    matrix = np.ones((count + 1, count + 1))
    matrix[:count, :count], matrix[count, count] = distance[given], 0.0
    weights = np.linalg.solve(matrix, np.vstack([(there - rest)[given], np.zeros((1, 3))]))
    return rest + distance @ weights[:count] + weights[count]


def produce(data):
    """A ParaView source with this data."""
    source = pv.TrivialProducer()
    source.GetClientSideObject().SetOutput(data)
    source.MarkModified(source)
    source.UpdatePipeline()
    return source


def points(places, **arrays):
    """A point set with point arrays, as a source."""
    data = vtkPolyData()
    data.SetPoints(vtkPoints())
    data.GetPoints().SetData(numpy_to_vtk(np.ascontiguousarray(places, dtype=float), deep=1))
    for name, values in arrays.items():
        array = numpy_to_vtk(np.ascontiguousarray(values, dtype=float), deep=1)
        array.SetName(name)
        data.GetPointData().AddArray(array)
    return produce(data)


def places_of(proxy):
    proxy.UpdatePipeline()
    return vtk_to_numpy(servermanager.Fetch(proxy).GetPoints().GetData()).astype(float)


def landmarks_of(folder, name):
    path = os.path.join(folder, "CT_3D_lung_%s_point_set_corrected.txt" % name)
    return places_of(pv.ChainMailLandmarkReader(FileName=path))


def mask_of(folder, name):
    """The image, with air around it. ParaView 5.11's own reader ends by a signal on these compressed files."""
    with open(os.path.join(folder, "3DCT_lung_%s_mask.mha" % name), "rb") as file:
        head, data = file.read().split(b"ElementDataFile = LOCAL\n", 1)
    header = dict(line.split(" = ", 1) for line in head.decode().splitlines())
    size, spacing, origin = (np.array(header[key].split(), float) for key in ("DimSize", "ElementSpacing", "Offset"))
    values = np.frombuffer(zlib.decompress(data), np.uint8).reshape(size[::-1].astype(int))
    return produce(make_image(np.pad(values, 3), "mask", spacing, origin - 3 * spacing))


def surface_of(mask):
    """Of a mask that is smoothed by a voxel, as its steps are no part of the lung."""
    smooth = vtkImageGaussianSmooth()
    smooth.SetStandardDeviations(1.0, 1.0, 0.5)
    cast = vtkImageCast()
    cast.SetInputData(servermanager.Fetch(mask))
    cast.SetOutputScalarTypeToFloat()
    smooth.SetInputConnection(cast.GetOutputPort())
    smooth.Update()
    contour = pv.Contour(Input=produce(smooth.GetOutput()), ContourBy=["POINTS", "mask"], Isosurfaces=[0.5], ComputeNormals=0)
    return pv.Decimate(Input=contour, TargetReduction=0.8, PreserveTopology=1)


class Lung:
    """The lung at rest, its surface now and then, and the landmarks at both times."""

    def __init__(self, folder, reduction=4):
        scan = mask_of(folder, "baseline")
        self.now = surface_of(scan)
        self.then = surface_of(mask_of(folder, "followup"))
        self.rest, self.there = landmarks_of(folder, "fixed"), landmarks_of(folder, "moving")
        # Soft tissue all over, which nothing holds: the shift of 35 mm costs nothing.
        self.deformation = pv.ChainMailDeformation(Input=scan, MaterialPreset="Function", TissueThreshold=0.5, CoarseToFine=1,
                                                   AnchoredFaces=[0] * 6, ModelReduction=reduction, RelaxationIterations=300)
        self.deformation.MaterialFunction.Points = [0, 0.4, 0.5, 0, 1, 0.4, 0.5, 0]
        self.farthest = 0.0

    def carry(self, data):
        return pv.ChainMailCarry(Input=data, Deformation=pv.OutputPort(self.deformation, 1))

    def predict(self, given, rotations, poisson, landmarks, surface, rounds, updated=lambda: None):
        """Where all landmarks end, by what is given: some of them, and the surface. Radii and tolerances. `updated` is called
        after each update."""
        self.deformation.Rotations, self.deformation.PoissonRatio = rotations, poisson
        probes, moved = [], None
        if given:
            probes = [pv.ChainMailLandmarks(From=points(self.rest[given]), To=points(self.there[given]), Radius=landmarks[0],
                                            Tolerance=landmarks[1])]
        for n in range(rounds + 1):
            if n > 0 or not given:
                motion = pv.ChainMailSurfaceMotion(Before=self.now, After=self.then, Iterations=1, Smoothing=0, Spacing=8.0,
                                                   Radius=surface[0], Tolerance=surface[1])
                if moved is not None:
                    motion.Start = moved
                motion.UpdatePipeline()
                ways = servermanager.Fetch(motion).GetPointData().GetArray("Displacement")
                self.farthest = max(self.farthest, float(np.linalg.norm(vtk_to_numpy(ways), axis=1).max()))
                self.deformation.Probes = probes + [motion]
            else:
                self.deformation.Probes = probes
            self.deformation.UpdatePipeline()
            updated()
            if n < rounds:  # the surface as tissue took it along is matched again
                carried = self.carry(self.now)
                carried.UpdatePipeline()
                moved = produce(servermanager.Fetch(carried))
        return places_of(self.carry(points(self.rest)))
