"""What the tests of the plugin share. A test is a plain script: it ends with status 0 when all is well, 125 when what it
needs is not there, and anything else when something is wrong. CTest gives it the variables that are read here."""

import os
import shutil
import subprocess
import sys

import numpy as np
from paraview import servermanager
from paraview.simple import TrivialProducer
from vtkmodules.util.misc import calldata_type
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.util.vtkConstants import VTK_STRING
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPolyData
from vtkmodules.vtkParallelCore import vtkMultiProcessController

SKIPPED = 125
# All scenes, as run-all.sh --all wants them; else those that say most.
EVERY = bool(os.environ.get("CHAINMAIL_ALL_SCENES"))
OUTPUT = os.environ.get("CHAINMAIL_OUTPUT", os.getcwd())
DATA = os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir, os.pardir, "Data")


def require(condition, message, *values):
    """As assert, with the numbers in the message."""
    if not condition:
        sys.exit("FAILED: " + (message % values if values else message))


def skip(reason):
    print("SKIPPED:", reason)
    sys.exit(SKIPPED)


def scan(name):
    """The path of a shared scan, or None."""
    path = os.path.join(os.environ.get("CHAINMAIL_VOLUMES", ""), name + ".mhd")
    return path if os.path.isfile(path) else None


class Reports:
    """Errors and warnings of a filter. ParaView itself would print them and go on with status 0."""

    def __init__(self, *proxies):
        self.errors, self.warnings = [], []
        for proxy in proxies:
            for event, messages in (("ErrorEvent", self.errors), ("WarningEvent", self.warnings)):
                self._watch(proxy.GetClientSideObject(), event, messages)
                self._watch(proxy.GetClientSideObject().GetExecutive(), event, messages)

    @staticmethod
    def _watch(thing, event, messages):
        @calldata_type(VTK_STRING)
        def note(caller, name, text):
            messages.append(text)
        thing.AddObserver(event, note)

    def take(self):
        """The errors since the last call, as one text."""
        text = "\n".join(self.errors)
        del self.errors[:]
        return text


def update(proxy, reports):
    """Brings a filter up to date; nothing may go wrong. Returns copies of its outputs."""
    proxy.UpdatePipeline()
    errors = reports.take()
    require(not errors, "the filter reports an error:\n%s", errors)
    return servermanager.Fetch(proxy, 0, idx=0), servermanager.Fetch(proxy, 0, idx=1)


def expect_error(proxy, reports, *parts):
    """Brings a filter up to date; it has to report one error that holds every part."""
    proxy.UpdatePipeline()
    count, text = len(reports.errors), reports.take()
    require(count == 1, "%d errors instead of one that says %s:\n%s", count, parts, text)
    for part in parts:
        require(part in text, "the error does not say '%s':\n%s", part, text)


def settable(proxy):
    """The properties of a proxy that users set, by name: all but inputs, information and buttons."""
    found = {}
    properties = servermanager.PropertyIterator(proxy.SMProxy)
    for property in properties:
        is_button = property.GetClassName() == "vtkSMProperty"
        if not (is_button or property.GetInformationOnly() or property.IsA("vtkSMInputProperty")):
            found[properties.GetKey()] = property
    return found


def make_image(values, name="scalars", spacing=(1.0, 1.0, 1.0), origin=(0.0, 0.0, 0.0), first=(0, 0, 0), direction=None):
    """An image from an array [z, y, x] or [z, y, x, component]."""
    size = values.shape[2::-1]
    image = vtkImageData()
    image.SetExtent(first[0], first[0] + size[0] - 1, first[1], first[1] + size[1] - 1, first[2], first[2] + size[2] - 1)
    image.SetSpacing(spacing)
    image.SetOrigin(origin)
    if direction is not None:
        image.SetDirectionMatrix(np.asarray(direction, float).ravel().tolist())
    add_array(image, values, name)
    image.GetPointData().SetActiveScalars(name)
    return image


def add_array(image, values, name):
    components = values.shape[3] if values.ndim == 4 else 1
    flat = np.ascontiguousarray(values).reshape(-1, components) if components > 1 else np.ascontiguousarray(values).ravel()
    array = numpy_to_vtk(flat, deep=1)
    array.SetName(name)
    image.GetPointData().AddArray(array)


def make_points(places, **arrays):
    """A point set with point arrays, all in double precision."""
    points = vtkPoints()
    points.SetData(numpy_to_vtk(np.ascontiguousarray(places, dtype=float), deep=1))
    data = vtkPolyData()
    data.SetPoints(points)
    for name, values in arrays.items():
        array = numpy_to_vtk(np.ascontiguousarray(values, dtype=float), deep=1)
        array.SetName(name)
        data.GetPointData().AddArray(array)
    return data


def produce(data):
    """A ParaView source with this data."""
    source = TrivialProducer()
    source.GetClientSideObject().SetOutput(data)
    source.MarkModified(source)
    source.UpdatePipeline()
    return source


def points_of(data, name):
    """A point array as numpy."""
    array = data.GetPointData().GetArray(name)
    require(array is not None, "there is no point array '%s'", name)
    return vtk_to_numpy(array)


def field(data, name):
    """A field array as numpy, a row for each tuple."""
    array = data.GetFieldData().GetArray(name)
    require(array is not None, "there is no field array '%s'", name)
    return vtk_to_numpy(array).reshape(array.GetNumberOfTuples(), array.GetNumberOfComponents())


def same_bits(a, b):
    """Equal type, shape and bytes (so NaN equals NaN and -0.0 is not 0.0)."""
    return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()


def run_pvpython(*arguments, **environment):
    """Runs a pvpython of its own with other environment variables; None removes one. Returns status and all output."""
    variables = {**os.environ, **{k: v for k, v in environment.items() if v is not None}}
    for name, value in environment.items():
        if value is None:
            variables.pop(name, None)
    done = subprocess.run([os.environ.get("CHAINMAIL_PVPYTHON", "pvpython"), *arguments], env=variables,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=600)
    return done.returncode, done.stdout


def mpiexec(processes, program):
    """The beginning of a command that runs a program in some processes; the test skips where there is no mpiexec."""
    launcher = shutil.which("mpiexec")
    if not launcher:
        skip("mpiexec was not found (on Debian the package openmpi-bin)")
    return [launcher, "--oversubscribe", "-n", str(processes), program]


def mpi_environment():
    """For such a command. pvpython has started MPI for itself, and what that left in the environment would be taken for
    the new job's. Open MPI asks root for its word; other implementations know neither variable."""
    environment = {key: value for key, value in os.environ.items()
                   if not key.startswith(("OMPI_", "PMIX_", "PMI_", "ORTE_"))}
    environment.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
    return environment


def run_pvbatch(processes, *arguments, timeout=600):
    """Runs pvbatch in some processes, which must end well. Returns all output."""
    command = mpiexec(processes, os.environ.get("CHAINMAIL_PVBATCH", "pvbatch")) + list(arguments)
    done = subprocess.run(command, env=mpi_environment(), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          timeout=timeout)
    output = done.stdout.replace("\0", "")  # mpiexec's own messages may hold such, and pvpython prints none
    require(done.returncode == 0, "%d processes end with status %d:\n%s", processes, done.returncode, output)
    return output


def run_together(processes, script, *arguments, timeout):
    """Runs a script in some processes, each of which has to come to end_together(). Returns all output."""
    output = run_pvbatch(processes, "--sym", os.path.abspath(script), *arguments, timeout=timeout)
    require("all are done" in output, "the processes did not end:\n%s", output)
    return output


def end_together():
    """Waits for all processes, since whoever ends first would take the others with it."""
    controller = vtkMultiProcessController.GetGlobalController()
    controller.Barrier()
    if controller.GetLocalProcessId() == 0:
        os.write(1, b"all are done\n")  # at once: mpiexec mixes what processes print
