"""What no test reaches of the kernels, from gcov's data of a run with kernels as C++ (Testing/HostOpenCL).

    kernel_coverage.py DATA KERNELS LIST [--write]

DATA is the folder with the data (*.gcda), KERNELS that of the sources, LIST the file that names every line and branch
that is not reached, and why. Fails where one is missing there, or named though it is reached. --write brings LIST up to
date; reasons that are still missing are left as a question mark, which fails, too.

A kernel is compiled once for every size of brick, number of axes, ...: what one of these variants reaches is reached.
Lines are known by their text, so that those above may change.
"""

import collections
import concurrent.futures
import glob
import json
import os
import re
import subprocess
import sys

Gap = collections.namedtuple("Gap", "missing total")  # branches; total 0: the line itself is never reached


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


def gaps_of(lines, branches, kernels):
    """file -> {text of a line: Gap}, in the order of the lines."""
    gaps = collections.defaultdict(dict)
    for name, number in sorted(lines):
        text = kernels[name][number - 1].strip()
        taken = branches[name, number]
        if lines[name, number] == 0:
            gap = Gap(0, 0)
        else:
            gap = Gap(sum(times == 0 for times in taken.values()), len(taken))
            if gap.missing == 0:
                continue
        before = gaps[name].get(text, Gap(0, 0))
        gaps[name][text] = Gap(before.missing + gap.missing, before.total + gap.total)
    return gaps


ENTRY = re.compile(r"^- `(?P<text>.*)` \((?:(?P<missing>\d+) of (?P<total>\d+) branches|never)\): (?P<reason>.*)$")


def read_list(path):
    """What stands before the entries, and file -> {text: (Gap, reason)}."""
    head, entries, name = [], {}, None
    for line in open(path, encoding="utf-8").read().splitlines():
        if line.startswith("## "):
            name = line[3:].strip()
            entries[name] = {}
        elif name is None:
            head.append(line)
        elif line.strip():
            found = ENTRY.match(line)
            if not found:
                sys.exit("%s: this is no entry: %s" % (path, line))
            entries[name][found["text"]] = (Gap(int(found["missing"] or 0), int(found["total"] or 0)), found["reason"])
    return head, entries


def write_list(path, head, gaps, entries):
    with open(path, "w", encoding="utf-8") as out:
        out.write("\n".join(head).rstrip() + "\n")
        for name in sorted(gaps):
            out.write("\n## %s\n\n" % name)
            for text, gap in gaps[name].items():
                reason = entries.get(name, {}).get(text, (None, "?"))[1]
                share = "%d of %d branches" % gap if gap.total else "never"
                out.write("- `%s` (%s): %s\n" % (text, share, reason))


def main():
    write = "--write" in sys.argv
    data, folder, path = [word for word in sys.argv[1:] if word != "--write"]
    kernels = {os.path.basename(file): open(file, encoding="utf-8").read().splitlines()
               for end in ("cl", "clh") for file in glob.glob(os.path.join(folder, "**", "*." + end), recursive=True)}
    lines, branches, programs = gather(data, kernels)
    if not lines:
        sys.exit("There are no data in " + data)
    gaps = gaps_of(lines, branches, kernels)
    reached = sum(count > 0 for count in lines.values())
    taken = sum(count > 0 for found in branches.values() for count in found.values())
    print("%d programs: %d of %d lines, %d of %d branches reached" %
          (programs, reached, len(lines), taken, sum(map(len, branches.values()))))
    unseen = sorted(name for name in kernels if not any(place[0] == name for place in lines))
    head, entries = read_list(path)
    if write:
        write_list(path, head, gaps, entries)
        head, entries = read_list(path)

    problems = ["%s: no test builds it" % name for name in unseen]
    for name, found in sorted(gaps.items()):
        for text, gap in found.items():
            known, reason = entries.get(name, {}).get(text, (None, "?"))
            if known is None or gap.missing > known.missing or (gap.total == 0 and known.total > 0):
                problems.append("%s: no test reaches %s `%s`" %
                                (name, "%d of %d branches of" % gap if gap.total else "the line", text))
            elif gap.missing < known.missing or (gap.total > 0 and known.total == 0):
                problems.append("%s: a test reaches more of `%s` than is listed" % (name, text))
            elif reason.strip() in ("", "?"):
                problems.append("%s: the reason is missing for `%s`" % (name, text))
    for name, found in sorted(entries.items()):
        for text in found:
            if text not in gaps.get(name, {}):
                problems.append("%s: a test reaches `%s`; it need not be listed" % (name, text))
    print("\n".join(problems))
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
