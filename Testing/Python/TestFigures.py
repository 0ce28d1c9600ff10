"""The figures that an update leaves as field data reach ParaView's panels and scripts, with probes and without."""

import numpy as np
from harness import Reports, field, require, update
from paraview.simple import *

FIGURES = {"ProbeReached": 3, "ProbeForce": 3, "Energy": 1, "MaxLinkExcess": 1, "PropagationIterationsUsed": 1,
           "RelaxationIterationsUsed": 1, "CoarseToFineStep": 1,
           "DisplacedElements": 1, "Milliseconds": 5, "PeakDeviceMemory": 1}

wavelet = Wavelet(WholeExtent=[0, 14, 0, 14, 0, 14])
deformation = ChainMailDeformation(Input=wavelet)
reports = Reports(deformation)
for count in (0, 1, 2):
    deformation.Probes = [ChainMailProbe(Position=[6 + 2 * n, 7, 7], Target=[6 + 2 * n, 7.25, 7]) for n in range(count)]
    outputs = update(deformation, reports)
    for port, data in enumerate(outputs):
        for name, components in FIGURES.items():
            rows = count if name.startswith("Probe") else 1
            require(field(data, name).size == rows * components, "%d probes, port %d: %s holds %s", count, port, name,
                    field(data, name))
        device = data.GetFieldData().GetAbstractArray("DeviceName")
        require(device is not None and device.GetNumberOfValues() == 1 and device.GetValue(0), "no DeviceName")

        # What ParaView knows of the data: its Information panel shows this. Arrays without a row may be left out.
        known = deformation[port].FieldData.keys()
        missing = [name for name in [*FIGURES, "DeviceName"] if name not in known and (count or not name.startswith("Probe"))]
        require(not missing, "%d probes, port %d: ParaView does not see %s", count, port, missing)

    # 15^3 places of 28 bytes, in bricks; a processor needs no more than a handful of them for one pull.
    require((0.1 if count else 0) < field(outputs[0], "PeakDeviceMemory")[0, 0] < 20, "%s MB on the device",
            field(outputs[0], "PeakDeviceMemory"))
    if count:
        require(np.allclose(field(outputs[0], "ProbeReached"), [[0, 0.25, 0]] * count, atol=1e-4), "reached %s",
                field(outputs[0], "ProbeReached"))
        # Who pulls along y has to pull with a force along y, and puts energy in.
        require((field(outputs[0], "ProbeForce")[:, 1] > 0).all() and field(outputs[0], "Energy")[0, 0] > 0,
                "force %s, energy %s", field(outputs[0], "ProbeForce"), field(outputs[0], "Energy"))
        require(0 < field(outputs[0], "DisplacedElements")[0, 0] < 15**3, "%s elements moved", field(outputs[0], "DisplacedElements"))
        require(0 < field(outputs[0], "RelaxationIterationsUsed")[0, 0] <= 40, "%s iterations",
                field(outputs[0], "RelaxationIterationsUsed"))
    else:
        require(field(outputs[0], "Energy")[0, 0] == 0 and field(outputs[0], "DisplacedElements")[0, 0] == 0,
                "something moved without a probe")
print("the figures are there")
