"""What Trade/ has CalculiX compute, against solutions in closed form: a bar in tension, one of two materials, and a
body that turns."""

import math
import sys
import tempfile

import calculix
import numpy as np

SKIPPED = 125
NODES = (3, 4, 9)  # a bar of 2 x 3 x 8 cubes, on purpose as long along no two axes
LENGTH = NODES[2] - 1
AREA = (NODES[0] - 1) * (NODES[1] - 1)


def require_near(value, expected, tolerance, what):
    """CalculiX prints seven digits, so that much may be missing and no more."""
    worst = float(np.abs(np.asarray(value) - expected).max())
    print("%s: %.3g off" % (what, worst))
    if not worst <= tolerance:
        sys.exit("FAILED: %s is %s, not %s" % (what, value, expected))


def ends(pull):
    """The bar's lower end on a table, its upper end pulled; both free to become thinner. One corner keeps it in place."""
    number = np.arange(np.prod(NODES)).reshape(NODES[::-1])
    prescribed = [(node, 2, 0.0) for node in number[0].ravel()] + [(node, 2, pull) for node in number[-1].ravel()]
    return prescribed + [(number[0, 0, 0], 0, 0.0), (number[0, 0, 0], 1, 0.0), (number[0, 0, -1], 1, 0.0)]


def pulled(folder, materials, pull, material=None):
    if material is None:
        material = np.zeros([n - 1 for n in NODES[::-1]], int)
    return calculix.solve(folder, NODES, materials, material, ends(pull))


def hooke(folder):
    for poisson in (0.0, 0.3):
        u, force = pulled(folder, [calculix.Material(5.0, poisson)], 0.8)
        z, y, x = np.meshgrid(*(np.arange(n) for n in NODES[::-1]), indexing="ij")
        strain = 0.8 / LENGTH
        exact = np.stack([-poisson * strain * x, -poisson * strain * y, strain * z], -1)
        require_near(u, exact, 1e-6, "Hooke, Poisson's ratio %g: displacement" % poisson)
        require_near(force[-1, ..., 2].sum(), 5.0 * strain * AREA, 1e-5, "Hooke, Poisson's ratio %g: force" % poisson)


def neo_hooke(folder):
    """A bar twice as long. Its thickness t solves dW/dt = 0, W = mu / 2 J^(-2/3) (l^2 + 2 t^2) + K / 2 (J - 1)^2, J = l t^2,
    and dW/dl is the force on the area at rest."""
    stretch = 2.0
    for poisson in (0.0, 0.3):
        law = calculix.Material(5.0, poisson, finite=True)

        def slopes(t):
            volume, trace = stretch * t * t, stretch**2 + 2 * t * t
            distortion = law.shear / 2 * volume ** (-2 / 3)
            pressure = law.bulk * (volume - 1)
            return (distortion * (4 * t - 2 / 3 * trace * 2 / t) + pressure * 2 * stretch * t,
                    distortion * (2 * stretch - 2 / 3 * trace / stretch) + pressure * t * t)

        low, high = 0.3, 1.5
        while high - low > 1e-13:
            t = 0.5 * (low + high)
            low, high = (t, high) if slopes(t)[0] < 0 else (low, t)
        u, force = pulled(folder, [law], (stretch - 1) * LENGTH)
        z, y, x = np.meshgrid(*(np.arange(n) for n in NODES[::-1]), indexing="ij")
        exact = np.stack([(t - 1) * x, (t - 1) * y, (stretch - 1) * z], -1)
        require_near(u, exact, 1e-5, "neo-Hooke, Poisson's ratio %g: displacement" % poisson)
        require_near(force[-1, ..., 2].sum(), slopes(t)[1] * AREA, 1e-3, "neo-Hooke, Poisson's ratio %g: force" % poisson)


def two_materials(folder):
    """Springs in a row: three cubes' length of one, five of the other. No Poisson's ratio, so nothing bends."""
    material = np.zeros([n - 1 for n in NODES[::-1]], int)
    material[3:] = 1
    u, force = pulled(folder, [calculix.Material(2.0, 0.0), calculix.Material(200.0, 0.0)], 1.0, material)
    stress = 1.0 / (3 / 2.0 + 5 / 200.0)
    along = np.concatenate([np.arange(4) * stress / 2.0, 3 * stress / 2.0 + np.arange(1, 6) * stress / 200.0])
    require_near(u[..., 2], along[:, None, None], 1e-6, "two materials: displacement")
    require_near(force[-1, ..., 2].sum(), stress * AREA, 1e-5, "two materials: force")


def turned(folder):
    """Large displacements: a body that is turned by a right angle is not strained. All nodes of the surface are turned; the
    inner ones, and the absence of any force, are for CalculiX to find."""
    z, y, x = np.meshgrid(*(np.arange(n) for n in NODES[::-1]), indexing="ij")
    angle = math.pi / 2
    target = np.stack([math.cos(angle) * x - math.sin(angle) * y - x, math.sin(angle) * x + math.cos(angle) * y - y, 0 * z], -1)
    surface = np.ones(NODES[::-1], bool)
    surface[1:-1, 1:-1, 1:-1] = False
    prescribed = [(int(node), axis, float(target.reshape(-1, 3)[node, axis])) for node in np.flatnonzero(surface)
                  for axis in range(3)]
    u, force = calculix.solve(folder, NODES, [calculix.Material(5.0, 0.3, finite=True)],
                              np.zeros([n - 1 for n in NODES[::-1]], int), prescribed)
    require_near(u, target, 1e-4, "turned: displacement")
    require_near(force, 0.0, 1e-3, "turned: force")


if not calculix.available():
    print("SKIPPED: CalculiX is not there (on Debian the package calculix-ccx)")
    sys.exit(SKIPPED)
with tempfile.TemporaryDirectory() as folder:
    for test in (hooke, neo_hooke, two_materials, turned):
        test(folder)
