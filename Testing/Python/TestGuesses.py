"""What the defaults take scans for, in ParaView: one wrong voxel, rings, slopes and padding change nothing; labels are labels;
an image of cells is refused with what to do; and the model at rest is saved as its displacement."""

import os

import numpy as np
from harness import OUTPUT, Reports, expect_error, field, make_image, points_of, produce, require, same_bits, scan, update
from paraview import servermanager
from paraview.simple import *
from vtkmodules.vtkCommonCore import vtkFloatArray


def read(name):
    """A shared scan as numpy and its spacing; None where it is not there."""
    path = scan(name)
    if not path:
        print("not there, so not tested:", name)
        return None, None
    image = servermanager.Fetch(OpenDataFile(path), 0)
    return points_of(image, "MetaImage").reshape(image.GetDimensions()[::-1]), image.GetSpacing()


def report(deformation):
    deformation.UpdatePropertyInformation()
    return deformation.Report


# A T1-weighted head: the same pull of 6 mm, at the same place, of the scan as it is and as it may come.
head, spacing = read("head_mr")
if head is not None:
    head = head[::3, ::3, ::3]
    spacing = [3 * length for length in spacing]
    # On the scalp, in the middle of the front.
    middle = np.array(head.shape[::-1]) // 2
    column = np.argwhere(head[middle[2], :, middle[0]] > 60).ravel()
    place = np.array([middle[0], column[-1] - 3, middle[2]]) * spacing
    rng = np.random.default_rng(3)
    rings = 4.0 * head.astype(np.float32)
    beside = (head < 5) & (rng.random(head.shape) < 0.04)
    rings[beside] -= rng.exponential(120.0, beside.sum()).astype(np.float32)
    hot, dead = head.astype(np.int16), head.astype(np.int16)
    hot[3, 4, 5], dead[3, 4, 5] = 5 * 255, -1000
    outside = np.hypot(*np.ogrid[-1:1:1j * head.shape[1], -1:1:1j * head.shape[2]]) > 1.0
    around = head.astype(np.int16)
    around[np.broadcast_to(outside, head.shape)] = -3024
    versions = {"as it is": head, "one voxel at five times the largest": hot, "a dead voxel at -1000": dead,
                "rings below zero": rings, "stretched": (200 * head.astype(np.int32) - 20000).astype(np.int16),
                "-3024 around": around}
    shares = {}
    for name, values in versions.items():
        source = produce(make_image(values, spacing=spacing))
        deformation = ChainMailDeformation(Input=source, AnchoredFaces=[0, 0, 0, 0, 1, 0], RelaxationIterations=5,
                                           Probes=[ChainMailProbe(Position=place, Target=place + [0, 6, 0], Radius=5)])
        reports = Reports(deformation)
        volume, model = update(deformation, reports)
        reached = np.linalg.norm(field(volume, "ProbeReached")[0])
        shares[name] = points_of(model, "Element").mean()
        require(reached > 5.99, "%s: the pull reached %g of 6 mm; %s", name, reached, report(deformation))
        require("Taken for MR" in report(deformation), "%s: the report is %s", name, report(deformation))
        # Of the voxels that were changed themselves, none may make others air or tissue.
        bound = 0.002 if name != "-3024 around" else 0.02
        require(abs(shares[name] - shares["as it is"]) <= bound, "%s: %.2f %% of the voxels are tissue, not %.2f %%", name,
                100 * shares[name], 100 * shares["as it is"])
        doubtful = name in ("rings below zero", "stretched")
        require(bool(reports.warnings) == doubtful, "%s: the warnings are %s", name, reports.warnings)
        Delete(deformation)

# Labels of organs, as the scan itself: all of them are tissue, and no voxel shows one that is nowhere near.
labels, spacing = read("abdomen_labels")
if labels is not None:
    source = produce(make_image(labels, spacing=spacing))
    index = np.argwhere(labels == 5)
    index = index[((index - index.mean(axis=0)) ** 2).sum(axis=1).argmin()]
    place = index[::-1] * np.array(spacing)
    deformation = ChainMailDeformation(Input=source, RelaxationIterations=5,
                                       Probes=[ChainMailProbe(Position=place, Target=place + [4, 5, 6], Radius=20)])
    reports = Reports(deformation)
    volume, model = update(deformation, reports)
    require(not reports.warnings, "labels: the warnings are %s", reports.warnings)
    require((deformation.TissueThreshold, deformation.BackgroundValue) == (0.5, 0.0), "labels: threshold %g, background %g",
            deformation.TissueThreshold, deformation.BackgroundValue)
    require("Taken for labels" in report(deformation), "labels: the report is %s", report(deformation))
    require(same_bits(points_of(model, "Element") > 0, labels.ravel() > 0), "labels: not all but 0 are tissue")
    after = points_of(volume, "scalars").reshape(labels.shape)
    moved = np.argwhere(after != labels)
    require(len(moved) > 300, "labels: only %d voxels changed", len(moved))
    # Nothing goes further than the probe, 3 voxels, and the nearest voxel is at most one more.
    nowhere = sum(after[tuple(v)] not in labels[tuple(slice(max(0, c - 4), c + 5) for c in v)] for v in moved)
    require(nowhere == 0, "%d of %d changed voxels have labels that are nowhere near", nowhere, len(moved))
    print("labels: %d voxels changed, none to a label from elsewhere" % len(moved), flush=True)
    Delete(deformation)

# Padding around a CT: holes show air, and nothing shows a blend.
ct, spacing = read("abdomen_ct")
if ct is not None:
    outside = np.hypot(*np.ogrid[-1:1:1j * ct.shape[1], -1:1:1j * ct.shape[2]]) > 0.75  # goes through the flanks
    for padding, kind, offset in ((-3024, np.int16, 0), (-2000, np.int16, 0), (-32768, np.int16, 0), (65535, np.uint16, 1207),
                                  (63536, np.uint16, 1207)):
        values = (ct.astype(np.int32) + offset).astype(kind)
        values[np.broadcast_to(outside, ct.shape)] = padding
        low, high = values[values != padding].min(), values[values != padding].max()
        deformation = ChainMailDeformation(Input=produce(make_image(values, spacing=spacing)), RelaxationIterations=5)
        reports = Reports(deformation)
        volume, model = update(deformation, reports)
        require(same_bits(points_of(volume, "scalars"), values.ravel()), "%d: a voxel changed at rest", padding)
        require(not points_of(model, "Element")[values.ravel() == padding].any(), "%d: padding is tissue", padding)
        require("padding" in report(deformation), "%d: the report is %s", padding, report(deformation))
        air = deformation.BackgroundValue - offset
        require(-1010 < air < -950, "%d: the background is %g", padding, air)
        # A pull from the middle of the right flank inwards and up, where tissue ends at the padding.
        row = np.argwhere(points_of(model, "Element").reshape(ct.shape)[56, 50] > 0).ravel()
        place = np.array([row[0], 50, 56]) * spacing
        deformation.Probes = [ChainMailProbe(Position=place, Target=place + [7, 2, 4], Radius=12)]
        volume, model = update(deformation, reports)
        after = points_of(volume, "scalars")
        changed = after != values.ravel()
        require(changed.sum() > 300, "%d: only %d voxels changed", padding, changed.sum())
        require(((after[changed] >= low) & (after[changed] <= high)).all(), "%d: voxels changed to %s, and scans have %d to %d",
                padding, np.unique(after[changed & ((after < low) | (after > high))])[:5], low, high)
        # Where tissue went away from the padding there is air, not what was not measured.
        require((after[changed] == deformation.BackgroundValue).any(), "%d: no hole shows the background", padding)
        Delete(deformation)
    print("padding: set aside", flush=True)

# Cells alone, as GDAL's reader gives them.
image = make_image(rng.uniform(0, 100, (6, 7, 8)).astype(np.float32)) if head is not None else \
    make_image(np.random.default_rng(3).uniform(0, 100, (6, 7, 8)).astype(np.float32))
image.GetPointData().Initialize()
cells = vtkFloatArray()
cells.SetName("Band 1")
cells.SetNumberOfTuples(image.GetNumberOfCells())
cells.Fill(1.0)
image.GetCellData().SetScalars(cells)
deformation = ChainMailDeformation(Input=produce(image))
reports = Reports(deformation)
expect_error(deformation, reports, "cell data alone", "Band 1", "Cell Data to Point Data")
deformation = ChainMailDeformation(Input=CellDatatoPointData(Input=produce(image)))
update(deformation, Reports(deformation))

# The model at rest, saved as MetaImage: the displacement, as Data/InAndOut.md says.
image = make_image(np.full((9, 10, 11), 100, np.int16), spacing=(1, 2, 3), origin=(5, 6, 7))
deformation = ChainMailDeformation(Input=produce(image), Probes=[ChainMailProbe(Position=[10, 16, 19], Target=[10.5, 17, 20])])
_, model = update(deformation, Reports(deformation))
for ending in ("mhd", "vti", "vtk"):
    path = os.path.join(OUTPUT, "model-at-rest." + ending)
    SaveData(path, proxy=OutputPort(deformation, 1))
    saved = servermanager.Fetch(OpenDataFile(path), 0)
    arrays = saved.GetPointData()
    name = "MetaImage" if ending == "mhd" else "Displacement"
    require(arrays.GetArray(name) is not None and same_bits(points_of(saved, name), points_of(model, "Displacement")),
            "%s holds no displacement but %s", path, [arrays.GetArrayName(a) for a in range(arrays.GetNumberOfArrays())])
    require(points_of(saved, name).any(), "%s: nothing moved", path)
    require(np.allclose(saved.GetOrigin(), image.GetOrigin()) and np.allclose(saved.GetSpacing(), image.GetSpacing()),
            "%s is at another place", path)
print("guesses hold")
