"""Finite elements of Neo-Hooke's material: what tissue does whose bones are moved, for large strains and rotations. Elements
are cubes with a node in each voxel of tissue, eight Gauss points, Newton's method, and scipy's conjugate gradients. Nothing in
it knows ChainMail.

Energy per volume, with F the gradient of the deformation and J its determinant (Bonet and Wood):
    mu / 2 (tr F'F - 3) - mu ln J + lambda / 2 (ln J)^2
Its limit for small strains is Hooke's law."""

import inspect

import numpy as np
import scipy.sparse
import scipy.sparse.linalg

CORNERS = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)])
TOLERANCE = "rtol" if "rtol" in inspect.signature(scipy.sparse.linalg.cg).parameters else "tol"
GAUSS = 0.5 + (CORNERS - 0.5) / np.sqrt(3.0)


def gradients(spacing):
    """Of the eight shape functions, at each Gauss point: [point, corner, axis]."""
    result = np.empty((8, 8, 3))
    for p, x in enumerate(GAUSS):
        values = np.where(CORNERS == 1, x, 1.0 - x)
        for axis in range(3):
            others = [a for a in range(3) if a != axis]
            result[p, :, axis] = (2 * CORNERS[:, axis] - 1) / spacing[axis] * values[:, others[0]] * values[:, others[1]]
    return result


def solve(tissue, young, poisson, spacing, held, places, gaps=None, tolerance=1e-7):
    """The displacements [voxel, axis] of all voxels [x, y, z] of tissue, given those of the held ones. `young` is the modulus
    of each voxel; an element has the mean of the soft ones among its corners. `gaps` [x, y, z] marks elements, by
    their first corners, that are left out, as where a blade went. Returns an array of the shape of the image."""
    numbers = np.full(tissue.shape, -1)
    numbers[tissue] = np.arange(tissue.sum())
    size = np.array(tissue.shape) - 1
    corners = np.stack([numbers[tuple(slice(c, c + n) for c, n in zip(corner, size))] for corner in CORNERS], -1).reshape(-1, 8)
    there = (corners >= 0).all(axis=1)
    cells = corners[there if gaps is None else there & ~gaps.reshape(-1)]
    fixed = held[tissue]
    cells = cells[~fixed[cells].all(axis=1)]
    modulus, is_soft = young[tissue][cells], ~fixed[cells]
    modulus = (modulus * is_soft).sum(axis=1) / is_soft.sum(axis=1)
    mu = modulus / (2.0 * (1.0 + poisson))
    bulk = modulus * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson))
    used = np.zeros(len(fixed), bool)
    used[cells] = True
    free = np.repeat(used & ~fixed, 3)
    rows = (3 * cells[:, :, None] + np.arange(3)).reshape(len(cells), 24)
    shape, weight = gradients(spacing), np.prod(spacing) / 8.0
    goal = places[tissue]
    u = np.zeros_like(goal)

    def assemble(u, with_matrix=True):
        force, blocks, energy = np.zeros((len(cells), 8, 3)), np.zeros((len(cells), 8, 3, 8, 3)), 0.0
        for g in shape:
            F = np.eye(3) + np.einsum("eci,cj->eij", u[cells], g)
            J = np.linalg.det(F)
            if (J <= 0.0).any():
                return np.inf, None, None
            G = np.einsum("cj,eji->eci", g, np.linalg.inv(F))  # gradients where the tissue is now
            log = np.log(J)
            energy += weight * (mu / 2 * ((F ** 2).sum(axis=(1, 2)) - 3) - mu * log + bulk / 2 * log ** 2).sum()
            force += weight * (mu[:, None, None] * np.einsum("eij,cj->eci", F, g) + ((bulk * log - mu)[:, None, None]) * G)
            if with_matrix:
                blocks += weight * np.einsum("e,ab,ij->eaibj", mu, g @ g.T, np.eye(3))
                blocks += weight * np.einsum("e,eai,ebj->eaibj", bulk, G, G)
                blocks -= weight * np.einsum("e,eaj,ebi->eaibj", bulk * log - mu, G, G)
        total = np.zeros(u.size)
        np.add.at(total, rows, force.reshape(len(cells), 24))
        if not with_matrix:
            return energy, total, None
        matrix = scipy.sparse.csr_matrix((blocks.ravel(), (np.repeat(rows, 24, axis=1).ravel(), np.tile(rows, (1, 24)).ravel())),
                                         shape=(u.size, u.size))
        return energy, total, matrix

    def correct(matrix, right):
        inner = matrix[free][:, free]
        scale = scipy.sparse.diags(1.0 / inner.diagonal())
        step, status = scipy.sparse.linalg.cg(inner, right[free], M=scale, maxiter=5000, **{TOLERANCE: 1e-6})
        assert status == 0, "conjugate gradients did not converge"
        return step

    # The held voxels go in one step; the tissue starts where Hooke's law puts it.
    _, _, matrix = assemble(u)
    u[fixed] = goal[fixed]
    flat = u.reshape(-1)
    flat[free] = correct(matrix, -(matrix @ flat))
    energy, force, matrix = assemble(u)
    assert np.isfinite(energy), "the first guess turns an element inside out: take smaller steps"
    for _ in range(30):
        step = correct(matrix, -force)
        share, start = 1.0, flat[free].copy()
        while True:
            flat[free] = start + share * step
            lower, force, _ = assemble(u, with_matrix=False)
            if lower <= energy + 1e-12 * abs(energy):
                break
            share /= 2.0
            assert share > 1e-6, "no step lowers the energy"
        energy, force, matrix = assemble(u)
        if np.abs(share * step).max() < tolerance * max(np.abs(goal).max(), 1e-300):
            break
    else:
        raise AssertionError("Newton's method did not converge")
    result = np.zeros(tissue.shape + (3,))
    result[tissue] = u
    return result
