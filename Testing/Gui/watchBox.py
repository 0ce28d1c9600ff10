"""Runs in ParaView's window: writes a line for every picture, with the box's matrix, where its middle is on the screen, and
how far the handles are from there."""

import json
import math
import os

from paraview.simple import *
from vtkmodules.vtkCommonTransforms import vtkTransform
from vtkmodules.vtkRenderingCore import vtkPropCollection

watched = open(os.environ["CHAINMAIL_WATCHED"], "w")
view = GetActiveViewOrCreate("RenderView")


def note(*_):
    renderer = view.SMProxy.GetClientSideObject().GetNonCompositedRenderer()
    for prop in renderer.GetViewProps():
        if prop.IsA("vtkBoxRepresentation") and prop.GetVisibility():
            transform = vtkTransform()
            prop.GetTransform(transform)
            matrix = transform.GetMatrix()
            bounds = list(prop.GetBounds())
            middle = [(bounds[a] + bounds[a + 1]) / 2 for a in (0, 2, 4)]
            renderer.SetWorldPoint(*middle, 1)
            renderer.WorldToDisplay()
            size = renderer.GetSize()
            place = renderer.GetDisplayPoint()
            props = vtkPropCollection()
            prop.GetActors(props)
            actors = [props.GetItemAsObject(n) for n in range(props.GetNumberOfItems())]
            handles = [math.dist(actor.GetCenter(), middle) for actor in actors if actor.GetVisibility() and
                       actor.GetProperty() in (prop.GetHandleProperty(), prop.GetSelectedHandleProperty())]
            print(json.dumps({"handles": handles, "matrix": [matrix.GetElement(i, j) for i in range(4) for j in range(4)], "bounds": bounds,
                              "screen": [place[0] / size[0], 1 - place[1] / size[1]]}), file=watched, flush=True)


view.SMProxy.AddObserver("EndEvent", note)
