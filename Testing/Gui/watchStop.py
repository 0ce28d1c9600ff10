"""Runs in ParaView's window: makes and shows a deformation that would go on for hours, and writes a line for every update that
begins or ends, and for what it is about."""

import os

from paraview.simple import *

watched = open(os.environ["CHAINMAIL_WATCHED"], "w")
scan = OpenDataFile(os.path.join(os.path.dirname(watched.name), "scan.vti"))
probe = ChainMailProbe(Position=[1, 28, 1.5], Target=[1, 31, 1.5], Radius=4)
deformation = ChainMailDeformation(Input=scan, Probes=[probe], RelaxationIterations=10000000, RelaxationTolerance=0)
SetActiveSource(deformation)
algorithm = deformation.GetClientSideObject()
last = None


def note(_, event):
    global last
    what = "begins" if event == "StartEvent" else algorithm.GetProgressText()
    if event == "EndEvent":
        fields = algorithm.GetOutput().GetFieldData()
        error, used = fields.GetAbstractArray("Error"), fields.GetArray("RelaxationIterationsUsed")
        what = "ends: %s; %s iterations" % (error and error.GetValue(0), used and int(used.GetValue(0)))
    if what != last:
        print(what, file=watched, flush=True)
    last = what


for event in ("StartEvent", "ProgressEvent", "EndEvent"):
    algorithm.AddObserver(event, note)
Show(deformation, GetActiveViewOrCreate("RenderView"))
Render()
