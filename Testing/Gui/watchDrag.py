"""Runs in ParaView's window: writes a line for every picture of a drag, with the number of the deformation's state."""

import os

from paraview.simple import *

watched = open(os.environ["CHAINMAIL_WATCHED"], "w")
view = GetActiveViewOrCreate("RenderView")


def note(*_):
    sources = [proxy for (name, _), proxy in GetSources().items() if name.startswith("ChainMailDeformation")]
    if sources and view.EnableRenderOnInteraction == 0:  # in a drag that the tissue follows ParaView does not draw by itself
        states = [source.GetClientSideObject().GetOutputDataObject(0).GetMTime() for source in sources]
        print(len(sources), max(states), file=watched, flush=True)


view.SMProxy.AddObserver("EndEvent", note)
