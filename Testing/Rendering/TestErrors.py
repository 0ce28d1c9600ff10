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


nowhere = lost_probe()
holder = ChainMailProbe(Position=[0, -7, 0], Anchor=1, Radius=3)
hole = Plane(Origin=[-5, -5, 0], Point1=[5, -5, 0], Point2=[-5, 5, 0])
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
    ("displacement of NaN", "finite", lambda scene: setattr(scene.filter, "Probes", [nowhere, holder]),
     lambda scene: setattr(scene.filter, "Probes", [scene.probe, holder])),
    ("unknown array", "density", *setter("Scalars", ["POINTS", "scalars"], ["POINTS", "density"])),
    ("constraint above 1", "MaterialFunction", lambda scene: setattr(scene.filter.MaterialFunction, "Points", TOO_SOFT),
     lambda scene: setattr(scene.filter.MaterialFunction, "Points", SOFT)),
]


view = make_view((80, 80), position=(10, 14, 52), focus=(0, 0, 0), up=(0, 1, 0), angle=32)


class Scene:
    """A filter with two probes, one of which only holds, shown in the view."""

    def __init__(self, representation, spoil=None, **properties):
        self.name = "%s %s" % (representation, properties)
        self.probe = ChainMailProbe(Position=PLACE, Target=TARGET, Radius=2)
        self.filter = ChainMailDeformation(Input=source, Probes=[self.probe, holder], TissueThreshold=50,
                                           RelaxationIterations=20, **properties)
        self.filter.MaterialFunction.Points = SOFT
        if spoil:
            spoil(self)
        self.show(self.filter, representation)

    def show(self, thing, representation):
        display = show_volume(thing, view, "scalars", COLOURS, OPACITIES)
        display.SetRepresentationType(representation)
        display.Shade = 0

    def settled(self):
        """The picture when the filter asks for no more updates, as the window shows it."""
        for _ in range(200):
            Render(view)
            self.filter.UpdatePropertyInformation()
            if not self.filter.NeedsUpdate:
                return capture(view)
            self.filter.MarkModified(self.filter)
        require(False, "%s: it never settles", self.name)

    def delete(self):
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
    Hide(scene.filter, view)
    scene.show(source, representation)
    rest = capture(view)
    Hide(source, view)
    scene.delete()
    require(not reported, "the scene without errors reports: %s", reported)
    return rest, pulled, moved


def fails(scene, error, shown, what):
    """The scene was just spoiled: it goes on showing what it showed, and says why, once."""
    found = scene.settled()
    says = error[1]
    require(len(reported) == 1 and says in reported[0], "%s: instead of one message that says '%s' there are %d:\n%s", what,
            says, len(reported), "\n".join(reported))
    del reported[:]
    require((found == shown).all(), "%s: %d pixels changed", what, (found != shown).any(axis=2).sum())
    Hide(scene.filter, view)
    Render(view)
    Show(scene.filter, view)
    require((scene.settled() == shown).all(), "%s: hidden and shown again it is another picture", what)
    require(not reported, "%s: hiding and showing it reports %s", what, reported)


def recovers(scene, error, expected, what):
    """Mended, the scene is where it would be without the error, and follows its probe."""
    _, pulled, moved = expected
    error[3](scene)
    same(scene.settled(), pulled, what + ": corrected")
    scene.probe.Target = ELSEWHERE
    same(scene.settled(), moved, what + ": the target moved")
    require(not reported, "%s: after the correction: %s", what, reported)


def play(errors, representation, **properties):
    expected = references(representation, **properties)
    for one, other in ((0, 1), (0, 2), (1, 2)):
        require(representation == "Outline" or not same_picture(expected[one], expected[other]),
                "%s: pictures %d and %d cannot be told apart", representation, one, other)
    for error in errors:
        scene = Scene(representation, spoil=error[2], **properties)
        what = "%s, %s, first update" % (scene.name, error[0])
        fails(scene, error, expected[0], what)
        recovers(scene, error, expected, what)
        scene.delete()

    scene = Scene(representation, **properties)
    for error in errors:
        what = "%s, %s, later update" % (scene.name, error[0])
        scene.probe.Target = TARGET
        before = scene.settled()
        same(before, expected[1], what + ": before")
        error[2](scene)
        fails(scene, error, before, what)
        recovers(scene, error, expected, what)
    scene.delete()
    print("%s: %d errors" % (scene.name, 2 * len(errors)), flush=True)


for mode in ("FromRest", "Interactive"):
    play(ERRORS, "Volume", Mode=mode)
    play(ERRORS[:1], "Volume", Mode=mode, OutputPadding=2)  # larger than the scan that is shown at first
for representation in ("Slice", "Outline"):  # drawn from geometry
    play(ERRORS[:1], representation, Mode="Interactive")
