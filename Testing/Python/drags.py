"""A drag in several processes, and the same one in each of them alone, for TestRankFailures.py and TestRankMemory.py."""

import harness
from chainmail.ChainMailFilters import vtkChainMailDeformation
from harness import require
from pieces import content, differs, processes
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPiecewiseFunction
from vtkmodules.vtkCommonExecutionModel import vtkTrivialProducer
from vtkmodules.vtkFiltersCore import vtkPassThrough
from vtkmodules.vtkImagingCore import vtkImageCast, vtkRTAnalyticSource

# Steps of a drag: where the probe's tissue is to go.
TARGETS = [[2.0, 1.0, 4.0], [3.5, 1.5, -2.0], [-3.0, 2.0, 5.0]]


class Drag:
    """A filter with its own source and probe, which all processes have."""

    def __init__(self, alone):
        self.source = vtkRTAnalyticSource()
        self.source.SetWholeExtent(-12, 12, -11, 13, -10, 14)
        self.filter = vtkChainMailDeformation()
        self.filter.SetInputConnection(self.source.GetOutputPort())
        self.filter.SetMode(1)  # Interactive
        self.filter.SetTissueThreshold(0.0)
        self.filter.SetBackgroundValue(0.0)
        material = vtkPiecewiseFunction()
        material.AddPoint(0.0, 0.3)
        material.AddPoint(300.0, 0.1)
        self.filter.SetMaterialFunction(material)
        self.filter.SetRelaxationIterations(3)
        self.filter.SetPropagationTimes(True)
        for name in ("Constraint", "Cluster"):
            self.filter.GetModelArraySelection().EnableArray(name)
        self.alone = alone
        if alone:
            self.filter.SetController(None)
        self.pull(TARGETS[0])

    def give_all_to_first(self, let_go):
        """The first process has all of the image, and with `let_go` VTK frees it after each update."""
        image = vtkImageData()
        if processes()[0] == 0 or self.alone:
            self.source.Update()
            image.ShallowCopy(self.source.GetOutput())
        producer = vtkTrivialProducer()
        producer.SetOutput(image)
        producer.SetWholeExtent(self.source.GetWholeExtent())
        again = vtkPassThrough()
        again.SetInputConnection(producer.GetOutputPort())
        again.SetReleaseDataFlag(let_go)
        self.filter.SetInputConnection(again.GetOutputPort())

    def reduce(self):
        """A reduced model of whole numbers, which all processes make together."""
        self.source.UpdatePiece(*((0, 1) if self.alone else processes()), 0)
        whole = vtkImageCast()
        whole.SetInputData(self.source.GetOutput())
        whole.SetOutputScalarTypeToShort()
        whole.Update()
        producer = vtkTrivialProducer()
        producer.SetOutput(whole.GetOutput())
        producer.SetWholeExtent(self.source.GetWholeExtent())
        self.filter.SetInputConnection(producer.GetOutputPort())
        self.filter.SetModelReduction(2)

    def pull(self, way):
        points = harness.make_points([[0.0, 1.0, 2.0]], Displacement=[way], Radius=[3.0])
        self.filter.SetInputDataObject(1, points)

    def update(self, ghosts=0):
        rank, size = (0, 1) if self.alone else processes()
        self.filter.UpdatePiece(rank, size, ghosts)
        # VTK marks ghosts in the outputs of any filter.
        return [{key: value.copy() for key, value in content(self.filter.GetOutputDataObject(port)).items()
                 if not key.endswith("vtkGhostType")} for port in range(2)]

    def problem(self):
        """The message of the last update; empty where it went well."""
        array = self.filter.GetOutput().GetFieldData().GetAbstractArray("Error")
        return array.GetValue(0) if array else ""


def compare(drag, reference, when, ghosts=0):
    parts = drag.update(ghosts)
    require(drag.problem() == "", "%s: %s", when, drag.problem())
    wholes = reference.update()
    for port in range(2):
        why = differs(parts[port], wholes[port])
        require(not why, "%s, output %d: %s", when, port, why)
    return parts
