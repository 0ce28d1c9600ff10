"""Key frames of a probe, as the Animation View sets them, and a series of scans: from rest a frame depends on its time alone,
whatever was shown before; in Interactive mode going to a time is a drag from where the tissue is. The tissue is a bar along x
with links of one length, where every result has a closed form."""

import os

import numpy as np
from harness import OUTPUT, Reports, field, make_image, points_of, produce, require, same_bits, update
from paraview import servermanager
from paraview.simple import *
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
from vtkmodules.vtkIOXML import vtkXMLImageDataWriter

LENGTH, LIMIT, SPACING = 40, 0.25, 2.0  # a quarter of a spacing of 2 mm: half a millimetre a link
GRIPPED = 20  # the element at 40 mm


def bar(first=10):
    return make_image(np.arange(first, first + LENGTH, dtype=np.int16).reshape(1, 1, LENGTH), spacing=(SPACING, 1, 1))


def deform(source, **properties):
    """The bar, held at its low end: 20 links before the probe, which goes no further than 10 mm to the right."""
    probe = ChainMailProbe(Position=[40, 0, 0], Target=[40, 0, 0])
    deformation = ChainMailDeformation(Input=source, Probes=[probe], TissueThreshold=0, AnchoredFaces=[1, 0, 0, 0, 0, 0],
                                       RelaxationIterations=0, **properties)
    deformation.MaterialFunction.Points = [0, LIMIT, 0.5, 0, 100, LIMIT, 0.5, 0]
    return deformation, probe, Reports(deformation)


def key_frames(proxy, name, *values):
    """What the Animation View calls the x component of a property goes through values, evenly over the time from 0 to 1."""
    track = GetAnimationTrack(name, index=0, proxy=proxy)
    frames = [CompositeKeyFrame(KeyTime=i / (len(values) - 1), KeyValues=[value], Interpolation="Ramp")
              for i, value in enumerate(values)]
    track.KeyFrames = frames
    return track


def at(time, deformation, reports):
    """The displacements along x and the volume at a time of the animation."""
    scene.AnimationTime = time
    volume, model = update(deformation, reports)
    return points_of(model, "Displacement")[:, 0].astype(float), volume


def from_rest(target, gripped=GRIPPED):
    """What a pull gives tissue that was at rest."""
    slack = LIMIT * SPACING * np.abs(np.arange(LENGTH) - gripped)
    pull = min(target - SPACING * gripped, LIMIT * SPACING * gripped)
    return np.clip(0, pull - slack, pull + slack)


scene = GetAnimationScene()
scene.PlayMode = "Sequence"
scene.StartTime, scene.EndTime, scene.NumberOfFrames = 0, 1, 8
times = np.linspace(0, 1, 8)

# Target, from rest: the probe is asked for 0 to 14 mm and gets 10.
deformation, probe, reports = deform(produce(bar()))
track = key_frames(probe, "Target", 40, 54)
shown = {}
for time in [*times, *times[::-1], *times[::3]]:
    moved, volume = at(time, deformation, reports)
    require(np.allclose(probe.Target[0], 40 + 14 * time), "at %g the target is %s", time, probe.Target)
    require(np.allclose(moved, from_rest(40 + 14 * time), atol=1e-5), "at %g:\n%s", time, moved)
    bits = points_of(volume, "scalars").tobytes()
    require(shown.setdefault(time, bits) == bits, "at %g the frame depends on what was shown before", time)
require(len(set(shown.values())) == 6, "of 8 frames, of which the last three are alike, %d differ", len(set(shown.values())))

# Frames that are alike, as the pull is at its limit, are explained.
for time, words in ((times[2], "Probe 1 reached 4 of 4 mm."),
                    (times[6], "Probe 1 reached 10 of 12 mm: held by the face x- of the scan."),
                    (times[7], "Probe 1 reached 10 of 14 mm: held by the face x- of the scan.")):
    at(time, deformation, reports)
    deformation.UpdatePropertyInformation()
    require(words in deformation.Report, "at %g the report is\n%s", time, deformation.Report)

# Interactive: each frame drags on from the one before, and going back drags back. What an earlier frame moved and this one
# does not ask for stays.
deformation.Mode = "Interactive"
expected = np.zeros(LENGTH)
slack = LIMIT * SPACING * np.abs(np.arange(LENGTH) - GRIPPED)
for time in [*times, 0.5, 0.0]:
    pull = min(14 * time, 10)
    expected = np.clip(expected, pull - slack, pull + slack)
    moved, _ = at(time, deformation, reports)
    require(np.allclose(moved, expected, atol=1e-5), "interactive, at %g:\n%s\n%s", time, moved, expected)
require(np.abs(moved).max() > 1, "back at the beginning nothing is left of the way there")
deformation.InvokeCommand("Reset")
deformation.MarkModified(deformation)
moved, volume = at(0.0, deformation, reports)
require(same_bits(points_of(volume, "scalars"), points_of(bar(), "scalars")), "after Reset the first frame is not the scan")
print("key frames of Target", flush=True)

# Position: from rest each frame grabs other tissue; in Interactive mode the probe lets go and grabs anew.
deformation, probe, reports = deform(produce(bar()))
probe.Target = [61, 0, 0]
track.Enabled = 0
track = key_frames(probe, "Position", 40, 60)
for time in (0.0, 1.0, 0.0):
    moved, _ = at(time, deformation, reports)
    gripped = 20 if time == 0 else 30
    require(np.allclose(moved, from_rest(61, gripped), atol=1e-5), "grabbed at %g, at time %g:\n%s", 2 * gripped, time, moved)
deformation.Mode = "Interactive"
first, _ = at(0.0, deformation, reports)
second, _ = at(1.0, deformation, reports)
require(np.isclose(second[20], first[20]), "what was let go does not stay where it is without relaxation")
require(field(servermanager.Fetch(deformation, 0, idx=0), "ProbeReached")[0, 0] > 0, "nothing was grabbed anew")
track.Enabled = 0
print("key frames of Position", flush=True)

# A series of scans: each is deformed from rest, in both modes.
folder = os.path.join(OUTPUT, "TestTime")
os.makedirs(folder, exist_ok=True)
files = []
for number in range(3):
    files.append(os.path.join(folder, "scan_%d.vti" % number))
    writer = vtkXMLImageDataWriter()
    writer.SetDataModeToBinary()
    writer.SetFileName(files[-1])
    writer.SetInputData(bar(10 + 100 * number))
    require(writer.Write() == 1, "cannot write %s", files[-1])
series = OpenDataFile(files)
series.UpdatePipelineInformation()
for mode in ("FromRest", "Interactive"):
    deformation, probe, reports = deform(series, Mode=mode)
    deformation.MaterialFunction.Points = [0, LIMIT, 0.5, 0, 1000, LIMIT, 0.5, 0]
    probe.Target = [43, 0, 0]
    deformation.UpdatePipeline(0)
    information = deformation.GetClientSideObject().GetOutputInformation(0)
    steps = list(information.Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS()))
    require(steps == [0, 1, 2], "the result has the times %s", steps)
    for time in (0, 1, 2, 1):
        deformation.UpdatePipeline(time)
        alone, other, others = deform(produce(bar(10 + 100 * time)))
        alone.MaterialFunction.Points = deformation.MaterialFunction.Points
        other.Target = [43, 0, 0]
        expected, _ = update(alone, others)
        volume = servermanager.Fetch(deformation, 0, idx=0)
        require(not reports.take(), "an error at time %d", time)
        require(same_bits(points_of(volume, "scalars"), points_of(expected, "scalars")), "%s, at time %d:\n%s\n%s", mode, time,
                points_of(volume, "scalars"), points_of(expected, "scalars"))
print("a series of scans")
