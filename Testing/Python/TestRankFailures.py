"""What goes wrong in one process of several goes wrong in all of them, in the same words, and none waits for ever: an error
of the device, a stop, also while parts of the outputs are made. Afterwards all go on as before. Other pieces of the outputs
are those of the same state.

Under mpiexec this file is the program: `pvbatch --sym TestRankFailures.py ranks`."""

import sys

import harness
from drags import TARGETS, Drag, compare
from harness import require
from paraview.simple import *
from pieces import content, differs, processes

PROCESSES = 3


def main():
    rank, size = processes()
    require(size == PROCESSES, "there are %d processes", size)
    drag, reference = Drag(False), Drag(True)
    errors = []
    drag.filter.AddObserver("ErrorEvent", lambda *_: errors.append(rank))
    compare(drag, reference, "first")

    # Pieces with ghosts are other pieces of the same state: nothing settles on.
    compare_same_state(drag, reference)

    # One process has a device that does not exist.
    drag.pull(TARGETS[1])
    if rank == 1:
        drag.filter.SetDevice("no such device")
    drag.update()
    require("no such device" in drag.problem(), "the device of process 1 is wrong, and process %d says '%s'", rank,
            drag.problem())
    require(len(errors) == 1, "process %d has had %d errors", rank, len(errors))
    if rank == 1:
        drag.filter.SetDevice("")
    drag.filter.Modified()
    drag.update()  # from the state that the failed update left: all processes agree on it
    require(drag.problem() == "", "after the error: %s", drag.problem())
    drag.filter.Reset()
    reference.pull(TARGETS[1])
    reference.filter.Reset()
    drag.pull(TARGETS[2])
    reference.pull(TARGETS[2])
    compare(drag, reference, "after the error")

    # One process is stopped while it makes its part of the image, or the first one while tissue settles.
    for stopped, text in ((2, "ChainMail: moving the voxels"), (0, "ChainMail: settling"), (0, "ChainMail: reading back")):
        def stop(caller, event):
            if caller.GetProgressText() == text:
                caller.SetAbortExecute(1)

        drag.pull(TARGETS[0])
        tag = drag.filter.AddObserver("ProgressEvent", stop) if rank == stopped else None
        drag.update()
        require(drag.problem() == "The update was stopped.", "process %d is stopped, and process %d says '%s'", stopped,
                rank, drag.problem())
        if tag is not None:
            drag.filter.RemoveObserver(tag)
        drag.filter.SetAbortExecute(0)
        # A stop puts the tissue at rest.
        drag.filter.Reset()
        reference.filter.Reset()
        for one in (drag, reference):
            one.pull(TARGETS[1])
        compare(drag, reference, "after a stop of process %d in '%s'" % (stopped, text))
    require(len(errors) == 1, "process %d has had %d errors", rank, len(errors))


def compare_same_state(drag, reference):
    """Asks for pieces with a layer of ghosts, and compares them with the whole of the state that is shown."""
    whole = [content(reference.filter.GetOutputDataObject(port)) for port in range(2)]
    narrow = drag.update()
    wide = drag.update(ghosts=1)
    require(drag.problem() == "", "with ghosts: %s", drag.problem())
    wider = 0
    for port in range(2):
        for part in (narrow[port], wide[port]):
            why = differs(part, whole[port])
            require(not why, "with ghosts, output %d: %s", port, why)
        wider += int((wide[port]["extent"] != narrow[port]["extent"]).sum())
    require(wider > 0, "the pieces with ghosts are no larger")


if len(sys.argv) > 1:
    main()
    harness.end_together()
else:
    harness.mpiexec(1, "")  # or skips
    harness.run_together(PROCESSES, __file__, "ranks", timeout=300)
    print(PROCESSES, "processes")
