"""As soon as the plugin is loaded, its kernels are compiled in the background, by a process that outlives this one. The first
updates then compile nothing. It is done once, and not where it is not wanted."""

import glob
import os
import shutil
import subprocess
import tempfile
import time

from harness import require, run_pvpython

PROGRAM = os.path.join(os.path.dirname(os.environ["CHAINMAIL_PLUGIN"]), "ChainMailCompileAhead")
LOAD = "import paraview.simple\n"
UPDATES = """
from paraview.simple import *
scan = Wavelet(WholeExtent=[0, 60, 0, 50, 0, 40])
probe = ChainMailProbe(Position=[30, 25, 20], Target=[36, 21, 24], Radius=4)
blade = Plane(Origin=[30, -1, -1], Point1=[30, 25, -1], Point2=[30, -1, 41])
deformation = ChainMailDeformation(Input=scan, Probes=[probe], RelaxationPreset="Balanced")
deformation.UpdatePipeline()
deformation.Cuts = [blade]
deformation.UpdatePipeline()
displaced = deformation.FieldData["DisplacedElements"].GetRange(0)[0]
assert displaced > 100, displaced
"""


def compiled(folder):
    """The engine's programs."""
    return sorted(os.path.basename(path) for path in glob.glob(os.path.join(folder, "engine", "*.clprogram")))


def at_work(folder):
    """Whether a process compiles into this folder."""
    for process in glob.glob("/proc/[0-9]*"):
        try:
            with open(os.path.join(process, "environ"), "rb") as file:
                if folder.encode() in file.read() and os.readlink(os.path.join(process, "exe")) == os.path.realpath(PROGRAM):
                    return True
        except OSError:
            pass  # of somebody else, or gone
    return False


def run(folder, script, **variables):
    status, text = run_pvpython("-c", script, CHAINMAIL_CACHE_DIR=os.path.join(folder, "engine"),
                                POCL_CACHE_DIR=os.path.join(folder, "pocl"), CUDA_CACHE_PATH=os.path.join(folder, "cuda"),
                                **variables)
    require(status == 0, "pvpython ends with status %d:\n%s", status, text)


folder = tempfile.mkdtemp()
try:
    require(os.access(PROGRAM, os.X_OK), "there is no program %s", PROGRAM)
    run(folder, LOAD, CHAINMAIL_COMPILE_AHEAD="0")
    require(not at_work(folder), "kernels are being compiled although this is not wanted")
    require(not compiled(folder), "kernels are compiled although this is not wanted: %s", compiled(folder))

    run(folder, LOAD)  # until everybody has closed what it prints into
    early = compiled(folder)
    end = time.time() + 240
    while len(compiled(folder)) < 2 and time.time() < end:
        time.sleep(0.1)
    require(len(compiled(folder)) >= 2, "nothing is compiled after the plugin has been loaded")
    # The same once more ends when all is done, whoever did it.
    environment = dict(os.environ, CHAINMAIL_CACHE_DIR=os.path.join(folder, "engine"),
                       POCL_CACHE_DIR=os.path.join(folder, "pocl"), CUDA_CACHE_PATH=os.path.join(folder, "cuda"))
    subprocess.run([PROGRAM], env=environment, check=True, timeout=600)
    before = os.times()
    subprocess.run([PROGRAM], env=environment, check=True, timeout=600)
    again = sum(os.times()[2:4]) - sum(before[2:4])  # of the processor: a busy machine takes no more of it
    require(again < 1.0, "it takes %.1f s of the processor to find that all is done", again)

    ahead = compiled(folder)
    require(len(early) < len(ahead), "the process that loads the plugin waits until all is compiled")
    run(folder, UPDATES)
    require(compiled(folder) == ahead, "the first updates compile: %s beside %s", compiled(folder), ahead)
    print("%d programs were compiled ahead, and none by the first updates" % (len(ahead) - 1))
finally:
    shutil.rmtree(folder, ignore_errors=True)
