"""ChainMail Carry in several processes: a mesh and images, of which each process has a part, go along as in one, to the
bit.

Under mpiexec this file is the program: `pvbatch --sym TestCarryRanks.py FOLDER` writes what each process has got."""

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
NAMES = ("image", "back", "mesh")


def carried():
    """The outputs of three filters on one deformation, none of which was updated before."""
    probe = ChainMailProbe(Position=[0, 0, 11], Target=[2, 1, 15], Radius=3)
    blade = Plane(Origin=[0.5, -20, 3], Point1=[0.5, 20, 3], Point2=[0.5, -20, 20])
    wavelet = Wavelet(WholeExtent=[-12, 12, -11, 13, -10, 14])
    deformation = ChainMailDeformation(Input=wavelet, Probes=[probe], Cuts=[blade])
    # Processes of --sym do not fit properties to the data.
    deformation.MaterialPreset, deformation.TissueThreshold, deformation.BackgroundValue = "Function", 0.0, 0.0
    deformation.MaterialFunction.Points = [0.0, 0.3, 0.5, 0, 300.0, 0.3, 0.5, 0]
    deformation.AnchoredFaces = [0, 0, 0, 0, 1, 0]
    image = ChainMailCarry(Input=wavelet, Deformation=OutputPort(deformation, 1))
    back = ChainMailCarry(Input=OutputPort(deformation, 0), Deformation=OutputPort(deformation, 1), Direction="Backward")
    # Its pieces are sectors.
    mesh = ChainMailCarry(Input=Sphere(Radius=8, Center=[0, 0, 5], ThetaResolution=30, PhiResolution=20),
                          Deformation=OutputPort(deformation, 1))
    result = {}
    for name, proxy in zip(NAMES, (image, back, mesh)):
        proxy.UpdatePipeline()
        output = proxy.GetClientSideObject().GetOutputDataObject(0)
        require(not output.GetFieldData().HasArray("Error"), "%s has an error", name)
        if name == "mesh":
            result[name] = vtk_to_numpy(output.GetPoints().GetData()) if output.GetPoints() else np.zeros((0, 3), np.float32)
        else:
            result[name] = vtk_to_numpy(output.GetPointData().GetArray("RTData"))
            result[name + " extent"] = np.array(output.GetExtent())
    return result


if len(sys.argv) > 1:
    controller = vtkMultiProcessController.GetGlobalController()
    require(controller.GetNumberOfProcesses() == PROCESSES, "there are %d processes", controller.GetNumberOfProcesses())
    np.savez(os.path.join(sys.argv[1], "%d.npz" % controller.GetLocalProcessId()), **carried())
else:
    harness.mpiexec(1, "")  # or skips
    whole = carried()
    with tempfile.TemporaryDirectory(dir=harness.OUTPUT) as folder:
        harness.run_pvbatch(PROCESSES, "--sym", os.path.abspath(__file__), folder)
        parts = [dict(np.load(os.path.join(folder, "%d.npz" % rank))) for rank in range(PROCESSES)]
    for name in NAMES[:2]:
        first, last = whole[name + " extent"][::2], whole[name + " extent"][1::2]
        values = whole[name].reshape((last - first + 1)[::-1])
        seen = np.zeros(values.shape, bool)
        for part in parts:
            low, high = part[name + " extent"][::2] - first, part[name + " extent"][1::2] - first + 1
            box = tuple(slice(a, b) for a, b in zip(low[::-1], high[::-1]))
            require(part[name].size < values.size, "a process has all of the %s", name)
            require(harness.same_bits(np.ascontiguousarray(values[box]).ravel(), part[name]), "the %s differs", name)
            seen[box] = True
        require(seen.all(), "the parts are not all of the %s", name)
    # Points are of several sectors; each process has its own.
    rows = lambda points: set(map(bytes, np.ascontiguousarray(points)))
    require(rows(np.concatenate([part["mesh"] for part in parts])) == rows(whole["mesh"]), "the mesh differs")
    require(all(len(part["mesh"]) < len(whole["mesh"]) for part in parts), "a process has all of the mesh")
    print(PROCESSES, "processes;", len(rows(whole["mesh"])), "points")
