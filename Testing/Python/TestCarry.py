"""Data/carry.py carries points, images and labels along as the filter itself deforms them: on a phantom without cuts, in an
image that is turned and flipped, too."""

import os
import sys

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from harness import (DATA, OUTPUT, Reports, add_array, make_image, points_of, produce, require,  # noqa: E402
                     run_pvpython, same_bits, update)
from paraview.simple import *  # noqa: E402, F403
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkPolyData

sys.path.insert(0, DATA)
from carry import carry_image, carry_points, transform_of  # noqa: E402
from make_forearm import make_forearm  # noqa: E402

AIR = -300
phantom = make_forearm((66, 62, 64))
n = phantom.GetDimensions()
spacing = np.array(phantom.GetSpacing())
ct = points_of(phantom, "CT").reshape(n[::-1])
# What another examination would bring: labels and a smooth image, where there is tissue.
z, y, x = np.meshgrid(*(np.arange(size) for size in ct.shape), indexing="ij")
labels = np.where(ct >= AIR, 1 + (x // 3 + y // 3 + z // 3) % 5, 0).astype(np.uint8)
smooth = np.where(ct >= AIR, 200 + 50 * np.sin(x / 7) + 40 * np.cos(y / 6) + 30 * np.sin(z / 9), 0).astype(np.float32)


def points_as_data(places):
    points = vtkPoints()
    points.SetData(numpy_to_vtk(np.ascontiguousarray(places, dtype=float), deep=1))
    data = vtkPolyData()
    data.SetPoints(points)
    return data


def moved(places, transform):
    return vtk_to_numpy(carry_points(points_as_data(places), transform).GetPoints().GetData())


def largest(difference):
    return float(np.abs(difference).max())


def play(what, direction, origin, first):
    turn = np.asarray(direction, float)
    world = lambda index: origin + (turn @ (np.asarray(index) * spacing).T).T
    image = make_image(ct, "CT", spacing, origin, first, turn)
    add_array(image, labels, "Labels")
    add_array(image, smooth, "Smooth")
    # Skin and fat of the upper side, pulled along the limb and outwards.
    k, i = 30, 33
    j = int(np.flatnonzero(ct[k, :, i] >= AIR).max()) - 3
    position = world(np.array([i, j, k]) + first)
    probe = ChainMailProbe(Position=position, Target=position + turn @ [2.0, 2.0, 5.0], Radius=5.0)
    deformation = ChainMailDeformation(Input=produce(image), Probes=[probe], MaterialPreset="CT (Hounsfield units)",
                                       LabelArrays=["Labels"], RelaxationPreset="Balanced")
    volume, model = update(deformation, Reports(deformation))
    displacement = points_of(model, "Displacement")
    tissue = points_of(model, "Element") > 0
    far = np.linalg.norm(displacement, axis=1)
    require(far.max() > 4 and (far[tissue] > 1).mean() > 0.005, "%s: tissue moved by up to %g mm", what, far.max())
    transform = transform_of(model)

    # At its elements the transform is the displacement. VTK keeps the points as floats of up to 300 mm.
    rest = world(np.stack([x, y, z], axis=-1).reshape(-1, 3) + first)[tissue]
    there = moved(rest, transform)
    require(largest(there - rest - displacement[tissue]) < 1e-4, "%s: an element is off by %g mm", what,
            largest(there - rest - displacement[tissue]))
    # And back, as exactly as the inverse is asked for. Where links are squeezed to nothing there is no way back.
    some = slice(None, None, 7)
    back = largest(moved(there[some], transform.GetInverse()) - rest[some]) / spacing.min()
    require(back < 0.05, "%s: there and back is %g voxels off", what, back)
    # A place in the air goes along with the skin that it is next to.
    outside = world(np.array([[i, j + 5, k]]) + first)
    require(np.linalg.norm(moved(outside, transform) - outside) > 2, "%s: air beside the skin stays", what)

    # Images: as the filter deforms the array, but for the border of tissue and what was pushed out of it.
    inside = points_of(volume, "CT") >= AIR
    print("%s: up to %.1f mm; there and back %.1e voxels" % (what, far.max(), back), end="")
    for name, nearest, most in (("Smooth", False, 3.0), ("Labels", True, 0.0)):
        alone = make_image(points_of(image, name).reshape(n[::-1]), name, spacing, origin, first, turn)
        carried = points_of(carry_image(alone, transform, labels=nearest), name).astype(float)
        own = points_of(volume, name).astype(float)
        stayed = points_of(image, name).astype(float)
        changed = inside & (np.abs(own - stayed) > most)
        off = np.abs(carried - own) > most
        require(changed.sum() > 300, "%s, %s: too little changed to tell", what, name)
        print("; %s: %.2f %% of the voxels that changed differ, %.3f %% of the others" % (
            name, 100 * off[changed].mean(), 100 * off[inside & ~changed].mean()), end="")
        require(off[changed].mean() < 0.06, "%s, %s: %.1f %% of what changed differs from the filter's", what, name,
                100 * off[changed].mean())
        require(off[inside & ~changed].mean() < 0.01, "%s, %s: %.2f %% of what stayed differs", what, name,
                100 * off[inside & ~changed].mean())
        # The wrong way round would not do.
        if nearest:
            wrong = points_of(carry_image(alone, transform.GetInverse(), labels=True), name)
            require((wrong != own)[changed].mean() > 0.3, "%s: the inverse does as well", what)
    print()
    return deformation, volume, rest, there


deformation, volume, rest, there = play("straight", np.eye(3), np.array(phantom.GetOrigin()), (0, 0, 0))

# Labels from a file of their own, whose array has the name of the scan's: the filter takes them along as it does its own.
scan, other = (produce(make_image(values, "CT", spacing, phantom.GetOrigin())) for values in (ct, labels))
resampled = ResampleWithDataset(SourceDataArrays=other, DestinationMesh=scan, CategoricalData=1)
deformation.Input = AppendAttributes(Input=[scan, resampled])
deformation.LabelArrays = ["CT_input_1"]
both, _ = update(deformation, Reports(deformation))
require(same_bits(points_of(both, "CT_input_1"), points_of(volume, "Labels")), "labels from a file of their own differ")

c, s = np.cos(0.5), np.sin(0.5)
play("turned", np.array([[c, s, 0], [0, 0, 1], [-s, c, 0]]), np.array([31.0, -7.0, 12.0]), (3, -2, 5))

# The program: landmarks of the deformed scan, back to rest.
paths = {name: os.path.join(OUTPUT, "Carry-" + name + kind) for name, kind in (("model", ".vti"), ("there", ".vtp"), ("back", ".vtp"))}
SaveData(paths["model"], proxy=OutputPort(deformation, 1), DataMode="Binary")
SaveData(paths["there"], proxy=produce(points_as_data(there[::997])), DataMode="Binary")
status, output = run_pvpython(os.path.join(DATA, "carry.py"), paths["model"], paths["there"], paths["back"], "--back")
require(status == 0, "carry.py ends with status %d:\n%s", status, output)
source = OpenDataFile(paths["back"])
source.UpdatePipeline()
back = vtk_to_numpy(servermanager.Fetch(source).GetPoints().GetData())
require(largest(back - rest[::997]) < 0.05 * spacing.min(), "carry.py does not bring landmarks back")
