"""Memory that runs out in one process of several, wherever it may: all processes show the same error, none waits for ever, and
afterwards all go on as if nothing had been. One after the other, every large request for memory of an update fails.

Under mpiexec this file is the program: `pvbatch --sym TestRankMemory.py ranks`."""

import ctypes
import os
import sys

import harness
from drags import TARGETS, Drag, compare
from harness import require
from paraview.simple import *
from pieces import processes
from vtkmodules.vtkCommonCore import vtkIntArray
from vtkmodules.vtkParallelCore import vtkMultiProcessController

PROCESSES = 3
LIBRARY = os.environ.get("CHAINMAIL_FAILING_MEMORY", "")
LARGE = 40000 if harness.EVERY else 300000  # [bytes]
LARGE_REDUCED = LARGE // 8                  # of a reduced model, which has fewer elements
MOST = 400     # requests of an update


def shared(value, rank):
    """The number of one process, in all of them."""
    array = vtkIntArray()
    array.InsertNextValue(value)
    vtkMultiProcessController.GetGlobalController().Broadcast(array, rank)
    return array.GetValue(0)


def fail_each(rank_that_fails, first, make, way, large):
    """Fails the large requests of one process in the updates of filters that make() gives, each with its reference."""
    rank = processes()[0]
    library = ctypes.CDLL(LIBRARY)
    library.failAllocation.argtypes = [ctypes.c_size_t, ctypes.c_int]
    count = 0
    for n in range(1, MOST):
        drag, reference = make()
        if not first:  # memory of the first update is there already
            compare(drag, reference, "before")
            drag.pull(way)
            reference.pull(way)
        library.failAllocation(large, n if rank == rank_that_fails else 0)
        drag.update()
        has_failed = library.hasFailed()
        library.failAllocation(large, 0)
        if not shared(has_failed, rank_that_fails):
            require(drag.problem() == "", "nothing has failed, and process %d says '%s'", rank, drag.problem())
            return count
        count += 1
        # Some requests have a second way, as has a cache.
        problem = drag.problem()
        require(problem == "" or "memory" in problem, "request %d of process %d fails, and process %d says '%s'", n,
                rank_that_fails, rank, problem)
        require(shared(len(problem), 0) == len(problem), "request %d: process %d says '%s'", n, rank, problem)
        drag.filter.Modified()
        drag.filter.Reset()
        reference.filter.Reset()
        compare(drag, reference, "after request %d of process %d has failed" % (n, rank_that_fails))
    require(False, "there are more than %d requests", MOST)


def scene(kind):
    """A filter of all processes, and its reference."""
    drags = Drag(False), Drag(True)
    for drag in drags:
        drag.source.SetWholeExtent(-25, 25, -22, 26, -24, 24)
        if kind in ("first has all", "let go"):
            drag.give_all_to_first(kind == "let go")
        elif kind == "reduced":
            drag.reduce()
        else:
            drag.source.UpdatePiece(*((0, 1) if drag.alone else processes()), 0)  # what a source takes is its own affair
    return drags


def main():
    compare(*scene("pieces"), "first")  # compiles all kernels
    compare(*scene("reduced"), "first")
    for kind in ("pieces", "first has all", "let go", "reduced"):
        for rank in (0, 1):
            for first in (True, False) if kind == "pieces" else (True,):
                count = fail_each(rank, first, lambda: scene(kind), TARGETS[1], LARGE_REDUCED if kind == "reduced" else LARGE)
                if processes()[0] == 0:
                    os.write(1, b"%s: %d requests of process %d\n" % (kind.encode(), count, rank))


if len(sys.argv) > 1:
    main()
    harness.end_together()
else:
    harness.mpiexec(1, "")  # or skips
    if not LIBRARY:
        harness.skip("CHAINMAIL_FAILING_MEMORY names no library, which is made on Linux alone")
    os.environ["LD_PRELOAD"] = LIBRARY
    output = harness.run_together(PROCESSES, __file__, "ranks", timeout=600)
    print([line for line in output.split("\n") if " requests of process " in line])
