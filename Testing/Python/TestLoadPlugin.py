"""The plugin is found by PV_PLUGIN_PATH and by LoadPlugin, and is there only because of them."""

import os

from harness import require, run_pvpython

USE = """
import sys
names = [name for name in ("ChainMailDeformation", "ChainMailProbe") if name in globals()]
probe = ChainMailProbe(Position=[6, 6, 6], Target=[6.5, 6, 6]) if len(names) == 2 else sys.exit("only %s" % names)
deformation = ChainMailDeformation(Input=Wavelet(WholeExtent=[0, 12, 0, 12, 0, 12]), Probes=[probe])
deformation.UpdatePipeline()
reached = deformation.FieldData["ProbeReached"].GetRange(0)
sys.exit(0 if reached == (0.5, 0.5) else "the probe reached %s" % (reached,))
"""
IMPORT = "from paraview.simple import *\n"

plugin = os.environ["CHAINMAIL_PLUGIN"]
require(os.path.isfile(plugin), "there is no plugin '%s'", plugin)

status, text = run_pvpython("-c", IMPORT + USE, PV_PLUGIN_PATH=os.environ["PV_PLUGIN_PATH"])
require(status == 0, "with PV_PLUGIN_PATH:\n%s", text)

load = "LoadPlugin(r'%s', remote=False, ns=globals())\n" % plugin
status, text = run_pvpython("-c", IMPORT + load + USE, PV_PLUGIN_PATH=None)
require(status == 0, "with LoadPlugin:\n%s", text)

status, text = run_pvpython("-c", IMPORT + USE, PV_PLUGIN_PATH=None)
require(status != 0 and "only []" in text, "ParaView has the plugin although nothing names it:\n%s", text)
print("found by PV_PLUGIN_PATH and by LoadPlugin")
