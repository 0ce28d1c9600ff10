"""The trade of speed for accuracy, measured: what each setting of the filter costs and how far it is off.

    pvpython Testing/Trade/measure.py RESULTS [--small | --half] [--repeats N] [--scenes elements,block,forearm,heart] [--device NAME]

run.sh calls it. RESULTS is a folder: trade.json goes there, and solutions of CalculiX are kept there. An error is

- the distance from the converged constrained optimum (the reference), over the tissue that moves in it by more than a
  thousandth of the pull, and the energy above its own. Loose pieces are left out: no link holds them, so they have no place;
- on a block with a stiff bar, also the distance from a solution by finite elements.

How good the reference is, is measured as well: by a second way to it, and on a small block by an independent optimiser with a
proof. Settings that the filter does not have are left out."""

import argparse
import itertools
import json
import math
import os
import statistics
import subprocess
import sys
import time

import numpy as np
try:
    from scipy import ndimage
except ImportError:
    print("SKIPPED: SciPy is not there (on Debian the package python3-scipy)")
    sys.exit(125)
from vtkmodules.util.misc import calldata_type
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.util.vtkConstants import VTK_STRING
from vtkmodules.vtkCommonCore import reference as mutable, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkPiecewiseFunction, vtkPolyData
from vtkmodules.vtkImagingCore import vtkExtractVOI

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, os.pardir, os.pardir, "Data"))
sys.path.insert(0, HERE)
import block  # noqa: E402
import calculix  # noqa: E402
import finger  # noqa: E402
import scenes  # noqa: E402
from chainmail.ChainMailFilters import vtkChainMailDeformation as Deformation  # noqa: E402
from find_scene import Volume, plan_scene  # noqa: E402
from make_forearm import DEFAULT_SIZE, make_forearm  # noqa: E402

# What is offered in the panel: to drag, to look, to measure.
PRESETS = {"Fast": {"RelaxationPreset": 1}, "Balanced": {"RelaxationPreset": 2}, "Accurate": {"RelaxationPreset": 3}}
# More changes nothing but the last bits of float32.
REFERENCE = {"RelaxationIterations": 3000, "RelaxationTolerance": 1e-7, "CoarseToFine": 1}

# Tolerance 0: an iteration that is asked for is made.
BASE = {"PropagationTimes": 0, "RelaxationPreset": 0, "RelaxationTolerance": 0.0, "RelaxationIterations": 40,
        "ModelReduction": 1, "CoarseToFine": 1, "PropagationMethod": Deformation.PROPAGATION_ENVELOPE, "RelaxationMethod": Deformation.RELAXATION_PROJECTED,
        "Interpolation": Deformation.INTERPOLATION_LINEAR}
ITERATIONS = (0, 5, 10, 20, 40, 100, 400)
REDUCTIONS = (1, 2, 4, 8)
WAYS = {"coarse to fine": {"CoarseToFine": 1}, "fine alone": {"CoarseToFine": 0},
        "Paper": {"CoarseToFine": 0, "RelaxationMethod": Deformation.RELAXATION_PAPER}}
TIMES = ("upload", "propagate", "relax", "resample", "download")


def variations(small):
    """(label, settings) of everything that is tried on a scene."""
    for reduction in (1, 2) if small else REDUCTIONS:
        iterations = (0, 10, 40) if small else ITERATIONS if reduction == 1 else (0, 10, 40, 100)
        for (way, settings), n in itertools.product(WAYS.items(), iterations):
            if way == "Paper" and reduction > 1 or n == 0 and way != "fine alone":
                continue  # without iterations all ways are the same
            yield way, {**BASE, **settings, "ModelReduction": reduction, "RelaxationIterations": n}
    yield "Timestamp", {**BASE, "PropagationMethod": Deformation.PROPAGATION_TIMESTAMP, "CoarseToFine": 0,
                        "RelaxationIterations": 0}
    yield "Nearest", {**BASE, "Interpolation": Deformation.INTERPOLATION_NEAREST}
    yield "PropagationTimes", {**BASE, "PropagationTimes": 1}
    for tolerance in (1e-2, 1e-3) if small else (1e-2, 1e-3, 1e-4, 1e-5):
        yield "to a tolerance", {**BASE, "RelaxationIterations": 2000, "RelaxationTolerance": tolerance}


# ----------------------------------------------------------------------------------------------------------------------
# The scenes


class Scene:
    """image: with active scalars. probes: place, displacement [mm] and radius of each. material: (scalar, constraint)
    points, or None where the image has the array "Constraint". properties: further ones of the filter."""

    def __init__(self, image, probes, material=None, **properties):
        self.image, self.probes, self.material, self.properties = image, probes, material, properties

    def pull(self):
        return max(float(np.linalg.norm(displacement)) for _, displacement, _ in self.probes)


def block_scene(tissue, displacement, contrast=math.inf):
    constraint = tissue.constraint(contrast)
    image = scenes.make_image(np.ones(tissue.shape, np.float32), "Tissue")
    scenes.add_array(image, constraint, "Constraint")
    image.GetPointData().SetActiveScalars("Tissue")
    # A ball so far above the block that it reaches into its uppermost layer alone.
    above = tissue.size / 2
    x, y, z = tissue.top
    handle = ((x, y, z + above), displacement, math.hypot(above, tissue.radius))
    return Scene(image, [handle], ConstraintArray="Constraint", TissueThreshold=0.5, AnchoredFaces=(0, 0, 0, 0, 1, 0))


def finger_scene(tissue, handle, lift):
    image = scenes.make_image(tissue.tissue.astype(np.float32), "Tissue")
    scenes.add_array(image, tissue.constraint(), "Constraint")
    image.GetPointData().SetActiveScalars("Tissue")
    place, radius = tissue.handles[handle]
    return Scene(image, [(place, (0, 0, lift), radius)], ConstraintArray="Constraint", TissueThreshold=0.5,
                 AnchoredFaces=(1, 0, 0, 0, 0, 0))


def forearm_scene(size):
    """The main job's: two handles on the skin, CT material 1.7 times as soft, no incision."""
    image = make_forearm(size)
    function = vtkPiecewiseFunction()
    Deformation.GetPresetMaterial(Deformation.MATERIAL_CT, image.GetPointData().GetScalars().GetRange(), mutable(0.0), function)
    node, material = [0.0] * 4, []
    for n in range(function.GetSize()):
        function.GetNodeValue(n, node)
        material.append((node[0], 1.7 * node[1]))
    plan = plan_scene(Volume(image, "CT"), scenes.AIR, scenes.BONE)
    return Scene(image, [(p[0:3], p[3:6], p[6]) for p in plan.probes], material, TissueThreshold=scenes.AIR)


def heart_scene(folder, step):
    """Figure 9 of the gallery, every so many voxels."""
    scene = scenes.probed_heart(folder)
    sample = vtkExtractVOI()
    sample.SetInputData(scene.image)
    sample.SetVOI(*scene.image.GetExtent())
    sample.SetSampleRate(step, step, step)
    sample.Update()
    probes = [(p["Position"], np.subtract(p["Target"], p["Position"]), p["Radius"]) for p in scene.probes]
    return Scene(sample.GetOutput(), probes, scene.material, TissueThreshold=scenes.AIR)


# ----------------------------------------------------------------------------------------------------------------------
# The filter


def available(settings):
    """Whether the filter has what is asked for. A property that it does not have is at its plain value."""
    plain = {"ModelReduction": 1, "CoarseToFine": 0, "RelaxationPreset": 0, "Rotations": 0}
    return all(hasattr(Deformation, "Set" + name) or plain.get(name) == value for name, value in settings.items())


class Pull:
    """The filter on a scene."""

    def __init__(self, scene, device):
        self.scene = scene
        self.filter = Deformation()
        self.filter.SetInputData(scene.image)
        self.filter.SetDevice(device)
        if scene.material:
            function = vtkPiecewiseFunction()
            for scalar, constraint in scene.material:
                function.AddPoint(scalar, constraint)
            self.filter.SetMaterialFunction(function)
        for name, value in scene.properties.items():
            getattr(self.filter, "Set" + name)(value)
        errors = self.errors = []

        @calldata_type(VTK_STRING)
        def note(caller, event, text):
            errors.append(text)  # through self the filter would live on, and its memory count as others'
        self.filter.AddObserver("ErrorEvent", note)

    def set(self, settings):
        for name, value in settings.items():
            if hasattr(self.filter, "Set" + name):
                getattr(self.filter, "Set" + name)(value)

    def update(self, share=1.0):
        """The handles at so much of their way; the milliseconds until the outputs are there, by the clock and of all cores."""
        places, displacements, radii = zip(*self.scene.probes)
        data, points = vtkPolyData(), vtkPoints()
        points.SetDataTypeToDouble()
        for place in places:
            points.InsertNextPoint(*place)
        data.SetPoints(points)
        for name, values in (("Displacement", share * np.array(displacements, float)), ("Radius", np.array(radii, float))):
            array = numpy_to_vtk(values, deep=True)
            array.SetName(name)
            data.GetPointData().AddArray(array)
        self.filter.SetInputDataObject(1, data)
        clock, processor = time.perf_counter(), time.process_time()
        self.filter.Update()
        elapsed = 1000 * (time.perf_counter() - clock), 1000 * (time.process_time() - processor)
        if self.errors:
            raise RuntimeError("the filter reports: " + "\n".join(self.errors))
        return elapsed

    def field(self, name):
        return vtk_to_numpy(self.filter.GetOutput().GetFieldData().GetArray(name)).ravel()

    def displacement(self):
        """Of every voxel of the image [mm], [z, y, x, axis]."""
        model = self.filter.GetModelOutput()
        values = vtk_to_numpy(model.GetPointData().GetArray("Displacement"))
        return values.reshape(*model.GetDimensions()[::-1], 3)

    def reduced(self):
        """Whether an element stands for several voxels: a model with other links, and so with another energy."""
        return hasattr(self.filter, "GetModelReduction") and self.filter.GetModelReduction() > 1

    def connected(self):
        """The largest piece of tissue that links hold together, [z, y, x]."""
        model = self.filter.GetModelOutput()
        element = vtk_to_numpy(model.GetPointData().GetArray("Element")).reshape(model.GetDimensions()[::-1])
        piece, _ = ndimage.label(element)
        return piece == np.bincount(piece[element > 0]).argmax()

    def picture(self):
        scalars = self.scene.image.GetPointData().GetScalars().GetName()
        return vtk_to_numpy(self.filter.GetOutput().GetPointData().GetArray(scalars)).astype(np.float32)


# ----------------------------------------------------------------------------------------------------------------------
# Error against the optimum


class Reference:
    """Where the tissue comes to rest: of two ways there, the one that ends with less energy. `checks` tells how far the other
    way ended from there, and how far off half the iterations are."""

    def __init__(self, pull):
        ways = {}
        for name, settings in (("coarse to fine", REFERENCE), ("fine alone", {**REFERENCE, "CoarseToFine": 0})):
            if available(settings):
                pull.set({**BASE, **settings})
                pull.update()
                ways[name] = float(pull.field("Energy")[0])
        self.way = min(ways, key=ways.get)
        chosen = {**REFERENCE, "CoarseToFine": int(self.way == "coarse to fine")}
        pull.set({**BASE, **chosen})
        pull.update()
        displacement = pull.displacement()
        self.pull = float(np.linalg.norm(pull.field("ProbeReached").reshape(-1, 3), axis=1).max())
        self.touched = pull.connected() & ((displacement**2).sum(-1) > (1e-3 * self.pull) ** 2)
        self.displacement = displacement[self.touched].copy()
        self.energy = float(pull.field("Energy")[0])
        self.iterations = int(pull.field("RelaxationIterationsUsed")[0])
        self.excess = float(pull.field("MaxLinkExcess")[0])
        self.picture = pull.picture()
        self.changed = self.picture != vtk_to_numpy(pull.scene.image.GetPointData().GetScalars())
        self.checks = {}
        others = {"half the iterations": {**chosen, "RelaxationIterations": self.iterations // 2}}
        others.update({name: {**REFERENCE, "CoarseToFine": 1 - chosen["CoarseToFine"]} for name in ways if name != self.way})
        for name, settings in others.items():
            pull.set({**BASE, **settings})
            pull.update()
            self.checks[name] = self.errors(pull)

    def errors(self, pull):
        """Of the filter's present state."""
        away = np.sqrt(((pull.displacement()[self.touched] - self.displacement) ** 2).sum(-1, dtype=float))
        rms = float(np.sqrt((away**2).mean()))
        figures = {"rms": rms, "share": rms / self.pull, "p99": float(np.percentile(away, 99)), "worst": float(away.max()),
                   "excess": float(pull.field("MaxLinkExcess")[0]),
                   "iterations": int(pull.field("RelaxationIterationsUsed")[0])}
        if not pull.reduced():
            figures["energy"] = float(pull.field("Energy")[0]) / self.energy - 1
        if self.changed.any():
            difference = (pull.picture() - self.picture)[self.changed]
            figures["picture"] = float(np.sqrt((difference.astype(float) ** 2).mean()))
        return figures


def time_updates(pull, settings, repeats):
    """Milliseconds of updates from rest, in all and of each part. No two that follow each other are of the same pull, as the
    filter computes nothing twice; the last one is of the pull itself."""
    pull.set(settings)
    pull.update(0.0)  # builds the model where it has to be another one
    rounds = [(*pull.update(1 - 1e-3 * n), pull.field("Milliseconds").tolist()) for n in reversed(range(repeats))]
    best = min(rounds)
    return {"milliseconds": [clock for clock, _, _ in rounds], "processor": [processor for _, processor, _ in rounds],
            "parts": dict(zip(TIMES, best[2]))}


def drag(pull, reference, settings, frames=12, settling=12):
    """Interactive mode: the handles go their way in so many updates, then hold still. Milliseconds of a frame, and errors on
    arrival and after the frames that follow."""
    pull.set({**settings, "Mode": Deformation.MODE_INTERACTIVE})
    pull.filter.Reset()
    pull.update(0.0)
    times = [pull.update(frame / frames)[0] for frame in range(1, frames + 1)]
    arrival = reference.errors(pull)
    after = 0
    while pull.filter.GetNeedsUpdate() and after < settling:
        times.append(pull.update(1.0)[0])
        after += 1
    settled = reference.errors(pull)
    pull.set({"Mode": Deformation.MODE_FROM_REST})
    return {"milliseconds": times, "arrival": arrival, "settled": settled, "settling": after}


def load():
    return os.getloadavg()[0]


def measure_scene(name, scene, options):
    pull = Pull(scene, options.device)
    reference = Reference(pull)
    size = scene.image.GetDimensions()
    elements = int(vtk_to_numpy(pull.filter.GetModelOutput().GetPointData().GetArray("Element")).sum())
    result = {"scene": name, "size": size, "spacing": scene.image.GetSpacing(), "elements": elements,
              "touched": int(reference.touched.sum()), "pull": reference.pull, "asked": scene.pull(),
              "device": str(pull.filter.GetOutput().GetFieldData().GetAbstractArray("DeviceName").GetValue(0)),
              "reference": {"way": reference.way, "energy": reference.energy, "excess": reference.excess,
                            "iterations": reference.iterations, "checks": reference.checks},
              "settings": [], "presets": {}}
    print("%s: %s voxels, %d elements, %d touched, pull %.2f of %.2f mm; reference: %s, %d iterations; %s" % (
        name, " x ".join(map(str, size)), elements, result["touched"], result["pull"], result["asked"], reference.way,
        reference.iterations, "; ".join("%s: %.2g mm off, energy %+.1e" % (other, check["rms"], check["energy"])
                                        for other, check in reference.checks.items())), flush=True)

    def row(label, settings):
        figures = {"label": label, "values": settings, **time_updates(pull, settings, options.repeats), "load": load(),
                   **reference.errors(pull)}
        print("  %-16s reduction %d, %4d iterations: %7.0f ms (relax %6.0f; of all cores %6.0f), %.3g mm, %.2f %% of the pull, "
              "energy %s, excess %.1e, load %.1f" % (
                  label, settings.get("ModelReduction", 1), figures["iterations"], min(figures["milliseconds"]),
                  figures["parts"]["relax"], min(figures["processor"]), figures["rms"], 100 * figures["share"],
                  "%+.2g" % figures["energy"] if "energy" in figures else "-", figures["excess"], figures["load"]), flush=True)
        return figures

    for label, settings in variations(options.small):
        if available(settings):
            result["settings"].append(row(label, settings))
    for label, preset in PRESETS.items():
        settings = {**BASE, **preset}
        if available(settings):
            figures = result["presets"][label] = row(label, settings)
            if label == "Accurate":
                continue  # nobody drags with it
            figures["drag"] = drag(pull, reference, settings)
            print("    dragged: %.0f ms a frame, %.2f %% of the pull on arrival, %.2f %% after %d more" % (
                statistics.median(figures["drag"]["milliseconds"]), 100 * figures["drag"]["arrival"]["share"],
                100 * figures["drag"]["settled"]["share"], figures["drag"]["settling"]), flush=True)
    return result


# ----------------------------------------------------------------------------------------------------------------------
# How good the reference is


def check_optimum(options):
    """The reference of a small block against an optimum with a proof (Testing/Oracles)."""
    program = os.environ.get("CHAINMAIL_OPTIMUM", "")
    if not os.path.isfile(program):
        return None
    tissue = block.Block(9 if options.small else 16)
    results = []
    for displacement in ((0, 0, 1.0), (0.5, 0, 3.0)):  # the second brings links to their limits
        pull = Pull(block_scene(tissue, displacement), options.device)
        pull.set({**BASE, **REFERENCE})
        pull.update()
        u = pull.displacement()
        reached = pull.field("ProbeReached")
        given = np.where(tissue.grabbed[..., None], reached, 0.0)
        task, answer = (os.path.join(options.results, name) for name in ("optimum.task", "optimum.answer"))
        with open(task, "wb") as file:
            np.array(tissue.shape[::-1], np.int32).tofile(file)
            tissue.constraint(math.inf).astype(np.float64).tofile(file)
            (tissue.held | tissue.grabbed).astype(np.uint8).tofile(file)
            given.astype(np.float64).tofile(file)
        subprocess.run([program, task, answer], check=True)
        values = np.fromfile(answer)
        energy, bound, exact = values[0], values[1], values[2:].reshape(u.shape)
        os.remove(task)
        os.remove(answer)
        away = np.sqrt(((u - exact) ** 2).sum(-1))
        results.append({"size": tissue.size, "displacement": reached.tolist(), "gap": (energy - bound) / energy,
                        "energy": float(pull.field("Energy")[0]) / energy - 1, "rms": float(np.sqrt((away**2).mean())),
                        "worst": float(away.max())})
        print("optimum of a block of %d^3, proven to %.1e: the reference is %.1e mm off (%.1e at most), energy %+.1e" % (
            tissue.size, results[-1]["gap"], results[-1]["rms"], results[-1]["worst"], results[-1]["energy"]), flush=True)
    return results


# ----------------------------------------------------------------------------------------------------------------------
# Error against finite elements


def compare_with_elements(options):
    """Shapes of fields, as shares of the pull. Hooke's law knows no size of a pull; the others do."""
    if not calculix.available():
        print("CalculiX is not there (on Debian the package calculix-ccx): no finite elements", flush=True)
        return None
    tissue = block.Block(9 if options.small else 25)
    pulls = (1.0, 1.5, 2.0) if options.small else (1.0, 3.0, 6.0)  # the last one nearly all that the limits allow
    directions = {"up": np.array((0, 0, 1.0)), "aside": np.array((1.0, 0, 0))}
    kept = os.path.join(options.results, "calculix")
    result = {"size": tissue.size, "soft": block.SOFT, "contrast": block.CONTRAST, "cases": []}
    for name, direction in directions.items():
        solutions = {}
        for (law, pull), poisson in itertools.product((("Hooke", pulls[0]), ("neo-Hooke", pulls[-1])), (0.0, 0.3)):
            solutions[law, poisson, pull] = tissue.finite_elements(kept, pull * direction, poisson, law == "neo-Hooke")
        for (law, poisson, pull), u in solutions.items():
            result["cases"].append({"direction": name, "law": law, "poisson": poisson, "pull": pull,
                                    **block.describe(tissue, pull * direction, u)})
        chains = [("reference", math.inf, pull, REFERENCE) for pull in pulls]
        chains.append(("reference", block.CONTRAST, pulls[1], REFERENCE))
        chains += [(preset, math.inf, pulls[1], settings) for preset, settings in PRESETS.items()]
        for rotations, (label, contrast, pull, settings) in itertools.product((0, 1), chains):
            values = {**BASE, **settings, "Rotations": rotations}
            if not available(values):
                continue
            runner = Pull(block_scene(tissue, pull * direction, contrast), options.device)
            cost = time_updates(runner, values, 1 if label == "reference" else options.repeats)
            u = runner.displacement()
            entry = {"direction": name, "law": "ChainMail", "settings": label, "rotations": rotations, "pull": pull,
                     "contrast": contrast if math.isfinite(contrast) else None, "milliseconds": cost["milliseconds"],
                     "memory": float(runner.field("PeakDeviceMemory")[0]), **block.describe(tissue, pull * direction, u),
                     "against": []}
            for (law, poisson, other), exact in solutions.items():
                # Hooke's field belongs to every pull, once it is scaled.
                scaled = exact * (pull / other) if law == "Hooke" else exact if pull == other else None
                if scaled is not None:
                    entry["against"].append({"law": law, "poisson": poisson,
                                             **block.compare(tissue, pull * direction, u, scaled)})
            result["cases"].append(entry)
            print("%s by %g mm, ChainMail (%s, Rotations %s, bar %s): %.0f ms; %s" % (
                name, pull, label, "on" if rotations else "off",
                "rigid" if not math.isfinite(contrast) else "%g times stiffer" % contrast, min(cost["milliseconds"]),
                "; ".join("%s %.1f: correlation %.3f, rms %.1f %%" % (a["law"], a["poisson"], a["correlation"], 100 * a["rms"])
                          for a in entry["against"])), flush=True)
    result["finger"] = list(bend_finger(options))
    return result


def bend_finger(options):
    tissue = finger.Finger()
    kept = os.path.join(options.results, "calculix")
    for handle, lift in (("skin", 1.0), ("bone", 4.0)) if options.small else (("skin", 1.0), ("bone", 4.0), ("bone", 8.0)):
        exact = tissue.finite_elements(kept, handle, lift)
        for rotations, (label, settings) in itertools.product((0, 1), {"reference": REFERENCE, **PRESETS}.items()):
            values = {**BASE, **settings, "Rotations": rotations}
            if not available(values):
                continue
            runner = Pull(finger_scene(tissue, handle, lift), options.device)
            cost = time_updates(runner, values, 1 if label == "reference" else options.repeats)
            u = runner.displacement()
            entry = {"handle": handle, "lift": lift, "settings": label, "rotations": rotations,
                     "milliseconds": cost["milliseconds"], "reached": float(runner.field("ProbeReached")[2]),
                     "angle": tissue.angle(u), "solid": tissue.angle(exact), "rms": tissue.distance(lift, u, exact)}
            print("finger lifted by its %s by %g mm (%s, Rotations %s): reached %.2f mm, tip turned by %.2f of %.2f degrees, "
                  "rms %.1f %%" % (handle, lift, label, "on" if rotations else "off", entry["reached"], entry["angle"],
                                   entry["solid"], 100 * entry["rms"]), flush=True)
            yield entry


def main(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("results", help="folder")
    parser.add_argument("--small", action="store_true", help="small scenes: shows that it runs, not how fast")
    parser.add_argument("--half", action="store_true", help="scenes of half the voxels along each axis, where time is short")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--scenes", default="elements,block,forearm,heart")
    parser.add_argument("--device", default=os.environ.get("CHAINMAIL_TEST_DEVICE", ""))
    options = parser.parse_args(arguments)
    options.repeats = max(1, options.repeats)
    if options.small:
        REFERENCE["RelaxationIterations"] = 400
    os.makedirs(options.results, exist_ok=True)
    result = {"date": time.strftime("%Y-%m-%d"), "small": options.small, "half": options.half, "cores": os.cpu_count(), "loads": [load()],
              "absent": [name for name in ("CoarseToFine", "ModelReduction") if not hasattr(Deformation, "Set" + name)],
              "optimum": check_optimum(options), "elements": None, "scenes": []}
    heart = os.path.join(os.environ.get("CHAINMAIL_VOLUMES", ""), "heart_cta.mhd")
    for name in options.scenes.split(","):
        if name == "elements":
            result["elements"] = compare_with_elements(options)
            continue
        if name == "heart" and (options.small or not os.path.isfile(heart)):
            print("heart: left out, the scan heart_cta is %s" % ("not small" if options.small else "not there"), flush=True)
            continue
        step = 2 if options.half else 1
        if name == "block":
            scene = block_scene(block.Block(17 if options.small else 64 // step + 1), (0, 0, 3.0 if options.small else 13.0 / step))
        elif name == "forearm":
            scene = forearm_scene((64, 64, 64) if options.small else [n // step for n in DEFAULT_SIZE])
        else:
            scene = heart_scene(os.path.dirname(heart), step)
        result["scenes"].append(measure_scene(name, scene, options))
    result["loads"].append(load())
    with open(os.path.join(options.results, "trade.json"), "w") as file:
        json.dump(result, file, indent=1)
        file.write("\n")


if __name__ == "__main__":
    main(sys.argv[1:])
