"""Surfaces before and after, and fields of displacements, as probes in ParaView: tissue follows them; fields that come in
pieces make the same probes on any number of processes."""

import os
import sys

import numpy as np
from harness import OUTPUT, Reports, add_array, field, make_image, points_of, produce, require, run_pvbatch, update
from paraview import servermanager
from paraview.simple import *

EXPECTED = os.path.join(OUTPUT, "TestSurfacesAndFields.npy")


def probes_in_pieces():
    """Places and displacements, in an order of their own."""
    motion = Calculator(Input=Wavelet(WholeExtent=[-10, 10, -8, 9, 0, 11]), ResultArrayName="Motion",
                        Function="coordsY*iHat+coordsZ*jHat+coordsX*kHat")
    probes = ChainMailFieldProbes(Input=motion, Mask=Wavelet(WholeExtent=[-6, 8, -20, 20, 2, 20]), Field="Motion",
                                  MaskMinimum=150, Spacing=2.0)
    probes.UpdatePipeline()
    made = servermanager.Fetch(probes)
    rows = np.hstack([np.array([made.GetPoint(n) for n in range(made.GetNumberOfPoints())]), points_of(made, "Displacement")])
    return rows[np.lexsort(rows.T)]


if len(sys.argv) > 1:
    rows, expected = probes_in_pieces(), np.load(EXPECTED)
    assert rows.tobytes() == expected.tobytes(), (rows.shape, expected.shape)
    sys.stdout.flush()
else:
    # A block of soft tissue in air, its field, and its surface.
    values = np.full((22, 24, 26), -1000, np.int16)
    values[4:18, 4:20, 4:22] = 100
    spacing, origin = np.array([1.5, 1.25, 2.0]), np.array([-20.0, 10.0, -300.0])
    image = make_image(values, "CT", spacing, origin)
    places = origin + spacing * np.argwhere(np.ones(values.shape))[:, ::-1].reshape(values.shape + (3,))
    ways = 0.02 * (places - places.mean(axis=(0, 1, 2))) + [0.5, -0.25, 0.0]
    add_array(image, ways.astype(np.float32), "Motion")
    scan = produce(image)
    probes = ChainMailFieldProbes(Input=scan, Mask=scan, Field="Motion", MaskArray="CT", MaskMinimum=0, Spacing=4.0)
    deformation = ChainMailDeformation(Input=scan, Probes=[probes], MaterialPreset="Function", TissueThreshold=0)
    deformation.Scalars = ["POINTS", "CT"]
    deformation.MaterialFunction.Points = [0, 0.3, 0.5, 0, 200, 0.3, 0.5, 0]
    reports = Reports(deformation, probes)
    volume, model = update(deformation, reports)
    made = servermanager.Fetch(probes)
    asked, reached = points_of(made, "Displacement"), field(volume, "ProbeReached")
    require(len(asked) > 100 and len(asked) == len(reached), "%d probes, %d answers", len(asked), len(reached))
    require(np.abs(reached - asked).max() < 1e-4, "the field is missed by %g mm", np.abs(reached - asked).max())
    probes.UpdatePropertyInformation()
    require("%d probes" % len(asked) in str(probes.Report), "the report: %s", probes.Report)

    # One mesh before and after: its probes find the tissue beside them.
    before = Sphere(Center=origin + spacing * [13, 12, 11], Radius=8.0, ThetaResolution=16, PhiResolution=12)
    after = Transform(Input=before, Transform="Transform")
    after.Transform.Translate = [0.75, 0.5, -0.25]
    surface = ChainMailSurfaceMotion(Before=before, After=after, Radius=2.0, Spacing=2.0)
    deformation.Probes = [surface]
    volume, model = update(deformation, reports)
    reached = field(volume, "ProbeReached")
    require(len(reached) > 50 and np.abs(reached - [0.75, 0.5, -0.25]).max() < 1e-4, "the surface reached %s", reached)
    surface.UpdatePropertyInformation()
    require("by the order of their points" in str(surface.Report), "the report: %s", surface.Report)

    # In pieces.
    rows = probes_in_pieces()
    require(len(rows) > 20 and np.abs(rows[:, 3:] - rows[:, [1, 2, 0]]).max() < 1e-12, "the field of %d places", len(rows))
    np.save(EXPECTED, rows)
    for processes in (2, 3):
        run_pvbatch(processes, os.path.abspath(__file__), "pieces")
    print("surfaces and fields are met")
