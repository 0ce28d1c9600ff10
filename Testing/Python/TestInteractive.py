"""Interactive mode as scripts use it: probes dragged in steps, a knife, settling in a loop, plastic tissue, Reset. The
tissue is a bar along x with links of one length, where every result has a closed form."""

import numpy as np
from harness import Reports, expect_error, field, make_image, points_of, produce, require, same_bits, update
from paraview.simple import *

LENGTH, LIMIT, SPACING = 40, 0.25, 2.0  # 0.25 of a spacing of 2 mm: half a millimetre a link
scan = make_image(np.arange(10, 10 + LENGTH, dtype=np.int16).reshape(1, 1, LENGTH), spacing=(SPACING, 1, 1))
source = produce(scan)


def bar(**properties):
    """A deformation of the bar, held at its low end, with one probe at element 20."""
    probe = ChainMailProbe(Position=[40, 0, 0], Target=[40, 0, 0])
    deformation = ChainMailDeformation(Input=source, Probes=[probe], TissueThreshold=0, AnchoredFaces=[1, 0, 0, 0, 0, 0],
                                       PropagationTimes=1, **properties)
    deformation.MaterialFunction.Points = [0, LIMIT, 0.5, 0, 100, LIMIT, 0.5, 0]
    return deformation, probe, Reports(deformation)


def along(model):
    return points_of(model, "Displacement")[:, 0].astype(float)


def needs_update(deformation):
    """As the documentation says: a script asks the filter whether there is more to do."""
    deformation.UpdatePropertyInformation()
    return deformation.NeedsUpdate


def settle(deformation, reports, limit=2000):
    count = 0
    while needs_update(deformation) and count < limit:
        deformation.MarkModified(deformation)
        deformation.UpdatePipeline()
        count += 1
    require(count < limit, "not settled after %d updates", count)
    volume, model = update(deformation, reports)
    return count, volume, model


# Dragged in steps. An element keeps what a step gave it until another step asks for something else.
deformation, probe, reports = bar(Mode="Interactive", RelaxationIterations=0)
distance = LIMIT * SPACING * np.abs(np.arange(LENGTH) - 20)
expected = np.zeros(LENGTH)
for target in (6.0, -2.0, 3.5, 1.0):
    probe.Target = [40 + target, 0, 0]
    volume, model = update(deformation, reports)
    expected = np.clip(expected, target - distance, target + distance)
    require(np.allclose(along(model), expected, rtol=0, atol=1e-5), "at %g mm:\n%s\n%s", target, along(model), expected)
    require(np.isclose(field(volume, "ProbeReached")[0, 0], target, atol=1e-5), "reached %s", field(volume, "ProbeReached"))
deformation.Mode = "FromRest"
_, model = update(deformation, reports)
require(np.allclose(along(model), np.clip(0, 1 - distance, 1 + distance), atol=1e-5), "from rest:\n%s", along(model))
print("drag", flush=True)

# A knife cuts where it is, at the deformation of that moment, and once. Element 20 is dragged by 6 mm to 46 mm; the knife
# comes at 47.3 mm, between it and the next, and would have cut between 23 and 24 at rest.
deformation.Mode = "Interactive"
probe.Target = [46, 0, 0]
update(deformation, reports)
knife = Plane(Origin=[47.3, -5, -5], Point1=[47.3, 5, -5], Point2=[47.3, -5, 5])
deformation.Cuts = [knife]
_, model = update(deformation, reports)
before = along(model)
probe.Target = [34, 0, 0]
_, model = update(deformation, reports)
after = along(model)
require((after[21:] == before[21:]).all(), "the far side of the cut follows:\n%s", after[21:])
require(np.isclose(after[20], -6), "the near side is at %g", after[20])
# Through the knife and back: it has cut already.
for target in (50.0, 36.0):
    probe.Target = [target, 0, 0]
    _, model = update(deformation, reports)
require(np.allclose(along(model)[15:21], -4 + distance[15:21], atol=1e-5), "cut twice:\n%s", along(model)[10:21])
# Moved, it cuts again.
moved = 2 * 17.5 + along(model)[17:19].mean()
for name in ("Origin", "Point1", "Point2"):
    place = list(getattr(knife, name))
    setattr(knife, name, [moved] + place[1:])
update(deformation, reports)
probe.Target = [44, 0, 0]
_, last = update(deformation, reports)
require((along(last)[:18] == along(model)[:18]).all(), "the moved knife does not cut:\n%s", along(last)[10:21])
print("knife", flush=True)

# Reset: the input, bit for bit, with everything still connected.
deformation.InvokeCommand("Reset")
require(needs_update(deformation), "nothing to do after Reset")
deformation.MarkModified(deformation)
volume, model = update(deformation, reports)
require(same_bits(points_of(volume, "scalars"), points_of(scan, "scalars")), "Reset leaves something")
require(not points_of(model, "Displacement").any() and (points_of(model, "PropagationTime") == -1).all(),
        "Reset leaves something in the model")
require(not field(volume, "ProbeReached").any(), "a probe holds on after Reset")
probe.Target = [41.5, 0, 0]
_, model = update(deformation, reports)
require(np.allclose(along(model), np.clip(0, 1.5 - distance, 1.5 + distance), atol=1e-5),
        "after Reset the tissue is not whole:\n%s", along(model))
print("reset", flush=True)

# A bad probe in between loses nothing.
lost = ChainMailProbe(Position=[500, 0, 0], Target=[501, 0, 0])
deformation.Probes = [probe, lost]
expect_error(deformation, reports, "Probes input 1", "no tissue")
deformation.Probes = [probe]
_, again = update(deformation, reports)
require(same_bits(points_of(again, "Displacement"), points_of(model, "Displacement")), "an error lost the state")

# Carved where it is now: a ball around where element 25 is.
place = 50 + along(model)[25]
ball = Sphere(Center=[place, 0, 0], Radius=0.9)
deformation.Carves = [ball]
volume, model = update(deformation, reports)
element = points_of(model, "Element")
require(element[25] == 0 and element.sum() == LENGTH - 1, "carved: %s", np.flatnonzero(element == 0))
deformation.Carves = []
expect_open = Plane(Origin=[20, -5, -5], Point1=[20, 5, -5], Point2=[20, -5, 5])
deformation.Carves = [expect_open]
expect_error(deformation, reports, "Carves input 0", "not closed")
deformation.Carves = []
_, model = update(deformation, reports)
require(points_of(model, "Element").sum() == LENGTH - 1, "carved tissue came back")
print("errors and carving", flush=True)

# It settles in a loop, and ends. The probe's side of the bar is a straight line then: the least energy.
deformation, probe, reports = bar(Mode="Interactive", RelaxationIterations=5, RelaxationTolerance=1e-5)
probe.Target = [44, 0, 0]
update(deformation, reports)
count, volume, model = settle(deformation, reports)
require(count > 3, "settled after %d updates", count)
line = 4 * np.minimum(np.arange(LENGTH) / 20, 1)
require(np.allclose(along(model), line, atol=0.02), "settled:\n%s", along(model))
require(not needs_update(deformation), "it never ends")

# Released, all of it goes back when elastic; with a recovery of 80 %, a fifth of each link's limit stays: 0.1 mm a link.
deformation.Probes = []
update(deformation, reports)
_, volume, model = settle(deformation, reports)
require(np.abs(along(model)).max() < 0.02, "elastic tissue stays by %g mm", np.abs(along(model)).max())
for recovery in (0.8, 0.5):
    stays = (1 - recovery) * LIMIT * SPACING
    deformation, probe, reports = bar(Mode="Interactive", RelaxationIterations=40, RelaxationTolerance=1e-6,
                                      ElasticRecovery=recovery)
    probe.Target = [49, 0, 0]  # 0.45 mm a link, close to their limit of 0.5
    update(deformation, reports)
    settle(deformation, reports)
    deformation.Probes = []
    update(deformation, reports)
    _, volume, model = settle(deformation, reports)
    require(np.isclose(along(model)[20], 20 * stays, rtol=0.02), "recovery of %g: %g mm stay, not %g", recovery,
            along(model)[20], 20 * stays)
    require(field(volume, "Energy")[0, 0] < 1e-3, "recovery of %g: what stays costs %g", recovery,
            field(volume, "Energy")[0, 0])
print("settling and plastic tissue", flush=True)
