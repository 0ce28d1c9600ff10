"""makeBones.py FOLDER: writes a scan of two bones in soft tissue in air, scan.vti, their labels, labels.vti, and the scan without
them, soft.vti."""

import os
import sys

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkIOXML import vtkXMLImageDataWriter

SIZE = (48, 40, 56)
scan = np.full(SIZE[::-1], -1000, np.int16)
labels = np.zeros(scan.shape, np.uint8)
scan[3:-3, 3:-3, 3:-3] = 40
for label, slices in ((4, slice(10, 22)), (5, slice(23, 35))):
    scan[slices, 12:28, 14:34] = 900
    labels[slices, 12:28, 14:34] = label
for name, values in (("scan", scan), ("labels", labels), ("soft", np.minimum(scan, 40))):
    image = vtkImageData()
    image.SetDimensions(SIZE)
    image.SetSpacing(2, 2, 2)
    image.SetOrigin(-47, -39, -57)
    array = numpy_to_vtk(values.ravel(), deep=1)
    array.SetName("values")
    image.GetPointData().SetScalars(array)
    writer = vtkXMLImageDataWriter()
    writer.SetFileName(os.path.join(sys.argv[1], name + ".vti"))
    writer.SetInputData(image)
    writer.Write()
