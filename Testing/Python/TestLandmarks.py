"""Landmarks of other programs pull at a scan: files as 3D Slicer and elastix write them are read along the scan's axes,
paired, and met by the tissue; lists of mixed axes are seen; states keep all of it. Real landmarks of two breaths, too."""

import json
import os
import sys

import numpy as np
from harness import OUTPUT, Reports, expect_error, field, make_image, points_of, produce, require, run_pvpython, update
from paraview import servermanager
from paraview.simple import *

STATE = os.path.join(OUTPUT, "TestLandmarks.pvsm")
TURN = np.array([-1.0, -1.0, 1.0])  # from LPS to RAS and back


def write(name, text):
    path = os.path.join(OUTPUT, "TestLandmarks-" + name)
    with open(path, "w", newline="") as file:
        file.write(text)
    return path


def rows(points, separator):
    return "".join(separator.join(repr(float(x)) for x in point) + "\n" for point in points)


def write_markups(name, points, axes, labels):
    return write(name, json.dumps({"markups": [{"type": "Fiducial", "coordinateSystem": axes, "coordinateUnits": "mm",
        "controlPoints": [{"label": label, "position": list(point), "positionStatus": "defined"}
                          for label, point in zip(labels, points)]}]}))


def write_fcsv(name, points, axes, labels):
    return write(name, "# Markups fiducial file version = 4.11\n# CoordinateSystem = %s\n# columns = id,x,y,z,ow,ox,oy,oz,"
                 "vis,sel,lock,label,desc,associatedNodeID\n" % axes + "".join(
                     "%s,%r,%r,%r,0,0,0,1,1,1,0,%s,,\n" % (n, *map(float, point), label)
                     for n, (point, label) in enumerate(zip(points, labels))))


def report_of(proxy):
    proxy.UpdatePipelineInformation()
    proxy.UpdatePropertyInformation()
    return str(proxy.GetPropertyValue("Report"))


def reached_of(deformation, reports):
    return field(update(deformation, reports)[0], "ProbeReached")


if len(sys.argv) > 1:
    LoadState(sys.argv[1])
    deformation = FindSource("deformation")
    require(np.abs(reached_of(deformation, Reports(deformation)) - np.load(sys.argv[2])).max() == 0, "another result")
    require("axes RAS, from the file; the scan has LPS (World)" in report_of(FindSource("there")), "the report after a state")
    print("the state came back")
    sys.exit()

# A scan of soft tissue with four landmarks in it, and where they go.
scan = produce(make_image(np.full((24, 26, 28), 100, np.int16), spacing=(1.5, 1.25, 2.0), origin=(-20.0, 10.0, -300.0)))
rest = np.array([[-10.0, 20.0, -290.0], [5.0, 22.0, -280.0], [-5.0, 32.0, -270.0], [8.0, 30.0, -285.0]])
ways = np.array([[0.5, 0.0, 0.25], [0.0, -0.5, 0.0], [0.25, 0.5, -0.5], [0.0, 0.0, 0.5]])
there = rest + ways
names = ["A", "B", "C", "D"]

# Every format, and both ways the axes may go, of the file and of the scan.
files = {
    "lps.mrk.json": write_markups("there-lps.mrk.json", there, "LPS", names),
    "ras.mrk.json": write_markups("there-ras.mrk.json", there * TURN, "RAS", names),
    "lps.fcsv": write_fcsv("there-lps.fcsv", there, "LPS", names),
    "ras.fcsv": write_fcsv("there-ras.fcsv", there * TURN, "0", names),
    "txt": write("there.txt", "point\n4\n" + rows(there, " ")),
    "csv": write("there.csv", "label,l,p,s\n" + "".join("%s,%r,%r,%r\n" % (n, *map(float, p)) for n, p in zip(names, there))),
}
first = ChainMailLandmarkReader(FileName=write("rest.txt", "point\n4\n" + rows(rest, " ")))
probes, reports = None, None
for name, path in files.items():
    second = ChainMailLandmarkReader(FileName=path)
    if probes is None:
        probes = ChainMailLandmarks(From=first, To=second)
        deformation = ChainMailDeformation(Input=scan, Probes=[probes], MaterialPreset="Function", TissueThreshold=50)
        deformation.MaterialFunction.Points = [0, 0.3, 0.5, 0, 200, 0.3, 0.5, 0]
        reports = Reports(deformation, probes)
    probes.To = second
    for world in (0, 1):
        first.World = second.World = world
        probes.UpdatePipeline()
        made = servermanager.Fetch(probes)
        turn = TURN if world else 1.0
        expected = rest * turn, ways * turn
        found = np.array([made.GetPoint(n) for n in range(4)]), points_of(made, "Displacement")
        for what, one, other in zip(("places", "ways"), found, expected):
            require(np.abs(one - other).max() < 1e-12, "%s, world %d: %s are\n%s", name, world, what, one)
        require(("RAS" if "ras" in name else "LPS") in report_of(second).split(";")[1], "%s: %s", name, report_of(second))
    first.World = second.World = 0
    reached = reached_of(deformation, reports)
    require(np.abs(reached - ways).max() < 1e-5, "%s: the landmarks reached\n%s", name, reached)
require("4 pairs" in report_of(probes), "the report: %s", report_of(probes))

# Axes mixed up: the file says nothing and the user has it wrong. It is seen, in a warning.
mixed = ChainMailLandmarkReader(FileName=write("silent.csv", rows(there * TURN, ",")))
probes.To = mixed
probes.UpdatePipeline()
require(any("LPS axes" in text for text in reports.warnings), "no warning of mixed axes: %s", reports.warnings)
mixed.FileWorld = "Right, front, head (RAS)"
require(np.abs(reached_of(deformation, reports) - ways).max() < 1e-5, "put right")

# An error leaves the last good result, and the next good input works.
short = ChainMailLandmarkReader(FileName=write("short.csv", rows(there[:3], ",")))
probes.To = short
probes_reports = Reports(probes)
probes.UpdatePipeline()
require("From has 4 landmarks and To has 3" in probes_reports.take(), "unequal lists")
probes.To = mixed
reports.take()
require(np.abs(reached_of(deformation, reports) - ways).max() < 1e-5, "after an error")

# By label, in another order.
order = [2, 0, 3, 1]
shuffled = ChainMailLandmarkReader(FileName=write_markups("shuffled.mrk.json", there[order] * TURN, "RAS", [names[n] for n in order]))
labelled = ChainMailLandmarkReader(FileName=write_markups("rest.mrk.json", rest, "LPS", names))
probes.From, probes.To, probes.MatchLabels = labelled, shuffled, 1
require(np.abs(reached_of(deformation, reports) - ways).max() < 1e-5, "by label")

# ParaView's own table of pairs.
pairs = CSVReader(FileName=[write("pairs.csv", "x1,y1,z1,x2,y2,z2\n" + rows(np.hstack([rest, there]), ","))])
table = ChainMailLandmarks(From=pairs)
deformation.Probes = [table]
require(np.abs(reached_of(deformation, reports) - ways).max() < 1e-5, "a table of pairs")
deformation.Probes = [probes]

# Files are opened by name; a table that is no list of landmarks is not taken away from ParaView's own reader.
for name, path in files.items():
    opened = OpenDataFile(path)
    if not path.endswith((".csv", ".txt")):
        require(opened.GetXMLName() == "ChainMailLandmarkReader", "%s is opened by %s", path, opened.GetXMLName())
for text in ("a,b\n1,2\n", "x,y,z\n1,2,3\n"):
    opened = OpenDataFile(write("plain.csv", text))
    require(opened.GetXMLName() == "CSVReader", "a .csv is opened by %s", opened.GetXMLName())

# A state.
RenameSource("there", shuffled)
deformation = ChainMailDeformation(Input=Wavelet(WholeExtent=[-20, 20, 0, 40, -300, -260]), Probes=[probes],
                                   TissueThreshold=-1000)
RenameSource("deformation", deformation)
expected = reached_of(deformation, Reports(deformation))
require(np.abs(expected).max() > 0.2, "nothing moves")
np.save(STATE + ".npy", expected)
SaveState(STATE)
status, text = run_pvpython(os.path.abspath(__file__), STATE, STATE + ".npy")
require(status == 0, "the state:\n%s", text)
print(text.strip().splitlines()[-1])

# Two breaths of a patient, by 51 landmarks in LPS. They go 35.3 mm, as the data's description says.
folder = os.path.join(os.environ.get("CHAINMAIL_VOLUMES", ""), "lung")
points = [os.path.join(folder, "CT_3D_lung_%s_point_set_corrected.txt" % name) for name in ("fixed", "moving")]
if all(os.path.isfile(path) for path in points):
    lung = ChainMailLandmarks(From=ChainMailLandmarkReader(FileName=points[0]),
                              To=ChainMailLandmarkReader(FileName=points[1]), Tolerance=2.0)
    quiet = Reports(lung)
    lung.UpdatePipeline()
    made = servermanager.Fetch(lung)
    length = np.linalg.norm(points_of(made, "Displacement"), axis=1)
    require(made.GetNumberOfPoints() == 51 and abs(length.mean() - 35.3) < 0.05, "%d landmarks go %g mm",
            made.GetNumberOfPoints(), length.mean())
    require(not quiet.take() and not quiet.warnings, "the lungs: %s", quiet.warnings)
    require((points_of(made, "Tolerance") == 2.0).all(), "the tolerance")
    print(report_of(lung).strip())
print("landmarks are read, paired and met")
