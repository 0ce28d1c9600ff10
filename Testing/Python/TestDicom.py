"""Scans that come as DICOM, as Data/InAndOut.md says: a series of slices, written by pydicom, becomes the phantom that it was
written from, by ParaView's own reader and by plastimatch; and the filter deforms it."""

import os
import shutil
import subprocess
import sys

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from harness import DATA, OUTPUT, Reports, field, points_of, require, same_bits, skip, update  # noqa: E402
from paraview import servermanager  # noqa: E402
from paraview.simple import *  # noqa: E402, F403

try:
    from pydicom.dataset import FileDataset, FileMetaDataset
    from pydicom.uid import CTImageStorage, ExplicitVRLittleEndian, generate_uid
except ImportError:
    skip("pydicom was not found (on Debian the package python3-pydicom)")

sys.path.insert(0, DATA)
from make_forearm import make_forearm  # noqa: E402

phantom = make_forearm((44, 40, 48))
n, origin = np.array(phantom.GetDimensions()), np.array(phantom.GetOrigin())
spacing = np.array([3.0, 3.0, phantom.GetSpacing()[2]])
hounsfield = points_of(phantom, "CT").reshape(n[::-1])
folder = os.path.join(OUTPUT, "Dicom")
shutil.rmtree(folder, ignore_errors=True)
os.makedirs(folder)
study, series, frame = (generate_uid() for _ in range(3))


def write_slice(path, k):
    meta = FileMetaDataset()
    meta.MediaStorageSOPClassUID, meta.MediaStorageSOPInstanceUID = CTImageStorage, generate_uid()
    meta.TransferSyntaxUID = ExplicitVRLittleEndian
    data = FileDataset(path, {}, file_meta=meta, preamble=b"\0" * 128)
    data.is_little_endian, data.is_implicit_VR = True, False
    data.SOPClassUID, data.SOPInstanceUID = CTImageStorage, meta.MediaStorageSOPInstanceUID
    data.StudyInstanceUID, data.SeriesInstanceUID, data.FrameOfReferenceUID = study, series, frame
    data.PatientName, data.PatientID, data.Modality, data.StudyDate = "Phantom", "1", "CT", "20260101"
    data.SeriesNumber, data.InstanceNumber = 1, k + 1
    data.ImagePositionPatient = [float(v) for v in origin + [0, 0, k * spacing[2]]]
    data.ImageOrientationPatient = [1, 0, 0, 0, 1, 0]  # rows to the patient's left, columns to the back: x and y
    data.PixelSpacing, data.SliceThickness = [float(spacing[1]), float(spacing[0])], float(spacing[2])
    data.Rows, data.Columns = hounsfield.shape[1:]
    data.SamplesPerPixel, data.PhotometricInterpretation, data.PixelRepresentation = 1, "MONOCHROME2", 0
    data.BitsAllocated, data.BitsStored, data.HighBit = 16, 12, 11
    data.RescaleIntercept, data.RescaleSlope = -1024, 1
    data.PixelData = (hounsfield[k] + 1024).astype("<u2").tobytes()
    data.save_as(path, write_like_original=False)


for number, k in enumerate(np.random.default_rng(3).permutation(n[2])):  # names say nothing about the order
    write_slice(os.path.join(folder, "IM%04d.dcm" % number), int(k))


def pulled(source, what):
    """The filter has Hounsfield units before it: it grabs muscle in the middle of the limb."""
    deformation = ChainMailDeformation(Input=source, MaterialPreset="CT (Hounsfield units)")
    image = servermanager.Fetch(source)
    values = points_of(image, image.GetPointData().GetArrayName(0)).reshape(n[::-1])
    k, j, i = min(np.argwhere((values > 40) & (values < 80)), key=lambda place: np.abs(place - n[::-1] / 2).sum())
    place = np.array(image.GetOrigin()) + [i, j, k] * np.array(image.GetSpacing())
    deformation.Probes = [ChainMailProbe(Position=place, Target=place + [0.5, 0, 0])]
    volume, _ = update(deformation, Reports(deformation))
    require(np.allclose(field(volume, "ProbeReached"), [0.5, 0, 0], atol=1e-3), "%s: the probe reached %s", what,
            field(volume, "ProbeReached"))


# ParaView's reader: the rows from below and the slices from above, so the patient is turned by half a turn about x and not
# mirrored, and lies at the origin.
reader = DICOMReaderdirectory(FileName=folder)
reader.UpdatePipeline()
image = servermanager.Fetch(reader)
require(tuple(image.GetDimensions()) == tuple(n), "the reader gives %s voxels", image.GetDimensions())
values = points_of(image, "DICOMImage").reshape(n[::-1])
require(same_bits(values, np.ascontiguousarray(hounsfield[::-1, ::-1])), "the reader gives other values")
require(np.allclose(image.GetSpacing(), spacing, rtol=1e-4), "the reader gives the spacing %s", image.GetSpacing())
require(image.GetOrigin() == (0, 0, 0), "the reader gives the origin %s", image.GetOrigin())
pulled(reader, "ParaView's reader")

if not shutil.which("plastimatch"):
    print("there is no plastimatch: ParaView's reader alone was tried")
    sys.exit()
path = os.path.join(OUTPUT, "Dicom.mhd")
done = subprocess.run(["plastimatch", "convert", "--input", folder, "--output-img", path, "--output-type", "short"],
                      stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=300)
require(done.returncode == 0, "plastimatch ends with %d:\n%s", done.returncode, done.stdout)
scan = OpenDataFile(path)
scan.UpdatePipeline()
image = servermanager.Fetch(scan)
require(same_bits(points_of(image, "MetaImage").reshape(n[::-1]), hounsfield), "plastimatch gives other values")
require(np.allclose(image.GetSpacing(), spacing, rtol=1e-4), "plastimatch gives the spacing %s", image.GetSpacing())
require(np.allclose(image.GetOrigin(), origin, atol=1e-3), "plastimatch gives the origin %s", image.GetOrigin())
pulled(scan, "plastimatch")
print("both read the series")
