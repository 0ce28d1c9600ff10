"""Without an OpenCL driver the filter says so and what to install; nothing crashes, and the panel has no device."""

import os

from harness import require, run_pvpython

CODE = """
from harness import Reports, expect_error
from paraview.simple import *
deformation = ChainMailDeformation(Input=Wavelet(WholeExtent=[0, 5, 0, 5, 0, 5]))
reports = Reports(deformation)
print("devices:", list(deformation.GetProperty("AvailableDevices")))
print(expect_error(deformation, reports, "No OpenCL device", "Install"))
print("and goes on")
"""

here = os.path.dirname(os.path.abspath(__file__))
path = here + os.pathsep + os.environ.get("PYTHONPATH", "")
status, text = run_pvpython("-c", CODE, OCL_ICD_VENDORS="/nonexistent", PYTHONPATH=path)
require(status == 0, "status %d:\n%s", status, text)
for part in ("devices: []", "and goes on"):
    require(part in text, "'%s' is not said:\n%s", part, text)

# The same code with a driver does not fail, so it does fail for want of one.
status, text = run_pvpython("-c", CODE, PYTHONPATH=path)
require(status != 0 and "0 errors instead of one" in text, "with a driver: status %d\n%s", status, text)
print("a clear message without OpenCL")
