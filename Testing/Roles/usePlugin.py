"""Run with PV_PLUGIN_PATH: ParaView has loaded the plugin and its filter moves what a probe holds."""

import sys

from paraview import servermanager
from paraview.simple import ChainMailDeformation, ChainMailProbe, Wavelet

wavelet = Wavelet(WholeExtent=[0, 12, 0, 12, 0, 12])
probe = ChainMailProbe(Position=[6.0, 6.0, 6.0], Target=[7.0, 6.0, 6.0])
deformation = ChainMailDeformation(Input=wavelet, Probes=probe)

output = servermanager.Fetch(deformation)
reached = output.GetFieldData().GetArray("ProbeReached")
if reached is None or reached.GetTuple3(0) != (1.0, 0.0, 0.0):
    sys.exit("the probe reached %s" % (reached and str(reached.GetTuple3(0))))
print("the plugin is loaded and its probe moved by", reached.GetTuple3(0))
