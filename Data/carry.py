"""Carries meshes, landmarks, images and labels along with a deformation.

    pvpython Data/carry.py model.vti organ.vtp moved.vtp             a mesh or landmarks: the points move
    pvpython Data/carry.py model.vti pet.mhd moved.vti               an image: resampled, on its own grid
    pvpython Data/carry.py model.vti labels.mhd moved.vti --labels   each voxel takes the nearest label
    pvpython Data/carry.py model.vti moved.vtp rest.vtp --back       from the deformed scan to the scan at rest

model.vti is the second output of ChainMail Deformation, saved with SaveData: the displacement u of every element. A
place X of the tissue at rest is at X + u(X) now; both are in the scan's world axes, in mm. What lies beside tissue goes
along with the tissue next to it.

As a module, `transform_of(model)` gives the same as a VTK transform. It is smooth, so it knows no cut: within a voxel of
one, a point takes a mean of both lips. Images on the scan's own grid are better given to the filter itself, as further
point arrays of its input; it resamples them with the scan, with cuts and all.
"""

import argparse
import os
import sys

import numpy as np

try:
    from paraview import vtk  # noqa: F401  (puts ParaView's own vtkmodules on the path)
except ImportError:
    pass
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPointSet
from vtkmodules.vtkCommonTransforms import vtkGeneralTransform, vtkTransform
from vtkmodules.vtkFiltersGeneral import vtkTransformFilter
from vtkmodules.vtkFiltersHybrid import vtkGridTransform
from vtkmodules.vtkImagingCore import vtkImageReslice


def spread(values, known):
    """values [z, y, x, component] where they are known, and elsewhere smoothly on from there: a mean over blocks twice as
    large, and so on until all is known."""
    if known.all() or not known.any():
        return values
    size = np.array(known.shape)
    even = [(0, n % 2) for n in size]
    blocks = np.array([(n + 1) // 2 for n in size])
    cells = np.ravel([(n, 2) for n in blocks])
    weight = np.pad(known.astype(np.float32), even).reshape(cells).sum(axis=(1, 3, 5))
    total = np.pad(np.where(known[..., None], values, 0), even + [(0, 0)]).reshape(*cells, -1).sum(axis=(1, 3, 5))
    coarse = spread(total / np.maximum(weight, 1)[..., None], weight > 0)
    for axis, n in enumerate(size):  # a quarter of the next block, three of its own
        before = np.take(coarse, np.maximum(np.arange(blocks[axis]) - 1, 0), axis)
        after = np.take(coarse, np.minimum(np.arange(blocks[axis]) + 1, blocks[axis] - 1), axis)
        pair = np.stack([0.75 * coarse + 0.25 * before, 0.75 * coarse + 0.25 * after], axis + 1)
        shape = list(coarse.shape)
        shape[axis] *= 2
        coarse = np.take(pair.reshape(shape), np.arange(n), axis)
    return np.where(known[..., None], values, coarse).astype(np.float32)


def axes_of(image):
    """The transform from the coordinates of an image without its direction matrix to world coordinates."""
    origin, turn = np.array(image.GetOrigin()), np.eye(4)
    turn[:3, :3] = [[image.GetDirectionMatrix().GetElement(i, j) for j in range(3)] for i in range(3)]
    turn[:3, 3] = origin - turn[:3, :3] @ origin
    transform = vtkTransform()
    transform.SetMatrix(turn.ravel())
    return transform


def chain(*transforms):
    """One transform for all of them, the first of which comes first."""
    result = vtkGeneralTransform()
    result.PostMultiply()
    for transform in transforms:
        result.Concatenate(transform)
    return result


def transform_of(model):
    """The vtkGeneralTransform that takes a place of the tissue at rest to where it is now; GetInverse() of it is the way
    back. model: the filter's second output."""
    size = model.GetDimensions()
    arrays = model.GetPointData()
    displacement = vtk_to_numpy(arrays.GetArray("Displacement")).reshape(*size[::-1], 3)
    tissue = vtk_to_numpy(arrays.GetArray("Element")).reshape(size[::-1]) > 0
    # The grid is VTK's, which knows no direction matrix: displacements along the image's axes.
    axes = axes_of(model)
    turn = np.array([[axes.GetMatrix().GetElement(i, j) for j in range(3)] for i in range(3)])
    along = np.ascontiguousarray((spread(displacement, tissue) @ turn.astype(np.float32)).reshape(-1, 3))
    grid = vtkImageData()
    grid.SetExtent(model.GetExtent())
    grid.SetOrigin(model.GetOrigin())
    grid.SetSpacing(model.GetSpacing())
    grid.GetPointData().SetScalars(numpy_to_vtk(along, deep=1))
    transform = vtkGridTransform()
    transform.SetDisplacementGridData(grid)
    transform.SetInterpolationModeToLinear()
    transform.SetInverseTolerance(1e-3 * min(model.GetSpacing()))
    return chain(axes.GetInverse(), transform, axes)


def carry_points(data, transform):
    """A copy of a mesh or of landmarks (any vtkPointSet) whose points went along."""
    filter_ = vtkTransformFilter()
    filter_.SetInputData(data)
    filter_.SetTransform(transform)
    filter_.Update()
    return filter_.GetOutput()


def carry_image(image, transform, labels=False, background=None):
    """What the image shows when it goes along, on its own grid. A voxel looks back to where its tissue was. background:
    of voxels whose tissue was not in the image; by default its smallest value."""
    axes = axes_of(image)
    straight = image.NewInstance()  # vtkImageReslice minds directions in some versions of VTK
    straight.ShallowCopy(image)
    straight.SetDirectionMatrix(1, 0, 0, 0, 1, 0, 0, 0, 1)
    reslice = vtkImageReslice()
    reslice.SetInputData(straight)
    reslice.SetResliceTransform(chain(axes, transform.GetInverse(), axes.GetInverse()))
    reslice.SetInterpolationModeToNearestNeighbor() if labels else reslice.SetInterpolationModeToLinear()
    reslice.SetBackgroundLevel(image.GetScalarRange()[0] if background is None else background)
    reslice.Update()
    result = reslice.GetOutput()
    result.SetDirectionMatrix(image.GetDirectionMatrix())
    return result


def main(arguments):
    from paraview import servermanager
    from paraview.simple import OpenDataFile, SaveData, TrivialProducer
    parser = argparse.ArgumentParser(prog="carry.py", formatter_class=argparse.RawDescriptionHelpFormatter, description=__doc__)
    parser.add_argument("model", help="the second output of ChainMail Deformation, in a file")
    parser.add_argument("data", help="what is carried along: a mesh, points or an image, in a file that ParaView reads")
    parser.add_argument("output", help="the file to write")
    parser.add_argument("--labels", action="store_true", help="nearest voxel, for images of labels")
    parser.add_argument("--back", action="store_true", help="the other way, to rest")
    options = parser.parse_args(arguments)

    def read(path):
        source = OpenDataFile(path)
        return servermanager.Fetch(source) if source else None
    model, data = read(options.model), read(options.data)
    if not model or not model.GetPointData().GetArray("Displacement") or not model.GetPointData().GetArray("Element"):
        return "'%s' has no arrays Displacement and Element: it is not the model at rest." % options.model
    transform = transform_of(model)
    if options.back:
        transform = transform.GetInverse()
    if isinstance(data, vtkImageData):
        moved = carry_image(data, transform, options.labels)
    elif isinstance(data, vtkPointSet):
        moved = carry_points(data, transform)
    else:
        return "'%s' holds neither an image nor points." % options.data
    source = TrivialProducer()
    source.GetClientSideObject().SetOutput(moved)
    xml = os.path.splitext(options.output)[1].startswith(".vt") and not options.output.endswith(".vtk")
    SaveData(options.output, proxy=source, **({"DataMode": "Binary"} if xml else {}))  # readable also with a new expat


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
