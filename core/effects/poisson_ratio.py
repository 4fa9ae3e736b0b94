"""The declared Poisson ratio is wrong.

Law         K = mu(nu) G + kappa(nu) B
Tells       torsion against bending, and all that squeezes; hardly seen in slender bending
Looks like  graded_stiffness; a twist of the object settles it
Source      Landau and Lifshitz, Theory of Elasticity (1986), 5
"""

import numpy as np

from ..data import replace
from .base import Effect, Family, Parameter, reduced_basis

VALUES = (0.05, 0.3, 0.42, 0.47, 0.495)


def change_model(model, theta):
    """theta = (nu,)."""
    return replace(model, material=replace(model.material, poisson_ratio=float(theta[0])))


def families(body, solve):
    """From cork to rubber; theta = nu."""
    model = body.model
    modes = body.modes.shapes.reshape(-1, body.modes.shapes.shape[2])
    others = [solve(change_model(model, (v,)), 10) for v in VALUES]
    basis = reduced_basis([modes, *others], model.mass)
    G, B = basis.T @ (model.shear @ basis), basis.T @ (model.bulk @ basis)
    stress = 0 if model.stress is None else basis.T @ (model.stress @ basis)
    M = np.eye(basis.shape[1])
    grid = np.r_[np.linspace(0.0, 0.44, 12), 0.46, 0.48, 0.49, 0.495][:, None]
    one = Family(
        basis,
        lambda theta: (G / (2 * (1 + theta[0])) + B / (3 * (1 - 2 * theta[0])) + stress, M),
        grid,
        np.array([0.0]),
        np.array([0.499]),
        lambda theta, young: {"value": float(theta[0])},
    )
    return (one,)


EFFECT = Effect(
    name="poisson_ratio",
    layer="modal",
    parameters=(Parameter("value", "1", 0.0, 0.5),),
    twins=("graded_stiffness",),
    settle="twist it and film, or squeeze it between plates and see how far it bulges",
    change_model=change_model,
    families=families,
)
