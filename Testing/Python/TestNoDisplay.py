"""The main job, which renders, on a machine without an X server: a clear message, no crash, a status that tells. Since 6.1
ParaView renders without one: then the pictures are there."""

import os
import shutil
import subprocess

from paraview.simple import GetParaViewVersion

from harness import DATA, OUTPUT, require

job = os.path.join(DATA, "main_job.py")
require(os.path.isfile(job), "there is no %s", job)
pvbatch = os.environ.get("CHAINMAIL_PVBATCH", "pvbatch")

needs_display = GetParaViewVersion() < (6, 1)
output = os.path.join(OUTPUT, "TestNoDisplay")
shutil.rmtree(output, ignore_errors=True)
for display in (None, ":4095"):  # none named, and one that nobody runs
    environment = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
    if display:
        environment["DISPLAY"] = display
    done = subprocess.run([pvbatch, job, "--output", output, "--size", "64", "64", "64"], env=environment,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=300)
    if not needs_display:
        require(done.returncode == 0 and os.path.getsize(os.path.join(output, "cut.png")) > 0,
                "DISPLAY=%s: no picture, the status is %d\n%s", display, done.returncode, done.stdout)
        shutil.rmtree(output)
        continue
    require(done.returncode > 0, "DISPLAY=%s: the status is %d (negative: a signal)\n%s", display, done.returncode,
            done.stdout)
    require("display" in done.stdout.lower() and "Traceback" not in done.stdout, "DISPLAY=%s: no clear message:\n%s",
            display, done.stdout)
print("a clear message without a display" if needs_display else "pictures without a display")
