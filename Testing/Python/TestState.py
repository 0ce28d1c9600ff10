"""A saved state brings the scene back in a ParaView of its own: the same properties, the same bits. So does one that is a
script, a trace, and one that was saved before the filter had all its properties: they have their defaults then. Properties that are
copied and pasted give the same bits, too, and share nothing; a name changes nothing. The values of CHANGED make one scene; that
really every property comes back is tested with values that need not make any."""

import json
import os
import sys
import xml.etree.ElementTree as ElementTree

import chainmail.ChainMailFilters  # without it Python would see the filter as a mere vtkImageAlgorithm
import numpy as np
from harness import OUTPUT, Reports, points_of, require, run_pvpython, same_bits, settable, update
from paraview import smstate, smtrace
from paraview.modules.vtkRemotingMisc import vtkSMProxyClipboard
from paraview.simple import *

STATE = os.path.join(OUTPUT, "TestState.pvsm")
SCRIPT = os.path.join(OUTPUT, "TestState-script.py")
TRACE = os.path.join(OUTPUT, "TestState-trace.py")
RESULT = os.path.join(OUTPUT, "TestState.npz")

CHANGED = {"MaterialPreset": "Function", "TissueThreshold": 60.0, "AnchorRigid": 1, "AnchoredFaces": [1, 0, 1, 0, 1, 1],
           "RelaxationIterations": 7, "RelaxationTolerance": 0.01, "Interpolation": "Nearest", "BackgroundValue": -5.0,
           "Mode": "Interactive", "PropagationMethod": "Timestamp", "PropagationIterations": 500,
           "ConflictPolicy": "Latest", "PropagationTimes": 1, "RelaxationMethod": "Paper",
           "RelaxationPreset": "Accurate", "CoarseToFine": 1,
           "ElasticRecovery": 0.75, "BodyArray": "RTData", "JointSize": 3, "JointConstraint": 0.0, "JointMargin": 5,
           "ModelArrays": ["Displacement", "Cluster"], "OutputPadding": 2, "OutputMagnification": 2, "UseOutputBounds": 1,
           "OutputBounds": [-6.0, 5.0, -4.0, 6.5, -5.0, 4.0], "SmoothCuts": 0, "PullBack": 1, "ScalarSmoothing": 1.5, "BrickSize": [8, 4, 4], "ModelReduction": "2", "LabelArrays": ["RTData"]}
# What the filter had at first, and OutputBounds, whose default is the image's box. Old states have no other properties.
FIRST = {"Scalars", "MaterialPreset", "TissueThreshold", "MaterialFunction", "ConstraintArray", "AnchoredFaces", "AnchorRigid",
         "RelaxationIterations", "RelaxationTolerance", "OutputPadding", "OutputBounds", "BackgroundValue", "Interpolation",
         "LabelArrays", "Device", "BrickSize"}
FIRST_INPUTS = {"Input", "Probes", "Cuts"}
# No function of the class gives these as numbers or text.
NO_GETTER = {"Scalars", "MaterialFunction", "LabelArrays", "ModelArrays"}
OLD_STATE = os.path.join(OUTPUT, "TestState-old.pvsm")
EVERY_STATE = os.path.join(OUTPUT, "TestState-every.pvsm")
EVERY_SCRIPT = os.path.join(OUTPUT, "TestState-every.py")
EVERY_VALUES = os.path.join(OUTPUT, "TestState-every.json")
POINTS = [60.0, 0.35, 0.5, 0.0, 150.0, 0.25, 0.5, 0.0, 277.0, 0.15, 0.5, 0.0]


def value_of(deformation, name):
    """The value of a property as scripts set it."""
    value = deformation.GetPropertyValue(name)
    value = value.GetData() if hasattr(value, "GetData") else value
    return list(value) if isinstance(value, (list, tuple)) else value


def later(deformation):
    """What the filter did not have at first, with the values of a new filter."""
    fresh = ChainMailDeformation(Input=deformation.Input)
    values = {name: value_of(fresh, name) for name in settable(fresh) if name not in FIRST}
    Delete(fresh)
    return values


def vector_of(property):
    """The property with the elements that are set; those of the material function are its points."""
    return property.GetProxy(0).GetProperty("Points") if property.IsA("vtkSMProxyProperty") else property


def state_of(deformation, name, property):
    """The elements of a property, and the value that the VTK object has where a function gives it."""
    vector = vector_of(property)
    get = getattr(deformation.GetClientSideObject(), "Get" + name, None) if vector == property else None
    value = get() if get else None
    return [[vector.GetElement(n) for n in range(vector.GetNumberOfElements())],
            list(value) if isinstance(value, tuple) else value]


def domain_of(property, kind):
    """The property's domain of a kind, None without such a domain."""
    iterator = property.NewDomainIterator()
    iterator.UnRegister(None)
    iterator.Begin()
    while not iterator.IsAtEnd():
        if iterator.GetDomain().IsA("vtkSM%sDomain" % kind):
            return iterator.GetDomain()
        iterator.Next()


def candidates(property, n):
    """Values that the property's domains allow for its element n."""
    if domain_of(property, "Boolean"):
        return [0, 1]
    domain = domain_of(property, "Enumeration")
    if domain:
        return [domain.GetEntryValue(entry) for entry in range(domain.GetNumberOfEntries())]
    if property.IsA("vtkSMStringVectorProperty"):
        domain = domain_of(property, "StringList")
        return [domain.GetString(string) for string in range(domain.GetNumberOfStrings())] if domain else ["another"]
    value, domain = property.GetElement(n), domain_of(property, "IntRange") or domain_of(property, "DoubleRange")
    low = domain.GetMinimum(n) if domain and domain.GetMinimumExists(n) else -np.inf
    high = domain.GetMaximum(n) if domain and domain.GetMaximumExists(n) else np.inf
    return [number for number in (value + 1, value - 1, low, high) if low <= number <= high]


def other_elements(property):
    """Other elements for a property. Properties changed so may make no sense together."""
    def other(n, *refused):
        found = [candidate for candidate in candidates(property, n) if candidate not in refused]
        require(found, "the domains of %s allow nothing but %s", property.GetXMLName(), refused)
        return found[0]

    elements = [property.GetElement(n) for n in range(property.GetNumberOfElements())]
    if property.GetRepeatable():  # a list of names, which may be empty
        return [other(0, *elements)]
    # Of several words only the last is a choice: the name of an array, behind where to look for it.
    kept = len(elements) - 1 if property.IsA("vtkSMStringVectorProperty") else 0
    return elements[:kept] + [other(n, elements[n]) for n in range(kept, len(elements))]


def change(deformation, name, property):
    """Gives a property another value, and returns what state_of() then gives."""
    before = state_of(deformation, name, property)
    vector = vector_of(property)
    elements = other_elements(property) if vector == property else POINTS
    vector.SetNumberOfElements(len(elements))
    for n, element in enumerate(elements):
        vector.SetElement(n, element)
    deformation.SMProxy.UpdateVTKObjects()
    after = state_of(deformation, name, property)
    require(after[0] == elements != before[0], "%s cannot become %s", name, elements)
    require(after[1] is not None or name in NO_GETTER, "the class has no Get%s", name)
    require(after[1] is None or after[1] != before[1], "%s does not arrive in the VTK object", name)
    return after


def compare_states(deformation, states):
    for name, property in settable(deformation).items():
        found = state_of(deformation, name, property)
        require(found == states[name], "%s is %s, not %s", name, found, states[name])


def compare(deformation, values):
    for name, value in values.items():
        found = value_of(deformation, name)
        require(found == value, "%s is %s, not %s", name, found, value)
    require(list(deformation.MaterialFunction.Points) == POINTS, "the function is %s", deformation.MaterialFunction.Points)
    carves = 1 if values["Mode"] == "Interactive" else 0
    counts = [len(deformation.Probes), len(deformation.Cuts), len(deformation.Carves)]
    require(counts == [2, 1, carves], "probes, cuts and carves: %s", counts)


def results(deformation):
    """The scalars of the volume and the displacements of the model."""
    volume, model = update(deformation, Reports(deformation))
    return points_of(volume, "RTData"), points_of(model, "Displacement")


def paste(source, target):
    """What Copy and Paste in the menu Edit do."""
    clipboard = vtkSMProxyClipboard()
    clipboard.Copy(source.SMProxy)
    require(clipboard.Paste(target.SMProxy), "%s cannot be pasted", source.GetXMLName())


if len(sys.argv) == 1:
    smtrace.start_trace()
    wavelet = Wavelet(WholeExtent=[0, 20, 0, 22, 0, 24])
    probes = [ChainMailProbe(Position=[8, 9, 10], Target=[8.5, 9.25, 9], Radius=1.5),
              ChainMailProbe(Position=[12, 13, 14], Anchor=1, Radius=2, Tolerance=0.5, Rotation=[0, 4, 0])]
    blade = Plane(Origin=[5, -1, 15.5], Point1=[25, -1, 15.5], Point2=[5, 30, 15.5])
    ball = Sphere(Center=[5, 16, 6], Radius=3.3)
    deformation = ChainMailDeformation(Input=wavelet, Probes=probes, Cuts=[blade], Carves=[ball], **CHANGED)
    with open(TRACE, "w") as file:
        file.write(smtrace.stop_trace())
    traced = results(deformation)
    np.savez(TRACE + ".npz", scalars=traced[0], displacement=traced[1])

    deformation.MaterialFunction.Points = POINTS  # which a script's trace does not hold
    compare(deformation, CHANGED)
    volume, model = update(deformation, Reports(deformation))
    require(points_of(model, "Displacement").any(), "nothing moves")
    expected = points_of(volume, "RTData"), points_of(model, "Displacement")
    np.savez(RESULT, scalars=expected[0], displacement=expected[1])
    SaveState(STATE)
    with open(SCRIPT, "w") as file:
        file.write(smstate.get_state())

    # Another filter on the same inputs, with other probes, takes the properties of these, and keeps its inputs.
    others = [ChainMailProbe(Position=[8, 9, 10], Target=[8, 9, 10]), ChainMailProbe(Position=[3, 4, 5], Target=[3, 4, 5])]
    another = ChainMailDeformation(Input=wavelet, Probes=others, Cuts=[blade], Carves=[ball])
    require(not same_bits(results(another)[1], expected[1]), "the other filter does the same before anything is pasted")
    another.Carves = []
    paste(deformation, another)
    for one, other in zip(probes, others):
        paste(one, other)
        for name in ("Position", "Target", "Radius", "Anchor", "Tolerance", "Turns", "Rotation", "Body"):
            found = other.GetPropertyValue(name), one.GetPropertyValue(name)
            require(found[0] == found[1], "pasted, %s is %s, not %s", name, *found)
    require([probe.SMProxy for probe in another.Probes] == [probe.SMProxy for probe in others], "other probes were pasted")
    another.Carves = [ball]
    compare(another, CHANGED)
    another.Mode = "FromRest"
    deformation.Mode = "FromRest"
    for one, other in zip(results(another), results(deformation)):
        require(same_bits(one, other), "pasted, the same properties give something else")
    another.MaterialFunction.Points = [0, 0.1, 0.5, 0, 300, 0.1, 0.5, 0]
    require(list(deformation.MaterialFunction.Points) == POINTS, "what was pasted shares its material function")
    deformation.Mode = "Interactive"

    tree = ElementTree.parse(STATE)
    for proxy in tree.iter("Proxy"):
        if proxy.get("type") == "ChainMailDeformation":
            for item in [p for p in proxy.findall("Property") if p.get("name") not in FIRST | FIRST_INPUTS]:
                proxy.remove(item)
    tree.write(OLD_STATE)
    deformation.Carves = []
    for name, value in later(deformation).items():
        setattr(deformation, name, value)
    volume, model = update(deformation, Reports(deformation))
    np.savez(OLD_STATE + ".npz", scalars=points_of(volume, "RTData"), displacement=points_of(model, "Displacement"))

    RenameSource("lip", probes[0])
    RenameSource("limb", deformation)
    for one, name in zip(results(deformation), ("scalars", "displacement")):
        require(same_bits(one, np.load(OLD_STATE + ".npz")[name]), "another name gives other %s", name)

    # Every property changed, pasted and saved. Such a filter is never updated.
    arrays = Elevation(Input=wavelet)  # two to choose from
    every = ChainMailDeformation(registrationName="every", Input=arrays)
    states = {name: change(every, name, property) for name, property in settable(every).items()}
    pasted = ChainMailDeformation(Input=arrays)
    paste(every, pasted)
    compare_states(pasted, states)
    with open(EVERY_VALUES, "w") as file:
        json.dump(states, file)
    SaveState(EVERY_STATE)
    with open(EVERY_SCRIPT, "w") as file:
        file.write(smstate.get_state())

    for path, result in ((STATE, RESULT), (SCRIPT, RESULT), (TRACE, TRACE + ".npz"), (OLD_STATE, OLD_STATE + ".npz"),
                         (EVERY_STATE, EVERY_VALUES), (EVERY_SCRIPT, EVERY_VALUES)):
        status, text = run_pvpython(os.path.abspath(__file__), path, result)
        require(status == 0, "%s:\n%s", path, text)
        print(text.strip().splitlines()[-1])
else:
    if sys.argv[1].endswith(".py"):
        with open(sys.argv[1]) as file:
            exec(compile(file.read(), sys.argv[1], "exec"))
    else:
        LoadState(sys.argv[1])
    if sys.argv[2] == EVERY_VALUES:
        with open(EVERY_VALUES) as file:
            compare_states(FindSource("every"), json.load(file))
        print("every property came back")
        sys.exit()
    deformation = next(proxy for proxy in GetSources().values() if proxy.GetXMLName() == "ChainMailDeformation")
    if sys.argv[1] != TRACE:
        compare(deformation, {**CHANGED, **later(deformation)} if sys.argv[1] == OLD_STATE else CHANGED)
    volume, model = update(deformation, Reports(deformation))
    expected = np.load(sys.argv[2])
    require(same_bits(points_of(volume, "RTData"), expected["scalars"]), "the volume is another")
    require(same_bits(points_of(model, "Displacement"), expected["displacement"]), "the displacements are others")
    print("the state came back, bit for bit")
