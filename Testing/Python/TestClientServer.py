"""ParaView's client with a server of one process and of two: the plugin is found in any order of loading, and pulling,
settling, Reset, errors and their correction, and the pose of a bone give the bits that one process alone gives. Settling is done by the lines of
the README."""

import os
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time

import numpy as np
from harness import OUTPUT, mpi_environment, mpiexec, require, run_pvpython
from paraview import servermanager
from paraview.simple import *
from vtkmodules.util.misc import calldata_type
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.util.vtkConstants import VTK_STRING
from vtkmodules.vtkCommonCore import vtkOutputWindow

ORIGIN, SIZE = -8, 17  # of the scan, along each axis
README = os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir, os.pardir, "README.md")


def points_of(proxy, port, name):
    """A point array of the whole scan, put together on the client from what each process of the server has."""
    whole = None
    for process in range(servermanager.ActiveConnection.GetNumberOfDataPartitions()):
        piece = servermanager.Fetch(proxy, process, idx=port)
        values = vtk_to_numpy(piece.GetPointData().GetArray(name))
        low, size = np.array(piece.GetExtent()[::2]) - ORIGIN, piece.GetDimensions()
        if whole is None:
            whole = np.zeros((SIZE,) * 3 + values.shape[1:], values.dtype)
            missing = np.full((SIZE,) * 3, True)
        place = tuple(slice(low[a], low[a] + size[a]) for a in (2, 1, 0))
        whole[place] = values.reshape(size[::-1] + values.shape[1:])
        missing[place] = False
    require(not missing.any(), "the processes lack %d voxels", missing.sum())
    return whole


def play(results):
    """What a user does, and what comes of it, into a file."""
    reported = []

    @calldata_type(VTK_STRING)
    def note(caller, event, text):
        reported.append(text.strip())

    vtkOutputWindow.GetInstance().AddObserver("ErrorEvent", note)
    with open(README, encoding="utf-8") as file:
        recipe = next(block for block in re.findall(r"```python\n(.*?)```", file.read(), re.S) if "NeedsUpdate" in block)
    settle = recipe[:recipe.index("deformation.InvokeCommand")]

    wavelet = Wavelet(WholeExtent=[ORIGIN, ORIGIN + SIZE - 1] * 3)
    probe = ChainMailProbe(Position=[1, 2, 3], Target=[2, 2.5, 2], Radius=2)
    blade = Plane(Origin=[-9, -9, 5.5], Point1=[9, -9, 5.5], Point2=[-9, 4, 5.5])
    deformation = ChainMailDeformation(Input=wavelet, Probes=[probe], Cuts=[blade], TissueThreshold=60,
                                       RelaxationIterations=5)
    require(deformation.GetPropertyValue("AvailableDevices"), "the server has no device")
    kept = {}

    def keep(name, proxy=deformation):
        for port, array in ((0, "RTData"), (1, "Displacement")):
            kept[name + " " + array] = points_of(proxy, port, array)
        require(not reported, "%s: %s", name, reported)
        print(name, flush=True)

    keep("from rest")
    carry = ChainMailCarry(Input=wavelet, Deformation=OutputPort(deformation, 1))
    kept["carried"] = points_of(carry, 0, "RTData")
    require(not reported and (kept["carried"] != points_of(wavelet, 0, "RTData")).any(), "nothing is carried: %s", reported)
    Delete(carry)
    exec(settle, {"deformation": deformation, "probe": probe})
    deformation.UpdatePropertyInformation()
    require(deformation.NeedsUpdate == 0, "the README's lines leave tissue that has not settled")
    keep("settled")

    deformation.InvokeCommand("Reset")
    deformation.UpdatePropertyInformation()
    require(deformation.NeedsUpdate == 1, "nothing to do after Reset")
    keep("reset")
    require((kept["reset RTData"] == points_of(wavelet, 0, "RTData")).all(), "Reset leaves something")

    probe.Target = [1, 4, 3]
    keep("pulled")
    for attempt in ("an error", "another error"):
        probe.Position = [100 + len(attempt), 2, 3]
        deformation.UpdatePipeline()
        require(len(reported) == 1 and "no tissue" in reported[0], "%s: %d messages: %s", attempt, len(reported), reported)
        del reported[:]
        keep("after " + attempt)
        require((kept["after %s RTData" % attempt] == kept["pulled RTData"]).all(), "%s changes what is shown", attempt)
        deformation.UpdatePropertyInformation()
        require(deformation.NeedsUpdate == 0, "tissue settles after an error")
    probe.Position = [1, 2, 3]
    keep("corrected")
    probe.Target = [3, 1, 2]
    keep("moved")

    # A bone in the middle, where two processes meet.
    ball = Calculator(Input=wavelet, ResultArrayName="Constraint", Function="if(coordsX^2 + coordsY^2 + coordsZ^2 < 13, 0, 0.25)")
    pose = ChainMailPose(Position=[0, 0, 0], Target=[0, 0, 0], Rotation=[0, 4, 10])
    posed = ChainMailDeformation(Input=ball, Probes=[pose], Scalars=["POINTS", "RTData"], ConstraintArray="Constraint",
                                 TissueThreshold=60, Rotations=1, RelaxationIterations=5)
    keep("turned", posed)
    posed.UpdatePropertyInformation()
    require("rotated by 10.8 of 10.8 degrees" in posed.Report, "the bone is where the report says %s", posed.Report)
    posed.InvokeCommand("CollectBodies")  # as the button Turn Bone does, on all processes
    pose.Target = [0.5, 0, 0.25]
    keep("turned and moved", posed)
    np.savez(results, **kept)


def start_server(command, environment):
    """A server and its port. Another program may take the port that was free a moment ago: then it is tried again."""
    for _ in range(5):
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))  # a bare system knows no localhost
            port = free.getsockname()[1]
        log = tempfile.TemporaryFile("w+")
        server = subprocess.Popen(command + ["--server-port=%d" % port], env=environment, stdout=log,
                                  stderr=subprocess.STDOUT, start_new_session=True)
        for _ in range(1200):
            ended = server.poll() is not None
            log.seek(0)
            text = log.read()
            if ended or "Accepting connection" in text:
                break
            time.sleep(0.1)
        if "Accepting connection" in text:
            return server, port, log
        stop(server)
    require(False, "%s does not start:\n%s", " ".join(command), text)


def stop(server):
    """Ends the server with all its processes."""
    try:
        os.killpg(server.pid, signal.SIGKILL)
    except ProcessLookupError:
        pass
    server.wait()


def main():
    plugin = os.environ["CHAINMAIL_PLUGIN"]
    pvpython = os.environ["CHAINMAIL_PVPYTHON"]
    pvserver = os.path.join(os.path.dirname(pvpython), "pvserver")
    alone = os.path.join(OUTPUT, "TestClientServer-alone.npz")
    play(alone)
    expected = np.load(alone)

    one = [pvserver]
    two = mpiexec(2, pvserver)
    inherited = mpi_environment()
    for name, command, loading in (("one process, loaded on the client first", one, ["local", "remote"]),
                                   ("one process, loaded on the server first", one, ["remote", "local"]),
                                   ("two processes, PV_PLUGIN_PATH", two, [])):
        path = None if loading else os.environ["PV_PLUGIN_PATH"]
        environment = {key: value for key, value in {**inherited, "PV_PLUGIN_PATH": path}.items() if value}
        server, port, log = start_server(command, environment)
        results = os.path.join(OUTPUT, "TestClientServer.npz")
        try:
            status, text = run_pvpython(os.path.abspath(__file__), str(port), results, plugin, *loading, PV_PLUGIN_PATH=path)
            log.seek(0)
            require(status == 0, "%s: the client ends with status %d:\n%s\nThe server:\n%s", name, status, text, log.read())
            server.wait(60)  # the client is gone
        finally:
            stop(server)
        # Nothing but the two errors. Where the server has the plugin first, ParaView misses two things on the client, as
        # an error or, since 5.13, a warning.
        lines = [line for line in text.splitlines() if "ERR|" in line and "Could not create object" not in line]
        require(len(lines) == 2 and text.count("no tissue") == 2, "%s: instead of the two errors there are:\n%s", name, text)
        found = np.load(results)
        for key in expected:
            require((found[key] == expected[key]).all(), "%s: %s is another: %d of %d numbers", name, key,
                    (found[key] != expected[key]).sum(), expected[key].size)
        os.remove(results)
        print("%s: %d arrays, bit for bit" % (name, len(expected.files)), flush=True)


if __name__ == "__main__" and len(sys.argv) == 1:
    main()
elif __name__ == "__main__":
    Connect("127.0.0.1", int(sys.argv[1]))
    for where in sys.argv[4:]:
        LoadPlugin(sys.argv[3], remote=where == "remote", ns=globals())
    play(sys.argv[2])
    Disconnect()
