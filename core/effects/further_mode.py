"""One more mode of the body that no computed mode was matched to: part of it, not an effect.

Law         one more decaying motion with a pitch, a damping ratio and a shape of its own
Tells       a pole that is no overtone, no combination and no double of a known one
Looks like  an overtone or a combination tone when its pitch happens to be there
Source      Ewins, Modal Testing (2000), 4.4: residual modes
"""

import numpy as np

from .base import Effect, ring

STRAY = 0.05  # relative, that its pitch may move


def further_mode(frequency: float, damping_ratio: float) -> Effect:
    """The mode heard at `frequency` Hz; theta = (log of its pitch over that, damping ratio)."""

    def columns(theta, setting, time, u):
        omega = 2 * np.pi * frequency * np.exp(theta[:, 0])[:, None]
        return ring(omega, theta[:, 1][:, None], time)

    return Effect(
        name=f"mode at {frequency:.3g} Hz",
        layer="mode",
        parameters=(),
        twins=(),
        settle="",
        low=(-STRAY, 1e-4),
        high=(STRAY, 0.4),
        starts=lambda setting, residual: [(0.0, damping_ratio)],
        columns=columns,
    )
