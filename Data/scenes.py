"""The scenes of the paper on heterogeneous ChainMail (Rodriguez, Leon and Arroyo), as data.

Each function returns a Scene: an image, who grabs it and where it is cut, and the filter's properties. make_gallery.py
draws them, Testing/Python/TestPaper*.py measures them. Figure numbers are the paper's; where it shows a leg, a hand or
a sheep's heart, there are the forearm phantom and the scans of a heart and a head here.

A scene becomes a pipeline with `open_scene`, in any Python of ParaView that has the plugin (PV_PLUGIN_PATH).
"""

import os

import numpy as np
import paraview.simple as pv
from make_forearm import make_forearm
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkImagingCore import vtkExtractVOI

AIR, BONE = -300.0, 600.0  # [HU] tissue starts here, rigid bone starts here: as in the CT preset


class Scene:
    """image: vtkImageData with active scalars. probes: a dictionary of ChainMailProbe's properties for each. cuts: origin
    and two corners of a ParaView Plane for each. material: (scalar, constraint) points, or None. regions: a dictionary of
    ChainMailRegion's properties for each. properties: of ChainMailDeformation."""

    def __init__(self, image, probes, cuts=(), material=None, regions=(), **properties):
        self.image, self.probes, self.cuts = image, list(probes), list(cuts)
        self.material, self.regions, self.properties = material, list(regions), properties


def open_scene(scene):
    """(source, deformation): the scene as a pipeline, not yet updated."""
    source = pv.TrivialProducer()
    source.GetClientSideObject().SetOutput(scene.image)
    source.MarkModified(source)
    source.UpdatePipeline()
    deformation = pv.ChainMailDeformation(
        Input=source, PropagationTimes=1, ModelArrays=["Displacement", "Element", "Constraint", "Cluster"])
    if scene.material:
        deformation.MaterialFunction.Points = [number for point in scene.material for number in (*point, 0.5, 0.0)]
    for name, value in scene.properties.items():
        setattr(deformation, name, value)
    deformation.Probes = [pv.ChainMailProbe(**probe) for probe in scene.probes]
    deformation.Cuts = [pv.Plane(Origin=list(a), Point1=list(b), Point2=list(c)) for a, b, c in scene.cuts]
    deformation.Regions = [pv.ChainMailRegion(**region) for region in scene.regions]
    return source, deformation


def grab(position, drag, radius=0.0):
    """A probe that pulls what is within `radius` of a place by a vector."""
    return dict(Position=list(map(float, position)), Target=[float(p + d) for p, d in zip(position, drag)], Radius=radius)


def hold(position, radius=0.0):
    """A probe that holds its tissue where it is."""
    return dict(Position=list(map(float, position)), Target=list(map(float, position)), Radius=radius, Anchor=1)


def make_image(values, name, spacing=(1.0, 1.0, 1.0), origin=(0.0, 0.0, 0.0)):
    """An image from an array [z, y, x], which become its scalars."""
    image = vtkImageData()
    image.SetDimensions(values.shape[::-1])
    image.SetSpacing(spacing)
    image.SetOrigin(origin)
    add_array(image, values, name)
    image.GetPointData().SetActiveScalars(name)
    return image


def add_array(image, values, name):
    array = numpy_to_vtk(np.ascontiguousarray(values).ravel(), deep=1)
    array.SetName(name)
    image.GetPointData().AddArray(array)


def values_of(image, name):
    """A point array of one component as numpy [z, y, x]."""
    return vtk_to_numpy(image.GetPointData().GetArray(name)).reshape(image.GetDimensions()[::-1])


def coordinates(image):
    """Places of the voxels along x, y, z [mm]; broadcast as [z, y, x]. For images that are not turned."""
    first, size = image.GetExtent()[::2], image.GetDimensions()
    lines = [image.GetOrigin()[a] + (first[a] + np.arange(size[a])) * image.GetSpacing()[a] for a in range(3)]
    return lines[0][None, None, :], lines[1][None, :, None], lines[2][:, None, None]


def read_scan(folder, name):
    from vtkmodules.vtkIOImage import vtkMetaImageReader
    reader = vtkMetaImageReader()
    reader.SetFileName(os.path.join(folder, name + ".mhd"))
    reader.Update()
    return reader.GetOutput()


# ----------------------------------------------------------------------------------------------------------------------
# Figure 4


def three_elements():
    """Three elements in a row whose links may give by 1.5 and 3 mm; the first is moved by 8 mm."""
    spacing = 16.0
    image = make_image(np.array([1.0, 2.0, 4.0], np.float32).reshape(1, 1, 3) / spacing, "Fraction", (spacing,) * 3)
    return Scene(image, [grab((0, 0, 0), (8, 0, 0))], ConstraintArray="Fraction", TissueThreshold=0.0, AnchoredFaces=[0] * 6,
                 RelaxationIterations=0)


# ----------------------------------------------------------------------------------------------------------------------
# Figure 5

RING_SIZE = 17  # voxels of the ring's side; two of air around it


def heterogeneous_ring():
    """A ring, elastic on top and rigid at the sides and the bottom. Its upper left corner is moved: along the bottom the
    lower right one follows at once, whatever arrives later over the top."""
    n = RING_SIZE + 4
    tissue = np.zeros((1, n, n), np.float32)
    tissue[0, 2:-2, 2:-2] = 1
    tissue[0, 3:-3, 3:-3] = 0
    fraction = np.zeros_like(tissue)
    fraction[0, -3, 3:-3] = 0.25
    image = make_image(tissue, "Tissue")
    add_array(image, fraction, "Fraction")
    return Scene(image, [grab((2, n - 3, 0), (2.5, 1.75, 0))], ConstraintArray="Fraction", TissueThreshold=0.5,
                 RelaxationIterations=0)


# ----------------------------------------------------------------------------------------------------------------------
# Figures 6, 7 and 8: a slice

SLICE_AT = 0.62  # of the way from the wrist to the elbow


def forearm_slice():
    """A slice of the forearm phantom, across both bones: the scalars "CT" [HU]."""
    volume = make_forearm((176, 160, 32))
    extract = vtkExtractVOI()
    extract.SetInputData(volume)
    k = int(SLICE_AT * 32)
    extract.SetVOI(0, 175, 0, 159, k, k)
    extract.Update()
    return extract.GetOutput()


def surface(image, x, side):
    """y of the outermost tissue at x [mm], in a slice; side: 1 upper, -1 lower."""
    xs, ys, _ = coordinates(image)
    column = values_of(image, "CT")[0, :, np.abs(xs.ravel() - x).argmin()] >= AIR
    found = ys.ravel()[column]
    return float(found.max() if side > 0 else found.min())


def held_disc(image, x, side, depth, radius):
    """A disc that reaches `depth` into the limb from above or from below: its centre."""
    z = float(coordinates(image)[2].ravel()[0])
    return np.array([x, surface(image, x, side) + side * (radius - depth), z])


PRESS, PRESS_RADIUS, PRESS_DEPTH = 9.0, 30.0, 4.0  # [mm]


def compressed_slice(heterogeneous):
    """Figure 6: the slice between a plate that holds it from below and one that presses it from above. Heterogeneous: the
    CT preset, bones are rigid; homogeneous: muscle throughout."""
    image = forearm_slice()
    z = image.GetExtent()[4]
    add_array(image, np.full(values_of(image, "CT").shape, 0.25, np.float32), "Muscle")
    image.GetPointData().SetActiveScalars("CT")
    below, above = (held_disc(image, 3.0, side, PRESS_DEPTH, PRESS_RADIUS) for side in (-1, 1))
    assert z == image.GetExtent()[5]
    return Scene(image, [hold(below, PRESS_RADIUS), grab(above, (0, -PRESS, 0), PRESS_RADIUS)], MaterialPreset=1,
                 ConstraintArray="" if heterogeneous else "Muscle", RelaxationIterations=60)


CUT_Y, CUT_END = -11.625, 12.0  # [mm], halfway between voxels


def pulled_slice(cut):
    """Figure 7: muscle on the palm's side pulled outwards, whole or with a cut below the bones that the pull has to go
    around."""
    image = forearm_slice()
    z = float(coordinates(image)[2].ravel()[0])
    blades = [((-60, CUT_Y, z - 5), (CUT_END, CUT_Y, z - 5), (-60, CUT_Y, z + 5))] if cut else []
    return Scene(image, [grab((-12, -21, z), (-3, -9, 0), 4.0)], blades, MaterialPreset=1, RelaxationIterations=0)


INCISION_X, INCISION_DEPTH = 6.0, 19.0  # [mm]


def opened_slice(cut):
    """Figure 8: both lips of an incision pulled at once. "Side" labels the tissue: 1 left of the incision, 2 right."""
    image = forearm_slice()
    xs, ys, zs = coordinates(image)
    z = float(zs.ravel()[0])
    ct = values_of(image, "CT")
    add_array(image, np.where(ct >= AIR, np.where(xs < INCISION_X, 1, 2), 0).astype(np.uint8), "Side")
    image.GetPointData().SetActiveScalars("CT")
    top = surface(image, INCISION_X, 1)
    probes = [grab((INCISION_X + side * 9, surface(image, INCISION_X + side * 9, 1) - 5, z), (side * 7, 3, 0), 4.0)
              for side in (-1, 1)]
    blades = [((INCISION_X, top - INCISION_DEPTH, z - 5), (INCISION_X, top + 10, z - 5),
               (INCISION_X, top - INCISION_DEPTH, z + 5))] if cut else []
    return Scene(image, probes, blades, material=SKIN, LabelArrays=["Side"], TissueThreshold=AIR, RelaxationIterations=60)


# Skin and fat that a hook can draw wide open; bone stays rigid.
SKIN = [(-300.0, 0.7), (-100.0, 0.7), (60.0, 0.45), (150.0, 0.3), (BONE, 0.0)]

# ----------------------------------------------------------------------------------------------------------------------
# Figure 9


def probed_heart(folder):
    """A heart's left ventricle, grabbed at its lateral wall from inside the blood and pushed out towards the lung.

    Contrast agent fills the chambers with 250 to 550 HU, which is spongy bone to a preset; here blood is the softest
    tissue, myocardium gives by 0.35, and only metal and dense bone, from 1000 HU, are rigid. Air and lung, below -300
    HU, are no tissue, so that the heart's outer wall is free where it lies on the lung; the six faces of the box hold
    what touches them."""
    image = read_scan(folder, "heart_cta")
    material = [(-300.0, 0.35), (-100.0, 0.4), (50.0, 0.35), (150.0, 0.35), (250.0, 0.5), (600.0, 0.5), (1000.0, 0.0)]
    return Scene(image, [grab(place_of(image, HEART_WALL), (-18.0, -4.0, 0.0), 12.0)], material=material, TissueThreshold=-300.0,
                 RelaxationIterations=40)


HEART_WALL = (25, 83, 62)  # index of the voxel in the blood at the lateral wall
HEART_CHAMBER = (40, 84, 62)  # and in the middle of the chamber


def place_of(image, index):
    return np.array(image.GetOrigin()) + np.array(index) * np.array(image.GetSpacing())


# ----------------------------------------------------------------------------------------------------------------------
# Figure 10

THIN_RADIUS, THIN_WIDTH = 40.0, 2.0  # [mm] of the ring; voxels of 1 mm


def thin_ring():
    """A ring of tissue two voxels thin, dented on its left. The other side is the same tissue, and stays."""
    n = 101
    axis = np.arange(n) - n // 2
    away = np.hypot(axis[None, :], axis[:, None])
    tissue = (np.abs(away - THIN_RADIUS) <= 0.5 * THIN_WIDTH).astype(np.float32)[None]
    image = make_image(tissue, "Tissue", origin=(-(n // 2), -(n // 2), 0))
    return Scene(image, [grab((-THIN_RADIUS, 0, 0), (15, 0, 0), 2.0)], material=[(0.5, 0.3), (1.0, 0.3)], TissueThreshold=0.5,
                 RelaxationIterations=10)


# ----------------------------------------------------------------------------------------------------------------------
# Figure 11


def hooks(place, across, out, away, apart, lift, radius):
    """A hook on either side of an incision: grabs at `away` from it and pulls by `apart` along `across`, away from the
    incision, and by `lift` outwards."""
    place, across, out = (np.asarray(v, float) for v in (place, across, out))
    return [grab(place + side * away * across, side * apart * across + lift * out, radius) for side in (-1, 1)]


def opened_limb(size=(176, 160, 208), cut=True):
    """The forearm's skin, cut along the limb and drawn open by two hooks. As the paper's hand: constraints up to a half,
    bones rigid, 80 % elastic recovery."""
    image = make_forearm(size)
    xs, ys, zs = coordinates(image)
    x, z = 12.0, 30.0
    i, k = np.abs(xs.ravel() - x).argmin(), np.abs(zs.ravel() - z).argmin()
    top = float(ys.ravel()[values_of(image, "CT")[k, :, i] >= AIR].max())
    blades = [((x, top - 20, z - 34), (x, top + 15, z - 34), (x, top - 20, z + 34))] if cut else []
    material = [(AIR, 0.5), (-100.0, 0.5), (60.0, 0.4), (150.0, 0.3), (BONE, 0.0)]
    return Scene(image, hooks((x, top - 4, z), (1, 0, 0), (0, 1, 0), 9, 8, 4, 6.0), blades, material=material,
                 TissueThreshold=AIR, BackgroundValue=-1024.0, ElasticRecovery=0.8, RelaxationIterations=60)


CHEEK = (74, 38)  # y, z indices; the blade is right behind this y


def opened_cheek(folder, cut=True):
    """The cheek of a head, cut downwards and drawn open; skull, jaw and teeth are rigid. The scan has 8 bits:
    HU is about 16 v - 1024, skin starts at 35, bone at 100."""
    image = read_scan(folder, "head_vhf_ct")
    y, z = CHEEK
    line = values_of(image, "MetaImage")[z, y] >= 35
    x = int(np.nonzero(line & np.roll(line, 6) & np.roll(line, 3))[0].max())
    place = place_of(image, (x - 3, y + 0.5, z))  # between two layers of voxels
    a, b, c = (place + np.array(v) for v in ((-16, 0, -22), (18, 0, -22), (-16, 0, 22)))
    material = [(35.0, 0.5), (60.0, 0.5), (68.0, 0.4), (85.0, 0.2), (100.0, 0.0)]
    return Scene(image, hooks(place, (0, 1, 0), (1, 0, 0), 11, 8, 3, 5.0), [(a, b, c)] if cut else [], material=material,
                 TissueThreshold=35.0, BackgroundValue=0.0, RelaxationIterations=60)


def bent_finger(rotations, size=(112, 40, 44)):
    """Two bones and a joint in a finger whose left end is held; the tip's bone is grabbed at one voxel and lifted."""
    x, y, z = (axis.astype(float) for axis in np.meshgrid(*(np.arange(n) for n in size), indexing="ij"))
    x, y, z = (axis.transpose(2, 1, 0) for axis in (x, y, z))
    middle, radius, tip, low = (size[1] - 1) / 2.0, 9.5, size[0] - 14.0, 12.0
    beyond = np.maximum(x - tip + radius, 0.0)  # the fingertip is round
    off = np.sqrt((y - middle) ** 2 + (z - low) ** 2 + beyond**2)
    soft = (off > radius - 2.5) | (abs(x - 45.0) < 9.0)  # skin, and a joint of cartilage that gives
    scan = np.where(off < radius, np.where(soft, -90.0, 50.0), -1000.0)
    ends = (-10.0, 38.0), (52.0, tip - 6.0)
    for start, end in ends:
        axial = np.maximum(np.maximum(start + 4.0 - x, x - end + 4.0), 0.0)  # and so are the ends of bones
        bone = np.sqrt((y - middle) ** 2 + (z - low) ** 2 + axial**2) < 4.0
        scan = np.where(bone, 1100.0, scan)
    scan += np.random.default_rng(4).normal(0.0, 4.0, scan.shape)
    image = make_image(scan.astype(np.int16), "CT")
    held = tip - 12.0, middle, low
    return Scene(image, [grab(np.round(held), (-2.5, 0.0, 13.0))], MaterialPreset="CT (Hounsfield units)",
                 AnchoredFaces=[1, 0, 0, 0, 0, 0], RelaxationPreset="Accurate", Rotations=rotations)


# Of the generated hand: the joints of each finger from the wrist to the end of the last bone, thumb first, on the level z = HAND.
HAND = 24.0
FINGERS = [np.array([(*place, HAND) for place in finger], float) for finger in (
    [(-20, 34), (38, 8), (70, -8), (92, -14)],
    [(-20, 40), (72, 26), (112, 20), (135, 17), (153, 15)],
    [(-20, 46), (75, 46), (119, 46), (146, 46), (164, 46)],
    [(-20, 52), (72, 65), (113, 71), (138, 74), (155, 77)],
    [(-20, 58), (65, 82), (96, 92), (114, 98), (129, 103)])]


def make_hand():
    """A hand whose wrist goes on beyond the face x-, and the labels of its bones: 10 n + m is the m-th bone of finger n from the
    wrist on, the thumb being 1. In the palm and on the fingers lie 2 mm of fat and skin."""
    size, first = np.array([184, 150, 48]), np.array([0.0, -28.0, 0.0])
    places = np.stack(np.meshgrid(*(first[a] + np.arange(size[a]) for a in range(3)), indexing="ij"), axis=-1).transpose(2, 1, 0, 3)

    def outside(start, end, radii):
        """How far outside a rod with round ends, which tapers, a place is."""
        along = end - start
        share = np.clip((places - start) @ along / along.dot(along), 0.0, 1.0)
        return np.linalg.norm(places - start - share[..., None] * along, axis=-1) - (radii[0] + share * (radii[1] - radii[0]))

    def inside(distance):
        """Of a voxel, the share."""
        return np.clip(0.5 - distance, 0.0, 1.0)

    closeness, bone, labels = np.zeros(places.shape[:3]), np.zeros(places.shape[:3]), np.zeros(places.shape[:3], np.uint8)
    for n, joints in enumerate(FINGERS, 1):
        for m, (start, end) in enumerate(zip(joints[:-1], joints[1:]), 1):
            thickness = [12.0, 9.0, 8.0, 7.0, 6.0][m - 1 : m + 1]
            closeness += np.exp(-outside(start, end, thickness) / 2.0)  # a union that fills the webs
            along = (end - start) / np.linalg.norm(end - start)
            radius = [4.5, 4.0, 3.5, 3.0][m - 1]
            share = inside(outside(start + (radius + 1.0) * along, end - (radius + 1.0) * along, (radius, radius)))
            labels[share > bone] = 10 * n + m
            bone = np.maximum(bone, share)
    distance = -2.0 * np.log(np.maximum(closeness, 1e-30))
    scan = -1000.0 + 900.0 * inside(distance) + 140.0 * inside(distance + 2.0)
    scan = scan + bone * (1100.0 - scan) + np.random.default_rng(5).normal(0.0, 4.0, scan.shape)
    image = make_image(scan.astype(np.int16), "CT", origin=first)
    add_array(image, np.where(scan > 301.0, labels, 0).astype(np.uint8), "Bones")
    return image


def turn(degrees, axis):
    """A rotation, by Rodrigues' formula."""
    cross = np.cross(np.eye(3), np.asarray(axis, float) / np.linalg.norm(axis))
    angle = np.radians(degrees)
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross


def posed_hand(finger=3, degrees=30.0):
    """A generated hand whose finger bends by `degrees` at each of two joints, and is straight from there on. The palm's bones,
    which a face of the scan holds, and the other fingers stay."""
    def pose(place, target, angle, axis, label):
        return dict(Position=place.tolist(), Target=target.tolist(), Turns=1, Rotation=(angle * axis).tolist(), Body=label)

    joints = FINGERS[finger - 1]
    axis = np.cross((0.0, 0.0, -1.0), joints[2] - joints[1])
    axis /= np.linalg.norm(axis)
    probes, here = [], joints[1]
    for m, angle in zip(range(2, len(joints)), (degrees, 2 * degrees, 2 * degrees)):
        middle, motion = (joints[m - 1] + joints[m]) / 2, turn(angle, axis)
        probes.append(pose(middle, here + motion @ (middle - joints[m - 1]), angle, axis, 10 * finger + m))
        here = here + motion @ (joints[m] - joints[m - 1])
    for n, others in enumerate(FINGERS, 1):
        for m in range(2, len(others)):
            if n != finger:
                middle = (others[m - 1] + others[m]) / 2
                probes.append(pose(middle, middle, 0.0, axis, 10 * n + m))
    return Scene(make_hand(), probes, material=[(AIR, 0.8), (200.0, 0.8), (300.0, 0.1), (301.0, 0.0)], TissueThreshold=AIR,
                 BodyArray="Bones", JointConstraint=1.0, Rotations=1, RelaxationPreset="Balanced", OutputPadding=56,
                 BackgroundValue=-1024.0, AnchoredFaces=[1, 0, 0, 0, 0, 0])


JAW_JOINTS = (51, 103, 66), (151, 108, 66)  # voxels between the jaw and the skull
CHIN, CROWN = (103, 33, 4), (100, 124, 193)


def mouth_cuts(image):
    """Blades that open the mouth of head_vhf_ct: it is closed in the scan, and nothing there tells one lip or one gum from the
    other."""
    def in_mouth(x, y):
        """A place on the plane between the lips, which rises to the back."""
        return place_of(image, (x, y, 31.0 + 0.19 * y)).tolist()

    sides = (80, 122, -5, 30), (70, 135, 30, 45), (62, 148, 45, 85)
    return [(in_mouth(x0, y0), in_mouth(x1, y0), in_mouth(x0, y1)) for x0, x1, y0, y1 in sides]


def posed_jaw(folder, degrees=20.0):
    """A head whose jaw turns about the axis through its joints, with a mouth that a blade has opened."""
    image = read_scan(folder, "head_vhf_ct")
    left, right, jaw, skull = (place_of(image, index) for index in (*JAW_JOINTS, CHIN, CROWN))
    axis, middle = (right - left) / np.linalg.norm(right - left), (left + right) / 2
    # Where the turn about the middle of the joints takes the chin, by Rodrigues' formula.
    angle, arm = np.radians(degrees), jaw - middle
    turned = (np.cos(angle) * arm + np.sin(angle) * np.cross(axis, arm) + (1 - np.cos(angle)) * axis.dot(arm) * axis)
    pose = dict(Position=jaw.tolist(), Target=(middle + turned).tolist(), Turns=1, Rotation=(degrees * axis).tolist())
    stays = dict(Position=skull.tolist(), Target=skull.tolist(), Turns=1)
    material = [(25.0, 0.8), (88.0, 0.8), (96.0, 0.12), (97.0, 0.0)]
    return Scene(image, [pose, stays], cuts=mouth_cuts(image),
                 material=material, TissueThreshold=25.0, Rotations=1, JointSize=2, JointConstraint=1.0, JointMargin=8,
                 AnchoredFaces=[1, 1, 1, 1, 0, 1], RelaxationPreset="Balanced", OutputPadding=24, BackgroundValue=0.0)


def advanced_chin(folder, way=(0.0, -8.0, 0.0), degrees=5.0):
    """A head whose chin two saw cuts free from the jaw; it goes forward, and turns about the axis x. The cuts go on into the tissue
    around, as surgeons free it there, and the mouth is open; jaw and skull are in one piece, which the upper face of the scan
    holds."""
    image = read_scan(folder, "head_vhf_ct")
    cuts = [[place_of(image, index).tolist() for index in ((x, 24, -2), (x, 66, -2), (x, 24, 30))] for x in (92.5, 114.5)]
    chin = place_of(image, (103, 33, 4))
    pose = dict(Position=chin.tolist(), Target=(chin + way).tolist(), Turns=1, Rotation=[degrees, 0.0, 0.0])
    material = [(25.0, 0.8), (88.0, 0.8), (96.0, 0.12), (97.0, 0.0)]
    return Scene(image, [pose], cuts=cuts + mouth_cuts(image), material=material, TissueThreshold=25.0, Rotations=1, AnchoredFaces=[1, 1, 1, 1, 0, 1],
                 RelaxationPreset="Balanced", OutputPadding=16, BackgroundValue=0.0)


def bent_spine(folder, degrees=18.0):
    """An abdomen whose vertebrae bend to the side, each by its label and about its own middle, along an arc: `degrees`
    between the lowest, which stays, and the uppermost."""
    image, names = (read_scan(folder, name) for name in ("abdomen_ct", "abdomen_labels"))
    labels = values_of(names, "MetaImage")
    add_array(image, labels, "Bones")
    x, y, z = (axis.ravel() for axis in coordinates(image))
    middles = []
    for vertebra in range(26, 34):  # from the sacrum upwards
        k, j, i = (labels == vertebra).nonzero()
        middles.append((vertebra, [float(x[i].mean()), float(y[j].mean()), float(z[k].mean())]))
    middles.sort(key=lambda entry: entry[1][2])
    low, high = middles[0][1][2], middles[-1][1][2]
    radius = (high - low) / np.radians(degrees)
    probes = []
    for vertebra, (px, py, pz) in middles:
        angle = (pz - low) / radius
        target = [px + radius * (1.0 - np.cos(angle)), py, low + radius * np.sin(angle)]
        probes.append({"Position": [px, py, pz], "Target": target, "Turns": 1, "Rotation": [0.0, float(np.degrees(angle)), 0.0],
                       "Body": vertebra})
    # Spongy bone counts as bone here, since voxels of 3 mm leave little of the compact one.
    return Scene(image, probes, material=[(-300, 0.35), (249, 0.1), (250, 0.0)], TissueThreshold=-300.0, BodyArray="Bones",
                 JointConstraint=1.0, Rotations=1, RelaxationPreset="Balanced", AnchoredFaces=[1, 1, 1, 1, 1, 0])
