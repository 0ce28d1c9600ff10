"""What is saved with ParaView's defaults opens again, bit for bit: the deformed volume and the model at rest as .vti, a
probe as .vtp, and blocks as .vtm. A parser refuses XML files with raw data behind the XML, and so does ParaView up to 5.12
where libexpat is new; there they have to be whole XML."""

import glob
import os
import xml.etree.ElementTree as ElementTree

from paraview import servermanager
from paraview.simple import *
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet

from harness import OUTPUT, produce, require

folder = os.path.join(OUTPUT, "TestSaveData")
os.makedirs(folder, exist_ok=True)

scan = Wavelet(WholeExtent=[0, 15, 0, 13, 0, 11])
probe = ChainMailProbe(Position=[7.0, 6.0, 5.0], Target=[9.5, 6.0, 5.0], Radius=2)
deformation = ChainMailDeformation(Input=scan, Probes=[probe])
together = vtkMultiBlockDataSet()
for port in (0, 1):
    together.SetBlock(port, servermanager.Fetch(deformation, 0, idx=port))
blocks = produce(together)


def arrays(data):
    """{where and what: values} of all arrays of numbers."""
    if data.IsA("vtkCompositeDataSet"):
        blocks = [data.GetBlock(n) for n in range(data.GetNumberOfBlocks())]
        return {(n,) + name: values for n, block in enumerate(blocks) for name, values in arrays(block).items()}
    found = {}
    for kind, attributes in (("point", data.GetPointData()), ("field", data.GetFieldData())):
        for n in range(attributes.GetNumberOfArrays()):
            if attributes.GetArray(n):
                found[kind, attributes.GetArrayName(n)] = vtk_to_numpy(attributes.GetArray(n)).copy()
    return found


for name, source, port in (("deformed.vti", deformation, 0), ("model.vti", deformation, 1), ("probe.vtp", probe, 0),
                           ("blocks.vtm", blocks, 0)):
    path = os.path.join(folder, name)
    SaveData(path, proxy=OutputPort(source, port))
    back = OpenDataFile(path)
    back.UpdatePipeline()
    saved, read = arrays(servermanager.Fetch(source, 0, idx=port)), arrays(servermanager.Fetch(back))
    require(len(saved) > 1 and (name != "model.vti" or ("point", "Displacement") in saved), "%s: nothing to save", name)
    for key, values in saved.items():
        require(key in read and values.dtype == read[key].dtype and values.tobytes() == read[key].tobytes(),
                "%s: %s is not what was saved", name, key)
    if GetParaViewVersion() < (5, 13):
        for file in [path] + glob.glob(os.path.join(folder, "blocks", "*")):
            ElementTree.parse(file)  # or it raises an error
    print(name, "opens again")
