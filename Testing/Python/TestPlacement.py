"""Where a new probe, blade and drill appear: on the tissue that the active view shows, with sizes that fit the data, on one
process and on a server of two."""

import os
import sys

import numpy as np
from harness import mpi_environment, mpiexec, require, run_pvpython
from paraview import servermanager
from paraview.simple import *
from TestClientServer import start_server, stop

HALF = 40.0  # of the box, mm
DIAGONAL = 2 * HALF * 3 ** 0.5


def scan(formula):
    """An image of 81^3 voxels whose values are those of a formula of the place; what is positive is tissue."""
    box = Wavelet(WholeExtent=[-40, 40] * 3)
    calculated = Calculator(Input=box, ResultArrayName="CT", Function="if(%s > 0, 40, -1000)" % formula)
    calculated.UpdatePipeline()
    return calculated


def look(toward, up):
    """A view of the middle of the data."""
    view = CreateView("RenderView")
    view.CameraFocalPoint = [0, 0, 0]
    view.CameraPosition = [200 * x for x in toward]
    view.CameraViewUp = up
    SetActiveView(view)
    return view


def near(value, expected, tolerance, what):
    require(np.allclose(value, expected, atol=tolerance, rtol=0), "%s is %s instead of %s", what, list(np.atleast_1d(value)),
            expected)


def play():
    # A ball of 25 mm, looked at from the left: everything is on its left side.
    ball = scan("25^2 - coordsX^2 - coordsY^2 - coordsZ^2")
    view = look([1, 0, 0], [0, 0, 1])
    SetActiveSource(ball)
    probe = ChainMailProbe()
    near(probe.Position, [25, 0, 0], 1.0, "the probe's place")
    near(probe.Target, np.add(probe.Position, [0.03 * DIAGONAL, 0, 0.03 * DIAGONAL]), 1e-6, "the probe's target")
    near(probe.Radius, 0.025 * DIAGONAL, 1e-6, "the probe's radius")
    SetActiveSource(ball)
    blade = ChainMailBlade()
    for end, y in ((blade.Start, -0.08), (blade.End, 0.08)):
        near(end[1:], [y * DIAGONAL, -0.05 * DIAGONAL], 1e-6, "an end of the blade")
        near(np.linalg.norm(end), 25, 1.0, "its distance from the middle")
    near(blade.Direction, [-1, 0, 0], 1e-6, "the blade's direction")
    near([blade.Depth, blade.Height], [0.06 * DIAGONAL] * 2, 1e-6, "its depth and height")
    SetActiveSource(ball)
    drill = ChainMailDrill()
    near(np.linalg.norm(drill.Center), 25, 1.0, "the drill's distance from the middle")
    near(drill.Radius, 0.03 * DIAGONAL, 1e-6, "the drill's radius")

    # They do what they are for, and one that is added belongs to the scan in question, whatever else there is.
    other = scan("5^2 - (coordsX - 20)^2 - (coordsY - 20)^2 - (coordsZ - 20)^2")
    deformation = ChainMailDeformation(Input=ball, Probes=[probe], Cuts=[blade], Carves=[drill])
    deformation.UpdatePipeline()
    deformation.UpdatePropertyInformation()
    require("Probe 1 reached" in deformation.Report and "voxels moved" in deformation.Report, "the report is %s",
            deformation.Report)
    reached = servermanager.Fetch(deformation).GetFieldData().GetArray("ProbeReached").GetTuple3(0)
    near(list(deformation.GetPropertyValue("ProbeReached")), reached, 1e-12, "what the probe reached")
    # Where nothing of its kind is yet, and a probe not in a hole.
    for chosen in (deformation, probe, blade, drill):
        for make, others in ((ChainMailProbe, (probe.Position, drill.Center)), (ChainMailDrill, (drill.Center,)),
                             (ChainMailBlade, (np.add(blade.Start, blade.End) / 2,))):
            SetActiveSource(chosen)
            made = make()
            places = [np.array(made.Start), np.array(made.End)] if make is ChainMailBlade else [
                np.array(made.Center if make is ChainMailDrill else made.Position)]
            for place in places:
                near(np.linalg.norm(place), 25, 1.0, "the distance from the middle of a further %s" % make.__name__)
            for taken in others:
                apart = np.linalg.norm(np.mean(places, axis=0) - taken)
                require(apart > 0.05 * DIAGONAL, "a further %s is %g mm from the last", make.__name__, apart)
                require(apart > 0.14 * DIAGONAL or make is not ChainMailProbe, "a further probe is %g mm from %s", apart,
                        list(taken))
            Delete(made)
    # Step by step the tissue is where it is now: the drill has taken the pole away.
    drill.Center, drill.Radius = [25, 0, 0], 12
    deformation.Mode, deformation.Probes = "Interactive", []
    deformation.UpdatePipeline()
    SetActiveSource(deformation)
    require(np.linalg.norm(np.subtract(ChainMailProbe().Position, drill.Center)) > 12, "a probe is in a hole")
    Delete(deformation)

    # Looked at along a limb that the box cuts off, tissue is held at what is seen: the view turns to the front.
    limb = scan("20^2 - coordsX^2 - coordsY^2")
    look([0, 0, 1], [0, 1, 0])
    SetActiveSource(limb)
    near(ChainMailProbe().Position, [0, -20, 0], 1.0, "the probe's place on a limb")
    # Tissue all over: within it, away from the faces.
    block = scan("1 + 0*coordsX")
    SetActiveSource(block)
    require(np.abs(ChainMailProbe().Position).max() <= 0.9 * HALF, "a probe is at a face of the box")
    # No tissue: in the middle, as without a view.
    air = ChainMailDeformation(Input=scan("0*coordsX"), TissueThreshold=1)
    SetActiveSource(air)
    near(ChainMailProbe().Position, [0, 0, 0], 1e-6, "the probe's place in air")

    # What the view shows as a volume counts, not what it hides.
    shell = scan("25^2 - coordsX^2 - coordsY^2 - coordsZ^2")
    core = Calculator(Input=shell, ResultArrayName="CT",
                      Function="if(coordsX^2 + coordsY^2 + coordsZ^2 < 100, 1000, CT)")
    core.UpdatePipeline()
    view = look([1, 0, 0], [0, 0, 1])
    shown = Show(core, view, "UniformGridRepresentation")
    shown.SetRepresentationType("Volume")
    ColorBy(shown, ("POINTS", "CT"))
    opacity = GetOpacityTransferFunction("CT")
    opacity.Points = [-1000, 0, 0.5, 0, 500, 0, 0.5, 0, 900, 1, 0.5, 0, 1000, 1, 0.5, 0]
    SetActiveSource(core)
    near(ChainMailProbe().Position, [10, 0, 0], 1.0, "the place on what is seen")
    print("placed")


def main():
    play()
    server, port, log = start_server(mpiexec(2, os.path.join(os.path.dirname(os.environ["CHAINMAIL_PVPYTHON"]), "pvserver")),
                                     {**mpi_environment(), "PV_PLUGIN_PATH": os.environ["PV_PLUGIN_PATH"]})
    try:
        status, text = run_pvpython(os.path.abspath(__file__), str(port))
        require(status == 0 and "placed" in text, "on a server of two processes:\n%s", text)
    finally:
        stop(server)


if len(sys.argv) == 1:
    main()
else:
    Connect("127.0.0.1", int(sys.argv[1]))
    play()
    Disconnect()
