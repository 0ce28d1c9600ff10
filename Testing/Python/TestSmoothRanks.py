"""ChainMail Smooth in several processes, after a deformation: what each process has is what one alone has, to the bit.

Under mpiexec this file is the program: `pvbatch --sym TestSmoothRanks.py FOLDER` writes what each process has got."""

import os
import sys
import tempfile

import harness
import numpy as np
from harness import require
from paraview.simple import *
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkParallelCore import vtkMultiProcessController

PROCESSES = 3


def smoothed():
    probe = ChainMailProbe(Position=[0, 0, 11], Target=[2, 1, 15], Radius=3)
    deformation = ChainMailDeformation(Input=Wavelet(WholeExtent=[-12, 12, -11, 13, -10, 14]), Probes=[probe])
    # Processes of --sym do not fit properties to the data.
    deformation.MaterialPreset, deformation.TissueThreshold, deformation.BackgroundValue = "Function", 0.0, 0.0
    deformation.MaterialFunction.Points = [0.0, 0.3, 0.5, 0, 300.0, 0.3, 0.5, 0]
    deformation.AnchoredFaces = [0, 0, 0, 0, 1, 0]
    smooth = ChainMailSmooth(Input=deformation)
    smooth.UpdatePipeline()
    output = smooth.GetClientSideObject().GetOutputDataObject(0)
    shape = output.GetDimensions()[::-1]
    ghosts = output.GetPointData().GetArray("vtkGhostType")
    return {"values": vtk_to_numpy(output.GetPointData().GetArray("RTData")).reshape(shape),
            "own": (vtk_to_numpy(ghosts).reshape(shape) & 1) == 0 if ghosts else np.ones(shape, bool),
            "extent": np.array(output.GetExtent())}


if len(sys.argv) > 1:
    controller = vtkMultiProcessController.GetGlobalController()
    require(controller.GetNumberOfProcesses() == PROCESSES, "there are %d processes", controller.GetNumberOfProcesses())
    np.savez(os.path.join(sys.argv[1], "%d.npz" % controller.GetLocalProcessId()), **smoothed())
else:
    harness.mpiexec(1, "")  # or skips
    whole = smoothed()
    first = whole["extent"][::2]
    with tempfile.TemporaryDirectory(dir=harness.OUTPUT) as folder:
        harness.run_pvbatch(PROCESSES, "--sym", os.path.abspath(__file__), folder)
        parts = [dict(np.load(os.path.join(folder, "%d.npz" % rank))) for rank in range(PROCESSES)]
    seen = np.zeros(whole["values"].shape, bool)
    for part in parts:
        low, high = part["extent"][::2] - first, part["extent"][1::2] - first + 1
        box = tuple(slice(a, b) for a, b in zip(low[::-1], high[::-1]))
        own = part["own"]
        require(0 < own.sum() < seen.size, "a process has %d of %d points", own.sum(), seen.size)
        require(harness.same_bits(whole["values"][box][own], part["values"][own]), "a part differs")
        seen[box] |= own
    require(seen.all(), "the parts are not all of the image")
    print(PROCESSES, "processes;", seen.size, "points")
