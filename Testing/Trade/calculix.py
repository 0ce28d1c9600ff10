"""Finite elements with CalculiX (Debian's calculix-ccx): blocks of equal cubes, each of a material of its own.

An outside solver for what ChainMail is compared with. The mesh's nodes are the places of a grid's voxels, and eight of them
span a hexahedron of type C3D8. Units: mm, and any one unit of stress. Arrays are [z, y, x]. TestCalculix.py compares with
solutions in closed form."""

import hashlib
import os
import re
import shutil
import subprocess

import numpy as np

PROGRAM = "ccx"


def available():
    return shutil.which(PROGRAM) is not None


class Material:
    """Young's modulus and Poisson's ratio at rest. finite: the stored energy of a compressible neo-Hookean solid, W = mu / 2
    (J^(-2/3) tr C - 3) + K / 2 (J - 1)^2, and large displacements; else Hooke's law and small ones."""

    def __init__(self, modulus, poisson, finite=False):
        self.modulus, self.poisson, self.finite = modulus, poisson, finite
        self.shear = modulus / (2 * (1 + poisson))
        self.bulk = modulus / (3 * (1 - 2 * poisson))

    def cards(self):
        if self.finite:
            return "*HYPERELASTIC, NEO HOOKE\n%.9g, %.9g\n" % (self.shear / 2, 2 / self.bulk)
        return "*ELASTIC\n%.9g, %.9g\n" % (self.modulus, self.poisson)


def write(path, nodes, materials, material, prescribed):
    """Writes the input of CalculiX.

    nodes: how many along x, y, z, 1 mm apart. materials: a list. material: the number in this list of each cube, [z, y, x].
    prescribed: (node, axis, displacement [mm]) for every displacement that is given; all else is free."""
    count = int(np.prod(nodes))
    number = np.arange(1, count + 1).reshape(nodes[::-1])
    k, j, i = np.unravel_index(np.arange(count), nodes[::-1])
    low, high = number[:-1], number[1:]
    corners = np.stack([low[:, :-1, :-1], low[:, :-1, 1:], low[:, 1:, 1:], low[:, 1:, :-1],
                        high[:, :-1, :-1], high[:, :-1, 1:], high[:, 1:, 1:], high[:, 1:, :-1]], -1).reshape(-1, 8)
    with open(path, "w") as file:
        file.write("*NODE, NSET=ALL\n")
        np.savetxt(file, np.stack([number.ravel(), i, j, k], 1), "%d, %d.0, %d.0, %d.0")
        for which, law in enumerate(materials):
            chosen = np.flatnonzero(material.ravel() == which)
            if not chosen.size:
                continue
            file.write("*ELEMENT, TYPE=C3D8, ELSET=PART%d\n" % which)
            np.savetxt(file, np.column_stack([chosen + 1, corners[chosen]]), "%d" + 8 * ", %d")
            file.write("*MATERIAL, NAME=LAW%d\n%s*SOLID SECTION, ELSET=PART%d, MATERIAL=LAW%d\n"
                       % (which, law.cards(), which, which))
        finite = any(law.finite for law in materials)
        file.write("*BOUNDARY\n")
        file.writelines("%d, %d, %d, 0.0\n" % (node + 1, axis + 1, axis + 1) for node, axis, value in prescribed if value == 0)
        file.write("*STEP, INC=1000%s\n*STATIC\n%s" % ((", NLGEOM", "0.25, 1.0, 1e-3, 0.5\n") if finite else ("", "")))
        moved = ["%d, %d, %d, %.9g\n" % (node + 1, axis + 1, axis + 1, value) for node, axis, value in prescribed if value != 0]
        if moved:
            file.write("*BOUNDARY\n")
            file.writelines(moved)
        file.write("*NODE PRINT, NSET=ALL, FREQUENCY=1000\nU, RF\n*END STEP\n")


def read(path, nodes):
    """(displacements [mm], reactions), each [z, y, x, axis], of the last state in a .dat file."""
    blocks = {}
    rows = time = None
    with open(path) as file:
        for line in file:
            head = re.match(r"\s*(displacements|forces).*time\s+(\S+)", line)
            if head:
                rows = blocks[head.group(1)] = []
                time = float(head.group(2))
            elif line.strip() and rows is not None:  # since 2.22 the version comes first
                rows.append(line.split())
    if time != 1.0:
        raise RuntimeError("CalculiX came to time %g of 1 only" % time)
    result = []
    for name in ("displacements", "forces"):
        table = np.array(blocks[name], float)
        values = np.full((int(np.prod(nodes)), 3), np.nan)
        values[table[:, 0].astype(int) - 1] = table[:, 1:4]
        if not np.isfinite(values).all():
            raise RuntimeError("CalculiX left nodes without %s" % name)
        result.append(values.reshape(*nodes[::-1], 3))
    return result


def solve(folder, nodes, materials, material, prescribed):
    """(displacements, reactions) as read() gives them. Solutions are kept in `folder`, by what was asked, and not computed
    again."""
    os.makedirs(folder, exist_ok=True)
    draft = os.path.join(folder, "draft-%d.inp" % os.getpid())
    write(draft, nodes, materials, material, prescribed)
    with open(draft, "rb") as file:
        name = hashlib.sha256(file.read()).hexdigest()[:16]
    job = os.path.join(folder, name)
    kept = job + ".npz"
    if os.path.isfile(kept):
        os.remove(draft)
        with np.load(kept) as arrays:
            return arrays["displacements"], arrays["reactions"]
    os.replace(draft, job + ".inp")
    done = subprocess.run([PROGRAM, name], cwd=folder, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          env={**os.environ, "OMP_NUM_THREADS": str(os.cpu_count())})
    if done.returncode != 0 or "*ERROR" in done.stdout:
        raise RuntimeError("CalculiX failed on %s.inp:\n%s" % (job, done.stdout[-2000:]))
    displacements, reactions = read(job + ".dat", nodes)
    np.savez_compressed(kept, displacements=displacements, reactions=reactions)
    for suffix in (".inp", ".dat", ".frd", ".cvg", ".sta", ".12d"):
        if os.path.exists(job + suffix):
            os.remove(job + suffix)
    return displacements, reactions
