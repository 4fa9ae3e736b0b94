"""A stop, or a crack that closes, past a gap on one side.

Law         f = -k max(0, side x - gap) at the reference
Tells       the pitch drops to a constant once the amplitude falls below the gap; sharp harmonics
Looks like  large_amplitude, asymmetric_stiffness; with no gap relaxation
Source      Shaw and Holmes, J. Sound Vib. 90 (1983) 129: a periodically forced piecewise oscillator
"""

import numpy as np

from . import perspective
from .base import Effect, Parameter

LEAST_GAP = 0.02  # of the amplitude


def _side(side):
    def force(theta, setting):
        gap = side * theta[:, 0] * setting.amplitude
        stiffness = -(setting.omega[0] ** 2) * np.exp(theta[:, 1])
        beyond = np.maximum if side > 0 else np.minimum
        return lambda state: stiffness * beyond(0.0, state.x - gap)

    return force


def veto(found):
    """Without a gap it is but a body stiffer one way than the other."""
    return "there is no gap" if found.theta[-1][0][0] < LEAST_GAP else ""


def report(theta, setting, shape):
    """m at the marker that moves most."""
    return {"gap": theta[0] * setting.amplitude * setting.reach}


def _variant(side):
    return Effect(
        name="contact",
        layer="time",
        bends=True,
        parameters=(Parameter("gap", "m", 0.0, 10.0),),
        twins=("asymmetric_stiffness", "large_amplitude", "relaxation"),
        settle="film a take so small that nothing can touch, or hold a paper in the gap",
        low=(0.0, np.log(0.01)),
        high=(0.98, np.log(300.0)),
        starts=lambda setting, residual: [
            (gap, np.log(k)) for gap in (0.15, 0.4, 0.7) for k in (0.3, 6.0)
        ],
        force=_side(side),
        sudden=True,
        veto=veto,
        report=report,
        rival=perspective.instead,
    )


ABOVE = _variant(1.0)
BELOW = _variant(-1.0)
