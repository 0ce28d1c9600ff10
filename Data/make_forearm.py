"""A forearm as a CT scanner would see it: skin, fat, muscles, tendons, two bones, vessels, blur and noise.

    pvpython Data/make_forearm.py forearm.vti
    pvpython Data/make_forearm.py forearm.mhd --size 88 80 104

As a module, `make_forearm(size)` returns the vtkImageData. It needs numpy and the VTK of ParaView (or any other VTK).

The limb lies along z, the wrist at z-, the elbow at z+, the thumb's side at x+, the back of the hand at y+. The box
measures 132 x 124 x 230 mm whatever the size in voxels; the limb leaves it through both z faces, as in a scan of a part
of the body. Every millimetre below is from an adult's anatomy or a plausible guess at it; the scalars ("CT", int16) are
Hounsfield units. The same size and seed give the same voxels.
"""

import argparse
import os
import sys
import time

import numpy as np

try:
    from paraview import vtk  # noqa: F401  (puts ParaView's own vtkmodules on the path)
except ImportError:
    pass
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonCore import VTK_SHORT
from vtkmodules.vtkCommonDataModel import vtkImageData

BOX = (132.0, 124.0, 230.0)  # [mm]
DEFAULT_SIZE = (176, 160, 208)  # voxels

# Hounsfield units.
AIR, FAT, MARROW, VEIN, SKIN, MUSCLE, FASCIA, TENDON, ARTERY, SPONGY, CORTEX = (
    -1000, -100, -60, 45, 50, 58, 30, 110, 140, 320, 1450)

# A place along the limb is t: 0 at the wrist's end of the box, 1 at the elbow's. A profile is a list of (t, value).
HALF_WIDTH = [(0.0, 29.5), (0.1, 28.0), (0.22, 29.5), (0.42, 35.5), (0.65, 44.0), (0.82, 48.0), (1.0, 46.0)]
HALF_DEPTH = [(0.0, 20.0), (0.1, 19.5), (0.22, 22.5), (0.42, 29.0), (0.65, 37.0), (0.82, 41.5), (1.0, 42.5)]
CENTRE_X = [(0.0, -3.0), (0.3, 1.0), (0.6, 3.0), (1.0, -1.5)]
CENTRE_Y = [(0.0, 4.0), (0.3, 1.0), (0.65, -2.5), (1.0, -1.0)]

# Bones: centre relative to the limb's axis, half width and half depth, cortical thickness [mm].
RADIUS = dict(x=[(0, 8.5), (0.12, 9.5), (0.35, 14.5), (0.6, 18.0), (0.85, 17.5), (1, 17.0)],
              y=[(0, 0.5), (0.3, 0.0), (0.6, 0.0), (0.85, -2.0), (1, -2.5)],
              a=[(0, 14.5), (0.06, 14.0), (0.16, 10.0), (0.3, 7.6), (0.6, 7.2), (0.84, 6.8), (0.93, 9.5), (1, 11.0)],
              b=[(0, 9.5), (0.06, 9.3), (0.16, 7.6), (0.3, 6.4), (0.6, 6.4), (0.84, 6.6), (0.93, 9.5), (1, 11.0)],
              shell=[(0, 1.1), (0.12, 1.6), (0.3, 3.0), (0.6, 3.2), (0.84, 2.4), (1, 1.3)], edge=np.pi)
ULNA = dict(x=[(0, -16.5), (0.12, -15.5), (0.35, -13.0), (0.6, -11.0), (0.85, -9.5), (1, -8.5)],
            y=[(0, 3.0), (0.3, 4.0), (0.6, 8.5), (0.85, 15.0), (1, 17.5)],
            a=[(0, 7.0), (0.05, 7.6), (0.14, 5.6), (0.3, 6.0), (0.6, 7.0), (0.85, 9.5), (1, 13.0)],
            b=[(0, 6.6), (0.05, 7.2), (0.14, 5.6), (0.3, 6.2), (0.6, 7.8), (0.85, 11.0), (1, 14.5)],
            shell=[(0, 1.2), (0.12, 1.8), (0.3, 2.8), (0.6, 3.2), (0.85, 2.4), (1, 1.6)], edge=0.0)

# Muscles: centre and radius where the belly is thickest, as fractions of the way to the deep fascia; where along the
# limb the belly ends towards the wrist (its tendon goes on) and, for some, where it begins; tendon radius [mm].
MUSCLES = [
    # name                        p      q     r    ends begins tendon
    ("flexor carpi radialis", 0.36, -0.66, 0.36, 0.34, 1.30, 1.9),
    ("palmaris longus", 0.00, -0.80, 0.24, 0.44, 1.30, 1.5),
    ("flexor carpi ulnaris", -0.62, -0.50, 0.38, 0.12, 1.30, 2.0),
    ("flexor digitorum superficialis", -0.16, -0.48, 0.38, 0.14, 1.30, 3.0),
    ("flexor digitorum profundus", -0.44, -0.10, 0.42, 0.08, 1.30, 3.0),
    ("flexor digitorum profundus, ulnar part", -0.78, -0.02, 0.30, 0.30, 1.30, 0.0),
    ("flexor pollicis longus", 0.24, -0.28, 0.26, 0.08, 0.80, 1.8),
    ("pronator teres", 0.44, -0.30, 0.32, 0.50, 1.30, 0.0),
    ("pronator quadratus", 0.02, -0.26, 0.42, -0.2, 0.20, 0.0),
    ("brachioradialis", 0.80, -0.26, 0.38, 0.40, 1.30, 2.0),
    ("extensor carpi radialis longus", 0.84, 0.16, 0.32, 0.42, 1.30, 1.7),
    ("extensor carpi radialis brevis", 0.68, 0.44, 0.30, 0.34, 1.30, 1.7),
    ("extensor digitorum", 0.28, 0.72, 0.36, 0.20, 1.30, 2.6),
    ("extensor digiti minimi", -0.06, 0.78, 0.20, 0.22, 0.95, 1.2),
    ("extensor carpi ulnaris", -0.44, 0.72, 0.33, 0.20, 1.30, 1.7),
    ("abductor pollicis longus", 0.28, 0.38, 0.26, 0.12, 0.72, 1.7),
    ("extensor pollicis longus", -0.02, 0.44, 0.24, 0.12, 0.66, 1.4),
    ("supinator", 0.46, 0.18, 0.36, 0.58, 1.30, 0.0),
    ("anconeus", -0.72, 0.36, 0.32, 0.58, 1.30, 0.0),
]

# Vessels: (t, p, q) along the way, in the same fractions (1 = deep fascia), radius [mm] at the wrist and at the elbow.
ARTERIES = [
    ([(0, 0.66, -0.62), (0.3, 0.58, -0.55), (0.6, 0.52, -0.44), (0.85, 0.26, -0.28), (1, 0.10, -0.26)], 1.5, 2.2),
    ([(0, -0.52, -0.74), (0.3, -0.40, -0.44), (0.6, -0.22, -0.22), (0.85, 0.02, -0.22), (1, 0.06, -0.24)], 1.4, 2.0),
    ([(0, 0.00, 0.00), (0.5, 0.00, -0.08), (0.8, 0.02, -0.18), (1, 0.08, -0.24)], 0.9, 1.2),
]
# Veins run in the fat: angle [degrees] along the way, radius [mm].
VEINS = [
    ([(0, 35), (0.2, 20), (0.45, -8), (0.7, -28), (1, -42)], 1.8),  # cephalic
    ([(0, 140), (0.25, 165), (0.5, 192), (0.75, 214), (1, 226)], 1.8),  # basilic
    ([(0, -122), (0.25, -112), (0.5, -92), (0.72, -98), (1, -112)], 1.4),  # median antebrachial
    ([(0, 65), (0.3, 58), (0.55, 38), (0.75, 2), (1, -20)], 1.2),  # accessory cephalic
]


def profile(points, t):
    """Monotone cubic (Fritsch and Carlson 1980) through (t, value) points, constant beyond their ends."""
    x = np.array([p[0] for p in points], float)
    y = np.array([p[1] for p in points], float)
    h = np.diff(x)
    slope = np.diff(y) / h
    tangent = np.zeros_like(y)
    for i in range(1, len(x) - 1):
        if slope[i - 1] * slope[i] > 0:
            w1, w2 = 2 * h[i] + h[i - 1], h[i] + 2 * h[i - 1]
            tangent[i] = (w1 + w2) / (w1 / slope[i - 1] + w2 / slope[i])
    tangent[0], tangent[-1] = slope[0], slope[-1]
    t = np.clip(t, x[0], x[-1])
    i = np.clip(np.searchsorted(x, t, side="right") - 1, 0, len(h) - 1)
    s = (t - x[i]) / h[i]
    return (y[i] * (1 + 2 * s) * (1 - s) ** 2 + tangent[i] * h[i] * s * (1 - s) ** 2
            + y[i + 1] * s * s * (3 - 2 * s) + tangent[i + 1] * h[i] * s * s * (s - 1))


def smooth_step(low, high, t):
    s = np.clip((t - low) / (high - low), 0.0, 1.0)
    return s * s * (3 - 2 * s)


def angle_bump(angle, centre, width):
    """1 at the centre, falling off like a Gaussian with the angle [radians]."""
    off = np.angle(np.exp(1j * (angle - centre)))
    return np.exp(-0.5 * (off / width) ** 2)


def blur(volume, sigma):
    """Gaussian along all three axes, in voxels (a separate width for each axis, x first); edges repeat."""
    for axis, s in zip((2, 1, 0), sigma):
        reach = max(1, int(np.ceil(2.5 * s)))
        weight = np.exp(-0.5 * (np.arange(-reach, reach + 1) / s) ** 2)
        weight = (weight / weight.sum()).astype(np.float32)
        pad = [(0, 0)] * 3
        pad[axis] = (reach, reach)
        wide = np.pad(volume, pad, mode="edge")
        size = volume.shape[axis]
        result = np.zeros_like(volume)
        cut = [slice(None)] * 3
        for k, w in enumerate(weight):
            cut[axis] = slice(k, k + size)
            result += w * wide[tuple(cut)]
        volume = result
    return volume


def noise(rng, shape, sigma):
    """Gaussian noise of unit deviation, correlated over `sigma` voxels (x, y, z)."""
    field = blur(rng.standard_normal(shape, dtype=np.float32), sigma)
    return field / field.std()


def bone(bone_shape, t, x, y):
    """Depth under the bone's surface [mm, positive inside] and the cortex's thickness there."""
    dx = x - profile(bone_shape["x"], t)
    dy = y - profile(bone_shape["y"], t)
    a, b = profile(bone_shape["a"], t), profile(bone_shape["b"], t)
    angle = np.arctan2(dy, dx)
    # Towards the other bone the shaft has an edge, where the membrane between them is fixed.
    edge = 0.13 * smooth_step(0.1, 0.25, t) * (1 - smooth_step(0.75, 0.9, t))
    surface = a * b / np.hypot(b * np.cos(angle), a * np.sin(angle))
    surface = surface * (1 + edge * np.cos(3 * (angle - bone_shape["edge"])))
    return surface - np.hypot(dx, dy), profile(bone_shape["shell"], t)


def section(t, x, y, texture):
    """Hounsfield units of one slice, before blur and noise. x and y in mm from the box's centre."""
    x = x - profile(CENTRE_X, t)
    y = y - profile(CENTRE_Y, t)
    r = np.hypot(x, y) + 1e-6
    angle = np.arctan2(y, x)

    # The skin's surface: an ellipse with the bulges of the muscles, and of what lies right under the skin.
    a, b = profile(HALF_WIDTH, t), profile(HALF_DEPTH, t)
    belly = smooth_step(0.35, 0.75, t)
    radius = a * b / np.hypot(b * np.cos(angle), a * np.sin(angle))
    radius = radius * (1 + 0.07 * belly * angle_bump(angle, -0.25, 0.45)  # brachioradialis
                       + 0.08 * belly * angle_bump(angle, -2.0, 0.5)  # flexors
                       - 0.05 * belly * angle_bump(angle, -1.1, 0.3)  # furrow between the two
                       + 0.05 * belly * angle_bump(angle, 1.1, 0.4)  # extensors
                       - 0.05 * belly * angle_bump(angle, 2.3, 0.35)  # along the ulna
                       + 0.012 * np.cos(5 * angle + 9 * t) + 0.008 * np.cos(7 * angle - 14 * t + 1))
    wrist = 1 - smooth_step(0.12, 0.4, t)
    radius = radius + wrist * (1.2 * angle_bump(angle, -1.13, 0.11) + 1.4 * angle_bump(angle, -1.57, 0.09)
                               + 1.0 * angle_bump(angle, -2.45, 0.13) + 0.8 * angle_bump(angle, 1.2, 0.15))
    radius = radius + 2.2 * angle_bump(angle, 2.75, 0.30) * (1 - smooth_step(0.05, 0.14, t))  # head of the ulna
    for course, size in VEINS:
        at = np.radians(profile(course, t))
        radius = radius + 0.45 * size * angle_bump(angle, at, 2.4 * size / a)
    for crease in (0.035, 0.052):
        palm = angle_bump(angle, -np.pi / 2, 0.9)
        radius = radius - 0.9 * palm * np.exp(-0.5 * ((t - crease - 0.008 * np.cos(2 * angle)) / 0.0035) ** 2)
    # From the distance along the ray to the distance along the normal: their cosine on the ellipse.
    depth = (radius - r) * np.hypot(x / a, y / b) ** 2 / (r * np.hypot(x / a**2, y / b**2))

    skin = 1.7
    fat = (2.2 + 3.4 * t + 1.6 * angle_bump(angle, -2.6, 0.8) * t - 1.8 * angle_bump(angle, 2.1, 0.5)
           + 1.2 * angle_bump(angle, -0.9, 0.6) + 0.5 * np.cos(3 * angle + 5 * t))
    fat = np.maximum(fat, 1.2)

    ct = np.full(x.shape, AIR, np.float32)
    inside = depth > 0
    ct[inside] = SKIN
    ct[depth > skin] = FAT
    # Strands of connective tissue run through the fat.
    ct[(depth > skin) & (texture["strand"] > 2.2)] = -20

    # Fractions of the way from the axis to the deep fascia, turned a little along the limb.
    deep = skin + fat
    rho = r / np.maximum(radius - deep, 1.0)
    turn = 0.35 * (t - 0.5)
    p, q = rho * np.cos(angle + turn), rho * np.sin(angle + turn)
    scale = np.maximum(radius - deep, 1.0)
    ct[(depth > deep - 0.5) & (depth < deep + 0.6)] = FASCIA

    # Muscles share the room: each pixel goes to the belly it is deepest in, thin fat and fascia stay between them.
    nearest = np.full(x.shape, 9.0, np.float32)
    second = np.full(x.shape, 9.0, np.float32)
    nearest_radius = np.ones(x.shape, np.float32)
    tendons = np.zeros(x.shape, bool)
    for _, mp, mq, mr, ends, begins, tendon in MUSCLES:
        full = smooth_step(ends - 0.02, ends + 0.30, t) * (1 - smooth_step(begins - 0.15, begins, t))
        distance = np.hypot(p - mp, q - mq)
        if full > 0:
            size = mr * (0.35 + 0.65 * full) * 1.12
            relative = (distance / size).astype(np.float32)
            closer = relative < nearest
            second = np.where(closer, nearest, np.minimum(second, relative))
            nearest_radius = np.where(closer, np.float32(size), nearest_radius)
            nearest = np.where(closer, relative, nearest)
        if tendon > 0:
            core = tendon * (1 - 0.75 * smooth_step(ends + 0.05, ends + 0.40, t))
            tendons |= (distance * scale < core) & (t < ends + 0.40)
    under = depth > deep + 0.6
    gap = np.minimum((second - nearest) * 0.5, 1.0 - nearest) * nearest_radius * scale  # [mm] to the belly's border
    muscle = under & (gap > 0.55) & (nearest < 1)
    ct[muscle] = MUSCLE + 9 * texture["fibre"][muscle]
    ct[muscle & (texture["fibre"] > 2.1)] = -10  # fat between bundles
    ct[under & (gap > 0.25) & (gap <= 0.55)] = FASCIA
    ct[tendons & (depth > skin + 0.4)] = TENDON

    # Vessels.
    for course, at_wrist, at_elbow in ARTERIES:
        cp = profile([(c[0], c[1]) for c in course], t)
        cq = profile([(c[0], c[2]) for c in course], t)
        away = np.hypot(p - cp, q - cq) * scale
        size = at_wrist + (at_elbow - at_wrist) * t
        ct[away < size + 1.0] = FAT
        ct[away < size] = ARTERY
    for course, size in VEINS:
        at = np.radians(profile(course, t))
        off = np.angle(np.exp(1j * (angle - at))) * radius
        away = np.hypot(off, depth - (skin + 0.5 + size))
        ct[away < size] = VEIN

    # The membrane between the bones.
    rx, ry = profile(RADIUS["x"], t), profile(RADIUS["y"], t)
    ux, uy = profile(ULNA["x"], t), profile(ULNA["y"], t)
    length = np.hypot(rx - ux, ry - uy)
    along = ((x - ux) * (rx - ux) + (y - uy) * (ry - uy)) / length
    aside = np.abs((x - ux) * (ry - uy) - (y - uy) * (rx - ux)) / length
    if 0.16 < t < 0.86:
        ct[(aside < 0.7) & (along > 0) & (along < length)] = TENDON

    # Bones: cortex, spongy bone at the ends, marrow in the shaft.
    spongy = 1 - smooth_step(0.14, 0.30, t) * (1 - smooth_step(0.74, 0.90, t))
    for shape in (RADIUS, ULNA):
        inwards, shell = bone(shape, t, x, y)
        shell = shell * (1 + 0.12 * texture["cortex"])
        ct[(inwards > -0.8) & (inwards <= 0)] = TENDON  # periosteum
        ct[inwards > 0] = CORTEX
        core = inwards > shell
        trabeculae = SPONGY * (1 + 0.38 * texture["trabecula"])
        rim = np.exp(-np.maximum(inwards - shell, 0) / 2.5) * 0.5
        filled = np.clip(spongy + rim, 0, 1)
        ct[core] = (MARROW + filled * (trabeculae - MARROW))[core]
    return ct


def make_forearm(size=DEFAULT_SIZE, seed=7):
    """The phantom as vtkImageData with the int16 point array "CT" [HU].

    size: voxels along x, y, z (at least 32 each); the box in mm stays the same, so the spacing follows.
    seed: of the textures and the noise.
    """
    nx, ny, nz = (int(n) for n in size)
    if min(nx, ny, nz) < 32:
        raise ValueError("make_forearm: size must be at least 32 voxels along every axis, not %d x %d x %d." % (nx, ny, nz))
    spacing = tuple(length / n for length, n in zip(BOX, (nx, ny, nz)))
    rng = np.random.default_rng(seed)
    shape = (nz, ny, nx)

    def width(*mm):  # of a texture's correlation, in voxels
        return [max(0.3, m / s) for m, s in zip(mm, spacing)]

    fields = {
        "fibre": noise(rng, shape, width(0.9, 0.9, 6.0)),
        "trabecula": noise(rng, shape, width(0.7, 0.7, 1.4)),
    }
    fields["strand"] = np.roll(fields["fibre"], (nz // 3, ny // 5, nx // 7), (0, 1, 2))
    fields["cortex"] = np.roll(fields["trabecula"], (nz // 5, ny // 3, nx // 4), (0, 1, 2))

    x = ((np.arange(nx) + 0.5) * spacing[0] - BOX[0] / 2).astype(np.float32)[None, :]
    y = ((np.arange(ny) + 0.5) * spacing[1] - BOX[1] / 2).astype(np.float32)[:, None]
    x, y = np.broadcast_arrays(x, y)
    ct = np.empty(shape, np.float32)
    for k in range(nz):
        ct[k] = section((k + 0.5) / nz, x, y, {name: field[k] for name, field in fields.items()})

    # What a scanner adds: partial volume and its point spread, then noise with the grain of a soft kernel.
    ct = blur(ct, width(0.45, 0.45, 0.55))
    ct += 11.0 * noise(rng, shape, width(0.5, 0.5, 0.4))
    ct = np.clip(np.rint(ct), -1024, 3071).astype(np.int16)

    image = vtkImageData()
    image.SetDimensions(nx, ny, nz)
    image.SetSpacing(*spacing)
    image.SetOrigin(*(-length / 2 + s / 2 for length, s in zip(BOX, spacing)))
    array = numpy_to_vtk(ct.ravel(), deep=True, array_type=VTK_SHORT)
    array.SetName("CT")
    image.GetPointData().SetScalars(array)
    return image


def write(image, path):
    """Writes .vti or .mhd (with its .zraw)."""
    if path.endswith(".vti"):
        from vtkmodules.vtkIOXML import vtkXMLImageDataWriter
        writer = vtkXMLImageDataWriter()
        # VTK's default puts the data after the XML, which VTK 9.2 cannot read with expat from 2.6 on, nor with Debian
        # 12's 2.5.0-1+deb12u2: https://gitlab.kitware.com/vtk/vtk/-/issues/19258
        writer.SetDataModeToBinary()
    elif path.endswith((".mhd", ".mha")):
        from vtkmodules.vtkIOImage import vtkMetaImageWriter
        writer = vtkMetaImageWriter()
    else:
        raise ValueError("make_forearm: '%s' ends neither in .vti nor in .mhd." % path)
    writer.SetFileName(path)
    writer.SetInputDataObject(image)
    mistakes = []
    writer.AddObserver("ErrorEvent", lambda *_: mistakes.append(1))
    writer.Write()  # of the two writers only one tells here whether it could
    if mistakes or writer.GetErrorCode() != 0 or not os.path.isfile(path):
        raise OSError("make_forearm: could not write '%s'." % path)


def main(arguments):
    parser = argparse.ArgumentParser(description="Writes a forearm phantom with CT numbers.")
    parser.add_argument("file", help="output: .vti or .mhd")
    parser.add_argument("--size", type=int, nargs=3, default=DEFAULT_SIZE, metavar=("NX", "NY", "NZ"), help="voxels")
    parser.add_argument("--seed", type=int, default=7, help="seed of textures and noise (default: 7)")
    options = parser.parse_args(arguments)
    start = time.time()
    image = make_forearm(options.size, options.seed)
    write(image, options.file)
    print("%s: %d x %d x %d voxels, %.2f x %.2f x %.2f mm, %d..%d HU, %.1f s"
          % ((options.file,) + image.GetDimensions() + image.GetSpacing()
             + tuple(int(v) for v in image.GetScalarRange()) + (time.time() - start,)))


if __name__ == "__main__":
    main(sys.argv[1:])
