"""The documents say what is so:

    python3 Testing/Documents/checkDocuments.py

Every command of the pages in COMMAND_PAGES is run by a test that COMMANDS names, or is named there as one that is not run,
with the reason. Links, anchors, pictures and paths of all pages lead somewhere. Scripts compile, and the properties, methods
and targets in them exist. No fact is told twice in the same words, and words that the glossary says are gone stay away. Then the same is asked with a mistake planted, for each of
PLANTED, and has to be refused. Needs nothing but Python 3."""

import ast
import glob
import os
import re
import sys
import xml.etree.ElementTree as ElementTree

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir, os.pardir))
ROOMS = ("Data", "Filters", "Kernels", "Plugin", "Testing")
COMMAND_PAGES = ("README.md", "CONTRIBUTING.md", "Data/Install.md", "Data/Using.md", "Data/Bones.md", "Data/Output.md", "Data/Processes.md", "Data/Arrays.md",
                 "Data/InAndOut.md", "Data/Landmarks.md", "Data/Poses.md", "Data/Choosing.md", "Data/Gallery.md", "Data/Pictures.md")
MOST_LINES = {"README.md": 160, "CONTRIBUTING.md": 180}

ROLES = "Testing/Roles/"
# A command (an expression for all of it, blanks made single); why no test runs it as it stands, empty where one does; and in
# which file which words stand that run it or, where none does, that it relies on.
COMMANDS = [
    (r"git clone <.*> chainmail && cd chainmail", "the address is the reader's", {ROLES + "tryCommands.sh": ["git ls-files"]}),
    (r"bash Data/main-job\.sh", "", {ROLES + "tryCommands.sh": ["bash Data/main-job.sh"], "Testing/Rendering/TestMainJob.py": ["main_job.py"], "Data/main-job.sh": [
        "Data/main_job.py", "install_packages", "configure_and_build"]}),
    (r"bash Data/main-job\.sh scan\.mhd", "a scan of the user's; Rendering.MainJob is the same on the phantom",
     {"Data/main-job.sh": ['"$@"']}),
    (r"bash Data/main-job\.sh heart_cta\.mhd .*", "a scan that is not part of the repository",
     {"Data/main_job.py": ['"--softness"', '"--bone"']}),
    (r"bash Testing/run-all\.sh", "", {ROLES + "tryCommands.sh": ["bash Testing/run-all.sh"], ".ci/run": ["Testing/run-all.sh"]}),
    (r"bash Testing/prepare\.sh", "", {"Testing/run-all.sh": ["prepare.sh"]}),
    (r"PV_PLUGIN_PATH=build/\S+ paraview", "", {"Testing/Python/TestLoadPlugin.py": ['PV_PLUGIN_PATH=os.environ']}),
    (r"PV_PLUGIN_PATH=\$HOME/\S+ paraview", "", {ROLES + "Installed.cmake": ["PV_PLUGIN_PATH=${PREFIX}", "usePlugin.py"]}),
    (r"apt install --no-install-recommends .*", "it needs root and the network", {"Testing/prepare.sh": [
        "apt-get install --yes --no-install-recommends"]}),
    (r"cmake -S \. -B build -DCMAKE_INSTALL_PREFIX=\S+", "", {ROLES + "Steps.cmake": ['-S "${source}" -B "${build}"'],
                                                             ROLES + "EngineAlone.cmake": ["-DCMAKE_INSTALL_PREFIX="]}),
    (r"cmake -S \. -B build -DVTK_DIR=\S.*", "", {ROLES + "PlainVTK.cmake": ["-DVTK_DIR="]}),
    (r"cmake -S \. -B build-engine .*", "", {ROLES + "EngineAlone.cmake": [
        "-DCHAINMAIL_ENGINE_ONLY=ON", "-DCHAINMAIL_SANITIZE=address,undefined", "-DCMAKE_BUILD_TYPE=Debug"]}),
    (r"cmake --build build -j", "", {ROLES + "Steps.cmake": ['--build "${build}" --parallel']}),
    (r"cmake --install build", "", {ROLES + "Installed.cmake": ['--install "${BUILD}"']}),
    (r"ctest --test-dir build -L \w+( -R \w+)? --output-on-failure", "", {"Testing/run-all.sh": [
        'ctest --test-dir "$build" --output-on-failure']}),
    (r'export HWLOC_SYNTHETIC="numa:1\(memory=\d+\) core:\d+ pu:1"', "", {"Testing/prepare.sh": [
        'export HWLOC_SYNTHETIC="numa:1(memory=', ') core:', ' pu:1"']}),
    (r"export ASAN_OPTIONS=detect_leaks=0:use_sigaltstack=0", "",
        {ROLES + "EngineAlone.cmake": ["ENV{ASAN_OPTIONS} detect_leaks=0:use_sigaltstack=0"]}),
    (r"cmake -S \. -B build -DBUILD_TESTING=OFF", "", {"Data/main-job.sh": ["configure_and_build -DBUILD_TESTING=OFF"]}),
    (r"cpack --config build/CPackConfig\.cmake -B build", "", {ROLES + "Package.cmake": ['--config "${BUILD}/CPackConfig.cmake" -B']}),
    (r"apt install \./build/chainmail_\S+\.deb", "", {ROLES + "tryPackage.sh": ['apt-get install --yes "/root/']}),
    (r"podman (build|run) .*", "there is no container engine where the tests run; the package is tried in a bare system",
     {ROLES + "tryPackage.sh": ["make_bare_system", "usePlugin.xml"]}),
    (r"plastimatch convert --input FOLDER .*", "", {"Testing/Python/TestDicom.py": ['"plastimatch", "convert", "--input"']}),
    (r"plastimatch warp --input pet\.mha .*", "", {"Testing/Python/TestTransforms.py": ['"plastimatch", "warp", "--input"', '"--xf"']}),
    (r"antsApplyTransforms -d 3 .*", "", {"Testing/Python/TestTransforms.py": ['"antsApplyTransforms", "-d", "3", "-i"', '"-t"']}),
    (r"mpirun -np 4 pvbatch", "", {"Testing/Python/TestRanks.py": ["mpiexec("]}),
    (r"mpiexec -n 4 pvserver", "", {"Testing/Python/TestClientServer.py": ["mpiexec(2, pvserver)"]}),
    (r"export PV_PLUGIN_PATH=build/\S+", "", {"Testing/CMakeLists.txt": ["PV_PLUGIN_PATH=${CHAINMAIL_PLUGIN_FOLDER}"]}),
    (r"xvfb-run -a pvpython Data/make_gallery\.py .*", "", {"Testing/Rendering/TestGallery.py": ["make_gallery.main("]}),
    (r"bash Testing/Trade/run\.sh", "it takes long; its programs are run at a small size", {"Testing/Trade/CMakeLists.txt": [
        "measure.py", "report.py"], "Testing/Trade/run.sh": ["measure.py", "report.py"]}),
    (r"clang-format-14 -i FILES", "it changes files", {".clang-format": ["ColumnLimit"]}),
    (r"clang-tidy -p build FILES", "it is for the person who edits", {".clang-tidy": ["Checks"]}),
]
WORDS = ("antsApplyTransforms apt apt-get bash clang-format-14 clang-tidy cmake cpack ctest export git make mpiexec mpirun paraview pip plastimatch "
         "podman pvbatch pvpython pvserver python3 sh sudo xvfb-run").split()

# What scripts call of any proxy of ParaView, and programs of any filter of VTK.
OF_ALL_PROXIES = {"InvokeCommand", "MarkModified", "UpdatePipeline", "UpdatePropertyInformation", "GetPropertyValue", "FieldData"}
OF_ALL_FILTERS = {"GetOutput", "GetOutputPort", "SetInputConnection", "SetInputData", "Update"}


class Repository:
    """The files, of which some may be other than on disk: planted mistakes."""

    def __init__(self, changed=()):
        self.changed = dict(changed)
        found = glob.glob(os.path.join(ROOT, "*.md"))
        for room in ROOMS:
            found += glob.glob(os.path.join(ROOT, room, "**", "*.md"), recursive=True)
        self.pages = {os.path.relpath(path, ROOT).replace(os.sep, "/") for path in found}

    def exists(self, path):
        return os.path.exists(os.path.join(ROOT, path))

    def read(self, path):
        if path in self.changed:
            return self.changed[path]
        with open(os.path.join(ROOT, path), encoding="utf-8") as file:
            return file.read()

    def find(self, name):
        """The one file of this name in the rooms, wherever it stands."""
        found = [path for room in ROOMS for path in glob.glob(os.path.join(ROOT, room, "**", name), recursive=True)]
        return os.path.relpath(found[0], ROOT)


def split(text):
    """The fenced blocks of a page, [(language, text)], and the page without them."""
    blocks = re.findall(r"^[ ]{0,3}```(\w*)\n(.*?)^[ ]{0,3}```", text, re.S | re.M)
    return blocks, re.sub(r"^[ ]{0,3}```.*?^[ ]{0,3}```", "", text, flags=re.S | re.M)


def is_command(text):
    first = text.split(" ", 1)[0]
    return " " in text and (first in WORDS or re.match(r"[A-Z_]+=\S", first) is not None)


def commands(text):
    """All commands of a page: of shell blocks, fenced and indented, and within sentences."""
    blocks, rest = split(text)
    lines = []
    for language, block in blocks:
        if language in ("sh", "bash", "shell", "console"):
            lines += block.split("\n")
        elif not language:  # a tree of folders, say, or commands
            lines += [line for line in block.split("\n") if is_command(line.strip().lstrip("$ "))]
    indented = re.findall(r"(?:^|\n\n)((?:[ ]{4}.*\n?)+)", rest)
    lines += "".join(indented).split("\n")
    joined = re.sub(r"\\\n\s*", "", "\n".join(lines)).split("\n")
    found = [re.sub(r"\s+#.*", "", line.strip().lstrip("$ ")) for line in joined]
    found += [span for span in re.findall(r"`([^`\n]+)`", rest) if is_command(span)]
    return [re.sub(r"\s+", " ", command).strip() for command in found if command.strip()]


def check_commands(repository, problems):
    used = set()
    count = 0
    packages = repository.read("Testing/prepare.sh")
    options = repository.read("CMakeLists.txt")
    labels = "".join(repository.read(os.path.relpath(path, ROOT)) for path in
                     glob.glob(os.path.join(ROOT, "Testing", "**", "CMakeLists.txt"), recursive=True))
    for page in COMMAND_PAGES:
        for command in commands(repository.read(page)):
            count += 1
            entries = [n for n, entry in enumerate(COMMANDS) if re.fullmatch(entry[0], command)]
            if not entries:
                problems.append("%s: no test is named that runs: %s" % (page, command))
            used.update(entries)
            if command.startswith("apt "):
                for package in [word for word in command.split()[2:] if not word.startswith(("-", "./"))]:
                    if not re.search(r"(?<![\w-])" + re.escape(package) + r"(?![\w-])", packages):
                        problems.append("%s: prepare.sh does not install %s" % (page, package))
            for option in re.findall(r"-D(CHAINMAIL_\w+)", command):
                if not re.search(r"(option|set)\(%s\b" % option, options):
                    problems.append("%s: CMake has no option %s" % (page, option))
            for label in re.findall(r"ctest .*-L (\w+)", command):
                if not re.search(r"LABELS %s\b|chainmail_add_scripts\(%s\b" % (label, label), labels):
                    problems.append("%s: no test has the label %s" % (page, label))
    if not count:
        problems.append("no commands were found")
    for n, (pattern, reason, files) in enumerate(COMMANDS):
        if n not in used:
            problems.append("no page has the command any more: %s" % pattern)
        for path, texts in files.items():
            content = repository.read(path) if repository.exists(path) else ""
            for text in texts:
                if text not in content:
                    problems.append("%s does not %s: %s" % (path, "have" if reason else "run", text))
    return count


def anchors(text):
    """What GitHub calls the headings of a page."""
    found = set()
    for heading in re.findall(r"^#+ +(.*?) *#*$", split(text)[1], re.M):
        heading = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading)
        slug = re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
        number = 0
        while slug + ("-%d" % number if number else "") in found:
            number += 1
        found.add(slug + ("-%d" % number if number else ""))
    return found


def check_links(repository, problems):
    count = 0
    for page in sorted(repository.pages):
        rest = split(repository.read(page))[1]
        for path in re.findall(r"`((?:%s)/[^`\s]*)`" % "|".join(ROOMS), rest):
            places = [os.path.join(ROOT, folder, path) for folder in ("", os.path.dirname(page))]
            if not re.search(r"ROOM|[a-z]X\.|TestName", path) and not any(map(glob.glob, places)):
                problems.append("%s: there is no %s" % (page, path))
        rest = re.sub(r"`[^`\n]*`", "", rest)
        links = re.findall(r"\]\(([^)\s]+)\)", rest) + re.findall(r"^\[[^\]]+\]: *(\S+)", rest, re.M)
        for link in links:
            if re.match(r"[a-z]+:", link):
                continue
            count += 1
            path, _, anchor = link.partition("#")
            target = os.path.normpath(os.path.join(os.path.dirname(page), path)).replace(os.sep, "/") if path else page
            if target.startswith("..") or not repository.exists(target):
                problems.append("%s: the link leads nowhere: %s" % (page, link))
            elif anchor and (not target.endswith(".md") or anchor not in anchors(repository.read(target))):
                problems.append("%s: %s has no section #%s" % (page, target, anchor))
    if not count:
        problems.append("no links were found")
    return count


def properties(repository):
    """Of each proxy of the plugin: its properties, with the words of those that are enumerations."""
    found = {}
    for path in glob.glob(os.path.join(ROOT, "Plugin", "*.xml")):
        root = ElementTree.fromstring(repository.read(os.path.relpath(path, ROOT)))
        for group in root.iter("ProxyGroup"):
            for proxy in group:
                names = {}
                for item in proxy:
                    if item.tag.endswith("Property") and item.get("name"):
                        names[item.get("name")] = [entry.get("text") for entry in item.iter("Entry")]
                found[proxy.get("name")] = names
    return found


def check_python(repository, page, text, proxies, problems):
    try:
        tree = ast.parse(text)
        compile(text, page, "exec")
    except SyntaxError as error:
        problems.append("%s: a script does not compile: %s" % (page, error))
        return
    of_variable = {"deformation": proxies["ChainMailDeformation"], "probe": proxies["ChainMailProbe"]}

    def check(name, known, value=None):
        if name not in known:
            problems.append("%s: the plugin has no property %s" % (page, name))
        elif known[name] and isinstance(value, ast.Constant) and isinstance(value.value, str) and value.value not in known[name]:
            problems.append("%s: %s has no value '%s'" % (page, name, value.value))

    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            name = getattr(node.func, "id", "")
            if name.startswith("ChainMail") and name not in proxies:
                problems.append("%s: the plugin has no %s" % (page, name))
            for keyword in node.keywords if name in proxies else []:
                check(keyword.arg, proxies[name], keyword.value)
            if getattr(node.func, "attr", "") == "InvokeCommand":
                check(node.args[0].value, of_variable[node.func.value.id])
        elif isinstance(node, ast.Attribute) and getattr(node.value, "id", "") in of_variable:
            if node.attr not in OF_ALL_PROXIES:
                check(node.attr, of_variable[node.value.id])
        elif isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Attribute):
            target = node.targets[0]
            if getattr(target.value, "id", "") in of_variable and target.attr in of_variable[target.value.id]:
                check(target.attr, of_variable[target.value.id], node.value)


def check_cpp(repository, page, text, problems):
    headers = {"deformation": "vtkChainMailDeformation.h", "probe": "vtkChainMailProbeSource.h", "simulation": "Simulation.h"}
    for variable, method in re.findall(r"\b(deformation|probe|simulation)(?:->|\.)(\w+)\(", text):
        header = repository.read(repository.find(headers[variable]))
        macro = r"vtk\w*Macro\(%s\b" % re.sub("^[SG]et", "", method)
        if method not in OF_ALL_FILTERS and not re.search(r"\b%s\(|%s" % (method, macro), header):
            problems.append("%s: %s has no %s()" % (page, headers[variable], method))


def check_blocks(repository, problems):
    proxies = properties(repository)
    known = {name for names in proxies.values() for name in names}
    consumer = repository.read("Testing/Consumer/CMakeLists.txt")
    count = 0
    for page in sorted(repository.pages):
        blocks, rest = split(repository.read(page))
        for language, text in blocks:
            count += 1
            if language == "python":
                check_python(repository, page, text, proxies, problems)
            elif language == "cpp":
                check_cpp(repository, page, text, problems)
            elif language == "cmake":
                for target in re.findall(r"\w+::\w+", text):
                    if not re.search(re.escape(target) + r"\b", consumer):
                        problems.append("%s: no outside program links with %s" % (page, target))
        for name in re.findall(r"`([A-Z]\w+)` = ", rest):
            if name not in known:
                problems.append("%s: the plugin has no property %s" % (page, name))
    if not count:
        problems.append("no blocks were found")
    recipe = [text for language, text in split(repository.read("README.md"))[0] if language == "python" and "NeedsUpdate" in text]
    if not recipe or "deformation.InvokeCommand" not in recipe[0]:
        problems.append("README.md has no script that Python.ClientServer could play")
    return count


def check_words(repository, problems):
    """No page is too long, and no long sentence stands twice."""
    for page, most in MOST_LINES.items():
        lines = repository.read(page).count("\n")
        if lines > most:
            problems.append("%s has %d lines; at most %d" % (page, lines, most))
    seen = {}
    for page in sorted(repository.pages):
        if page.startswith("Testing/Benchmarks/"):
            continue
        text = re.sub(r"<!-- (\w+): begin -->.*?<!-- \1: end -->", "", split(repository.read(page))[1], flags=re.S)
        text = "\n".join("" if line.startswith(("|", "    ", "#")) else line for line in text.split("\n"))
        for paragraph in re.split(r"\n\s*\n|\n *(?:-|\d+\.) ", text):
            for sentence in re.split(r"(?<=[.:;]) ", re.sub(r"\s+", " ", paragraph)):
                if len(sentence) > 70:
                    if sentence in seen:
                        problems.append("%s and %s both say: %s" % (seen[sentence], page, sentence))
                    seen[sentence] = page


def check_glossary(repository, problems):
    """The glossary is in order, its files have their terms, and words that are gone stay away from the code."""
    tables = (repository.read("CONTRIBUTING.md").split("## Glossary")[-1] + "These words are gone").split("These words are gone")
    glossary, gone = (re.findall(r"^\| (.+?) \| (.+?) \|", table, re.M)[1:] for table in tables[:2])
    terms = [term.lower() for term, _ in glossary]
    if len(terms) < 40 or terms != sorted(terms):
        problems.append("the glossary of CONTRIBUTING.md has %d terms, or they are not in order" % len(terms))
    words = {word: say for old, say in gone for word in re.findall(r"\w+", old)}
    if len(words) < 10:
        problems.append("CONTRIBUTING.md names %d words that are gone" % len(words))
        return
    pattern = re.compile(r"\b(%s)\b" % "|".join(words))
    for room in ("Kernels", "Filters", "Plugin"):
        for path in glob.glob(os.path.join(ROOT, room, "**", "*"), recursive=True):
            if path.endswith((".h", ".cpp", ".cxx", ".cl", ".clh", ".xml")):
                name = os.path.relpath(path, ROOT).replace(os.sep, "/")
                for word in set(pattern.findall(repository.read(name))):
                    problems.append("%s has the word %s, which is gone: say %s" % (name, word, words[word]))


def check(repository):
    problems = []
    counts = check_commands(repository, problems), check_links(repository, problems), check_blocks(repository, problems)
    check_words(repository, problems)
    check_glossary(repository, problems)
    return counts, problems


# Mistakes that must be noticed: in which page, what is put in place of what (None: at the end), and what has to be said.
PLANTED = [
    ("README.md", None, "\n    bash Data/other-job.sh\n", "no test is named"),
    ("README.md", None, "\nTo tidy up, `cmake --build build --target clean`.\n", "no test is named"),
    ("Data/Install.md", None, "\n```bash\nmake install\n```\n", "no test is named"),
    ("Data/Install.md", None, "\n```\n$ sudo make install\n```\n", "no test is named"),
    ("Data/Install.md", "cmake --install build", "cmake --build build -j", "no page has the command any more"),
    ("Data/Install.md", "pocl-opencl-icd", "pocl-opencl-icd bash-completion", "does not install bash-completion"),
    ("CONTRIBUTING.md", "-L Documents", "-L Papers", "no test has the label Papers"),
    ("CONTRIBUTING.md", "-DCHAINMAIL_ENGINE_ONLY=ON", "-DCHAINMAIL_ENGINE=ON", "no option CHAINMAIL_ENGINE"),
    ("Testing/Roles/Installed.cmake", "--install", "--instal", "does not run"),
    ("Testing/Rendering/TestMainJob.py", "main_job.py", "other_job.py", "does not run"),
    ("README.md", "(Data/Gallery.md)", "(Data/Galery.md)", "leads nowhere"),
    ("README.md", "forearm.png)", "forarm.png)", "leads nowhere"),
    ("README.md", "Using.md#errors", "Using.md#mistakes", "has no section"),
    ("Data/Install.md", "## In your own program", "## Elsewhere", "has no section"),
    ("README.md", "`Data/main_job.py`", "`Data/main_jobs.py`", "there is no Data/main_jobs.py"),
    ("README.md", "\n## Material", "\n" * 160 + "## Material", "lines; at most 160"),
    ("README.md", "while deformation.NeedsUpdate:", "while deformation.NeedsUpdate", "does not compile"),
    ("README.md", "deformation.NeedsUpdate:", "deformation.NeedsUpdates:", "no property NeedsUpdates"),
    ("README.md", "Cuts=[blade]", "Blades=[blade]", "no property Blades"),
    ("README.md", '"Interactive"', '"Interacting"', "has no value 'Interacting'"),
    ("README.md", 'InvokeCommand("Reset")', 'InvokeCommand("Restart")', "no property Restart"),
    ("README.md", "`MaterialPreset` = CT", "`MaterialPresets` = CT", "no property MaterialPresets"),
    ("README.md", "deformation.InvokeCommand", "probe.InvokeCommand", "could play"),
    ("README.md", "SetMaterialPresetToCT()", "SetMaterialPresetToXray()", "has no SetMaterialPresetToXray()"),
    ("Data/Install.md", "simulation.relax(", "simulation.settle(", "has no settle()"),
    ("Data/Install.md", "VTK::ChainMailFilters", "VTK::ChainMail", "no outside program"),
    ("Data/Changes.md", None, "\nSofter tissue and a higher threshold for bone\nlet the wall of the heart move well:\n", "both say"),
    ("Kernels/Core/element.clh", None, "\n// The tension of a link.\n", "has the word tension"),
    ("CONTRIBUTING.md", "| anchor |", "| zanchor |", "not in order"),
    ("Plugin/ChainMailDeformation.xml", 'name="NeedsUpdate"', 'name="IsSettled"', "no property NeedsUpdate"),
]


def main():
    counts, problems = check(Repository())
    if problems:
        sys.exit("FAILED:\n" + "\n".join(problems))
    for page, old, new, expected in PLANTED:
        text = Repository().read(page)
        if old is not None and old not in text:
            problems.append("%s has no '%s', in place of which a mistake was to be planted" % (page, old))
            continue
        changed = text + new if old is None else text.replace(old, new)
        if not any(expected in problem for problem in check(Repository({page: changed}))[1]):
            problems.append("not noticed in %s: %s" % (page, new.strip()))
    empty = {page: "# Nothing\n" for page in Repository().pages}
    for expected in ("no commands were found", "no links were found", "no blocks were found"):
        if expected not in check(Repository(empty))[1]:
            problems.append("not noticed: pages without anything (%s)" % expected)
    if problems:
        sys.exit("FAILED:\n" + "\n".join(problems))
    print("%d commands, %d links and %d blocks are right; %d mistakes were noticed" % (*counts, len(PLANTED)))


if __name__ == "__main__":
    main()
