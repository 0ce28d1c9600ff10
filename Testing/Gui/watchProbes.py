"""Runs in ParaView's window: writes a line for every picture, with position and target of all probes, what they reached,
and what is written beside the line of the selected one."""

import json
import os

from paraview.simple import *

watched = open(os.environ["CHAINMAIL_WATCHED"], "w")
view = GetActiveViewOrCreate("RenderView")


def written():
    props = view.SMProxy.GetClientSideObject().GetNonCompositedRenderer().GetViewProps()
    return [prop.GetInput() for prop in props if prop.IsA("vtkBillboardTextActor3D") and prop.GetVisibility()]


def note(*_):
    sources = {name: proxy for (name, _), proxy in GetSources().items()}
    probes = {name: [list(proxy.Position), list(proxy.Target)] for name, proxy in sources.items() if "Probe" in name}
    deformation = sources.get("ChainMailDeformation1")
    if deformation:
        deformation.UpdatePropertyInformation()
        reached = list(deformation.GetPropertyValue("ProbeReached") or [])
        print(json.dumps({"probes": probes, "reached": reached, "written": written()}), file=watched, flush=True)


view.SMProxy.AddObserver("EndEvent", note)
