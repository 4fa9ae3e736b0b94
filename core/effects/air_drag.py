"""Force against the motion that grows with speed squared: air, water.

Law         traction = c |v| v per unit of surface seen from the motion: c (n v) v where n v > 0
Tells       the damping ratio falls with the amplitude while the pitch stays
Looks like  dry_friction the other way round; an extra mode of the same shape
Source      Blevins, Flow-Induced Vibration (1990), ch. 6
"""

import numpy as np

from .base import Effect, Parameter, too_faint


def acceleration(theta, setting):
    """theta = inner coefficient times the first amplitude (1), spread over the skin.

    By its modal mass, what mode k feels of mode l is what l feels of k: half of them will do.
    """
    K, facing = len(setting.facing), setting.facing.T
    skin, wind = (one.reshape(K, 3, -1) for one in (setting.skin, setting.wind.T))
    first, second = np.triu_indices(K)
    whole = wind / setting.masses[:, None, None]
    # `wind` counts both sides for mode 1 alone
    work = 2 * np.einsum("pis,pis->ps", whole[first], skin[second])  # by a point's own speed
    pair = np.zeros((K, K), int)
    pair[first, second] = pair[second, first] = np.arange(len(first))
    strength = -np.outer(setting.masses, theta[:, 0]) / setting.amplitude

    def push(state):
        v = np.ascontiguousarray(state.v)
        into = facing @ v
        np.maximum(into, 0.0, out=into)
        felt = np.take(work @ into, pair, axis=0)
        felt *= v
        return strength * np.add.reduce(felt, 1)

    return push


def report(theta, setting, shape):
    """kg/m3: the inner coefficient (1/m) times modal mass over the surface that pushes air."""
    return {"coefficient": theta[0] / setting.amplitude * setting.modal_mass / setting.drag_area}


EFFECT = Effect(
    name="air_drag",
    layer="time",
    damps=True,
    parameters=(Parameter("coefficient", "kg/m3", 0.0, 1e5),),
    twins=("dry_friction",),
    settle="film a take of twice the amplitude, or one with a card fixed to the object",
    low=(0.0,),
    high=(5.0,),
    starts=lambda setting, residual: [(0.03,), (0.2,)],
    acceleration=acceleration,
    requires=lambda setting, takes: "" if setting.skin.size else "no computed mode fits",
    report=report,
    veto=too_faint,
)
