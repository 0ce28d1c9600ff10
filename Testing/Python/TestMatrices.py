"""Matrices of bones as probes: files of ITK's programs and tables move the bones of a scan, along its axes, both ways;
middles of bones are the same on any number of processes."""

import os
import sys

import numpy as np
from harness import OUTPUT, Reports, add_array, field, make_image, points_of, produce, require, run_pvbatch, update
from paraview import servermanager
from paraview.simple import *

MIDDLES = os.path.join(OUTPUT, "TestMatrices-middles.npy")
TABLE = os.path.join(OUTPUT, "TestMatrices-pieces.csv")


def write(name, text):
    path = os.path.join(OUTPUT, "TestMatrices-" + name)
    with open(path, "w") as file:
        file.write(text)
    return path


def middles_in_pieces():
    """Of a scan that comes in pieces, where processes are several, to the last bit."""
    labels = Calculator(Input=Wavelet(WholeExtent=[-10, 10, -8, 9, 0, 11]), ResultArrayName="label",
                        Function="floor((coordsX+10)/7+coordsZ/5)")
    poses = ChainMailMatrices(Input=ChainMailMatrixReader(FileName=TABLE), Labels=labels, LabelArray="label")
    poses.UpdatePipeline()
    made = servermanager.Fetch(poses)
    return points_of(made, "Centre"), points_of(made, "Displacement")


if len(sys.argv) > 1:
    centres, ways = middles_in_pieces()
    expected = np.load(MIDDLES)
    for n in range(0, len(centres), 3):  # each process has all
        assert centres[n:n + 3].tobytes() == expected.tobytes(), (centres, expected)
    sys.stdout.flush()
else:
    # Two bones in soft tissue.
    values = np.full((24, 26, 28), 100, np.int16)
    labels = np.zeros(values.shape, np.int16)
    for label, box in ((25, np.s_[4:9, 5:12, 4:10]), (26, np.s_[14:20, 12:20, 14:22])):
        values[box], labels[box] = 200, label
    spacing, origin = np.array([1.5, 1.25, 2.0]), np.array([-20.0, 10.0, -300.0])
    image = make_image(values, "CT", spacing, origin)
    add_array(image, labels, "bones")
    scan = produce(image)
    middles = {label: origin + spacing * np.argwhere(labels == label).mean(axis=0)[::-1] for label in (25, 26)}

    shifts = {25: [0.5, 0.25, 0.0], 26: [-0.25, 0.0, 0.5]}
    matrices = {label: np.eye(4) for label in shifts}
    for label, shift in shifts.items():
        matrices[label][:3, 3] = shift
    rows = "".join("%d,%s\n" % (label, ",".join(repr(float(x)) for x in m.ravel())) for label, m in matrices.items())
    names = "label," + ",".join("m%d%d" % (i, j) for i in range(4) for j in range(4)) + "\n"
    bones = ChainMailMatrixReader(FileName=write("bones.csv", names + rows))
    table = CSVReader(FileName=[write("table.csv", names + rows)])
    poses = ChainMailMatrices(Input=bones, Labels=scan, LabelArray="bones")
    deformation = ChainMailDeformation(Input=scan, Probes=[poses], MaterialPreset="Function", TissueThreshold=50,
                                       BodyArray="bones")
    deformation.MaterialFunction.Points = [100, 0.3, 0.5, 0, 200, 0, 0.5, 0]
    reports = Reports(deformation, poses, bones)
    for source in (bones, table):
        poses.Input = source
        for inverted in (0, 1):
            poses.Invert = inverted
            volume, model = update(deformation, reports)
            made = servermanager.Fetch(poses)
            sign = -1.0 if inverted else 1.0
            moved = points_of(model, "Displacement").reshape(labels.shape + (3,))
            for n, (label, shift) in enumerate(shifts.items()):
                require(np.abs(np.array(made.GetPoint(n)) - middles[label]).max() < 1e-9, "body %d is at %s, not %s", label,
                        made.GetPoint(n), middles[label])
                require(points_of(made, "Body")[n] == label, "the body is %s", points_of(made, "Body")[n])
                off = np.abs(moved[labels == label] - sign * np.array(shift)).max()
                require(off < 1e-5, "body %d is %g mm off its matrix", label, off)
    bones.UpdatePropertyInformation()
    require("2 matrices" in str(bones.Report), "the report: %s", bones.Report)

    # A transform of ITK of a scan whose axes go to the right and front: x and y of the shift, and the turn about x, change.
    itk = ChainMailMatrixReader(FileName=write("bone.tfm", "#Insight Transform File V1.0\n#Transform 0\nTransform: "
        "Euler3DTransform_double_3_3\nParameters: 0.1 0 0 1 2 3\nFixedParameters: 4 5 6 0\n"), Body=25,
        World="Right, front, head (RAS: NIfTI)")
    require(itk.Invert == 0 and itk.FileWorld == "As it says, else as the scan's", "defaults: %s %s", itk.Invert, itk.FileWorld)
    itk.UpdatePipeline()
    made = servermanager.Fetch(itk)
    for name, expected in (("Rotation", [-np.degrees(0.1), 0, 0]), ("Displacement", [-1, -2, 3]), ("Centre", [-4, -5, 6])):
        found = points_of(made, name)[0]
        require(np.abs(found - expected).max() < 1e-9, "%s is %s, not %s", name, found, expected)
    itk.UpdatePropertyInformation()
    require("the signs of x and y were changed" in str(itk.Report), "the report: %s", itk.Report)
    require(OpenDataFile(itk.FileName).GetXMLName() == "ChainMailMatrixReader", "a .tfm is opened by another reader")
    require(OpenDataFile(bones.FileName).GetXMLName() == "CSVReader", "a .csv is taken away from ParaView's own reader")

    # A matrix that stretches is an error; what was shown stays, and the next good one works.
    bad = matrices[26] * 1.0
    bad[1, 1] = 1.1
    poses.Input = wrong = ChainMailMatrixReader(FileName=write("wrong.csv", "26," + ",".join(map(str, bad.ravel()))))
    wrong_reports = Reports(wrong)
    wrong.UpdatePipeline()
    require("it scales or shears" in wrong_reports.take(), "no error for a matrix that stretches")
    poses.Input, poses.Invert = bones, 0
    reports.take()
    update(deformation, reports)
    reached = field(servermanager.Fetch(deformation), "ProbeReached")
    require(np.abs(reached - list(shifts.values())).max() < 1e-5, "after an error: %s", reached)

    # In pieces.
    write("pieces.csv", "".join("%d,%s\n" % (label, ",".join(map(str, np.eye(4).ravel()))) for label in (1, 2, 3)))
    centres, ways = middles_in_pieces()
    np.save(MIDDLES, centres)
    require(len(centres) == 3 and (np.abs(ways) < 1e-12).all(), "the identity moves: %s", ways)
    for processes in (2, 3):
        run_pvbatch(processes, os.path.abspath(__file__), "pieces")
    print("matrices are read, placed and met")
