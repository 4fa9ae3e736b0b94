"""The stiffness varies along the object: cured unevenly, filled, drier on one side.

Law         E(s) = E (1 + (r - 1) s) or E r^s, s on an axis from the held end (0) to the other (1)
Tells       ratios of pitches and the curvature of the shapes change
Looks like  compliant_pin, added_mass; a second way of holding it settles it
Source      Elishakoff, Eigenvalues of Inhomogeneous Structures (2005), ch. 1
"""

from itertools import product

import numpy as np
from numpy.polynomial import chebyshev, polynomial

from ..data import replace
from ..elasticity import assemble
from ..factorization import factorize
from .base import Effect, Family, Parameter, reduced_basis

TURNED, TURNS = 12, 3  # modes that the gradient turns, and how often
DEGREE = 4  # of the polynomial that stands for r^s; within 0.3 % for a ratio of ten
ALIKE = 0.98  # cosine from which two axes are one


def _outwards(model, axis: np.ndarray) -> np.ndarray:
    """`axis` (3,) or its opposite: from the held end to the far one."""
    s = model.points @ axis
    held = s[model.pinned].mean() if model.pinned.any() else s.min()
    return -axis if s.max() - held < held - s.min() else axis


def _along(model, axis):
    """(T,) place of each tetrahedron from the held end (0) to the far end (1) of `axis`."""
    axis = _outwards(model, axis)
    s = model.points @ axis
    centres = model.mesh.nodes[model.mesh.tets].mean(axis=1) @ axis
    held = s[model.pinned].mean() if model.pinned.any() else s.min()
    return np.clip((centres - held) / max(s.max() - held, 1e-12), 0, 1)


def change_model(model, theta):
    """theta = (ratio, axis x, y, z), by the linear law."""
    share = _along(model, np.asarray(theta[1:4], float))
    return _scaled(model, 1 + (theta[0] - 1) * share)


def _scaled(model, by):
    """The model with the stiffness of every tetrahedron multiplied by `by` (T,)."""
    scaled = assemble(model.mesh, model.material, model.element, stiffness_scale=by)
    return replace(model, shear=scaled.shear, bulk=scaled.bulk)


def _axes(model) -> np.ndarray:
    """(n, 3) the body's own axes, and those of the file where they are others."""
    own = np.linalg.svd(model.points - model.points.mean(axis=0), full_matrices=False)[2]
    return np.vstack([own, *(one for one in np.eye(3) if np.abs(own @ one).max() < ALIKE)])


def powers(ratio: float) -> np.ndarray:
    """(DEGREE + 1,) coefficients of s^n in r^s, as near as a polynomial comes on 0..1."""
    series = chebyshev.Chebyshev.interpolate(lambda s: ratio**s, DEGREE, domain=[0, 1])
    told = series.convert(kind=polynomial.Polynomial).coef
    return np.pad(told, (0, DEGREE + 1 - len(told)))  # it leaves out last ones that are nought


def families(body, solve):
    """Gradients along some axes, one an axis; theta = (form: linear or exponential, log of ratio).

    The basis of each is that of a Krylov space: what the gradient turns the modes into, again and
    again (Saad, Iterative Methods for Sparse Linear Systems, 2003, 6.2).
    """
    model, free = body.model, body.model.free
    modes = body.modes.shapes.reshape(-1, body.modes.shapes.shape[2])
    factor = factorize(model.stiffness[free][:, free], np.repeat(model.points, 3, axis=0)[free])
    return (_along_one(model, axis, modes, factor) for axis in _axes(model))


def _along_one(model, axis, modes, factor) -> Family:
    share, free = _along(model, axis), model.free
    ends = [_scaled(model, 1 + share**n).stiffness - model.stiffness for n in range(1, DEGREE + 1)]
    parts, turned = [modes], modes[:, :TURNED]
    for _ in range(TURNS):
        pushed, turned = ends[0] @ turned, np.zeros_like(turned)
        turned[free] = factor.solve(pushed[free])
        parts.append(turned)
    basis = reduced_basis(parts, model.mass)
    K, M = basis.T @ (model.stiffness @ basis), np.eye(basis.shape[1])
    grown = np.array([basis.T @ (end @ basis) for end in ends])

    def matrices(theta):
        ratio = np.exp(theta[1])
        if not theta[0]:
            return K + (ratio - 1) * grown[0], M
        terms = powers(ratio)
        return terms[0] * K + np.tensordot(terms[1:], grown, 1), M

    def report(theta, young):
        return {"ratio": float(np.exp(theta[1])), "axis": _outwards(model, axis).tolist()}

    grid = np.array(list(product((0, 1), np.log(np.geomspace(0.15, 6.5, 14)))))
    low, high = np.array([0, np.log(0.1)]), np.array([1, np.log(10.0)])
    return Family(basis, matrices, grid, low, high, report, frozen=1, unknowns=2)


EFFECT = Effect(
    name="graded_stiffness",
    layer="modal",
    parameters=(Parameter("ratio", "1", 0.0, 1e3), Parameter("axis", "1", -1.0, 1.0)),
    twins=("compliant_pin", "added_mass"),
    settle="hold it by the other end and film again",
    change_model=change_model,
    nothing=("ratio", 1.0),
    families=families,
)
