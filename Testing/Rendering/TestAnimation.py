"""An animation of a probe's target, saved as frames: each frame is what the view shows at its time, from frame to frame the
tissue moves on, and where the pull is at its limit the frames are alike."""

import glob
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pictures import *  # noqa: E402, F403  (puts the harness on the path)
from harness import OUTPUT, Reports, produce  # noqa: E402

sys.path.insert(0, DATA)
from make_forearm import make_forearm  # noqa: E402

require_display()
folder = os.path.join(OUTPUT, "TestAnimation")
os.makedirs(folder, exist_ok=True)
for old in glob.glob(os.path.join(folder, "*.png")):
    os.remove(old)

COLOURS = [(-1000, 0.50, 0.30, 0.25), (-420, 0.95, 0.70, 0.57), (-60, 1.00, 0.86, 0.60), (60, 0.80, 0.16, 0.14),
           (250, 0.97, 0.90, 0.78), (1500, 1.00, 0.99, 0.95)]
OPACITIES = [(-1000, 0.0), (-800, 0.0), (-450, 0.7), (-120, 0.6), (-60, 0.3), (160, 0.12), (300, 0.75), (1500, 1.0)]

probe = ChainMailProbe(Position=[20, 28, 4], Target=[20, 28, 4], Radius=7)
deformation = ChainMailDeformation(Input=produce(make_forearm((66, 62, 92))), Probes=[probe], TissueThreshold=-400,
                                   BackgroundValue=-1000, RelaxationIterations=10)
deformation.MaterialFunction.Points = [-1024, 0.8, 0.5, 0, 200, 0.8, 0.5, 0, 600, 0, 0.5, 0]
reports = Reports(deformation)
view = make_view((260, 200), position=(190, 340, 10), focus=(0, 0, 10), up=(0, 1, 0), angle=28.0)
show_volume(deformation, view, "CT", COLOURS, OPACITIES)

# By 0, 10, 40 and 50 mm; the skin between the probe and the face that holds it stretches by less than 20.
for axis, values in enumerate(([20, 28, 52, 60], [28, 34, 52, 58])):
    track = GetAnimationTrack("Target", index=axis, proxy=probe)
    track.KeyFrames = [CompositeKeyFrame(KeyTime=n / 3, KeyValues=[value], Interpolation="Ramp")
                       for n, value in enumerate(values)]
scene = GetAnimationScene()
scene.PlayMode = "Sequence"
scene.StartTime, scene.EndTime, scene.NumberOfFrames = 0, 3, 4
SaveAnimation(os.path.join(folder, "frame.png"), view, ImageResolution=[260, 200], FrameWindow=[0, 3])
require(not reports.take(), "the filter reports an error")

frames = [read(path) for path in sorted(glob.glob(os.path.join(folder, "frame*.png")))]
require(len(frames) == 4, "%d frames were saved", len(frames))
differ = [sum(pixels_beyond(one, other)) for one, other in zip(frames, frames[1:])]
require(min(differ[:2]) > 10 * PIXELS_BEYOND, "from frame to frame %s pixels change", differ)
require(not (frames[2] != frames[3]).any(), "at the limit of the pull %s pixels change", differ)
for number in (3, 2, 1):  # backwards
    scene.AnimationTime = number
    require(same_picture(capture(view), frames[number]), "frame %d is not what the view shows at its time", number)
    deformation.UpdatePropertyInformation()
    words = {3: "of 50 mm: held by the face z- of the scan", 2: "of 40 mm: held by the face z- of the scan", 1: "10 of 10 mm."}
    require(words[number] in deformation.Report, "at time %d the report is\n%s", number, deformation.Report)
print("4 frames, in which %s pixels change from one to the next" % differ)
