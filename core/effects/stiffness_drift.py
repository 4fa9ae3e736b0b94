"""The stiffness changes during the recording: warming, drying, fatigue.

Law         K(t) = K (1 + r tau (1 - exp(-t / tau))): r at first, in time levelling off, or growing
Tells       every pitch follows time, not amplitude
Looks like  large_amplitude and structural changes while there is one take
Source      Kevorkian and Cole, Multiple Scale Methods (1996), 4.3: slowly varying oscillators
"""

import numpy as np

from .base import Effect, Parameter, too_faint

# of the fitted part over tau: what levels sooner follows the amplitude, what grows faster than
# by e within the recording is no drift
BENDS = (-1.0, 2.0)
SOFTEST = -0.95  # least relative change that leaves a stiffness


def acceleration(theta, setting):
    """theta = (the first rate, the bend) by the longest fitted part."""
    bend = np.where(np.abs(theta[:, 1]) < 1e-6, 1e-6, theta[:, 1])
    pace, rate = -bend / setting.duration, theta[:, 0] / bend
    stiffness = setting.omega[:, None] ** 2

    def push(state):
        less = np.minimum(rate * np.expm1(state.t * pace), -SOFTEST)
        return less * stiffness * state.u

    return push


def report(theta, setting, shape):
    """1/s"""
    return {"rate": theta[0] / setting.duration * setting.stiffer}


EFFECT = Effect(
    name="stiffness_drift",
    layer="time",
    parameters=(Parameter("rate", "1/s", -10.0, 10.0),),
    twins=("large_amplitude",),
    settle="film a second take of another amplitude: does the pitch follow time or amplitude?",
    low=(-0.6, BENDS[0]),
    high=(2.0, BENDS[1]),
    starts=lambda setting, residual: [(0.03, 0.0)],
    acceleration=acceleration,
    scales=True,
    grows=True,
    report=report,
    veto=too_faint,
)
