"""Several processes, each with its own piece, give the outputs of one, to the bit: from files that can be read in pieces and
from others, with probes and surfaces that only some of the processes have, from rest and in Interactive mode, with errors
in between."""

import json
import os
import tempfile

import numpy as np
import pieces
import harness  # not its names: scripts of programmable sources run in this module and bring their own

harness.mpiexec(1, "")  # or skips


def wholes_of(scenes):
    """What one process gives in each step of each scene."""
    wholes = {}
    for name, arguments in scenes.items():
        def keep(step, filter):
            filter.UpdatePipeline()
            for port in range(2):
                output = filter.GetClientSideObject().GetOutputDataObject(port)
                wholes[name, step, port] = {key: value.copy() for key, value in pieces.content(output).items()}

        pieces.Scene(*arguments).play(keep)
    return wholes


def compare(count, scenes, wholes, folder):
    """Plays the scenes in some processes, and compares all pieces with the wholes."""
    plan = os.path.join(folder, "plan.json")
    with open(plan, "w") as file:
        json.dump(scenes, file)
    output = harness.run_pvbatch(count, "--sym", pieces.__file__, plan, folder, timeout=6000)
    # The one error of each scene.
    harness.require(output.count("holds no tissue") == len(scenes), "%d processes report:\n%s", count, output)
    for (name, step, port), whole in wholes.items():
        parts = []
        for rank in range(count):
            path = os.path.join(folder, "%s %s %d %d of %d.npz" % (name, step, port, rank, count))
            with np.load(path) as stored:
                parts.append(dict(stored))
            why = pieces.differs(parts[-1], whole)
            harness.require(not why, "%s, %s, output %d, process %d of %d: %s", name, step, port, rank, count, why)
            os.remove(path)
        harness.require(pieces.covers(parts, whole), "%s, %s, output %d: the pieces of %d processes are not the whole", name,
                        step, port, count)


with tempfile.TemporaryDirectory(dir=harness.OUTPUT) as folder:
    everything = pieces.scenes(folder)
    # Large scans one by one, since all that they give is kept.
    groups = [{name: scene for name, scene in everything.items() if not name.startswith(pieces.LARGE)}]
    groups += [{name: scene} for name, scene in everything.items() if name.startswith(pieces.LARGE)]
    for scenes in groups:
        wholes = wholes_of(scenes)
        for count in (1, 2, 3, 5, 8) if pieces.EVERY else (3,):
            compare(count, scenes, wholes, folder)
            print(", ".join(scenes), "in", count, "processes", flush=True)
