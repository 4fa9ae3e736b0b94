"""Stiffness that depends on amplitude, the same both ways: stretching, or a softening gel.

Law         u'' + ... + w^2 u = -(8/3) w^2 s x^3 / (1 + q x^2/A^2), s the shift per metre2; q > 0
            levels off, q < 0 grows faster than a cube; at one place, or all over the body
Tells       the pitch follows the amplitude squared (backbone curve); a third harmonic
Looks like  stiffness_drift while there is one take; contact; a take of another size settles it
Source      Nayfeh and Mook, Nonlinear Oscillations (1979), 2.3: df/f = 3 k3 A^2 / (8 w^2)
"""

from dataclasses import replace

import numpy as np

from .base import Effect, Parameter, too_faint

# of q: what grows more steeply still is a stop, and what levels off sooner is no backbone
BENDS = (-0.6, 4.0)
SOFTEST = -0.95  # least relative change that leaves a stiffness
STEEPEST = 0.2  # least 1 + q x^2/A^2: the law has a pole where that is nought


def force(theta, setting):
    """Odd force at its place; theta = (pitch shift at the first amplitude by x^3, q)."""
    cubic = -(8 / 3) * (setting.omega[0] / setting.amplitude) ** 2 * theta[:, 0]
    bend = theta[:, 1] / setting.amplitude**2

    def push(state):
        x = state.x
        square = x * x
        return cubic * square * x / np.maximum(1 + bend * square, STEEPEST)

    return push


def acceleration(theta, setting):
    """The same where all of the body softens or stiffens by what all modes strain it: every mode in
    its own shape, x^2 the strain energy over that of the first one's swing of a metre. It never
    softens so far that nothing is left.
    """
    cubic = (8 / 3) / setting.amplitude**2 * theta[:, 0]
    bend = theta[:, 1] / setting.amplitude**2
    stiffness = setting.omega[:, None] ** 2
    energy = stiffness / stiffness[0] / setting.masses[:, None]

    def push(state):
        square = (energy * state.u**2).sum(axis=0)
        more = cubic * square / np.maximum(1 + bend * square, STEEPEST)
        return -np.maximum(more, SOFTEST) * stiffness * state.u

    return push


def report(theta, setting, shape):
    """1/m2 of the marker that moves most."""
    size = setting.amplitude * setting.reach
    return {"shift_per_metre2": theta[0] / size**2 * setting.stiffer}


EFFECT = Effect(
    name="large_amplitude",
    layer="time",
    bends=True,
    parameters=(Parameter("shift_per_metre2", "1/m2", -1e9, 1e9),),
    twins=("stiffness_drift", "contact"),
    settle="film a second take released from half, and one from twice, the amplitude",
    low=(-1.0, BENDS[0]),
    high=(1.5, BENDS[1]),
    starts=lambda setting, residual: [(0.03, 0.0), (0.03, -0.5), (0.03, 1.0)],
    force=force,
    scales=True,
    report=report,
    veto=too_faint,
)

OVERALL = replace(
    EFFECT,
    force=None,
    acceleration=acceleration,
    requires=lambda setting, takes: (
        "" if len(setting.couple) > 1 else "of one mode it is the same law"
    ),
)
