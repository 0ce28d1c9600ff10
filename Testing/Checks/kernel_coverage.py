"""How much of the kernels the unit tests reach, from gcov's data of a run with kernels as C++ (Testing/HostOpenCL).

    kernel_coverage.py DATA KERNELS

DATA is the folder with the data (*.gcda), KERNELS that of the sources. Names every line that is not reached, and every one
whose branches are not all taken; fails where a file is not built by any test, and where a file's or the whole's shares are
below the thresholds.

A kernel is compiled once for every size of brick, number of axes, ...: what one of these variants reaches is reached.
What is counted are kernels as a GPU gets them, with work-groups of a single item: kernels as C++ have no vectors, so lines for
WIDTH > 1 are not compiled, and what items of a group tell each other is not reached. That explains nearly all that is named;
Unit.Widths and the checks with oclgrind are for the rest.
"""

import collections
import concurrent.futures
import glob
import json
import os
import re
import subprocess
import sys

# Shares of lines and of branches. A file is mostly a kernel or two: an item's talk with its group weighs more there.
WHOLE = {"lines": 0.985, "branches": 0.955}
FILE = {"lines": 0.75, "branches": 0.70}


def read_gcov(path):
    """The files of one program: name -> lines."""
    gcov = os.environ.get("GCOV", "gcov")
    found = subprocess.run([gcov, "--json-format", "--stdout", "--branch-probabilities", path], stdout=subprocess.PIPE,
                           stderr=subprocess.DEVNULL, cwd=os.path.dirname(path), check=True)
    return {os.path.basename(file["file"]): file["lines"] for file in json.loads(found.stdout)["files"]}


def gather(data, kernels):
    """(file, line) -> times reached, and (file, line) -> {branch: times taken}, over all variants."""
    lines = collections.Counter()
    branches = collections.defaultdict(collections.Counter)
    paths = glob.glob(os.path.join(data, "*.gcda"))
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for files in pool.map(read_gcov, paths):
            for name, found in files.items():
                if name not in kernels:
                    continue
                for line in found:
                    place = name, line["line_number"]
                    lines[place] += line["count"]
                    count = len(line["branches"])
                    for n, branch in enumerate(line["branches"]):
                        branches[place][line.get("function_name"), count, n] += branch["count"]
    return lines, branches, len(paths)


def only_names(source):
    """Whether a file has nothing but comments and definitions of the preprocessor, which leave nothing to reach."""
    return all(re.match(r"\s*(//|#|$)", line) for line in source)


def report(name, found):
    """Prints one row; `found`: {kind: (reached, all)}."""
    print("%-24s" % name + "  ".join("%4d of %4d %s" % (*found[kind], kind) for kind in ("lines", "branches")))


def shortfalls(name, found, thresholds):
    return ["%s: %d of %d %s are reached, less than %.1f %%" % (name, *found[kind], kind, 100 * share)
            for kind, share in thresholds.items() if found[kind][0] < share * found[kind][1]]


def main():
    data, folder = sys.argv[1:]
    kernels = {os.path.basename(file): open(file, encoding="utf-8").read().splitlines()
               for end in ("cl", "clh") for file in glob.glob(os.path.join(folder, "**", "*." + end), recursive=True)}
    lines, branches, programs = gather(data, kernels)
    if not lines:
        sys.exit("There are no data in " + data)
    for name, number in sorted(lines):
        taken = branches[name, number].values()
        missed = sum(times == 0 for times in taken)
        if lines[name, number] == 0 or missed:
            what = "never reached" if lines[name, number] == 0 else "%d of %d branches not taken" % (missed, len(taken))
            print("%s:%d: %s: %s" % (name, number, what, kernels[name][number - 1].strip()))

    problems = []
    whole = collections.defaultdict(lambda: (0, 0))
    print("\n%d programs" % programs)
    for name in sorted(kernels):
        places = [place for place in lines if place[0] == name]
        if not places:
            if not only_names(kernels[name]):
                problems.append(name + ": no test builds it")
            continue
        taken = [times for place in places for times in branches[place].values()]
        found = {"lines": (sum(lines[place] > 0 for place in places), len(places)),
                 "branches": (sum(times > 0 for times in taken), len(taken))}
        for kind, (reached, total) in found.items():
            whole[kind] = (whole[kind][0] + reached, whole[kind][1] + total)
        report(name, found)
        problems += shortfalls(name, found, FILE)
    report("all", whole)
    problems += shortfalls("all", whole, WHOLE)
    print("\n".join(problems))
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
