"""The main job, which renders, on a machine without an X server: a clear message, no crash, a status that tells."""

import os
import subprocess

from harness import DATA, OUTPUT, require

job = os.path.join(DATA, "main_job.py")
require(os.path.isfile(job), "there is no %s", job)
pvbatch = os.environ.get("CHAINMAIL_PVBATCH", "pvbatch")

for display in (None, ":4095"):  # none named, and one that nobody runs
    environment = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
    if display:
        environment["DISPLAY"] = display
    done = subprocess.run([pvbatch, job, "--output", os.path.join(OUTPUT, "TestNoDisplay")], env=environment,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=300)
    require(done.returncode > 0, "DISPLAY=%s: the status is %d (negative: a signal)\n%s", display, done.returncode,
            done.stdout)
    require("display" in done.stdout.lower() and "Traceback" not in done.stdout, "DISPLAY=%s: no clear message:\n%s",
            display, done.stdout)
print("a clear message without a display")
