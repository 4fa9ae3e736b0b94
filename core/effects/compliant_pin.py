"""The support gives: springs where the model holds rigidly.

Law         traction = k displacement on the pinned surface
Tells       the lower pitches drop most, the shape slopes at its root
Looks like  graded_stiffness, added_mass; a marker near the root settles it
Source      Ewins, Modal Testing (2000), 3.2: no support is rigid
"""

import numpy as np

from ..data import replace
from ..elasticity import surface_springs
from .base import Effect, Family, Parameter, reduced_basis

STIFFNESSES = (0.3, 2.0, 10.0, 50.0, 400.0)  # Young's moduli over the body's size


def change_model(model, theta):
    """The body let go, on springs of theta[0] Young's moduli per metre."""
    loose = replace(model, pinned=np.zeros(len(model.points), bool))
    mu, bed = 2 * (1 + model.material.poisson_ratio), surface_springs(model, model.pinned)
    return replace(loose, shear=model.shear + mu * theta[0] * bed)


def families(body, solve):
    """Beds from soft to nearly rigid; theta = log of the bed's stiffness over the modulus, 1/m."""
    model = body.model
    size = np.linalg.norm(np.ptp(model.points, axis=0))
    bed = surface_springs(model, model.pinned)
    modes = body.modes.shapes.reshape(-1, body.modes.shapes.shape[2])
    parts = [modes] + [solve(change_model(model, (s / size,)), 10) for s in STIFFNESSES]
    basis = reduced_basis(parts, model.mass)
    K, B = basis.T @ (model.stiffness @ basis), basis.T @ (bed @ basis)
    M = np.eye(basis.shape[1])
    grid = np.log(np.geomspace(STIFFNESSES[0], STIFFNESSES[-1] * 3, 22) / size)[:, None]
    one = Family(
        basis,
        lambda theta: (K + np.exp(theta[0]) * B, M),
        grid,
        grid[0],
        grid[-1] + 2,
        lambda theta, young: {"stiffness": float(np.exp(theta[0]) * young)},
    )
    return (one,)


EFFECT = Effect(
    name="compliant_pin",
    layer="modal",
    parameters=(Parameter("stiffness", "N/m3", 0.0, 1e15),),
    twins=("graded_stiffness", "added_mass"),
    settle="stick a marker on the object right beside the support, and one on the support",
    change_model=change_model,
    families=families,
)
