"""Several processes, each with its own piece, give the outputs of one, to the bit: from files that can be read in pieces and
from others, with probes and surfaces that only some of the processes have, from rest and in Interactive mode, with errors
in between."""

import json
import os
import shutil
import subprocess
import tempfile

import numpy as np
import pieces
import harness  # not its names: scripts of programmable sources run in this module and bring their own

mpiexec = shutil.which("mpiexec")
if not mpiexec:
    harness.skip("mpiexec was not found (on Debian the package openmpi-bin)")

with tempfile.TemporaryDirectory(dir=harness.OUTPUT) as folder:
    plan = pieces.scenes(folder)
    wholes = {}
    for name, arguments in plan.items():
        def keep(step, filter):
            filter.UpdatePipeline()
            for port in range(2):
                output = filter.GetClientSideObject().GetOutputDataObject(port)
                wholes[name, step, port] = {key: value.copy() for key, value in pieces.content(output).items()}

        pieces.Scene(*arguments).play(keep)
    with open(os.path.join(folder, "plan.json"), "w") as file:
        json.dump(plan, file)

    for count in (1, 2, 3, 5) if pieces.EVERY else (3,):
        command = [mpiexec, "--oversubscribe", "-n", str(count), os.environ.get("CHAINMAIL_PVBATCH", "pvbatch"), "--sym",
                   pieces.__file__, os.path.join(folder, "plan.json"), folder]
        # pvpython has started MPI for itself, and what that left in the environment would be taken for the new job's.
        # Open MPI asks root for its word; other implementations know neither variable.
        environment = {key: value for key, value in os.environ.items()
                       if not key.startswith(("OMPI_", "PMIX_", "PMI_", "ORTE_"))}
        environment.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
        done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                              timeout=3000)
        harness.require(done.returncode == 0, "%d processes end with status %d:\n%s", count, done.returncode, done.stdout)
        # The one error of each scene.
        harness.require(done.stdout.count("holds no tissue") == len(plan), "%d processes report:\n%s", count, done.stdout)
        for (name, step, port), whole in wholes.items():
            parts = []
            for rank in range(count):
                path = os.path.join(folder, "%s %s %d %d of %d.npz" % (name, step, port, rank, count))
                with np.load(path) as stored:
                    parts.append(dict(stored))
                why = pieces.differs(parts[-1], whole)
                harness.require(not why, "%s, %s, output %d, process %d of %d: %s", name, step, port, rank, count, why)
                os.remove(path)
            harness.require(pieces.covers(parts, whole), "%s, %s, output %d: the pieces of %d processes are not the whole", name, step,
                    port, count)
        print(count, "processes", flush=True)
