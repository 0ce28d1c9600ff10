"""Errors in a view: it goes on showing the last good result (before there is one, the scan as it is), the user is told
once, and after the correction everything goes on as if nothing had happened. Pictures and messages are looked at, for
every kind of error, from rest and Interactive, at the first update and at a later one, in several representations."""

import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pictures import *  # noqa: E402, F403  (puts the harness on the path)
from harness import OUTPUT, make_image, produce  # noqa: E402
from vtkmodules.util.misc import calldata_type  # noqa: E402
from vtkmodules.util.vtkConstants import VTK_STRING  # noqa: E402
from vtkmodules.vtkCommonCore import vtkOutputWindow, vtkPoints  # noqa: E402
from vtkmodules.vtkCommonDataModel import vtkPolyData  # noqa: E402

require_display()

# A ball of layers in air, seen from the side.
z, y, x = np.meshgrid(*(np.arange(-11.5, 12),) * 3, indexing="ij")
radius = np.sqrt(x * x + y * y + z * z)
scan = make_image(np.where(radius < 9, 100 + 20 * ((y + 12) // 3), 0).astype(np.float32), origin=(-11.5,) * 3)
source = produce(scan)
COLOURS = [(0, 0, 0, 0), (100, 0.8, 0.2, 0.1), (170, 0.9, 0.9, 0.3), (260, 0.1, 0.3, 0.9)]
OPACITIES = [(0, 0), (80, 0), (100, 0.8), (260, 0.8)]
PLACE, TARGET, ELSEWHERE = [0, 7, 0], [0, 10, 0], [5, 8, 0]

reported = []


@calldata_type(VTK_STRING)
def note(caller, event, text):
    reported.append(text.strip())


# Everything that would come to the user's eyes, whoever reports it: the filter, an executive, a representation.
for kind in ("ErrorEvent", "WarningEvent"):
    vtkOutputWindow.GetInstance().AddObserver(kind, note)


def lost_probe():
    """A probe whose displacement is not a number."""
    data = vtkPolyData()
    points = vtkPoints()
    points.InsertNextPoint(PLACE)
    data.SetPoints(points)
    displacement = numpy_to_vtk(np.array([[np.nan, 0, 0]]), deep=1)
    displacement.SetName("Displacement")
    data.GetPointData().AddArray(displacement)
    return produce(data)


nowhere, hole = lost_probe(), Plane(Origin=[-5, -5, 0], Point1=[5, -5, 0], Point2=[-5, 5, 0])
SOFT, TOO_SOFT = [0, 0.6, 0.5, 0, 300, 0.6, 0.5, 0], [0, 0.6, 0.5, 0, 300, 1.2, 0.5, 0]


def set_position(scene, place):
    scene.probe.Position = place


def setter(name, good, bad):
    return lambda scene: setattr(scene.filter, name, bad), lambda scene: setattr(scene.filter, name, good)


# What goes wrong, a part of the message, how it is done and how it is mended.
ERRORS = [
    ("probe outside", "no tissue", lambda scene: set_position(scene, [80, 0, 0]), lambda scene: set_position(scene, PLACE)),
    ("threshold above all", "all air", *setter("TissueThreshold", 50, 1e6)),
    ("open surface as carve", "not closed", *setter("Carves", [], [hole])),
    ("displacement of NaN", "finite", lambda scene: setattr(scene.filter, "Probes", [nowhere]),
     lambda scene: setattr(scene.filter, "Probes", [scene.probe])),
    ("unknown array", "density", *setter("Scalars", ["POINTS", "scalars"], ["POINTS", "density"])),
    ("constraint above 1", "MaterialFunction", lambda scene: setattr(scene.filter.MaterialFunction, "Points", TOO_SOFT),
     lambda scene: setattr(scene.filter.MaterialFunction, "Points", SOFT)),
    ("unknown device", "no such card", *setter("Device", "", "no such card")),
]


class Scene:
    """A filter with its probe, shown in a view of its own."""

    def __init__(self, representation, spoil=None, **properties):
        self.probe = ChainMailProbe(Position=PLACE, Target=TARGET, Radius=2)
        self.filter = ChainMailDeformation(Input=source, Probes=[self.probe], TissueThreshold=50, RelaxationIterations=60,
                                           **properties)
        self.filter.MaterialFunction.Points = SOFT
        if spoil:
            spoil(self)
        self.view = make_view((110, 110), position=(10, 14, 52), focus=(0, 0, 0), up=(0, 1, 0), angle=32)
        self.show(self.filter, representation)

    def show(self, thing, representation):
        display = show_volume(thing, self.view, "scalars", COLOURS, OPACITIES)
        display.SetRepresentationType(representation)

    def settled(self):
        """The picture when the filter asks for no more updates, as the window shows it."""
        pixels = capture(self.view)
        for _ in range(200):
            self.filter.UpdatePropertyInformation()
            if not self.filter.NeedsUpdate:
                return pixels
            self.filter.MarkModified(self.filter)
            pixels = capture(self.view)
        require(False, "it never settles")

    def delete(self):
        Delete(self.view)
        Delete(self.filter)
        Delete(self.probe)


def same(found, expected, what):
    if not same_picture(found, expected):
        for name, pixels in (("found", found), ("expected", expected)):
            write(pixels, os.path.join(OUTPUT, "TestErrors-%s.png" % name))
        require(False, "%s: %d pixels are too dark, %d too bright, see TestErrors-*.png in %s", what,
                *pixels_beyond(found, expected), OUTPUT)


def references(representation, **properties):
    """The pictures of a pipeline in which nothing ever went wrong: the scan, pulled, pulled elsewhere."""
    scene = Scene(representation, **properties)
    pulled = scene.settled()
    scene.probe.Target = ELSEWHERE
    moved = scene.settled()
    Hide(scene.filter, scene.view)
    scene.show(source, representation)
    rest = capture(scene.view)
    scene.delete()
    require(not reported, "the scene without errors reports: %s", reported)
    return rest, pulled, moved


def told_once(says, what):
    require(len(reported) == 1 and says in reported[0], "%s: instead of one message that says '%s' there are %d:\n%s", what,
            says, len(reported), "\n".join(reported))
    del reported[:]


def fails_and_recovers(error, representation, expected, first, **properties):
    name, says, spoil, mend = error
    what = "%s, %s, %s, %s update" % (name, representation, properties or "from rest", "first" if first else "later")
    rest, pulled, moved = expected
    scene = Scene(representation, spoil=spoil if first else None, **properties)
    if not first:
        before = scene.settled()
        same(before, pulled, what + ": before")
        spoil(scene)
    after = scene.settled()
    told_once(says, what)
    shown = rest if first else before
    require((after == shown).all(), "%s: the error changed %d pixels", what, (after != shown).any(axis=2).sum())
    # Drawn again, and shown again, without an update in between: neither another picture nor another message.
    Hide(scene.filter, scene.view)
    capture(scene.view)
    Show(scene.filter, scene.view)
    require((scene.settled() == shown).all(), "%s: shown again it is another picture", what)
    require(not reported, "%s: drawing it again reports %s", what, reported)
    mend(scene)
    same(scene.settled(), pulled, what + ": corrected")
    scene.probe.Target = ELSEWHERE
    same(scene.settled(), moved, what + ": the target moved")
    require(not reported, "%s: after the correction: %s", what, reported)
    scene.delete()


MODES = ({"Mode": "FromRest"}, {"Mode": "Interactive"})
for properties in MODES:
    expected = references("Volume", **properties)
    for one, other in ((0, 1), (1, 2), (0, 2)):
        require(not same_picture(expected[one], expected[other]), "pictures %d and %d cannot be told apart", one, other)
    for error in ERRORS:
        for first in (True, False):
            fails_and_recovers(error, "Volume", expected, first, **properties)
        print("%s: %s" % (properties["Mode"], error[0]), flush=True)

# What is drawn from geometry, and an output larger than the scan.
for representation in ("Slice", "Surface", "Outline"):
    expected = references(representation, Mode="Interactive")
    for first in (True, False):
        fails_and_recovers(ERRORS[0], representation, expected, first, Mode="Interactive")
    print(representation, flush=True)
expected = references("Volume", Mode="FromRest", OutputPadding=2)
for first in (True, False):
    fails_and_recovers(ERRORS[0], "Volume", expected, first, Mode="FromRest", OutputPadding=2)
print("padded", flush=True)
