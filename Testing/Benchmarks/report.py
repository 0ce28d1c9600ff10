"""Turns what the benchmarks measured into a table, a page and plots:

    python3 Testing/Benchmarks/report.py RESULTS PAGES PICTURES

RESULTS: the folder that measure.sh left, or the one file of run-on-gpu.sh. PAGES: folder for Results.json (all numbers) and
Results.md, where what stands between the markers is replaced. PICTURES: folder for speed-figure12.png and speed-table1.png.
"""

import glob
import json
import os
import re
import statistics
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402


class Run:
    """All results, by benchmark."""

    def __init__(self, documents, before=()):
        self.before = before
        self.documents = {document["benchmark"]: document for document in documents}
        first = documents[0]
        self.gpu = first["gpu"]
        self.small = first["small"]
        self.machine = f"{first['device']} ({first['platform']}), host {first['processor']}"
        self.dates = sorted({document["date"][:10] for document in documents})

    def find(self, benchmark, scene="", method=""):
        """Results whose scene and method match these expressions."""
        results = self.documents.get(benchmark, {}).get("results", [])
        return [r for r in results if re.search(scene, r["scene"]) and re.search(method, r["method"])]

    def one(self, benchmark, scene="", method=""):
        found = self.find(benchmark, scene, method)
        if not found:
            raise Missing(f"{benchmark}: {scene} {method}")
        return found[0]

    def earlier(self, benchmark, result):
        """The same by an earlier version, measured in turns with this one."""
        for document in self.before:
            for r in document["results"]:
                if document["benchmark"] == benchmark and (r["scene"], r["method"]) == (result["scene"], result["method"]):
                    return r
        raise Missing(f"{benchmark} of an earlier version: {result['scene']}")

    def loads(self):
        loads = [r["load"] for document in self.documents.values() for r in document["results"]]
        return min(loads), max(loads)


class Missing(Exception):
    """What a row needs was not measured."""


def number(value):
    """Three digits are more than a shared machine deserves."""
    if value == 0:
        return "0"
    return f"{value:.0f}" if abs(value) >= 100 else f"{value:.3g}"


def milliseconds(result):
    values = result["milliseconds"]
    return f"{number(statistics.median(values))} ms ({number(min(values))} to {number(max(values))})"


def median(result):
    return statistics.median(result["milliseconds"])


# ----------------------------------------------------------------------------------------------------------------------
# The targets. Each row: what is asked for, what was measured, and whether every part of it holds.


def paper_block(run):
    scene = "homogeneous$"
    engine = run.one("B1", scene, "^engine")
    sp_results = run.find("B1", scene, "SP-ChainMail")
    sp = min(sp_results, key=median)
    paper = run.one("B1", scene, "the paper's method, no blocks")
    faster_than_sp = median(sp) / median(engine)
    faster_than_paper = median(paper) / median(engine)
    held = faster_than_sp >= 10 and faster_than_paper >= 20 and (run.gpu or median(engine) <= 458)
    return (
        f"{milliseconds(engine)}; SP-ChainMail at its best ({sp['method'].split(', ')[1]}) {milliseconds(sp)}: "
        f"{number(faster_than_sp)} times; the paper's method without blocks {milliseconds(paper)}: "
        f"{number(faster_than_paper)} times; the paper's GPU took 458 ms",
        held,
    )


def scan(run):
    parts = []
    held = True
    results = run.find("B2")
    if len(results) < 2:
        raise Missing("B2")
    for result in results:
        share = re.search(r"(\d+) %", result["scene"])[1]  # the nearest to 5 and 30 that the scan gives
        figures = result["figures"]
        held = held and figures["times the dense rate"] <= 1.5
        parts.append(
            f"{share} %: {number(figures['times the dense rate'])} times the dense rate; update {milliseconds(result)}, of it "
            f"deformation {number(figures['propagate [ms]'] + figures['relax [ms]'])}, resampling "
            f"{number(figures['resample [ms]'])}, copies {number(figures['upload [ms]'] + figures['download [ms]'])} ms"
        )
    return "; ".join(parts), held


def memory(run):
    updates = run.find("B3", method="filter")
    figures = run.one("B3", method="engine")["figures"]
    reached = figures["device bytes per element reached"]
    rest = figures["bytes per voxel not reached"]
    return (
        f"{number(reached)} bytes on the device per element reached "
        f"({number(figures['bytes of the process per element reached'])} in the process, host and device; "
        f"{number(figures['device bytes per place held'])} per place held), "
        f"{number(rest)} per voxel not reached; peak of an update of the filter, outputs, device and host: "
        + ", ".join(
            f"{r['scene']} {number(r['figures']['peak of an update, device and host [MB]'])} MB "
            f"({number(r['figures']['peak [MB per million voxels]'])} MB per million voxels), the device's own "
            f"{number(r['figures']['peak of an update, device [MB]'])} MB"
            for r in updates
        )
        + "; the paper's engine alone takes 55 MB per million elements",
        reached <= 60 and rest <= 2 and all(r["figures"]["peak [MB per million voxels]"] <= 40 for r in updates),
    )


def model_size(run):
    results = run.find("B4")
    if len(results) < 2:
        raise Missing("B4")
    grows = results[-1]["figures"]["times the smallest model"]
    return (
        f"{number(median(results[0]))} ms in {results[0]['scene']}, {number(median(results[-1]))} ms in "
        f"{results[-1]['scene']}: {number(grows)} times",
        grows < 1.2,
    )


def sweep(run):
    figure, least = ("share of copy / 25 B", 0.6) if run.gpu else ("times plain C++", 0.9)
    results = [r for r in run.find("B5", method="one sweep") if figure in r["figures"]]
    if not results:
        raise Missing("B5")
    parts = []
    for result in results:
        figures = result["figures"]
        share = f"{100 * figures[figure]:.0f} %" if run.gpu else f"{number(figures[figure])} times plain C++"
        parts.append(f"{result['scene']}: {share} ({number(figures['updates [M/s]'])} M updates/s)")
    # Bone is something that the plain sweep has not.
    held = all(r["figures"][figure] >= least for r in results if run.gpu or "bone" not in r["scene"])
    return "; ".join(parts), held


def drag(run):
    result = run.one("B6", method="filter")
    ratio = result["figures"]["times the engine"]
    engine = run.one("B6", method="engine")
    return f"{milliseconds(result)}, engine alone {milliseconds(engine)}: {number(ratio)} times", ratio <= 3


def start(run):
    first = run.one("B7", method="not compiled")
    later = run.one("B7", method="in the cache")
    return (
        f"{milliseconds(later)}; the first start, which compiles, {number(median(first) / 1000)} s",
        median(later) < 300 and median(first) <= (8000 if run.gpu else 6000),
    )


def propagation(run):
    least = 10 if run.gpu else 1
    results = run.find("B8", method="engine")
    if not results:
        raise Missing("B8")
    parts = []
    for result in results:
        queue = run.one("B8", f"^{re.escape(result['scene'])}$", "serial")
        parts.append(
            f"{result['scene']}: {milliseconds(result)}, queue {milliseconds(queue)}: "
            f"{number(result['figures']['times the serial queue'])} times as fast"
        )
    return "; ".join(parts), all(r["figures"]["times the serial queue"] >= least for r in results)


def coarse_to_fine(run):
    results = run.find("B9", "two bones", "coarse to fine$")
    results = [r for r in results if r["method"] == "coarse to fine"]
    if not results:
        raise Missing("B9")
    held = True
    parts = []
    for result in results:
        work = result["figures"]["work in fine sweeps"]
        held = held and work <= 25
        text = f"{result['scene'].split(',')[0]}: {milliseconds(result)}, {number(work)} fine sweeps"
        same = f"^{re.escape(result['scene'])}$"
        for method, name in (
            ("finest grid alone", "the engine's single grid"),
            ("best fixed factor", "the best fixed factor (sweeps counted)"),
        ):
            for other in run.find("B9", same, method):
                times = other["figures"]["times coarse to fine"]
                text += f", {name} {number(times)} times as long"
                rest = other["figures"].get("rests at energy over optimum", 1.0)
                if rest > 1.01:
                    text += f" and stuck {100 * (rest - 1):.1f} % above the optimum"
                if result["scene"].startswith("128"):
                    held = held and times >= 8
        parts.append(text)
    for result in run.find("B9", "gentle", "published"):
        parts.append(
            f"a gentle pull in {result['scene'].split(',')[0]}: the published scheme takes "
            f"{number(result['figures']['times coarse to fine'])} times as long"
        )
    return "; ".join(parts), held


def resampling(run):
    results = run.find("B10")
    if not results:
        raise Missing("B10")
    figure = "times as fast as VTK in two"
    text = "; ".join(
        f"{r['scene']}: {number(r['figures']['ns per displaced voxel'])} ns a displaced voxel, VTK in one thread "
        f"{number(r['figures']['ns per voxel, VTK in one thread'])}: {number(r['figures'][figure])} times as fast"
        for r in results
    )
    return text, all(r["figures"][figure] >= 8 for r in results)


def whole_update(run):
    parts = []
    held = True
    for benchmark, wanted in (("B2", (3, 3.5)), ("B6", (3,))):
        for result, least in zip(run.find(benchmark, method="iterations|filter"), wanted):
            before = run.earlier(benchmark, result)
            times = median(before) / median(result)
            held = held and times >= least
            parts.append(f"{result['scene']}: {milliseconds(result)}, was {milliseconds(before)}: {number(times)} times as fast")
    if not parts:
        raise Missing("B11")
    return "; ".join(parts), held


def largest(run):
    results = run.find("B12")
    if len(results) < 2:
        raise Missing("B12")
    smaller, larger = (r["figures"] for r in results)
    copy = larger["copy of the output [ms]"]
    same = smaller["ns per element displaced"] * 1e-6 * larger["elements displaced"]
    return (
        f"{results[1]['scene']}, {100 * larger['share of the elements']:.2g} % displaced: at most "
        f"{number(larger['peak of the process [MB]'])} MB, inputs and outputs included; a later update "
        f"{milliseconds(results[1])}, which for each displaced element is {number(larger['ns per element displaced'])} ns "
        f"against {number(smaller['ns per element displaced'])} in {results[0]['scene']}; a copy of the output takes "
        f"{number(copy)} ms",
        larger["peak of the process [MB]"] < 6000 and median(results[1]) <= 1.1 * same + copy,
    )


def presets(run):
    results = run.find("B13", method="Accurate")
    if not results:
        raise Missing("B13")
    off = "distance from the optimum [% of the pull]"
    parts = []
    for result in results:
        balanced = run.one("B13", f"^{re.escape(result['scene'])}$", "^Balanced$")
        parts.append(
            f"{result['scene']}: {milliseconds(result)}, {number(result['figures'][off])} % off; Balanced "
            f"{milliseconds(balanced)}, {number(balanced['figures'][off])} % off: "
            f"{number(result['figures']['times Balanced'])} times as long"
        )
    return "; ".join(parts), all(r["figures"][off] <= 0.1 and r["figures"]["times Balanced"] <= 4 for r in results)


def turning(run):
    sweeps = run.find("B5", method="a sweep with rotations")
    updates = run.find("B13", method="Balanced with rotations")
    if not sweeps or not updates:
        raise Missing("B14")
    parts = [
        f"{r['scene']}: a sweep {milliseconds(r)}, {number(r['figures']['times one without'])} times one without" for r in sweeps
    ]
    parts += [f"{r['scene']}: {milliseconds(r)}, {number(r['figures']['times Balanced'])} times Balanced" for r in updates]
    held = all(r["figures"]["times one without"] <= 2 for r in sweeps)
    return "; ".join(parts), held and all(r["figures"]["times Balanced"] <= 2.2 for r in updates)


def random_pulls(run):
    balanced, accurate, coarse = (run.one("B15", "all scans", f"^{m}$") for m in ("Balanced", "Accurate", "coarse to fine"))
    figures = [{name.split(", ")[-1]: value for name, value in r["figures"].items()} for r in (balanced, accurate, coarse)]
    times = median(accurate) / median(balanced)
    text = [f"median {number(f['median'])}, nine of ten {number(f['nine of ten'])}, worst {number(f['worst'])}" for f in figures]
    return (
        f"{len(balanced['milliseconds'])} pulls: Balanced {text[0]} % off; Accurate {text[1]} % off, {number(times)} times as long; "
        f"sweeps' time before the first one: {text[2]}",
        figures[0]["nine of ten"] <= 1 and figures[1]["nine of ten"] <= 0.1 and times <= 4 and figures[2]["nine of ten"] <= 25,
    )


def many_probes(run):
    results = [(run.one("B16", "smooth field", "that fit$"), 1000), (run.one("B16", "smooth field", "with rotations"), 3000),
               (run.one("B16", "a lung", "Share"), 5000)]  # fmt: skip
    parts = [
        f"{r['scene']}, {r['figures']['probes']:.0f} {r['method']}: {milliseconds(r)}, of it the waves "
        f"{number(r['figures']['propagate [ms]'])} ms"
        for r, _ in results
    ]
    return "; ".join(parts), all(median(r) <= most for r, most in results)


def poses(run):
    results = run.find("B17", method="^pose")
    if not results:
        raise Missing("B17")
    parts = []
    held = True
    for result, wanted, most in zip(results, (10, 30), (5, 3)):
        times = result["figures"]["times a pull"]
        turned = result["figures"]["turned by [degrees]"]
        parts.append(f"{result['scene']}: {milliseconds(result)}, {number(times)} times a pull as far, turned by {number(turned)}")
        held = held and times <= most and turned > 0.99 * wanted
    return "; ".join(parts), held


def one_bone(run):
    results = run.find("B18", method="alone")
    if not results:
        raise Missing("B18")
    times = [r["figures"]["times coarse to fine"] for r in results]
    parts = [
        f"{r['scene']}: {milliseconds(run.one('B18', '^' + re.escape(r['scene']) + '$', 'coarse'))}, the finest grid alone "
        f"{number(t)} times as long"
        for r, t in zip(results, times)
    ]
    return "; ".join(parts), all(t >= 1 for t in times)


TARGETS = [
    ("B1", "126^3 elements, homogeneous, all affected, from rest to within 1 % of the optimum: 10 times as fast as SP-ChainMail "
     "at its best block size, 20 times as fast as the paper's method without blocks (both at the paper's iterations); on two "
     "cores no slower than the paper's GPU", paper_block),
    ("B2", "chest CT (12.1 M voxels), 5 and 30 % displaced, 10 + 10 iterations: an element-update at most 1.5 times that of a "
     "dense sweep", scan),
    ("B3", "at most 60 bytes of the device per element reached, 2 per voxel not reached; peak of an update of the filter, device "
     "and host, 40 MB per million voxels", memory),
    ("B4", "the same pull in 2 to 128 M voxels: a frame takes less than 1.2 times as long in the largest", model_size),
    ("B5", "dense sweeps: 0.9 times the rate of plain C++ on a processor, 60 % of copy / 25 B on a GPU", sweep),
    ("B6", "a drag on the head CT (8.9 M voxels): at most 3 times the engine's own time", drag),
    ("B7", "the second start of a process adds less than 300 ms; the first, which compiles, takes 6 s, on a GPU 8", start),
    ("B8", "propagation alone: as fast as the serial queue, 10 times as fast on a GPU", propagation),
    ("B9", "to within 1 % of the optimum in at most 25 fine sweeps' time; 8 times as fast as the best single grid at 128^3",
     coarse_to_fine),
    ("B10", "resampling of a displaced voxel 8 times as fast as VTK's inverse warp in two threads", resampling),
    ("B11", "a whole update of the filter, a drag, as in B2 and B6, against that of the first version: chest 5 % 3 times as fast, "
     "32 % 3.5 times, head 3 times", whole_update),
    ("B12", "1024^3 bytes in the filter, a pull of 1 %: under 6 GB, a later update no more than in 256^3 for each displaced "
     "element, and the copy of the output", largest),
    ("B13", "the preset Accurate: within 0.1 % of the pull of the optimum in at most 4 times the time of Balanced", presets),
    ("B14", "with rotations a dense sweep takes at most 2 times as long, a whole update with Balanced 2.2 times", turning),
    ("B15", "pulls at random, nine of ten: Balanced within 1 % of the pull of the optimum, Accurate within 0.1 % in at most 4 times "
     "the time, and coarse to fine takes at most the time of 25 fine sweeps before its first one", random_pulls),
    ("B16", "many probes, an update of the filter: 20,000 that fit 1 s, 5000 with rotations 3 s; all of a lung's surface, which "
     "does not fit, 5 s", many_probes),
    ("B17", "a vertebra that rotates by 10 degrees takes at most 5 times a pull of it as far, by 30 degrees 3 times", poses),
    ("B18", "around one bone, to within 1 % of the optimum: coarse to fine never slower than the fine grid alone", one_bone),
]  # fmt: skip


def targets_table(run):
    lines = ["| | target | measured: median (lowest to highest) | held |", "|---|---|---|---|"]
    for name, target, measure in TARGETS:
        try:
            measured, held = measure(run)
            verdict = "" if run.small else "yes" if held else "**no**"
            lines.append(f"| {name} | {target} | {measured} | {verdict} |")
        except Missing:
            lines.append(f"| {name} | {target} | not measured | |")
    return "\n".join(lines)


def machine_text(run):
    low, high = run.loads()
    bandwidth = [r for r in run.find("Machine")]
    text = f"{run.machine}; {' to '.join(dict.fromkeys((run.dates[0], run.dates[-1])))}; load {low:.1f} to {high:.1f}"
    if bandwidth:
        best = {
            name: max(r["figures"][name] for r in bandwidth)
            for name in ("OpenCL triad [GB/s]", "OpenCL copy [GB/s]", "C++ triad [GB/s]", "C++ copy [GB/s]")
        }
        text += "; " + ", ".join(f"{name.split(' [')[0]} {value:.0f} GB/s" for name, value in best.items())
    if high > 1.5 * int(re.match(r"\d+", run.documents[next(iter(run.documents))]["processor"]).group()):
        text += "; the machine was busy with other work, so that little but ratios of what took turns can be relied on"
    return text + "."


def all_results(run):
    lines = []
    for name, document in run.documents.items():
        lines += [f"### {name}: {document['title']}", "", "| scene | method | time | figures | triad, copy [GB/s] | load |",
                  "|---|---|---|---|---|---|"]  # fmt: skip
        for r in document["results"]:
            figures = ", ".join(f"{key} {number(value)}" for key, value in r["figures"].items())
            time = milliseconds(r) if r["milliseconds"] else ""
            lines.append(
                f"| {r['scene']} | {r['method']} | {time} | {figures} | {number(r['triad'])}, {number(r['copy'])} "
                f"| {r['load']:.1f} |"
            )
        lines.append("")
    return "\n".join(lines)


# ----------------------------------------------------------------------------------------------------------------------
# Plots


def block_volume(method):
    x, y, z = re.search(r"(?:blocks|bricks) (\d+) x (\d+) x (\d+)", method).groups()
    return int(x) * int(y) * int(z)


def figure12(run, path):
    figure, axes = plt.subplots(figsize=(7.2, 4.6))
    series = (("SP-ChainMail", "SP-ChainMail, one launch a block", "tab:red"),
              ("the paper's method", "the paper's method, one launch over a list", "tab:blue"),
              ("engine", "this engine, to within 1 % of the optimum", "tab:green"))  # fmt: skip
    drawn = False
    for method, label, colour in series:
        points = sorted((block_volume(r["method"]), median(r)) for r in run.find("B1", "figure 12", f"^{method}"))
        if points:
            drawn = True
            axes.plot(*zip(*points), marker="o", color=colour, label=label)
        for whole in run.find("B1", "homogeneous$", f"^{method}, no blocks"):
            axes.axhline(median(whole), color=colour, linestyle="--", linewidth=1, label=f"{method}, no blocks")
    if not drawn:
        plt.close(figure)
        return False
    axes.axhline(458, color="grey", linestyle=":", linewidth=1, label="the paper's best, on its GPU")
    axes.set_xscale("log", base=2)
    axes.set_yscale("log")
    axes.set_xlabel("elements of a block or brick")
    axes.set_ylabel("propagation and relaxation [ms]")
    axes.set_title(f"Figure 12: {run.one('B1', 'figure 12')['scene'].split(',')[0]} elements, all affected", fontsize=11)
    axes.legend(fontsize=8)
    axes.grid(alpha=0.3, which="both")
    figure.text(0.01, 0.005, run.machine, fontsize=6, color="grey")
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    plt.close(figure)
    return True


def table1(run, path):
    results = run.find("Table 1")
    if not results:
        return False
    figure, axes = plt.subplots(figsize=(7.2, 0.6 + 0.5 * len(results)))
    places = range(len(results), 0, -1)
    colours = ["tab:red" if "mass-spring" in r["method"] else "tab:green" for r in results]
    labels = [f"{r['method'].split(',')[0]}: {r['scene']}" for r in results]
    axes.barh(places, [median(r) for r in results], color=colours,
              xerr=[[median(r) - min(r["milliseconds"]) for r in results], [max(r["milliseconds"]) - median(r) for r in results]])  # fmt: skip
    for place, r in zip(places, results):
        moved = r["figures"].get("shifted", r["figures"].get("displaced"))
        axes.text(median(r), place + 0.12, f"  {number(median(r))} ms, {moved:,.0f} displaced", fontsize=7, va="bottom")
    axes.set_yticks(list(places), labels, fontsize=7)
    axes.set_xscale("log")
    axes.set_xlim(right=40 * max(median(r) for r in results))
    axes.set_xlabel("a frame of 20 steps or iterations [ms]")
    axes.set_title("Table 1: mass-spring and ChainMail", fontsize=11)
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    plt.close(figure)
    return True


# ----------------------------------------------------------------------------------------------------------------------


def replace_between(path, name, text):
    """Puts text between a page's markers; a page that is not there is begun."""
    begin, end = f"<!-- {name}: begin -->", f"<!-- {name}: end -->"
    page = f"{begin}\n{end}\n"
    if os.path.exists(path):
        with open(path, encoding="utf-8") as file:
            page = file.read()
    if begin not in page or end not in page:
        sys.exit(f"{path} lacks the markers {begin} and {end}")
    before, after = page.split(begin)[0], page.split(end)[1]
    with open(path, "w", encoding="utf-8") as file:
        file.write(f"{before}{begin}\n\n{text}\n\n{end}{after}")


def read(path):
    if os.path.isdir(path):
        documents = []
        for name in sorted(glob.glob(os.path.join(path, "*.json"))):
            with open(name, encoding="utf-8") as file:
                content = json.load(file)
            if isinstance(content, dict):
                documents.append(content)
    else:
        with open(path, encoding="utf-8") as file:
            documents = json.load(file)
    if not documents:
        sys.exit(f"{path} holds no results")
    # Runs of one benchmark at several sizes belong together.
    merged = {}
    for document in documents:
        if document["benchmark"] in merged:
            merged[document["benchmark"]]["results"] += document["results"]
        else:
            merged[document["benchmark"]] = document
    return sorted(merged.values(), key=lambda document: document["benchmark"])


def main():
    results, pages, pictures = sys.argv[1:4]
    documents = read(results)
    before = os.path.join(results, "before")
    run = Run(documents, read(before) if os.path.isdir(before) else ())
    with open(os.path.join(pages, "Results.json"), "w", encoding="utf-8") as file:
        json.dump(documents, file, indent=1)
        file.write("\n")
    table = targets_table(run)
    small = "At small sizes, which only show that everything runs. " if run.small else ""
    summary = f"{small}Measured on {machine_text(run)}\n\n{table}"
    images = []
    for draw, name, text in (
        (figure12, "speed-figure12.png", "Time against the size of blocks"),
        (table1, "speed-table1.png", "A frame of mass-spring and of ChainMail"),
    ):
        picture = os.path.join(pictures, name)
        if draw(run, picture):
            images.append(f"![{text}]({os.path.relpath(picture, pages)})")
    page = "\n\n".join([summary, *images, "## All results", all_results(run).strip()])
    replace_between(os.path.join(pages, "Results.md"), "results", page)
    print(table)


if __name__ == "__main__":
    main()
