"""Runs in ParaView's window: writes a line for every picture: Rotations of the deformation, the number of its probes, and z of the
pose's Position and Target, - without one."""

import os

from paraview.simple import *

watched = open(os.environ["CHAINMAIL_WATCHED"], "w")


def note(*_):
    deformation, pose = FindSource("ChainMailDeformation1"), FindSource("ChainMailPose1")
    if deformation:
        places = ["%.1f" % place[2] for place in (pose.Position, pose.Target)] if pose else ["-", "-"]
        print(deformation.Rotations, len(deformation.Probes), *places, file=watched, flush=True)


GetActiveViewOrCreate("RenderView").SMProxy.AddObserver("EndEvent", note)
