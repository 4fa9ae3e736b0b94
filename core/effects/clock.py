"""The capture rate is not what was declared: all time is stretched.

Law         f_seen = f / c, c how many times as fast as declared the camera ran
Tells       the sag that the weight makes does not fit the pitch: neither knows Young's modulus
            beforehand, but their product does not depend on it
Looks like  Young's modulus, exactly, without gravity; relaxation, whose sag is larger too
Source      Rayleigh, The Theory of Sound, vol. 1, 182: the sag under own weight gives the pitch
"""

import numpy as np

from ..elasticity import gravity_force, static
from .base import Effect, Family, Parameter, reduced_basis

SLOWEST, FASTEST = 0.02, 50.0  # times the declared rate: slow motion played at 25 of 1000 frames/s


def families(body, solve):
    """The same body with another second; theta = log of c. None of them where no sag is seen."""
    gravity = body.case.takes[0].gravity
    if body.case.shape != "unloaded" or gravity is None:
        return ()
    modes = body.modes.shapes.reshape(-1, body.modes.shapes.shape[2])
    sag = static(body.model, gravity_force(body.model, gravity), 1.0)
    basis = reduced_basis([modes, sag.reshape(-1, 1)], body.model.mass)
    K, M = basis.T @ (body.model.stiffness @ basis), np.eye(basis.shape[1])
    grid = np.log(np.geomspace(SLOWEST, FASTEST, 120))[:, None]
    one = Family(
        basis,
        lambda theta: (K, M * np.exp(2 * theta[0])),
        grid,
        np.log([SLOWEST]),
        np.log([FASTEST]),
        lambda theta, youngs_modulus: {"factor": float(np.exp(theta[0]))},
    )
    return (one,)


EFFECT = Effect(
    name="clock",
    layer="modal",
    parameters=(Parameter("factor", "1", SLOWEST, FASTEST),),
    twins=("relaxation",),
    settle="film a running clock, and look up the capture rate in the camera's settings",
    families=families,
)
