"""The colour and opacity presets of Plugin/Presets.json stand on ParaView's list and keep their Hounsfield units; those that
the user has saved stay, and the user's settings hold none of the plugin's. The last two need settings, so pvpython runs
this file again as a child, with a home of its own."""

import json
import os
import sys

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from harness import DATA, OUTPUT, require, run_pvpython  # noqa: E402
from paraview import servermanager  # noqa: E402
from paraview.simple import *  # noqa: E402, F403

KEY = "TransferFunctionPresets.CustomPresets"
with open(os.path.join(DATA, os.pardir, "Plugin", "Presets.json"), encoding="utf-8") as file:
    presets = json.load(file)


def of_the_user():
    return servermanager.vtkSMSettings.GetInstance().GetSettingAsString(KEY, "")


def apply(preset, rescale):
    """The control points of a colour and of an opacity function, [n, 4], after the preset."""
    colours, opacities = GetColorTransferFunction("scan"), GetOpacityTransferFunction("scan")
    for function in (colours, opacities):
        function.RescaleTransferFunction(0, 255)
        require(function.ApplyPreset(preset["Name"], rescale), "%s cannot be applied", preset["Name"])
    return np.reshape(colours.RGBPoints, (-1, 4)), np.reshape(opacities.Points, (-1, 4)), colours


def require_shipped(preset):
    colours, opacities, table = apply(preset, False)
    require(np.allclose(colours, np.reshape(preset["RGBPoints"], (-1, 4))), "%s: other colours", preset["Name"])
    require(np.allclose(opacities, np.reshape(preset["Points"], (-1, 4))), "%s: other opacities", preset["Name"])
    return table


if len(sys.argv) > 1:  # the child: the settings hold a preset of the user's and an older one of the plugin's
    before, loaded = of_the_user(), sys.argv[1] == "loaded"
    if not loaded:
        require("CT bone" not in GetLookupTableNames(), "presets without the plugin")
        LoadPlugin(os.environ["CHAINMAIL_PLUGIN"], remote=False, ns=globals())
    names = GetLookupTableNames()
    require("mine" in names, "the preset of the user's is gone")
    require([names.count(preset["Name"]) for preset in presets] == [1] * len(presets), "not each of them once: %s", names[-20:])
    require_shipped(presets[0])
    require("mine" in before and of_the_user() == before, "the settings became %s", of_the_user())
    sys.exit()

require(len(presets) > 5, "there are %d presets", len(presets))
names = GetLookupTableNames()
for preset in presets:
    require(names.count(preset["Name"]) == 1, "%s stands on the list %d times", preset["Name"], names.count(preset["Name"]))
    table = require_shipped(preset)
    ct = preset["Name"].startswith("CT")
    require(table.AutomaticRescaleRangeMode == "Never" or not ct, "%s would be rescaled to the next scan", preset["Name"])
    # 12 bits of a scanner: stored in 8 of them, the preset is right when rescaled to these.
    first, last = (-1024, 3071) if ct else (0, 1)
    values = np.reshape(preset["RGBPoints"], (-1, 4))[:, 0]
    require(values[0] == first and values[-1] == last, "%s goes from %g to %g", preset["Name"], values[0], values[-1])
    require((np.diff(values) > 0).all(), "%s: points in disorder", preset["Name"])
    colours, opacities, _ = apply(preset, True)
    require(np.allclose(colours[:, 0], (values - first) * 255 / (last - first)), "%s: rescaled to %s", preset["Name"], colours[:, 0])

home = os.path.join(OUTPUT, "PresetsHome")
os.makedirs(os.path.join(home, ".config", "ParaView"), exist_ok=True)
saved = [dict(Name="mine", ColorSpace="RGB", RGBPoints=[0, 0, 0, 0, 1, 1, 1, 1]),
         dict(Name=presets[0]["Name"], ColorSpace="RGB", RGBPoints=[0, 1, 0, 0, 1, 0, 0, 1])]
with open(os.path.join(home, ".config", "ParaView", "ParaView-UserSettings.json"), "w", encoding="utf-8") as file:
    json.dump({"TransferFunctionPresets": {"CustomPresets": json.dumps(saved)}}, file)
for when, path in (("loaded", os.environ["PV_PLUGIN_PATH"]), ("loading", None)):
    status, output = run_pvpython(os.path.abspath(__file__), when, HOME=home, PV_PLUGIN_PATH=path)
    require(status == 0, "with settings, %s: status %d:\n%s", when, status, output)
print("%d presets on the list" % len(presets))
