"""How much too stiff a mesh rings, and what it would ring at if it were infinitely fine.

The same tetrahedra with quadratic and with cubic displacements give eigenvalues λ₂ and λ₃ whose
gap shrinks with every order; what is left beyond λ₃ is estimated as 0.35 ± 0.3 of the gap. That
factor is what bars, cones and leaves of 400 to 3,500 tetrahedra at ν = 0.3 and 0.48 show against
cubic elements on refined meshes: 0.1 where all is smooth, up to 0.8 where a clamped rim rules.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.optimize import linear_sum_assignment

from .data import ElasticModel, Modes, TetMesh
from .eigen import improved_eigenpairs, lowest_eigenpairs
from .elements import ELEMENTS
from .elements.simplex import gradients
from .factorization import factorize
from .interpolate import interpolation
from .modes import solve_modes

BEYOND, UNSURE = 0.35, 0.3  # of λ₂ - λ₃: how far the limit lies below λ₃
FLOOR = 1e-3  # relative: what pins and rounding of the geometry leave open
DIRECT = 9_000  # unknowns up to which the cubic eigenproblem is simply solved
STEPS = 8  # beyond that: each halves what is left of λ₂ - λ₃
SPARE = 4  # modes more than asked, so that those which swap places are found

Build = Callable[[TetMesh, str], ElasticModel]  # the held and loaded body with an element


@dataclass(frozen=True, eq=False)
class Converged:
    """Mesh-converged lowest eigenvalues at Y = 1 Pa, one standard deviation, and their shapes."""

    values: np.ndarray  # (m,) 1/s2
    sigma: np.ndarray  # (m,) 1/s2
    model: ElasticModel  # the quadratic one
    modes: Modes  # (m,) of it


def converged_eigenvalues(build: Build, mesh: TetMesh, count: int) -> Converged:
    """Limit of the lowest `count` eigenvalues (and a few more) under refinement of `mesh`.

    `build(mesh, element)` returns the held, loaded model, so that every order of element gets the
    same pins and loads.
    """
    coarse, fine = build(mesh, "p2"), build(mesh, "p3")
    count = min(count + SPARE, coarse.free.size - 1)
    K, M, places = _free(coarse)
    repeats = 4 if coarse.pinned.any() else 8
    quadratic, x = lowest_eigenpairs(K, M, count, places, multiplicity=repeats)
    up = nested_interpolation(coarse, fine)
    K3, M3, places3 = _free(fine)
    if len(places3) <= DIRECT:
        cubic, _ = lowest_eigenpairs(K3, M3, count, places3, multiplicity=repeats)
    else:
        up = up[fine.free][:, coarse.free].tocsr()
        solve = factorize(K, places).solve if coarse.pinned.any() else _shifted(K, M, places)
        smooth = 1 / K3.diagonal()[:, None]
        cubic, _ = improved_eigenpairs(
            K3, M3, up @ x, lambda r: up @ solve(up.T @ r) + smooth * r, steps=STEPS
        )
    gap = quadratic - cubic  # below nought where the finer points hold more of a pin's rim
    sigma = np.hypot(UNSURE * np.abs(gap), FLOOR * cubic)
    shapes = np.zeros((3 * len(coarse.points), count))
    shapes[coarse.free] = x
    frequency = np.sqrt(np.maximum(quadratic, 0)) / (2 * np.pi)
    modes = Modes(frequency, shapes.reshape(-1, 3, count))
    return Converged(cubic - BEYOND * np.maximum(gap, 0), sigma, coarse, modes)


def _free(model: ElasticModel):
    free = model.free
    places = np.repeat(model.points, 3, axis=0)[free]
    return model.stiffness[free][:, free], model.mass[free][:, free], places


def _shifted(K: sparse.csr_matrix, M: sparse.csr_matrix, places: np.ndarray):
    return factorize(K + 1e-6 * K.diagonal().sum() / M.diagonal().sum() * M, places).solve


def nested_interpolation(coarse: ElasticModel, fine: ElasticModel) -> sparse.csr_matrix:
    """(3P fine, 3P coarse): the fine element's points in the coarse one, on the same tetrahedra."""
    cells = ELEMENTS[fine.element].cells(fine.mesh)
    tet, local = np.empty(len(fine.points), int), np.empty(len(fine.points), int)
    tet[cells], local[cells] = np.arange(len(cells))[:, None], np.arange(cells.shape[1])
    _, g = gradients(fine.mesh.nodes, fine.mesh.tets[tet])
    offset = fine.points - fine.mesh.nodes[fine.mesh.tets[tet]].mean(axis=1)
    return interpolation(coarse, tet, 0.25 + np.einsum("nki,ni->nk", g, offset))


def stiffening(
    model: ElasticModel, modes: Modes, converged: Converged
) -> tuple[np.ndarray, np.ndarray]:
    """λ / λ_converged - 1 (m,) and its standard deviation (m,) of each of the model's modes.

    `modes` at Y = 1 Pa. A mode is compared with the converged one of the same shape, because a
    coarse mesh may put two modes in the wrong order.
    """
    alike = likeness(model, modes, converged)
    known = min(alike.shape)
    partner = np.empty(alike.shape[0], int)
    rows, columns = linear_sum_assignment(-alike)
    partner[rows] = columns
    if known < alike.shape[0]:
        partner[np.setdiff1d(np.arange(alike.shape[0]), rows)] = known - 1
    limit = converged.values[partner]
    ratio = (2 * np.pi * modes.frequency) ** 2 / limit
    return ratio - 1, ratio * converged.sigma[partner] / limit


def moved(model: ElasticModel, modes: Modes, other: ElasticModel) -> np.ndarray:
    """|λ' / λ - 1| (m,) of each mode of `model` in another model on the same points."""
    x = modes.shapes.reshape(-1, modes.shapes.shape[2])
    there = solve_modes(other, x.shape[1])
    alike = (x.T @ (model.mass @ there.shapes.reshape(x.shape))) ** 2
    rows, columns = linear_sum_assignment(-alike)
    return np.abs((there.frequency[columns] / modes.frequency[rows]) ** 2 - 1)


def likeness(model: ElasticModel, modes: Modes, converged: Converged) -> np.ndarray:
    """MAC (m, k) between the model's modes and the converged ones, in the middles of the tets."""
    volume, _ = gradients(model.mesh.nodes, model.mesh.tets)
    middles = np.full((len(volume), 4), 0.25)
    weight = np.repeat(np.sqrt(volume), 3)[:, None]
    everyone = np.arange(len(volume))
    a, b = (
        weight * (interpolation(m, everyone, middles) @ s.reshape(-1, s.shape[2]))
        for m, s in ((model, modes.shapes), (converged.model, converged.modes.shapes))
    )
    return (a.T @ b) ** 2 / np.outer((a**2).sum(0), (b**2).sum(0))
