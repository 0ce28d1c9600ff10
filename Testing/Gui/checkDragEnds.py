"""checkDragEnds.py FOLDER: the pictures of the drags that TestDragEnds.sh played, and the state in the end."""

import os
import sys
import xml.etree.ElementTree as ElementTree

folder = sys.argv[1]
with open(os.path.join(folder, "watched.txt"), encoding="utf-8") as watched:
    kinds = [line.split()[2] for line in watched]
drags = sum(before == "fine" and now == "quick" for before, now in zip(kinds, kinds[1:]))
if drags != 4:
    sys.exit("FAILED: %d drags began after a fine picture, not 4: %s" % (drags, kinds))

properties = {}
for proxy in ElementTree.parse(os.path.join(folder, "end.pvsm")).iter("Proxy"):
    for one in proxy.findall("Property"):
        properties[proxy.get("type"), one.get("name")] = [float(e.get("value")) for e in one.findall("Element")
                                                          if one.get("name") in ("Position", "RelaxationPreset")]
if abs(properties["ChainMailProbe", "Position"][2]) > 1e-6 or properties["ChainMailDeformation", "RelaxationPreset"] != [0]:
    sys.exit("FAILED: what the drag that was broken off left is not undone: %s, %s" % (
        properties["ChainMailProbe", "Position"], properties["ChainMailDeformation", "RelaxationPreset"]))
print("4 drags ended, and the view was drawn %d times" % len(kinds))
