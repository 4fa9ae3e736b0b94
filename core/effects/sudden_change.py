"""The body gives way all at once: a crack, a slip in the clamp, a marker's card that falls off.

Law         K -> K (1 + c) at an instant T
Tells       every pitch jumps at one instant, and stays there
Looks like  stiffness_drift, large_amplitude: what it is weighed against, being no effect to bake
Source      Friswell and Mottershead, Finite Element Model Updating (1995), 1.3: damage
"""

import numpy as np

from .base import Effect

RISE = 0.25  # of the first period


def acceleration(theta, setting):
    """theta = (relative change of stiffness, instant over the longest fitted part)."""
    rise = RISE * 2 * np.pi / setting.omega[0]
    begun = theta[:, 1] * setting.duration - 0.5 * rise
    stiffness = -(setting.omega[:, None] ** 2) * theta[:, 0]

    def push(state):
        after = np.minimum(np.maximum((state.t - begun) / rise, 0.0), 1.0)
        return after * stiffness * state.u

    return push


FOIL = Effect(
    name="sudden change of stiffness",
    layer="time",
    parameters=(),
    twins=("stiffness_drift",),
    settle="look for a crack, a slipping clamp or a part that came loose",
    low=(-0.6, 0.02),
    high=(1.5, 0.98),
    starts=lambda setting, residual: [
        (change, when) for when in np.linspace(0.1, 0.9, 9) for change in (-0.05, 0.05)
    ],
    acceleration=acceleration,
)
