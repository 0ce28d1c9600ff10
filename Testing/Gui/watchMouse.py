"""Runs in ParaView's window: makes and shows a deformation, and writes a line for what happens: an update of it begins or
ends, the mouse moves, a frame is drawn, ParaView has drawn a picture. With the key j it settles for as long as nobody stops it, with the key k in five
iterations, and is compared with another deformation of the same scene."""

import os

from paraview.simple import *
from vtkmodules.util.numpy_support import vtk_to_numpy

watched = open(os.environ["CHAINMAIL_WATCHED"], "w")


def say(*words):
    print(*words, file=watched, flush=True)


scan = OpenDataFile(os.path.join(os.path.dirname(watched.name), "scan.vti"))
probe = ChainMailProbe(Position=[1.0, 28.0, 1.5], Target=[1.0, 38.0, 1.5], Radius=4.0)
deformation = ChainMailDeformation(Input=scan, Probes=[probe])
algorithm = deformation.GetClientSideObject()
view = GetActiveViewOrCreate("RenderView")


def begins(*_):
    say("begins")


def ends(*_):
    fields = algorithm.GetOutput().GetFieldData()
    error, used = fields.GetAbstractArray("Error"), fields.GetArray("RelaxationIterationsUsed")
    say("ends:", error and error.GetValue(0), "after", used and int(used.GetValue(0)), "iterations")


def draws(*_):
    dragged = not view.SMProxy.GetClientSideObject().GetUseFXAA()  # then edges are not smoothed
    renderer = view.SMProxy.GetRenderer()
    renderer.SetWorldPoint(*probe.Target, 1.0)
    renderer.WorldToDisplay()
    pixel = [int(round(x)) for x in renderer.GetDisplayPoint()[:2]]
    say("picture", "quick" if dragged else "fine", *pixel, *probe.Position, *probe.Target)


def frame(*_):
    say("frame")


def moves(interactor, _):
    say("mouse", *interactor.GetEventPosition())


def settle(iterations):
    deformation.RelaxationIterations, deformation.RelaxationTolerance = iterations, 0.0
    Render(view)


def volume(source):
    source.UpdatePipeline()
    image = source.GetClientSideObject().GetOutputDataObject(0)
    return vtk_to_numpy(image.GetPointData().GetArray("CT")).tobytes()


def pressed(interactor, _):
    if interactor.GetKeyCode() == "j":
        settle(10000000)
    elif interactor.GetKeyCode() == "k":
        settle(5)
        other = ChainMailDeformation(Input=scan, Probes=[probe], RelaxationIterations=5, RelaxationTolerance=0.0)
        say("compared:", "the same" if volume(deformation) == volume(other) else "another state")


algorithm.AddObserver("StartEvent", begins)
algorithm.AddObserver("EndEvent", ends)
display = Show(deformation, view)
display.SetRepresentationType("Volume")
SetActiveSource(probe)
Render(view)
view.CameraParallelProjection, view.CameraParallelScale = 1, 45.0
view.CameraFocalPoint, view.CameraPosition, view.CameraViewUp = [1, 20, 0], [1, 20, 600], [0, 1, 0]
view.SMProxy.AddObserver("EndEvent", draws)
view.SMProxy.GetRenderWindow().AddObserver("EndEvent", frame)
view.SMProxy.GetInteractor().AddObserver("MouseMoveEvent", moves, 10.0)
view.SMProxy.GetInteractor().AddObserver("KeyPressEvent", pressed, 10.0)
Render(view)
say("ready")
