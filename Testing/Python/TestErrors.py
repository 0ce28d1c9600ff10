"""Bad input gives one message that says what is wrong and what to do, and the next good input works again."""

import numpy as np
from harness import (Reports, add_array, expect_error, field, make_image, points_of, produce, require, same_bits, update)
from paraview.simple import *
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPolyData

rng = np.random.default_rng(4)
values = rng.uniform(0, 100, (12, 14, 16)).astype(np.float32)
values[:, :, :3] = -500  # air at x-
values[:, :, 3:] += 20
image = make_image(values)
add_array(image, np.full(values.shape, 0.2), "good fractions")
add_array(image, np.full(values.shape, 1.2), "too large")
add_array(image, np.full(values.shape, -0.1), "negative")
add_array(image, np.full(values.shape + (2,), 0.2), "two components")
add_array(image, np.full(values.shape, np.nan), "not a number")
image.GetPointData().SetActiveScalars("scalars")
good_source = produce(image)

CENTRE = [9.0, 7.0, 6.0]
good_probe = ChainMailProbe(Position=CENTRE, Target=[9.5, 6.5, 6.25])
deformation = ChainMailDeformation(Input=good_source, Probes=[good_probe], TissueThreshold=0.0)
good_points = [0.0, 0.3, 0.5, 0.0, 120.0, 0.1, 0.5, 0.0]
deformation.MaterialFunction.Points = good_points
reports = Reports(deformation)
good_volume, good_model = update(deformation, reports)
require(points_of(good_model, "Displacement").any(), "the good scene moves nothing")


def recovers(what):
    volume, model = update(deformation, reports)
    require(same_bits(points_of(volume, "scalars"), points_of(good_volume, "scalars")) and
            same_bits(points_of(model, "Displacement"), points_of(good_model, "Displacement")),
            "after '%s' the good scene gives something else", what)
    print(what, flush=True)


def probes(place, **arrays):
    """A source of probes with the given point arrays."""
    data = vtkPolyData()
    points = vtkPoints()
    points.SetData(numpy_to_vtk(np.atleast_2d(np.array(place, float)), deep=1))
    data.SetPoints(points)
    for name, numbers in arrays.items():
        array = numpy_to_vtk(np.array(numbers, float), deep=1)
        array.SetName(name)
        data.GetPointData().AddArray(array)
    return produce(data)


GOOD = {"Device": "", "TissueThreshold": 0.0, "ConstraintArray": "", "LabelArrays": [], "Scalars": ["POINTS", "scalars"]}

# Properties: (what, name, bad value, what the message has to say).
for what, name, bad, parts in (
        ("unknown device", "Device", "no such card", ["no such card", "This machine has", "empty"]),
        ("threshold above all scalars", "TissueThreshold", 1e6, ["all air", " 1000000.", "Lower TissueThreshold"]),
        ("threshold above all numbers", "TissueThreshold", 1e30, ["all air", " 1e+30."]),
        ("unknown constraint array", "ConstraintArray", "nowhere", ["nowhere", "good fractions"]),
        ("constraint array of two components", "ConstraintArray", "two components", ["2 components", "1", "3"]),
        ("constraint array above 1", "ConstraintArray", "too large", ["1.2", "less than 1"]),
        ("constraint array below 0", "ConstraintArray", "negative", ["-0.1", "from 0"]),
        ("constraint array of NaN", "ConstraintArray", "not a number", ["nan", "less than 1"]),
        ("unknown label array", "LabelArrays", ["missing labels"], ["missing labels", "scalars"]),
        ("unknown scalars", "Scalars", ["POINTS", "density"], ["density", "scalars"])):
    setattr(deformation, name, bad)
    expect_error(deformation, reports, *parts)
    setattr(deformation, name, GOOD[name])
    recovers(what)

for what, y in (("material function that reaches 1", 1.0), ("material function below 0", -0.01)):
    deformation.MaterialFunction.Points = good_points[:4] + [120.0, y, 0.5, 0.0]
    expect_error(deformation, reports, "MaterialFunction", "%g" % y)
    deformation.MaterialFunction.Points = good_points
    recovers(what)

# Brick sizes outside what the property documents.
deformation.BrickSize = [5, 4, 4]
expect_error(deformation, reports, "5")
deformation.BrickSize = [0, 0, 0]
recovers("brick size that is no power of two")

# Probes.
air = ChainMailProbe(registrationName="lost probe", Position=[1.0, 7.0, 6.0], Target=[2.0, 7.0, 6.0])
outside = ChainMailProbe(Position=[90.0, 7.0, 6.0], Target=[91.0, 7.0, 6.0])
for what, bad, parts in (
        ("probe in air", [good_probe, air], ["Probes input 1", "no tissue", "radius"]),
        ("probe outside the image", [outside], ["Probes input 0", "no tissue"]),
        ("probe without Displacement", [probes(CENTRE)], ["Displacement", "Probes input 0"]),
        ("Displacement of two components", [probes(CENTRE, Displacement=[[1, 2]])], ["Displacement", "3 numbers"]),
        ("Displacement that is not finite", [probes(CENTRE, Displacement=[[1, np.nan, 0]])], ["nan", "finite"]),
        ("second point of a probe set", [probes([CENTRE, [1, 7, 6]], Displacement=np.zeros((2, 3)))], ["point 1", "no tissue"]),
        ("negative Radius", [probes(CENTRE, Displacement=[[1, 0, 0]], Radius=[-1])], ["radius", "-1"]),
        ("Radius that is not finite", [probes(CENTRE, Displacement=[[1, 0, 0]], Radius=[np.inf])], ["radius"])):
    deformation.Probes = bad
    expect_error(deformation, reports, *parts)
    deformation.Probes = [good_probe]
    recovers(what)

# In the air, but tissue is within its radius: the probe holds that.
deformation.Probes = [ChainMailProbe(Position=[1.5, 7.0, 6.0], Target=[1.75, 7.0, 6.0], Radius=2.0)]
volume, _ = update(deformation, reports)
require(0 < field(volume, "ProbeReached")[0, 0] <= 0.25, "a probe near tissue reached %s", field(volume, "ProbeReached"))
deformation.Probes = [good_probe]
recovers("probe in air near tissue is none")

# Cuts: a point that is nowhere.
blade = vtkPolyData()
points = vtkPoints()
for point in ([0, 0, 6.5], [20, 0, 6.5], [0, np.inf, 6.5]):
    points.InsertNextPoint(point)
blade.SetPoints(points)
blade.Allocate(1)
blade.InsertNextCell(5, 3, [0, 1, 2])
deformation.Cuts = [produce(blade)]
expect_error(deformation, reports, "Cuts input 0", "finite")
deformation.Cuts = []
recovers("cut through a point that is not finite")

# Carves: a surface that is not closed has no inside.
deformation.Carves = [Sphere(Center=CENTRE, Radius=2), Plane(Origin=[6, 0, 0], Point1=[6, 9, 0], Point2=[6, 0, 9])]
expect_error(deformation, reports, "Carves input 1", "not closed")
deformation.Carves = []
recovers("carving with an open surface")

# Images. (The material is the good one: its array has the same name.)
empty = vtkImageData()
nameless = vtkImageData()
nameless.SetDimensions(4, 4, 4)
for what, bad, parts in (
        ("empty image", empty, ["empty"]),
        ("image without scalars", nameless, ["no point array", "scalars"]),
        ("image of NaN", make_image(np.full((5, 5, 5), np.nan)), ["all air", "finite"])):
    deformation.Input = produce(bad)
    expect_error(deformation, reports, *parts)
    deformation.Input = good_source
    deformation.Scalars = ["POINTS", "scalars"]
    recovers(what)

# A new filter, whose material nothing could be fitted to, says the same.
fresh = ChainMailDeformation(Input=produce(make_image(np.full((5, 5, 5), np.nan))))
expect_error(fresh, Reports(fresh), "all air", "finite")

# A few scalars that are not finite are air; it is said once.
holes = values.copy()
holes[3, 5, 8], holes[4, 5, 8], holes[5, 5, 8] = np.nan, np.inf, -np.inf
del reports.warnings[:]
deformation.Input = produce(make_image(holes))
volume, model = update(deformation, reports)
element = points_of(model, "Element").reshape(holes.shape)
require(not element[3:6, 5, 8].any() and element[6, 5, 8] == 1, "scalars that are not finite are taken for tissue")
require(len(reports.warnings) == 1 and "3" in reports.warnings[0], "3 scalars are not finite; the warnings are: %s",
        reports.warnings)
deformation.RelaxationIterations = 3
update(deformation, reports)
require(len(reports.warnings) == 1, "the warning comes again: %s", reports.warnings)
deformation.RelaxationIterations = 40
deformation.Input = good_source
recovers("some scalars are not finite")
