"""Own weight stiffens what hangs and softens what stands.

Law         K <- K + K_G(s), s the stress of the weight at rest
Tells       mode 1 shifts most; up when hanging, down when standing
Looks like  nothing but Young's modulus while one mode is seen one way up; turn it over
Source      Bathe, Finite Element Procedures (1996), 6.2: linearized initial stress
"""

import numpy as np

from ..data import replace
from ..elasticity import geometric_stiffness, gravity_force, static
from .base import Effect, Family, reduced_basis


def change_model(model, theta):
    """theta = (gx, gy, gz m/s2, Young's modulus Pa that carries the weight)."""
    return replace(model, stress=weight_stiffness(model, np.asarray(theta[:3])) / theta[3])


def weight_stiffness(model, gravity: np.ndarray):
    """(3P, 3P) N/m of the weight's stress, which no modulus changes."""
    return geometric_stiffness(model, static(model, gravity_force(model, gravity), 1.0))


def families(body, solve):
    """No parameter of its own; theta = log of the modulus that carries the weight, Pa."""
    gravity = body.case.takes[0].gravity
    if gravity is None:
        return ()
    model = body.model
    modes = body.modes.shapes.reshape(-1, body.modes.shapes.shape[2])
    basis = reduced_basis([modes], model.mass)
    K, G = basis.T @ (model.stiffness @ basis), basis.T @ (weight_stiffness(model, gravity) @ basis)
    M = np.eye(basis.shape[1])
    grid = np.log(np.geomspace(1e2, 1e9, 60))[:, None]
    one = Family(
        basis,
        lambda theta: (K + G * np.exp(-theta[0]), M),
        grid,
        grid[0],
        grid[-1],
        lambda theta, young: {},
        unknowns=0,
    )
    return (one,)


EFFECT = Effect(
    name="gravity_preload",
    layer="modal",
    parameters=(),
    twins=(),
    settle="turn it over and film again: what stiffened now softens",
    nonlinear=True,
    change_model=change_model,
    families=families,
)
