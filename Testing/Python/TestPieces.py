"""Asked for a piece, as a writer that streams asks, the filter gives that piece of the whole, to the bit: both outputs, from
rest and in Interactive mode, in which the pieces of an update are of one state. The same scenes are shared out to several
processes by TestRanks.py."""

import tempfile

import pieces
import harness  # not its names: scripts of programmable sources run in this module and bring their own
from vtkmodules.vtkCommonCore import vtkInformationVector
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline as pipeline


def copies(filter):
    """Of both outputs: the next update writes into the same data objects."""
    outputs = [pieces.content(filter.GetClientSideObject().GetOutputDataObject(port)) for port in range(2)]
    return [{name: values.copy() for name, values in output.items()} for output in outputs]


def ask(filter, port, piece, count):
    requests = vtkInformationVector()
    requests.SetNumberOfInformationObjects(2)
    requests.GetInformationObject(port).Set(pipeline.UPDATE_PIECE_NUMBER(), piece)
    requests.GetInformationObject(port).Set(pipeline.UPDATE_NUMBER_OF_PIECES(), count)
    requests.GetInformationObject(port).Set(pipeline.UPDATE_NUMBER_OF_GHOST_LEVELS(), 0)
    filter.GetClientSideObject().Update(port, requests)


with tempfile.TemporaryDirectory(dir=harness.OUTPUT) as folder:
    for name, arguments in pieces.scenes(folder).items():
        wholes = {}

        def keep(step, filter):
            filter.UpdatePipeline()
            wholes[step] = copies(filter)

        pieces.Scene(*arguments).play(keep)
        moved = [wholes[step][1]["point 0 Displacement"] for step in ("from rest", "interactive", "dragged", "settled on")]
        for before, after in zip([0 * moved[0]] + moved, moved):
            harness.require((before != after).any(axis=1).sum() > 1000, "%s: steps of a scene are alike", name)
        for count in (2, 4, 7) if name == "forearm.vti" or pieces.EVERY else (4,):
            def compare(step, filter):
                # Either output may be the one that is asked for; the other one is of the same piece then.
                got = []
                for piece in range(count):
                    ask(filter, piece % 2, piece, count)
                    got.append(copies(filter))
                for port in range(2):
                    for piece in range(count):
                        why = pieces.differs(got[piece][port], wholes[step][port])
                        harness.require(not why, "%s, %s, output %d, piece %d of %d: %s", name, step, port, piece, count, why)
                    harness.require(pieces.covers([both[port] for both in got], wholes[step][port]),
                            "%s, %s, output %d: %d pieces are not the whole", name, step, port, count)

            pieces.Scene(*arguments).play(compare)
        print(name, flush=True)
