"""The main job, the README's first command, to its end on a small phantom: every file that it promises is there, the volumes
are deformed, the pictures differ, and the cut lets the probes go further. (What main-job.sh does before that, it shares with
run-all.sh: it installs and builds.)"""

import os
import re
import shutil
import subprocess
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pictures import *  # noqa: E402, F403  (puts the harness on the path)
from harness import DATA, OUTPUT, points_of, require  # noqa: E402
from vtkmodules.vtkIOImage import vtkPNGReader  # noqa: E402
from vtkmodules.vtkIOXML import vtkXMLImageDataReader  # noqa: E402

require_display()
folder = os.path.join(OUTPUT, "TestMainJob")
shutil.rmtree(folder, ignore_errors=True)
done = subprocess.run([os.environ.get("CHAINMAIL_PVBATCH", "pvbatch"), os.path.join(DATA, "main_job.py"), "--output", folder,
                       "--size", "88", "80", "104", "--image", "300", "200", "--iterations", "10"],
                      stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=600)
require(done.returncode == 0 and "Traceback" not in done.stdout and "ERR|" not in done.stdout, "status %d:\n%s",
        done.returncode, done.stdout)


def read(reader, name):
    path = os.path.join(folder, name)
    require(os.path.isfile(path), "%s was not written:\n%s", name, done.stdout)
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput()


pictures = {name: points_of(read(vtkPNGReader(), name + ".png"), "PNGImage") for name in ("input", "deformed", "cut")}
for one, other in (("input", "deformed"), ("deformed", "cut")):
    require((pictures[one] != pictures[other]).any(), "%s.png and %s.png show the same", one, other)
volumes = {name: points_of(read(vtkXMLImageDataReader(), name + ".vti"), "CT") for name in ("deformed", "cut")}
require((volumes["deformed"] != volumes["cut"]).any(), "the cut changes nothing")

lengths = [sum(float(n) ** 2 for n in numbers.split()) ** 0.5 for numbers in re.findall(r"reached ([-.\d ]+) mm", done.stdout)]
require(len(lengths) == 4, "two probes, twice, were to be reported:\n%s", done.stdout)
require(sum(lengths[2:]) > sum(lengths[:2]) > 0, "the probes reach %s mm, and with the cut %s mm", lengths[:2], lengths[2:])
print("the main job reaches %s mm, and with the cut %s mm" % (lengths[:2], lengths[2:]))
