"""A lung at two breaths: landmarks that were not given are predicted, from others and from the lung's surface, better than by
what knows no mechanics. The data are masks of the lung and 51 pairs of landmarks in it, of elastix.

What was free to choose (material, radii, tolerances, rounds) was chosen on halves of the landmarks that are drawn by the seeds
TUNED; `pvpython TestLungs.py tune` shows what else they would have chosen. The results are those of the halves by the seeds REPORTED, which had no part in it;
and of the surface alone, which is given no landmark, with the same choice."""

import os
import random
import sys
import zlib

import numpy as np
from harness import EVERY, Reports, make_image, make_points, produce, require, skip
from paraview import servermanager
from paraview.simple import *
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkImagingCore import vtkImageCast
from vtkmodules.vtkImagingGeneral import vtkImageGaussianSmooth

TUNED = range(101, 107)
REPORTED = range(1, 7)
GIVEN = 25
FOLDER = os.path.join(os.environ.get("CHAINMAIL_VOLUMES", ""), "lung")
# Measured 3.797 mm by the surface alone; a shift of the centre alone has 4.65.
ALONE = (3.4, 3.88)
# Chosen on the halves TUNED.
CHOICE = dict(rotations=1, poisson=0.0, landmarks=(20.0, 20.0), surface=(8.0, 0.3), rounds=3)


def half(seed):
    """The landmarks that are given, and those that are predicted."""
    given = sorted(random.Random(seed).sample(range(51), GIVEN))
    return given, [n for n in range(51) if n not in given]


def places_of(proxy):
    proxy.UpdatePipeline()
    return vtk_to_numpy(servermanager.Fetch(proxy).GetPoints().GetData()).astype(float)


def by_radial_basis(rest, there, given):
    """How far off all landmarks end by the linear radial basis through the given ones, and a shift."""
    distance = np.linalg.norm(rest[:, None] - rest[given], axis=2)
    count = len(given)
    matrix = np.ones((count + 1, count + 1))
    matrix[:count, :count], matrix[count, count] = distance[given], 0.0
    weights = np.linalg.solve(matrix, np.vstack([(there - rest)[given], np.zeros((1, 3))]))
    return np.linalg.norm(rest + distance @ weights[:count] + weights[count] - there, axis=1)


def landmarks_of(name):
    return places_of(ChainMailLandmarkReader(FileName=os.path.join(FOLDER, "CT_3D_lung_%s_point_set_corrected.txt" % name)))


def mask_of(name):
    """The image, with air around it. ParaView 5.11's own reader ends by a signal on these compressed files."""
    with open(os.path.join(FOLDER, "3DCT_lung_%s_mask.mha" % name), "rb") as file:
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
    contour = Contour(Input=produce(smooth.GetOutput()), ContourBy=["POINTS", "mask"], Isosurfaces=[0.5], ComputeNormals=0)
    return Decimate(Input=contour, TargetReduction=0.8, PreserveTopology=1)


class Lung:
    """The lung at rest, its surface now and then, and the landmarks at both times."""

    def __init__(self, reduction=4):
        scan = mask_of("baseline")
        self.now = surface_of(scan)
        self.then = surface_of(mask_of("followup"))
        self.rest, self.there = landmarks_of("fixed"), landmarks_of("moving")
        # Soft tissue all over, which nothing holds: the shift of 35 mm costs nothing.
        self.deformation = ChainMailDeformation(Input=scan, MaterialPreset="Function", TissueThreshold=0.5, CoarseToFine=1,
                                                AnchoredFaces=[0] * 6, ModelReduction=reduction, RelaxationIterations=300)
        self.deformation.MaterialFunction.Points = [0, 0.4, 0.5, 0, 1, 0.4, 0.5, 0]
        self.reports = Reports(self.deformation)
        self.farthest = 0.0

    def carry(self, data):
        return ChainMailCarry(Input=data, Deformation=OutputPort(self.deformation, 1))

    def predict(self, given, rotations, poisson, landmarks, surface, rounds):
        """How far off all landmarks end [mm], by what is given: some of them, and the surface. Radii and tolerances."""
        self.deformation.Rotations, self.deformation.PoissonRatio = rotations, poisson
        probes, moved = [], None
        if given:
            known = ChainMailLandmarks(From=produce(make_points(self.rest[given])), To=produce(make_points(self.there[given])),
                                       Radius=landmarks[0], Tolerance=landmarks[1])
            probes = [known]
        for n in range(rounds + 1):
            if n > 0 or not given:
                motion = ChainMailSurfaceMotion(Before=self.now, After=self.then, Iterations=1, Smoothing=0, Spacing=8.0,
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
            errors = self.reports.take()
            require(not errors, "the filter reports\n%s", errors)
            if n < rounds:  # the surface as tissue took it along is matched again
                carried = self.carry(self.now)
                carried.UpdatePipeline()
                moved = produce(servermanager.Fetch(carried))
        ends = places_of(self.carry(produce(make_points(self.rest))))
        return np.linalg.norm(ends - self.there, axis=1)

    def halves(self, seeds, **choice):
        """The mean error of the predicted landmarks, for each half."""
        return [self.predict(half(seed)[0], **choice)[half(seed)[1]].mean() for seed in seeds]


if not os.path.isdir(FOLDER):
    skip("the scans of a lung at two breaths are not there: %s" % FOLDER)
lung = Lung()

if sys.argv[1:] == ["tune"]:
    choices = [CHOICE, dict(CHOICE, rotations=0), dict(CHOICE, poisson=0.2)]
    choices += [dict(CHOICE, landmarks=pair) for pair in ((10.0, 2.0), (15.0, 5.0), (20.0, 5.0))]
    choices += [dict(CHOICE, surface=pair) for pair in ((5.0, 1.0), (8.0, 0.5), (8.0, 10.0))]
    choices += [dict(CHOICE, rounds=n) for n in (1, 6)]
    for choice in choices:
        errors = lung.halves(TUNED, **choice)
        print("%.3f  %s  %s" % (np.mean(errors), choice, np.round(errors, 2)), flush=True)
    sys.exit()

print("landmarks go %.1f mm" % np.linalg.norm(lung.there - lung.rest, axis=1).mean())
alone = lung.predict([], **CHOICE).mean()
print("surface alone, all predicted: %.3f mm" % alone, flush=True)
seeds = REPORTED if EVERY else [REPORTED[0]]
errors = lung.halves(seeds, **CHOICE)
basis = [by_radial_basis(lung.rest, lung.there, half(seed)[0])[half(seed)[1]].mean() for seed in seeds]
print("%d given, %d predicted: mean %.3f mm of %s; by a radial basis %.3f" % (
    GIVEN, 51 - GIVEN, np.mean(errors), np.round(errors, 3), np.mean(basis)))
print("no point of the surface goes farther than %.1f mm" % lung.farthest)
require(35.0 < lung.farthest < 60.0, "points of the surface go up to %g mm", lung.farthest)
require(ALONE[0] < alone < ALONE[1], "the surface alone is off by %g mm", alone)
# Measured 2.082 of six halves, 2.245 of the first; the radial basis has 2.294 and 2.282.
require(1.8 < np.mean(errors) < (2.1 if EVERY else 2.27), "landmarks are off by %g mm", np.mean(errors))
require(np.mean(errors) < np.mean(basis), "no better than the radial basis: %g and %g mm", np.mean(errors), np.mean(basis))
