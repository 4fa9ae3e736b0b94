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
from .base import Effect, Family, Parameter, reduced_basis

RATIOS = (0.3, 0.6, 1.8, 3.5)
DEGREE = 4  # of the polynomial that stands for r^s; within 0.3 % for a ratio of ten
ALIKE = 0.98  # cosine from which two axes are one


def _along(model, axis):
    """(T,) place of each tetrahedron from the held end (0) to the far end (1) of `axis`."""
    s = model.points @ axis
    centres = model.mesh.nodes[model.mesh.tets].mean(axis=1) @ axis
    held = s[model.pinned].mean() if model.pinned.any() else s.min()
    if s.max() - held < held - s.min():
        s, centres, held = -s, -centres, -held
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
    return series.convert(kind=polynomial.Polynomial).coef


def family(body, solve):
    """Gradients along some axes; theta = (axis, form: linear or exponential, log of ratio)."""
    model = body.model
    axes = _axes(model)
    parts, ends = [body.modes.shapes.reshape(-1, body.modes.shapes.shape[2])], []
    for axis in axes:
        share = _along(model, axis)
        rows = [_scaled(model, 1 + share**n) for n in range(1, DEGREE + 1)]
        shear, bulk = rows[0].shear - model.shear, rows[0].bulk - model.bulk
        for by in np.array(RATIOS) - 1:
            graded = replace(model, shear=model.shear + by * shear, bulk=model.bulk + by * bulk)
            parts.append(solve(graded, 6))
        ends.append([one.stiffness - model.stiffness for one in rows])
    basis = reduced_basis(parts, model.mass)
    K = basis.T @ (model.stiffness @ basis)
    grown = np.array([[basis.T @ (end @ basis) for end in some] for some in ends])
    M = np.eye(basis.shape[1])

    def matrices(theta):
        axis, ratio = grown[int(theta[0])], np.exp(theta[2])
        if not theta[1]:
            return K + (ratio - 1) * axis[0], M
        terms = powers(ratio)
        return terms[0] * K + np.tensordot(terms[1:], axis, 1), M

    def report(theta, young):
        return {"ratio": float(np.exp(theta[2])), "axis": axes[int(theta[0])].tolist()}

    steps = np.log(np.geomspace(0.15, 6.5, 14))
    grid = np.array(list(product(range(len(axes)), (0, 1), steps)))
    low, high = np.array([0, 0, np.log(0.1)]), np.array([len(axes) - 1, 1, np.log(10.0)])
    return Family(basis, matrices, grid, low, high, report, frozen=2, unknowns=2)


EFFECT = Effect(
    name="graded_stiffness",
    layer="modal",
    parameters=(Parameter("ratio", "1", 0.0, 1e3), Parameter("axis", "1", -1.0, 1.0)),
    twins=("compliant_pin", "added_mass"),
    settle="hold it by the other end and film again",
    change_model=change_model,
    nothing=("ratio", 1.0),
    family=family,
)
