"""Runs in ParaView's window: writes a line for every picture, with how many deformations there are, the number of their
state, and whether the hand waited for it."""

import os

from paraview.simple import *

watched = open(os.environ["CHAINMAIL_WATCHED"], "w")
view = GetActiveViewOrCreate("RenderView")


def note(*_):
    sources = [proxy for (name, _), proxy in GetSources().items() if name.startswith("ChainMailDeformation")]
    if sources:
        states = [source.GetClientSideObject().GetOutputDataObject(0).GetMTime() for source in sources]
        dragged = not view.SMProxy.GetClientSideObject().GetUseFXAA()  # then edges are not smoothed
        print(len(sources), max(states), "quick" if dragged else "fine", file=watched, flush=True)


view.SMProxy.AddObserver("EndEvent", note)
