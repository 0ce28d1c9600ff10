"""A forearm, shown as a volume: at rest the picture is the input's, pulled and pulled after a cut they are those in
Data/Baselines. Pictures that must differ do: the same comparison refuses each of them."""

import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pictures import *  # noqa: E402, F403  (puts the harness on the path)
from harness import OUTPUT, Reports, field, make_image, points_of, produce, update  # noqa: E402

sys.path.insert(0, DATA)
from make_forearm import make_forearm  # noqa: E402

require_display()

THRESHOLD = -400  # [HU] halfway between air and tissue
VACATED = -1100  # below every value of the phantom, so that vacated voxels are told from its air
COLOURS = [(-1000, 0.50, 0.30, 0.25), (-420, 0.95, 0.70, 0.57), (-150, 0.99, 0.81, 0.65), (-60, 1.00, 0.86, 0.60),
           (10, 0.88, 0.40, 0.32), (60, 0.80, 0.16, 0.14), (130, 0.90, 0.50, 0.38), (250, 0.97, 0.90, 0.78),
           (1500, 1.00, 0.99, 0.95)]
# The skin hides what is below it: a hole in it shows.
OPACITIES = [(-1000, 0.0), (-800, 0.0), (-450, 0.7), (-120, 0.6), (-60, 0.3), (70, 0.3), (160, 0.12), (300, 0.75),
             (1500, 1.0)]

image = make_forearm((66, 62, 92))
before = points_of(image, "CT").reshape(92, 62, 66)
forearm = produce(image)
view = make_view((260, 200), position=(190, 340, 10), focus=(0, 0, 10), up=(0, 1, 0), angle=28.0)

deformation = ChainMailDeformation(Input=forearm, TissueThreshold=THRESHOLD, BackgroundValue=VACATED)
deformation.Scalars = ["POINTS", "CT"]
# Soft enough to be drawn out by several voxels; bone is rigid.
deformation.MaterialFunction.Points = [-1024, 0.8, 0.5, 0, 200, 0.8, 0.5, 0, 600, 0, 0.5, 0]
reports = Reports(deformation)


def show(source):
    return picture(source, view, "CT", COLOURS, OPACITIES)


def show_values(values):
    return show(produce(make_image(values, "CT", image.GetSpacing(), image.GetOrigin())))


def tissue_neighbours(tissue):
    """How many of its six neighbours are tissue, for each voxel that has six; -1 at the box's faces."""
    count = np.full(tissue.shape, -1)
    inside = (slice(1, -1),) * 3
    count[inside] = sum(np.roll(tissue, step, axis)[inside].astype(int) for axis in range(3) for step in (1, -1))
    return count


def speckles(values):
    """Single voxels of no tissue within tissue, and single voxels of tissue outside."""
    tissue = values >= THRESHOLD
    count = tissue_neighbours(tissue)
    return int((~tissue & (count == 6)).sum()), int((tissue & (count == 0)).sum())


def refuse(pixels, expected, what):
    require(not same_picture(pixels, expected), "the comparison takes %s for the expected picture", what)
    print("refused: %s, %d pixels too dark, %d too bright" % ((what,) + pixels_beyond(pixels, expected)))


# Nothing pulls.
deformation.Probes = []
update(deformation, reports)
rest = show(forearm)
limb = (rest != rest[0, 0]).any(axis=2).mean()
require(0.3 < limb < 0.6, "the limb covers %.2f of the picture: it is not seen, or not as a limb", limb)
require((show(deformation) == rest).all(), "nothing pulls and the picture is another than the input's")
print("at rest the picture is the input's, pixel by pixel")


def skin(x, z):
    """y of the topmost tissue [mm]."""
    i, k = round((x - image.GetOrigin()[0]) / image.GetSpacing()[0]), round((z - image.GetOrigin()[2]) / image.GetSpacing()[2])
    return image.GetOrigin()[1] + image.GetSpacing()[1] * np.nonzero(before[k, :, i] >= THRESHOLD)[0].max()


# Two probes drag the back of the arm up and apart; between them a blade, 18 mm deep, along the arm.
right, left, middle = skin(20, 4), skin(-10, 4), skin(2, 4)
probes = [ChainMailProbe(Position=[20, right - 4, 4], Target=[42, right + 16, 4], Radius=7),
          ChainMailProbe(Position=[-10, left - 3, 4], Target=[-28, left + 12, 4], Radius=6)]
blade = Plane(Origin=[6, middle - 18, -30], Point1=[6, middle + 14, -30], Point2=[6, middle - 18, 38])
expected = {"forearm-rest": baseline("forearm-rest", rest)}
require(same_picture(rest, expected["forearm-rest"]), "the input's own picture differs from the baseline: %d pixels too dark, "
        "%d too bright", *pixels_beyond(rest, expected["forearm-rest"]))

rng = np.random.default_rng(1)
for label, cuts in (("forearm-pulled", []), ("forearm-cut", [blade])):
    deformation.Probes, deformation.Cuts = probes, cuts
    volume, _ = update(deformation, reports)
    reached = field(volume, "ProbeReached")
    require((abs(reached[:, 0]) > 5).all(), "%s: the probes reached %s", label, reached)
    after = points_of(volume, "CT").reshape(before.shape)
    require(speckles(after) == (0, 0), "%s: %d isolated holes, %d isolated bits of tissue", label, *speckles(after))

    seen = show(deformation)
    expected[label] = baseline(label, seen)
    if not same_picture(seen, expected[label]):
        path = os.path.join(OUTPUT, label + ".png")
        write(seen, path)
        require(False, "%s differs from the baseline: %d pixels too dark, %d too bright; see %s", label,
                *pixels_beyond(seen, expected[label]), path)
    print("%s: %d pixels too dark, %d too bright" % ((label,) + pixels_beyond(seen, expected[label])))

    # An eighth of a pixel aside, as a stand-in for another rasteriser. A pixel is about 1 mm wide.
    place, focus = list(view.CameraPosition), list(view.CameraFocalPoint)
    view.CameraPosition = [place[0], place[1], place[2] + 0.125]
    view.CameraFocalPoint = [focus[0], focus[1], focus[2] + 0.125]
    aside = show(deformation)
    view.CameraPosition, view.CameraFocalPoint = place, focus
    require((aside != seen).any() and same_picture(aside, expected[label]), "%s, an eighth of a pixel aside, is refused: %d "
            "pixels too dark, %d too bright", label, *pixels_beyond(aside, expected[label]))
    print("accepted: an eighth of a pixel aside, %d pixels too dark, %d too bright" % pixels_beyond(aside, expected[label]))

    # What must not pass.
    if cuts:
        refuse(seen, expected["forearm-pulled"], "the open cut for the closed skin")
        refuse(expected["forearm-pulled"], expected[label], "the closed skin for the open cut")
    refuse(rest, expected[label], "the limb at rest")
    tissue = after >= THRESHOLD
    border = tissue & (tissue_neighbours(tissue) < 6)
    refuse(show_values(np.where(border, VACATED, after).astype(after.dtype)), expected[label], "an eroded border")
    holes = tissue & (rng.random(after.shape) < 0.005)
    holed = np.where(holes, VACATED, after).astype(after.dtype)
    refuse(show_values(holed), expected[label], "holes of one voxel")
    found, inner = speckles(holed)[0], int((holes & (tissue_neighbours(tissue) == 6)).sum())
    require(0.9 * inner < found <= inner, "%d of %d planted holes found", found, inner)
