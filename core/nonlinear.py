"""Neo-Hookean equilibrium under a dead load, and the stiffness about it.

W(F) = μ/2 (J^(-2/3) F:F - 3) + κ/2 (J - 1)², J = det F. Its small strains are those of the linear
model, element by element: the first term lives where the element takes its deviatoric strain, the
second where it takes its volumetric one, so that what does not lock linearly does not lock here.

Source      Simo & Miehe, Comp. Meth. Appl. Mech. Eng. 98 (1992); Nocedal & Wright, Numerical
            Optimization, 2nd ed., ch. 3 (Newton with line search)
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from .data import ElasticModel, replace
from .elasticity import loose_motions
from .elements import ELEMENTS
from .elements.simplex import averages, each_axis, gradients, quadrature
from .errors import DataError
from .factorization import factorize
from .interpolate import gradient_at

STEPS = 60  # Newton steps before giving up
TOLERANCE = 1e-9  # force left over, in the load
ARMIJO = 1e-4


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """Where a body comes to rest, and its stiffness there."""

    displacement: np.ndarray  # (P, 3) m
    stiffness: sparse.csr_matrix  # (3P, 3P) N/m, tangent, at the modulus asked for
    energy: float  # J, elastic
    steps: int


@dataclass(frozen=True, eq=False)
class StrainPoints:
    """Where an element takes one part of its strain."""

    gradient: sparse.csr_matrix  # (9D, 3P) 1/m: ∂u_i/∂x_j of the D points, i slow, j fast
    volume: np.ndarray  # (D,) m3 that each stands for


def equilibrium(
    model: ElasticModel, force: np.ndarray, youngs_modulus: float, start: np.ndarray | None = None
) -> Equilibrium:
    """Rest position under `force` (3P,) N, dead in direction, by Newton with a line search.

    `start` (P, 3) m. Where the tangent is not positive definite it is shifted until it is, so every
    step goes down in energy. Raises DataError when a rigid motion is left free or no rest is found.
    """
    if loose_motions(model):
        raise DataError("equilibrium: the pins leave the body free to move. Pin an area.")
    parts = strain_points(model)
    nu, free = model.material.poisson_ratio, model.free
    moduli = youngs_modulus / (2 * (1 + nu)), youngs_modulus / (3 * (1 - 2 * nu))
    places = np.repeat(model.points, 3, axis=0)[free]
    u = np.zeros(model.points.size) if start is None else np.array(start, float).ravel()
    goal = TOLERANCE * np.linalg.norm(force[free]) + _rounding(parts, moduli)
    # J: a few of the last digits of F:F - 3 at every point, however little energy is in it; those
    # of (J - 1)² are as small as that energy
    unsure = 1e-15 * moduli[0] * parts[0].volume.sum()

    def total(v: np.ndarray) -> float:
        return elastic_energy(parts, moduli, v) - force @ v

    for step in range(STEPS):
        inner, K = forces_and_tangent(parts, moduli, u)
        rest = (force - inner)[free]
        if np.linalg.norm(rest) <= goal:
            energy = elastic_energy(parts, moduli, u)
            return Equilibrium(u.reshape(-1, 3), K, energy, step)
        move = np.zeros_like(u)
        move[free] = _downhill(K[free][:, free], rest, places)
        u = u + _line_search(total, u, move, rest @ move[free], unsure) * move
    raise DataError(
        f"equilibrium: no rest found in {STEPS} steps; the load is too large for the stiffness. "
        "Give a larger Young's modulus or a smaller gravity."
    )


def _downhill(K: sparse.csr_matrix, rest: np.ndarray, places: np.ndarray) -> np.ndarray:
    """(K + τ D) x = rest with the least τ of 0, 1e-3, 1e-2 ... that makes it positive definite."""
    D = sparse.diags(np.abs(K.diagonal()))
    for tau in (0.0, *10.0 ** np.arange(-3, 4)):
        try:
            move = factorize((K + tau * D).tocsr(), places).solve(rest)
        except DataError:
            continue
        if rest @ move > 0:  # the fallback factorization does not refuse indefinite matrices
            return move
    raise DataError("equilibrium: the tangent stiffness has no positive neighbour. Check the mesh.")


def _rounding(parts: tuple, moduli: tuple) -> float:
    """N: the force that the last digits of the strains make."""
    return sum(
        1e-15 * modulus * np.linalg.norm(abs(part.gradient).T @ np.repeat(part.volume, 9))
        for part, modulus in zip(parts, moduli, strict=True)
    )


def _line_search(
    total: Callable, u: np.ndarray, move: np.ndarray, slope: float, unsure: float
) -> float:
    """Step length that lowers the energy by its share (Armijo), halved from 1; by what the energy
    is `unsure` (J) it may rise.
    """
    here, length = total(u), 1.0
    rounding = 1e-13 * (abs(here) + abs(slope)) + unsure
    while not total(u + length * move) <= here - ARMIJO * length * slope + rounding:
        length /= 2
        if length < 1e-10:
            raise DataError("equilibrium: no step lowers the energy. Check mesh and load.")
    return length


def at_equilibrium(model: ElasticModel, rest: Equilibrium, youngs_modulus: float) -> ElasticModel:
    """The model whose stiffness, times `youngs_modulus`, is the tangent at `rest`."""
    share = 2 * (1 + model.material.poisson_ratio) / youngs_modulus
    return replace(model, shear=rest.stiffness * share, bulk=model.bulk * 0.0)


def is_nonlinear(model: ElasticModel) -> bool:
    """Whether the model's element has a nonlinear form."""
    return not ELEMENTS[model.element].mixed and model.element != "dg"


def strain_points(model: ElasticModel) -> tuple[StrainPoints, StrainPoints]:
    """Where the model's element takes its deviatoric and its volumetric strain.

    Raises DataError for a discontinuous or mixed element, which has no such points.
    """
    element, mesh = ELEMENTS[model.element], model.mesh
    if not is_nonlinear(model):
        raise DataError(
            f'equilibrium: element "{model.element}" has no nonlinear form. Use p1_smoothed or p2.'
        )
    volume, _ = gradients(mesh.nodes, mesh.tets)
    bary, weight = quadrature(3, 2 * (element.degree - 1))
    tet = np.tile(np.arange(len(volume)), len(weight))
    cells, g = gradient_at(model, tet, np.repeat(bary, len(volume), axis=0))
    n, k = cells.shape
    columns, starts = np.repeat(cells, 3, axis=0), np.arange(0, 3 * n * k + 1, k)
    scalar = sparse.csr_matrix(
        (g.transpose(0, 2, 1).ravel(), columns.ravel(), starts), shape=(3 * n, len(model.points))
    )
    if not element.domains:
        both = StrainPoints(_nine(scalar), np.outer(weight, volume).ravel())
        return both, both
    shear, bulk = (averages(d, volume) for d in element.domains(mesh))
    return tuple(
        StrainPoints(_nine(each_axis(mean) @ scalar), size) for mean, size in (shear, bulk)
    )


def _nine(scalar: sparse.csr_matrix) -> sparse.csr_matrix:
    """(9D, 3P) of all displacement gradients from (3D, P) of one component."""
    points = scalar.shape[0] // 3
    nine = sparse.kron(scalar, sparse.eye(3), format="csr")  # j slow, i fast
    order = np.arange(9).reshape(3, 3).T.ravel()
    return nine[(9 * np.arange(points)[:, None] + order).ravel()]


def elastic_energy(parts: tuple, moduli: tuple, u: np.ndarray) -> float:
    """J at displacement u (3P,); infinite where a strain point is turned inside out."""
    (shear, bulk), (mu, kappa) = parts, moduli
    F, G = (np.eye(3) + (p.gradient @ u).reshape(-1, 3, 3) for p in (shear, bulk))
    J = np.linalg.det(F)
    if J.min() <= 0:
        return np.inf
    iso = mu / 2 * (J ** (-2 / 3) * np.einsum("dij,dij->d", F, F) - 3)
    vol = kappa / 2 * (np.linalg.det(G) - 1) ** 2
    return float(shear.volume @ iso + bulk.volume @ vol)


def internal_force(parts: tuple, moduli: tuple, u: np.ndarray) -> np.ndarray:
    """(3P,) N at displacement u (3P,)."""
    force = 0
    for part, modulus, law in zip(parts, moduli, (isochoric, volumetric), strict=True):
        stress, _ = law(np.eye(3) + (part.gradient @ u).reshape(-1, 3, 3))
        force = force + part.gradient.T @ ((modulus * part.volume)[:, None, None] * stress).ravel()
    return force


def forces_and_tangent(parts: tuple, moduli: tuple, u: np.ndarray):
    """Internal force (3P,) N and tangent stiffness (3P, 3P) N/m at displacement u (3P,)."""
    force, tangent = 0, 0
    for part, modulus, law in zip(parts, moduli, (isochoric, volumetric), strict=True):
        F = np.eye(3) + (part.gradient @ u).reshape(-1, 3, 3)
        P, C = law(F)
        w = modulus * part.volume
        force = force + part.gradient.T @ (w[:, None, None] * P).ravel()
        d = len(F)
        blocks = sparse.bsr_matrix((w[:, None, None] * C, np.arange(d), np.arange(d + 1)))
        tangent = tangent + part.gradient.T @ (blocks.tocsr() @ part.gradient)
    return force, ((tangent + tangent.T) / 2).tocsr()


def isochoric(F: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """∂W/∂F (d, 3, 3) and ∂²W/∂F² (d, 9, 9) of W = ½ (J^(-2/3) F:F - 3)."""
    J, cofactor = _cofactor(F)
    H = cofactor / J[:, None, None]  # F^-T
    size = np.einsum("dij,dij->d", F, F)
    a = J ** (-2 / 3)
    P = a[:, None, None] * (F - size[:, None, None] / 3 * H)
    f, h = F.reshape(-1, 9), H.reshape(-1, 9)
    cross = f[:, :, None] * h[:, None, :]
    inner = np.eye(9) - 2 / 3 * (cross + cross.transpose(0, 2, 1))
    inner += (2 / 9 * size)[:, None, None] * h[:, :, None] * h[:, None, :]
    inner -= (size / 3)[:, None, None] * _inverse_slope(H)
    return P, a[:, None, None] * inner


def volumetric(F: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """∂W/∂F (d, 3, 3) and ∂²W/∂F² (d, 9, 9) of W = ½ (J - 1)²."""
    J, cofactor = _cofactor(F)
    c = cofactor.reshape(-1, 9)
    H = cofactor / np.where(J == 0, 1e-300, J)[:, None, None]
    h = H.reshape(-1, 9)
    curve = J[:, None, None] * (h[:, :, None] * h[:, None, :] + _inverse_slope(H))
    return (J - 1)[:, None, None] * cofactor, c[:, :, None] * c[:, None, :] + (J - 1)[
        :, None, None
    ] * curve


def _cofactor(F: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """det F (d,) and ∂det/∂F (d, 3, 3)."""
    a, b, c = F[:, 0], F[:, 1], F[:, 2]
    cofactor = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
    return np.einsum("di,di->d", a, cofactor[:, 0]), cofactor


def _inverse_slope(H: np.ndarray) -> np.ndarray:
    """∂F^-T/∂F (d, 9, 9): -H_il H_kj for entry (ij, kl)."""
    return -np.einsum("dil,dkj->dijkl", H, H).reshape(-1, 9, 9)
