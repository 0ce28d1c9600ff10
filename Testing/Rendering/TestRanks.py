"""Several processes, each with its piece of the deformed forearm, draw the volume that one draws alone: a cut that opens
across the pieces, nothing composited twice, no seams. Under mpiexec this file is also the program that draws."""

import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pictures import *  # noqa: E402, F403  (puts the harness on the path)
from harness import OUTPUT, run_pvbatch  # noqa: E402

COLOURS = [(-1000, 0.50, 0.30, 0.25), (-420, 0.95, 0.70, 0.57), (-60, 1.00, 0.86, 0.60), (60, 0.80, 0.16, 0.14),
           (250, 0.97, 0.90, 0.78), (1500, 1.00, 0.99, 0.95)]
OPACITIES = [(-1000, 0.0), (-800, 0.0), (-450, 0.7), (-120, 0.6), (-60, 0.3), (160, 0.12), (300, 0.75), (1500, 1.0)]


def draw(scan, folder):
    """The scan at rest and deformed, as rest.png and deformed.png of the folder."""
    forearm = OpenDataFile(scan)
    probe = ChainMailProbe(Position=[20, 28, 4], Target=[42, 50, 4], Radius=7)
    blade = Plane(Origin=[6, 10, -30], Point1=[6, 45, -30], Point2=[6, 10, 38])
    deformation = ChainMailDeformation(Input=forearm, Probes=[probe], Cuts=[blade], TissueThreshold=-400,
                                       BackgroundValue=-1000)
    deformation.MaterialFunction.Points = [-1024, 0.8, 0.5, 0, 200, 0.8, 0.5, 0, 600, 0, 0.5, 0]
    view = make_view((260, 200), position=(190, 340, 10), focus=(0, 0, 10), up=(0, 1, 0), angle=28.0)
    for name, source in (("rest", forearm), ("deformed", deformation)):
        # Unshaded: a piece knows no gradient across its border, ParaView's own readers give none.
        show_volume(source, view, "CT", COLOURS, OPACITIES).Shade = 0
        write(capture(view), os.path.join(folder, name + ".png"))
        Hide(source, view)


def main():
    require_display()
    sys.path.insert(0, DATA)
    from make_forearm import make_forearm
    from vtkmodules.vtkIOXML import vtkXMLImageDataWriter
    folder = os.path.join(OUTPUT, "ranks")
    os.makedirs(folder, exist_ok=True)
    scan = os.path.join(folder, "forearm.vti")
    writer = vtkXMLImageDataWriter()
    writer.SetFileName(scan)
    writer.SetDataModeToBinary()  # VTK 9.1 cannot read its default with a new expat
    writer.SetInputDataObject(make_forearm((66, 62, 92)))
    require(writer.Write() == 1, "could not write %s", scan)
    drawn = {}
    for count in (1, 3):
        there = os.path.join(folder, "%d" % count)
        run_pvbatch(count, os.path.abspath(__file__), scan, there)
        drawn[count] = {name: read(os.path.join(there, name + ".png")) for name in ("rest", "deformed")}
    for name, alone in drawn[1].items():
        print("%s: %d pixels too dark, %d too bright" % ((name,) + pixels_beyond(drawn[3][name], alone)))
    for name, alone in drawn[1].items():
        require(same_picture(drawn[3][name], alone), "%s: three processes draw another picture than one", name)
    require(not same_picture(drawn[1]["rest"], drawn[1]["deformed"]), "nothing is seen of the deformation")


if len(sys.argv) > 1:
    draw(*sys.argv[1:])
else:
    main()
