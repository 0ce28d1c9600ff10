"""Turns what measure.py left into the tables of Data/Choosing.md and its plots:

    python3 Testing/Trade/report.py RESULTS PAGES PICTURES

RESULTS: the folder with trade.json. PAGES: folder with Choosing.md, in which what stands between markers is replaced; where
there is none, the tables alone are written. PICTURES: folder for trade.png and trade-elements.png."""

import json
import os
import re
import statistics
import sys

try:
    import matplotlib
except ImportError:
    print("SKIPPED: matplotlib is not there (on Debian the package python3-matplotlib)")
    sys.exit(125)
matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

WAYS = ("coarse to fine", "fine alone", "Paper")
COLOURS = {"coarse to fine": "#1b6ca8", "fine alone": "#d98a1f", "Paper": "#b03a3a", "Fast": "#6a3d9a",
           "Balanced": "#1a7f37", "Accurate": "#111111"}
MARKS = {1: "o", 2: "s", 4: "^", 8: "v"}
LOWEST = 1e-3  # per cent of the pull; smaller errors are drawn here


def number(value):
    """Two digits are more than a shared machine deserves."""
    return f"{value:.0f}" if value >= 10 else f"{value:.2g}"


def percent(value):
    """Of a share: 3, 0.3, 0.03, and nothing finer."""
    value *= 100
    if value < 0.005:
        return "< 0.01"
    return f"{value:.0f}" if value >= 9.5 else f"{value:.1f}" if value >= 0.95 else f"{value:.2g}"


def fastest(row):
    """Whatever else runs on a machine makes updates slower, never faster."""
    return min(row["milliseconds"])


def of(row, name):
    return row["values"].get(name)


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def title(scene):
    voxels = scene["size"][0] * scene["size"][1] * scene["size"][2]
    return (f"{scene['scene']}: {voxels / 1e6:.2g} M voxels, {scene['elements'] / 1e6:.2g} M elements, of which "
            f"{scene['touched'] / 1e6:.2g} M move by more than a thousandth of the pull of {scene['pull']:.1f} mm")


def presets(run):
    """What is offered, and what it costs and errs."""
    parts = []
    for scene in run["scenes"]:
        rows = []
        for name, row in scene["presets"].items():
            drag = row.get("drag")
            rows.append([f"`{name}`", number(fastest(row)), number(row["parts"]["relax"]), number(min(row["processor"])),
                         f"{percent(row['share'])} ({number(row['rms'])} mm)", percent(row["p99"] / scene["pull"]),
                         percent(row["energy"]) if "energy" in row else "-", number(statistics.median(drag["milliseconds"])) if drag else "-",
                         f"{percent(drag['arrival']['share'])}, {percent(drag['settled']['share'])}" if drag else "-"])
        parts.append(title(scene) + "\n\n" + table(
            ["preset", "update from rest [ms]", "relaxation of it [ms]", "time of all cores [ms]", "error, rms [% of the pull]",
             "error of the worst hundredth [%]", "energy above the least [%]", "frame of a drag [ms]",
             "error on arrival, and settled [%]"], rows))
    return "\n\n".join(parts)


def grid(run):
    """Milliseconds and error of iterations x way x reduction."""
    parts = []
    for scene in run["scenes"]:
        rows = [row for row in scene["settings"] if row["label"] in WAYS]
        columns = sorted({of(row, "RelaxationIterations") for row in rows})
        lines = []
        for reduction in sorted({of(row, "ModelReduction") for row in rows}):
            for way in WAYS:
                cells = []
                for count in columns:
                    label = "fine alone" if count == 0 else way
                    found = [row for row in rows if row["label"] == label and of(row, "RelaxationIterations") == count
                             and of(row, "ModelReduction") == reduction]
                    cells.append(f"{number(fastest(found[0]))}, {percent(found[0]['share'])}" if found else "")
                if any(cells[1:]):
                    lines.append([way, str(reduction)] + cells)
        parts.append(title(scene) + "\n\n" + table(["relaxation", "ModelReduction"] + [str(count) for count in columns], lines))
    return "\n\n".join(parts)


def switches(run):
    """What else can be chosen, against the same settings without."""
    lines = []
    for scene in run["scenes"]:
        def find(label, count, reduction=1):
            found = [row for row in scene["settings"] if row["label"] == label and of(row, "ModelReduction") == reduction
                     and of(row, "RelaxationIterations") == count]
            return found[0] if found else None
        usual = find("coarse to fine", 40) or find("fine alone", 40)
        for label, count, plain, name in (("Timestamp", 0, find("fine alone", 0), "`PropagationMethod` = Timestamp, not relaxed"),
                                          ("Nearest", 40, usual, "`Interpolation` = Nearest"),
                                          ("PropagationTimes", 40, usual, "`PropagationTimes` on")):
            row = find(label, count)
            if row and plain:
                picture = f"{number(row['picture'])} (else {number(plain['picture'])})" if "picture" in row else "-"
                lines.append([scene["scene"], name, f"{number(fastest(row))} (else {number(fastest(plain))})",
                              f"{percent(row['share'])} (else {percent(plain['share'])})", picture])
        for row in scene["settings"]:
            if row["label"] == "to a tolerance":
                lines.append([scene["scene"], f"`RelaxationTolerance` = {of(row, 'RelaxationTolerance'):g}: {row['iterations']} "
                              "iterations", number(fastest(row)), percent(row["share"]),
                              number(row["picture"]) if "picture" in row else "-"])
    return table(["scene", "setting", "update [ms]", "error [% of the pull]", "error of the picture [grey levels, rms]"], lines)


def references(run):
    """How far the reference itself may be off."""
    lines = []
    for check in run["optimum"] or []:
        lines.append([f"block of {check['size']}³, pull {' '.join('%g' % v for v in check['displacement'])}",
                      f"an optimiser with a proof (gap {check['gap']:.1e})", f"{check['rms']:.1e} mm", f"{check['energy']:+.1e}"])
    for scene in run["scenes"]:
        reference = scene["reference"]
        for name, check in reference["checks"].items():
            lines.append([f"{scene['scene']}: {reference['way']}, {reference['iterations']} iterations",
                          f"{name}, {check['iterations']} iterations", f"{check['rms']:.1e} mm ({percent(check['share'])} % of the "
                          "pull)", f"{check['energy']:+.1e}"])
    return table(["reference", "compared with", "distance, rms", "energy of the other"], lines)


def named(name, case):
    """A name with what is particular about a case of ChainMail."""
    turning = ", Rotations on" if case["rotations"] else ""
    return name + turning + (f", bar {case['contrast']:g} times stiffer" if case.get("contrast") else "")


def elements(run):
    """ChainMail against finite elements."""
    cases = (run["elements"] or {}).get("cases", [])
    if not cases:
        return "CalculiX was not there."
    ways = {"up": "pulled up", "aside": "dragged aside"}
    fields = []
    for case in cases:
        chain = case["law"] == "ChainMail"
        if chain and case["settings"] != "reference":
            continue
        name = named("ChainMail", case) if chain else f"{case['law']}, Poisson's ratio {case['poisson']:g}"
        fields.append([f"{ways[case['direction']]} {case['pull']:g} mm", name, f"{case['halfDepth']:.1f}", percent(case["aside"]),
                       percent(case["barMoved"]), percent(case["barSpread"]), f"{case['barAngle']:.1f}",
                       percent(case["barStrain"])])
    order = {"pulled up": 0, "dragged aside": 1}
    fields.sort(key=lambda row: (order[row[0].rsplit(" ", 2)[0]], float(row[0].rsplit(" ", 2)[1]), row[1].startswith("Chain")))
    solids = [("Hooke", 0.0), ("Hooke", 0.3), ("neo-Hooke", 0.0), ("neo-Hooke", 0.3)]
    distances = []
    for case in cases:
        if "against" in case:
            against = {(other["law"], other["poisson"]): other for other in case["against"]}
            timed = case["settings"] != "reference"
            distances.append([f"{ways[case['direction']]} {case['pull']:g} mm", named(case["settings"], case),
                              number(fastest(case)) if timed else "-", number(case["memory"]) if timed else "-"]
                             + ["{:.2f}, {}, {}".format(other["correlation"], percent(other["rms"]), percent(other["rmsAxis"]))
                                if (other := against.get(solid)) else "" for solid in solids])
    return (table(["pull", "model", "half of the pull is left at depth [mm]", "moves across the pull, rms [%]",
                   "bar moves by [%]", "spread within the bar [%]", "bar turns by [°]", "bar strained by [%]"], fields)
            + "\n\nThe field of ChainMail against those of finite elements: correlation along the pull, distance everywhere, and "
            "distance along the line below the handle (rms, % of the pull):\n\n"
            + table(["pull", "ChainMail", "update [ms]", "memory [MB]"] + [f"{law}, {poisson:g}" for law, poisson in solids],
                    distances))


def bends(run):
    """A finger of ChainMail against one of finite elements."""
    cases = (run["elements"] or {}).get("finger", [])
    if not cases:
        return "CalculiX was not there."
    return table(["finger, lifted by its", "ChainMail", "update [ms]", "reached [mm]", "tip turns by [°]", "finite elements: by [°]",
                  "distance, rms [% of the lift]"],
                 [[f"{case['handle']}, {case['lift']:g} mm", named(case["settings"], case),
                   "-" if case["settings"] == "reference" else number(fastest(case)), f"{case['reached']:.2f}",
                   f"{case['angle']:.2f}", f"{case['solid']:.2f}", percent(case["rms"])] for case in cases])


# ----------------------------------------------------------------------------------------------------------------------


def plot_trade(run, path):
    figure, axes = plt.subplots(1, len(run["scenes"]), figsize=(5.2 * len(run["scenes"]), 4.6), squeeze=False)
    for axis, scene in zip(axes[0], run["scenes"]):
        for way in WAYS:
            for reduction in MARKS:
                rows = [row for row in scene["settings"] if row["label"] == way and of(row, "ModelReduction") == reduction]
                if rows:
                    rows.sort(key=lambda row: of(row, "RelaxationIterations"))
                    axis.plot([fastest(row) for row in rows], [max(100 * row["share"], LOWEST) for row in rows],
                              MARKS[reduction] + "-", color=COLOURS[way], ms=4, lw=1, alpha=1.0 if reduction == 1 else 0.55,
                              label=f"{way}, {'every voxel' if reduction == 1 else f'reduction {reduction}'}")
        for name, row in scene["presets"].items():
            axis.plot(fastest(row), max(100 * row["share"], LOWEST), "*", color=COLOURS[name], ms=15, mec="white", zorder=5,
                      label=name)
        axis.set_xscale("log")
        axis.set_yscale("log")
        axis.set_title(f"{scene['scene']}, {scene['elements'] / 1e6:.2g} M elements")
        axis.set_xlabel("an update of the filter from rest [ms]")
        axis.grid(True, which="both", alpha=0.2)
    axes[0][0].set_ylabel("distance from the optimum, rms [% of the pull]")
    handles, labels = [], []
    for axis in axes[0]:
        for handle, label in zip(*axis.get_legend_handles_labels()):
            if label not in labels:
                handles.append(handle)
                labels.append(label)
    figure.legend(handles, labels, loc="lower center", ncol=5, fontsize=8, frameon=False)
    figure.tight_layout(rect=(0, 0.02 + 0.045 * ((len(labels) + 4) // 5), 1, 1))
    figure.savefig(path, dpi=110)


def plot_elements(run, path):
    cases = (run["elements"] or {}).get("cases", [])
    if not cases:
        return
    figure, axes = plt.subplots(1, 2, figsize=(10.4, 4.4), sharey=True)
    pulls = sorted({case["pull"] for case in cases if case["law"] == "ChainMail"})
    colours = dict(zip(pulls, ("#1b6ca8", "#8a5fb5", "#b03a3a")))
    for axis, direction, name in ((axes[0], "up", "pulled up"), (axes[1], "aside", "dragged aside")):
        for case in cases:
            if case["direction"] != direction:
                continue
            depth = list(reversed(range(len(case["profile"]))))
            if case["law"] != "ChainMail":
                axis.plot(depth, case["profile"], "-" if case["poisson"] else "--", lw=1.2,
                          color="#777777" if case["law"] == "Hooke" else "#1a7f37",
                          label=f"{case['law']}, Poisson's ratio {case['poisson']:g}"
                          + ("" if case["law"] == "Hooke" else f", {case['pull']:g} mm"))
            elif case["settings"] == "reference" and case["contrast"] is None:
                axis.plot(depth, case["profile"], "s-" if case["rotations"] else "o:", ms=3, lw=1, color=colours[case["pull"]],
                          label=f"{named('ChainMail', case)}, {case['pull']:g} mm")
        axis.set_title(f"{name}, along the line below the handle")
        axis.set_xlabel("depth [mm]")
        axis.grid(True, alpha=0.2)
    axes[0].set_ylabel("displacement, share of the pull")
    axes[0].legend(fontsize=8, frameon=False)
    figure.tight_layout()
    figure.savefig(path, dpi=110)


def replace(path, sections):
    """Puts texts between their markers in a page."""
    with open(path) as file:
        page = file.read()
    for name, text in sections.items():
        begin, end = f"<!-- {name}: begin -->", f"<!-- {name}: end -->"
        if begin not in page or end not in page:
            sys.exit(f"{path} has no place for {name}")
        page = re.sub(f"(?s){re.escape(begin)}.*{re.escape(end)}", lambda _: f"{begin}\n{text}\n{end}", page)
    with open(path, "w") as file:
        file.write(page)


def main(results, pages, pictures):
    with open(os.path.join(results, "trade.json")) as file:
        run = json.load(file)
    sections = {"presets": presets(run), "grid": grid(run), "switches": switches(run), "reference": references(run),
                "elements": elements(run), "finger": bends(run)}
    loads = [row["load"] for scene in run["scenes"] for row in scene["settings"]] or run["loads"]
    sections["machine"] = (f"Measured on {run['scenes'][0]['device']}, {run['date']}, while the machine had a load of "
                           f"{min(loads):.1f} to {max(loads):.1f}. Times are the best of "
                           f"{len(run['scenes'][0]['settings'][0]['milliseconds'])} updates.")
    if min(loads) > run["cores"]:
        sections["machine"] += (" It was busy with other work: errors do not depend on that, but of times little more than the order "
                                "of magnitude can be relied on.")
    if run["half"]:
        sections["machine"] += " Scenes have half their voxels along each axis."
    path = os.path.join(pages, "Choosing.md")
    if not os.path.isfile(path):
        with open(path, "w") as file:
            file.write("".join(f"<!-- {name}: begin -->\n<!-- {name}: end -->\n\n" for name in sections))
    replace(path, sections)
    plot_trade(run, os.path.join(pictures, "trade.png"))
    plot_elements(run, os.path.join(pictures, "trade-elements.png"))


if __name__ == "__main__":
    main(*sys.argv[1:4])
