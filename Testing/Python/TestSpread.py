"""An image whose parts are on several processes, divided in any way: outputs, field data, the report and the bodies are those
of one process that has all, to the bit. Random images (types, sizes, extents, NaN, several arrays, labels), tissue (joints,
regions, reduced models, rotations), probes, blades and padding, drawn from seeds.

Under mpiexec this file is the program: `pvbatch --sym TestSpread.py FIRST END`, with the seeds from FIRST to END - 1."""

import os
import sys

import harness
import numpy as np
from chainmail.ChainMailFilters import vtkChainMailDeformation, vtkChainMailRegionSource
from harness import require
from paraview.simple import *  # noqa: F401,F403: pvbatch is to load what it loads for others
from pieces import content, differs, processes
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPiecewiseFunction
from vtkmodules.vtkCommonExecutionModel import vtkTrivialProducer
from vtkmodules.vtkFiltersCore import vtkPassThrough
from vtkmodules.vtkFiltersSources import vtkPlaneSource, vtkSphereSource

PROCESSES = 3
AT_ONCE = "CHAINMAIL_VOXELS_AT_ONCE"  # how many voxels of a reduced model have a displacement at the same time
SEEDS = 24 if harness.EVERY else 4


def image_of(random):
    """A ball of tissue with bones, some air, and labels; its place and its types are random."""
    size = random.integers(14, 26, 3)
    k, j, i = np.meshgrid(*(np.linspace(-1, 1, n) for n in size[::-1]), indexing="ij")
    far = np.sqrt(i * i + j * j + k * k)
    values = np.where(far < 0.95, 40 + 60 * random.random(far.shape), 0)
    bones = (np.abs(i) < 0.7) & (np.abs(j) < 0.25) & (np.abs(k) < 0.25)
    values[bones] = 200
    labels = np.where(bones, np.where(i < random.uniform(-0.2, 0.2), 3, 7), 0)
    kind = random.choice([np.uint8, np.int16, np.float32, np.float64])
    values = values.astype(kind)
    if kind in (np.float32, np.float64):
        values[random.random(far.shape) < 0.01] = np.nan
    image = harness.make_image(values, spacing=[float(s) for s in random.uniform(0.7, 1.4, 3)], name="scan")
    harness.add_array(image, labels.astype(np.int32), "labels")
    constraints = random.uniform(0.1, 0.9, far.shape + (int(random.choice([1, 3])),))
    constraints[bones] = 0
    if random.random() < 0.15:
        constraints[(values == 200) & (random.random(far.shape) < 0.02)] = 1.5  # the same error everywhere
    harness.add_array(image, constraints.astype(np.float32), "constraints")
    harness.add_array(image, (1000 * random.random(far.shape + (3,)) - 300).astype(np.int16), "vectors")
    first = [int(n) for n in random.integers(-9, 9, 3)]
    image.SetExtent(*(e for a in range(3) for e in (first[a], first[a] + int(size[a]) - 1)))
    return image


def divided(extent, count, random):
    """Pieces of an extent that share planes, as VTK divides images, but anywhere."""
    if count == 1:
        return [extent]
    axes = [a for a in range(3) if extent[2 * a + 1] - extent[2 * a] >= 2]
    if not axes:
        return [extent] + [[0, -1] * 3] * (count - 1)
    axis = int(random.choice(axes))
    at = int(random.integers(extent[2 * axis] + 1, extent[2 * axis + 1]))
    low, high = list(extent), list(extent)
    low[2 * axis + 1] = high[2 * axis] = at
    half = int(random.integers(1, count))
    return divided(low, half, random) + divided(high, count - half, random)


def part_of(image, kind, random):
    """A producer of what this process has of the image."""
    rank, size = processes()
    whole = image.GetExtent()
    pieces = divided(list(whole), size, random)
    if kind in ("first has all", "let go"):
        pieces = [list(whole)] + [[0, -1] * 3] * (size - 1)
    elif kind == "all have all":
        pieces = [list(whole)] * size
    elif kind == "overlapping":
        pieces = [[e for a in range(3) for e in (max(p[2 * a] - 2, whole[2 * a]), min(p[2 * a + 1] + 1, whole[2 * a + 1]))]
                  for p in pieces]
    part = vtkImageData()
    part.DeepCopy(image)
    if pieces[rank][0] > pieces[rank][1]:
        part.Initialize()
    else:
        part.Crop(pieces[rank])
    producer = vtkTrivialProducer()
    producer.SetOutput(part)
    producer.SetWholeExtent(whole)
    if kind == "let go":
        # VTK frees the image after each update, and asks for it again before the next one.
        again = vtkPassThrough()
        again.SetInputConnection(producer.GetOutputPort())
        again.SetReleaseDataFlag(True)
        return again
    return producer


def filter_of(producer, random):
    """A filter with random properties, alike for alike random numbers."""
    filter = vtkChainMailDeformation()
    filter.SetInputConnection(producer.GetOutputPort())
    filter.SetInputArrayToProcess(0, 0, 0, 0, "scan")
    if random.random() < 0.7:
        filter.SetTissueThreshold(20.0)
        material = vtkPiecewiseFunction()
        for scalar, constraint in ((0.0, 0.45), (120.0, 0.2), (190.0, 0.0)):
            material.AddPoint(scalar, constraint)
        filter.SetMaterialFunction(material)
    if random.random() < 0.25:
        filter.SetConstraintArray("constraints")
    filter.SetMode(int(random.integers(0, 2)))
    filter.SetRotations(bool(random.random() < 0.3))
    if not filter.GetRotations() and random.random() < 0.3:
        filter.SetModelReduction(int(random.choice([2, 8])))
    elif random.random() < 0.5:
        filter.SetBodyArray(str(random.choice(["", "labels"])))
        filter.SetJointSize(int(random.choice([0, 2])))
        filter.SetJointConstraint(float(random.choice([0.5, 1.0])))
    filter.SetCoarseToFine(bool(random.random() < 0.5))
    filter.SetRelaxationIterations(int(random.integers(0, 12)))
    filter.SetOutputPadding(int(random.choice([0, 0, 3])))
    filter.SetSmoothCuts(bool(random.random() < 0.5))
    filter.SetPullBack(bool(random.random() < 0.5))
    filter.SetScalarSmoothing(float(random.choice([0.0, 0.8])))
    filter.SetOutputMagnification(int(random.choice([1, 1, 2])))
    filter.SetInterpolation(int(random.integers(0, 2)))
    filter.SetPropagationTimes(bool(random.random() < 0.4))
    for name in ("Constraint", "Cluster"):
        if random.random() < 0.5:
            filter.GetModelArraySelection().EnableArray(name)
    return filter


def surfaces(filter, image, random):
    centre, size = np.array(image.GetCenter()), np.array(image.GetLength()) / 4
    if random.random() < 0.25:
        region = vtkChainMailRegionSource()
        region.SetCenter(*(centre + size * random.uniform(-1, 1, 3)))
        region.SetRadius(float(0.5 * size))
        region.SetConstraint(float(random.choice([0.0, 0.7])))
        filter.SetRegionsConnection(region.GetOutputPort())
    if random.random() < 0.6:
        blade = vtkPlaneSource()
        corner = centre + size * random.uniform(-1, 0, 3)
        blade.SetOrigin(*corner)
        blade.SetPoint1(*(corner + size * np.array([0.1, 1.4, 0.1])))
        blade.SetPoint2(*(corner + size * np.array([0.2, 0.1, 1.5])))
        filter.SetCutsConnection(blade.GetOutputPort())
    if random.random() < 0.4:
        ball = vtkSphereSource()
        ball.SetCenter(*(centre + 0.4 * size * random.uniform(-1, 1, 3)))
        ball.SetRadius(float(0.4 * size))
        filter.SetCarvesConnection(ball.GetOutputPort())


def probes(image, filter, random):
    """Two probes: pulls, soft pulls, or poses of the tissue around a point or of the bones with a label."""
    centre, size = np.array(image.GetCenter()), image.GetLength() / 4
    places = centre + 0.4 * size * random.uniform(-1, 1, (2, 3))
    more = {}
    if random.random() < 0.3:
        more["Tolerance"] = random.uniform(0, 2, 2)
    elif filter.GetRotations() and random.random() < 0.6:
        more["Rotation"] = random.uniform(-20, 20, (2, 3))
        if filter.GetBodyArray():
            more["Body"] = [7, -1]
    return harness.make_points(places, Displacement=random.uniform(-0.5, 0.5, (2, 3)) * size,
                               Radius=[0.3 * size, 0.2 * size], **more)


def words(filter):
    """The report, without times and memory."""
    return [line for line in filter.GetReport().split("\n") if " MB on " not in line]


def play(seed):
    """The life of two filters: this process's part of one, and all of the other."""
    rank, size = processes()
    kinds = ["pieces"] * 5 + ["first has all", "all have all", "overlapping", "let go"]
    random = np.random.default_rng(seed)
    image = image_of(random)
    kind = str(random.choice(kinds))
    shared = part_of(image, kind, random)
    alone = vtkTrivialProducer()
    alone.SetOutput(image)
    # A generator for each, so that both draw the same numbers.
    filters = []
    for producer in (shared, alone):
        same = np.random.default_rng([seed, 1])
        filters.append(filter_of(producer, same))
        surfaces(filters[-1], image, same)
    mine, reference = filters
    reference.SetController(None)
    for step in range(3):
        points = probes(image, mine, random)
        for filter in filters:
            filter.SetInputDataObject(1, points)
        mine.UpdatePiece(rank, size, 0)
        reference.UpdatePiece(0, 1, 0)
        for port in range(2):
            part, whole = (content(filter.GetOutputDataObject(port)) for filter in filters)
            if "field 0 Error" in whole and not any(name.startswith("point") for name in part):
                part = {**whole, "field 0 Error": part["field 0 Error"]}  # its piece is in the padding that is not made then
            why = differs(part, whole)
            require(not why, "seed %d (%s), step %d, output %d, process %d: %s", seed, kind, step, port, rank, why)
        if rank == 0:
            require(words(mine) == words(reference), "seed %d (%s), step %d: '%s' and '%s'", seed, kind, step, words(mine),
                    words(reference))
        bodies, expected = vtkImageData(), vtkImageData()
        mine.CollectBodies()
        known = mine.GetBodies(bodies)
        is_known = reference.GetBodies(expected)
        require(known == (is_known and rank == 0), "seed %d: process %d knows the bodies: %s", seed, rank, known)
        for a in range(expected.GetPointData().GetNumberOfArrays() if known else 0):
            require(harness.same_bits(vtk_to_numpy(bodies.GetPointData().GetArray(a)),
                                      vtk_to_numpy(expected.GetPointData().GetArray(a))), "seed %d: bodies differ", seed)


def play_large():
    """A scan of more pages than the first process keeps: rows are read again of which it still has some."""
    rank, size = processes()
    shape = (90, 160, 330)
    k, j, i = np.meshgrid(*(np.arange(n) for n in shape), indexing="ij")
    image = harness.make_image((50 + (i * 7 + j * 5 + k * 3) % 60).astype(np.float32), spacing=[1.0] * 3, name="scan")
    filters = []
    for alone in (False, True):
        producer = part_of(image, "pieces", np.random.default_rng(1)) if not alone else vtkTrivialProducer()
        if alone:
            producer.SetOutput(image)
        filters.append(vtkChainMailDeformation())
        filters[-1].SetInputConnection(producer.GetOutputPort())
        filters[-1].SetTissueThreshold(20.0)
        filters[-1].GetModelArraySelection().EnableArray("Constraint")
    filters[1].SetController(None)
    for step in range(2):
        points = harness.make_points([[165.0, 80.0, 45.0]], Displacement=[[9.0, 5.0 * step, 2.0]], Radius=[5.0])
        for filter in filters:
            filter.SetInputDataObject(1, points)
        filters[0].UpdatePiece(rank, size, 0)
        filters[1].UpdatePiece(0, 1, 0)
        for port in range(2):
            why = differs(*(content(filter.GetOutputDataObject(port)) for filter in filters))
            require(not why, "a large scan, step %d, output %d, process %d: %s", step, port, rank, why)


def play_portions(reduction, kind):
    """A reduced model of which more moves than has a displacement at once: outputs are made in portions."""
    rank, size = processes()
    random = np.random.default_rng(reduction)
    k, j, i = np.meshgrid(*(np.linspace(-1, 1, n) for n in (104, 112, 160)), indexing="ij")
    far = np.sqrt(i * i + j * j + k * k)
    values = np.where((far < 0.95) & (random.random(far.shape) > 0.02), 50 + 60 * random.random(far.shape), 0)
    values[(np.abs(i) < 0.5) & (np.abs(j) < 0.06) & (np.abs(k - 0.2) < 0.06)] = 220
    image = harness.make_image(values.astype(np.uint8), spacing=[1.0, 1.0, 1.0], name="scan", first=(-5, 3, 40))
    material = vtkPiecewiseFunction()
    for scalar, constraint in ((0.0, 0.09), (130.0, 0.07), (200.0, 0.0)):
        material.AddPoint(scalar, constraint)
    ways = {"spread": "1300000", "in portions": "1300000", "at once": None}  # voxels at once, of 1,860,000
    filters = {}
    for way in ways:
        producer = part_of(image, kind, np.random.default_rng(1)) if way == "spread" else vtkTrivialProducer()
        if way != "spread":
            producer.SetOutput(image)
        filter = filters[way] = vtkChainMailDeformation()
        filter.SetInputConnection(producer.GetOutputPort())
        filter.SetTissueThreshold(20.0)
        filter.SetMaterialFunction(material)
        filter.SetAnchoredFaces(0, 0, 0, 0, 0, 0)
        filter.SetModelReduction(reduction)
        filter.SetRotations(reduction == 8)
        filter.SetRelaxationIterations(4)
        filter.SetMode(1 if reduction == 8 else 0)
        filter.SetPullBack(True)
        filter.SetScalarSmoothing(0.8)
        filter.SetOutputPadding(4)
        filter.SetOutputMagnification(2 if reduction == 8 else 1)
        filter.GetModelArraySelection().EnableArray("Displacement")
        surfaces(filter, image, np.random.default_rng(3))
    centre = np.array(image.GetCenter())
    # From rest, the third one moves little, so all is displaced at once again.
    pulls = [[4.0, 0.0, 2.0], [4.0, 3.0, 2.0], [0.1, 0.0, 0.2], [4.0, -3.0, 2.0]]
    for pull in pulls[:2] if reduction == 8 else pulls:
        points = harness.make_points([centre + [0, 0, 9]], Displacement=[pull], Radius=[9.0])
        for way, filter in filters.items():
            filter.SetInputDataObject(1, points)
            os.environ.pop(AT_ONCE, None)
            if ways[way]:
                os.environ[AT_ONCE] = ways[way]
            if way == "spread":
                filter.UpdatePiece(rank, size, 0)
            else:
                filter.SetController(None)
                filter.UpdatePiece(0, 1, 0)
        for way in list(ways)[:2]:
            for port in range(2):
                why = differs(*(content(filters[one].GetOutputDataObject(port)) for one in (way, "at once")))
                require(not why, "%s, reduced by %d (%s), a pull of %s, output %d, process %d: %s", way, reduction, kind, pull,
                        port, rank, why)


def main():
    play_portions(4, "pieces")
    play_portions(8, "pieces")
    play_portions(4, "first has all")
    play_portions(4, "let go")
    play_large()
    for seed in range(int(sys.argv[1]), int(sys.argv[2])):
        vtkChainMailDeformation.SetGlobalProbeWarnings(False)
        play(seed)


if len(sys.argv) > 1:
    main()
    harness.end_together()
else:
    harness.mpiexec(1, "")  # or skips
    harness.run_together(PROCESSES, __file__, "0", str(SEEDS), timeout=1500)
    print(SEEDS, "scenes")
