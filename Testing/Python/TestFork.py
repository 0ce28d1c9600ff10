"""A process that multiprocessing forks from one that has used the filter gets an error that says to spawn, and comes to
its end; one that it spawns works, and so does the first afterwards."""

import multiprocessing
import os
import shutil

from harness import Reports, require


def update(deformation):
    """The errors of an update."""
    reports = Reports(deformation)
    deformation.MarkModified(deformation)
    deformation.UpdatePipeline()
    return reports.take()


def make():
    from paraview.simple import ChainMailDeformation, ChainMailProbe, Wavelet

    probe = ChainMailProbe(Position=[2, 2, 2], Target=[3, 2, 2])
    return ChainMailDeformation(Input=Wavelet(WholeExtent=[0, 5, 0, 5, 0, 5]), Probes=[probe], TissueThreshold=0)


def inForked(deformation, queue):
    old = update(deformation)
    new = update(make())
    queue.put((old, new))


def inSpawned(queue):
    queue.put(update(make()))


def outcome(context, target, *arguments):
    queue = context.Queue()
    process = context.Process(target=target, args=(*arguments, queue))
    process.start()
    result = queue.get(timeout=200)
    process.join(60)
    require(process.exitcode == 0, "the process ended with %s", process.exitcode)
    return result


if __name__ == "__main__":
    deformation = make()
    errors = update(deformation)
    require(not errors, "the first update: %s", errors)
    for errors in outcome(multiprocessing.get_context("fork"), inForked, deformation):
        require("spawn" in errors, "a forked process does not say what to do: %s", errors)
    # ParaView 5 takes itself to be a program that is not installed.
    multiprocessing.set_executable(shutil.which(os.environ.get("CHAINMAIL_PVPYTHON", "pvpython")))
    errors = outcome(multiprocessing.get_context("spawn"), inSpawned)
    require(not errors, "a spawned process: %s", errors)
    errors = update(deformation)
    require(not errors, "the first process afterwards: %s", errors)
    print("forked: told to spawn; spawned: works")
