"""A deformation saved as a transform: programs of ITK's family deform the scan with it as the filter did, on oblique axes
and odd spacings, with a cut; and carry points with that of the model at rest. Held against scipy and, as far as they are
there, transformix (elastix), plastimatch and antsApplyTransforms."""

import os
import shutil
import subprocess
import sys

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from harness import DATA, OUTPUT, Reports, make_image, points_of, produce, require, skip, update  # noqa: E402
from paraview.simple import *  # noqa: E402, F403

try:
    from scipy.ndimage import map_coordinates
except ImportError:
    skip("scipy was not found (on Debian the package python3-scipy)")

sys.path.insert(0, DATA)
from make_forearm import make_forearm  # noqa: E402

AIR = -1000.0
folder = os.path.join(OUTPUT, "Transforms")
shutil.rmtree(folder, ignore_errors=True)
os.makedirs(folder)

phantom = make_forearm((58, 54, 60))
ct = points_of(phantom, "CT").reshape(phantom.GetDimensions()[::-1]).astype(np.float32)
size, spacing = np.array(phantom.GetDimensions()), np.array([1.9, 2.3, 3.1])
c, s = np.cos(0.4), np.sin(0.4)
direction = np.array([[c, -s * 0.8, s * 0.6], [s, c * 0.8, -c * 0.6], [0.0, 0.6, 0.8]])
origin, first = np.array([-70.0, 31.0, 12.5]), np.array([4, -2, 7])
corner = origin + direction @ (first * spacing)


def world(index):
    return corner + (direction @ (np.asarray(index) * spacing).T).T


def write_mha(path, values):
    """An image [z, y, x], as other programs have it."""
    with open(path, "wb") as file:
        file.write(("ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nCompressedData = False\n"
                    "TransformMatrix = %s\nOffset = %s\nCenterOfRotation = 0 0 0\nElementSpacing = %s\nDimSize = %s\n"
                    "ElementType = MET_FLOAT\nElementDataFile = LOCAL\n" % tuple(
                        " ".join(repr(float(x)) if kind else str(x) for x in numbers) for kind, numbers in (
                            (1, direction.T.ravel()), (1, corner), (1, spacing), (0, values.shape[::-1])))).encode())
        file.write(np.ascontiguousarray(values, "<f4").tobytes())


def read_mha(path):
    """({key: text}, values [z, y, x] or [z, y, x, 3])."""
    with open(path, "rb") as file:
        head = {}
        while "ElementDataFile" not in head:
            key, text = file.readline().decode().split("=", 1)
            head[key.strip()] = text.strip()
        require(head["ElementDataFile"] == "LOCAL" and head.get("CompressedData", "False") == "False", "%s: %s", path, head)
        kind = {"MET_FLOAT": "<f4", "MET_SHORT": "<i2", "MET_DOUBLE": "<f8"}[head["ElementType"]]
        shape = [int(n) for n in head["DimSize"].split()][::-1]
        channels = int(head.get("ElementNumberOfChannels", 1))
        return head, np.frombuffer(file.read(), kind).reshape(shape + ([channels] if channels > 1 else []))


def numbers(text):
    return np.array([float(x) for x in text.split()])


# --- A pull at one side of an incision

k, i = 30, 28
j = int(np.flatnonzero(ct[k, :, i] > -300).max()) - 2
blade = [world([i + 2.5, j - 9, k - 8]), world([i + 2.5, j - 9, k + 8]), world([i + 2.5, j + 9, k - 8])]
cut = Plane(Origin=blade[0].tolist(), Point1=blade[1].tolist(), Point2=blade[2].tolist())
grip = world([i, j, k])
probe = ChainMailProbe(Position=grip.tolist(), Target=(grip + direction @ [-7.0, 3.0, 4.0]).tolist(), Radius=6.0)
deformation = ChainMailDeformation(Input=produce(make_image(ct, "CT", spacing, origin, first, direction)), Probes=[probe],
                                   Cuts=[cut], MaterialPreset="CT (Hounsfield units)", BackgroundValue=AIR, PullBack=1, SmoothCuts=0)
volume, model = update(deformation, Reports(deformation))
mine = points_of(volume, "CT").reshape(ct.shape)
back = points_of(volume, "PullBack").reshape(ct.shape + (3,))
nowhere = np.isnan(back[..., 0])
moved = ~nowhere & (np.abs(back) > 0).any(axis=3)
require(moved.sum() > 5000 and nowhere.sum() > 20, "%d voxels moved, %d show background", moved.sum(), nowhere.sum())

pull_back, forward = os.path.join(folder, "pull-back.mha"), os.path.join(folder, "forward.mha")
SaveData(pull_back, proxy=deformation)
SaveData(forward, proxy=OutputPort(deformation, 1))

# --- The file

head, saved = read_mha(pull_back)
require(np.abs(numbers(head["TransformMatrix"]).reshape(3, 3).T - direction).max() < 1e-12, "direction: %s", head)
require(np.abs(numbers(head["Offset"]) - corner).max() < 1e-9, "corner: %s, not %s", head["Offset"], corner)
require(np.abs(numbers(head["ElementSpacing"]) - spacing).max() < 1e-12, "spacing: %s", head["ElementSpacing"])
require(saved.dtype == np.float32 and (saved[~nowhere] == back[~nowhere]).all(), "other values are in the file")
require(np.isfinite(saved).all() and np.abs(saved[nowhere]).min() > 1e4, "background does not lie far away")
ras = os.path.join(folder, "ras.mha")
SaveData(ras, proxy=deformation, World="Right, front, head (RAS: NIfTI)")
head, turned = read_mha(ras)
turn = np.array([-1.0, -1.0, 1.0])
require((turned[~nowhere] == back[~nowhere] * turn.astype("f4")).all(), "vectors of axes to the right, front and head")
require(np.abs(numbers(head["Offset"]) - corner * turn).max() < 1e-9, "their corner: %s", head["Offset"])
require(np.abs(numbers(head["TransformMatrix"]).reshape(3, 3).T - turn[:, None] * direction).max() < 1e-12, "their axes")

# --- What it makes of the scan

k, j, i = np.indices(ct.shape)
source = np.stack([i, j, k], axis=-1) + np.where(nowhere[..., None], 0, back) @ direction / spacing
sampled = map_coordinates(ct.astype(float), source.reshape(-1, 3).T[::-1], order=1, mode="nearest").reshape(ct.shape)
sampled[nowhere] = AIR


def compare(what, theirs):
    # Places outside the scan are its border for the filter, and background for others. Voxels at it are left out.
    inside = (source >= 0.01).all(axis=3) & (source <= size - 1.01).all(axis=3)
    off = np.abs(theirs - mine)
    print("%s: %d voxels moved, largest difference %.2g HU, of background %.2g" % (
        what, moved.sum(), off[inside & moved].max(), off[nowhere].max()))
    require(off[inside & moved].max() < 0.1, "%s: %g HU off", what, off[inside & moved].max())
    require(off[inside & ~moved & ~nowhere].max() < 0.1, "%s: what rests is %g HU off", what,
            off[inside & ~moved & ~nowhere].max())
    require(off[nowhere].max() < 0.1, "%s: there is something in the background", what)


compare("scipy", sampled)

scan = os.path.join(folder, "scan.mha")
write_mha(scan, ct)
tried = []


def run(program, *arguments):
    """Whether a program is there and has done its work."""
    if not shutil.which(program):
        print("%s was not found" % program)
        return False
    done = subprocess.run([program, *arguments], cwd=folder, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    require(done.returncode == 0, "%s ends with %d:\n%s", program, done.returncode, done.stdout[-3000:])
    tried.append(program)
    return True


if run("plastimatch", "warp", "--input", scan, "--xf", pull_back, "--output-img", "plastimatch.mha", "--interpolation",
       "linear", "--default-value", "%g" % AIR, "--algorithm", "itk", "--output-type", "float"):
    compare("plastimatch", read_mha(os.path.join(folder, "plastimatch.mha"))[1])

if run("antsApplyTransforms", "-d", "3", "-i", scan, "-r", scan, "-t", pull_back, "-o", "ants.mha", "-n", "Linear", "-f",
       "%g" % AIR):
    compare("antsApplyTransforms", read_mha(os.path.join(folder, "ants.mha"))[1])


def parameters(field):
    text = lambda values: " ".join(repr(float(x)) for x in values)
    return """(Transform "DeformationFieldTransform")
(NumberOfParameters 0)
(InitialTransformParametersFileName "NoInitialTransform")
(InitialTransformParameterFileName "NoInitialTransform")
(HowToCombineTransforms "Compose")
(DeformationFieldFileName "%s")
(DeformationFieldInterpolationOrder 1)
(FixedImageDimension 3)
(MovingImageDimension 3)
(FixedInternalImagePixelType "float")
(MovingInternalImagePixelType "float")
(Size %d %d %d)
(Index 0 0 0)
(Spacing %s)
(Origin %s)
(Direction %s)
(UseDirectionCosines "true")
(ResampleInterpolator "FinalBSplineInterpolator")
(FinalBSplineInterpolationOrder 1)
(Resampler "DefaultResampler")
(DefaultPixelValue %g)
(ResultImageFormat "mha")
(ResultImagePixelType "float")
(CompressResultImage "false")
""" % (field, *size, text(spacing), text(corner), text(direction.T.ravel()), AIR)


for name, field in (("back.txt", pull_back), ("forward.txt", forward)):
    with open(os.path.join(folder, name), "w") as file:
        file.write(parameters(field))
if run("transformix", "-in", scan, "-out", folder, "-tp", "back.txt"):
    compare("transformix", read_mha(os.path.join(folder, "result.mha"))[1])
    # Points go forward: elements of the model at rest.
    displacement = points_of(model, "Displacement").reshape(ct.shape + (3,))
    chosen = np.argwhere((np.abs(displacement) > 1).any(axis=3))[::11]
    rest = world(chosen[:, ::-1])
    with open(os.path.join(folder, "points.txt"), "w") as file:
        file.write("point\n%d\n" % len(rest))
        np.savetxt(file, rest, "%.9f")
    require(run("transformix", "-def", "points.txt", "-out", folder, "-tp", "forward.txt"), "no transformix")
    with open(os.path.join(folder, "outputpoints.txt")) as file:
        there = np.array([numbers(line.split("OutputPoint = [")[1].split("]")[0]) for line in file])
    wanted = rest + displacement[tuple(chosen.T)]
    require(len(there) > 20 and np.abs(there - wanted).max() < 1e-3, "points are %g mm off", np.abs(there - wanted).max())
    print("transformix: %d points within %.1e mm" % (len(there), np.abs(there - wanted).max()))

print("read by: %s" % (", ".join(tried) or "no other program, as none is here"))
