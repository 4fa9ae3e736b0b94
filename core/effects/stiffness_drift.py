"""The stiffness changes during the recording: warming, drying, fatigue.

Law         K(t) = K (1 + r t)
Tells       every pitch follows time, not amplitude
Looks like  large_amplitude and structural changes while there is one take
Source      Kevorkian and Cole, Multiple Scale Methods (1996), 4.3: slowly varying oscillators
"""

from .base import Effect, Parameter


def acceleration(theta, setting, state):
    """theta = relative change of stiffness over the longest fitted part."""
    rate = theta[:, 0] / setting.duration
    return -(rate * state.t)[:, None] * setting.omega**2 * state.u


def report(theta, setting, shape):
    """1/s"""
    return {"rate": theta[0] / setting.duration}


EFFECT = Effect(
    name="stiffness_drift",
    layer="time",
    parameters=(Parameter("rate", "1/s", -10.0, 10.0),),
    twins=("large_amplitude",),
    settle="film a second take of another amplitude: does the pitch follow time or amplitude?",
    low=(-0.6,),
    high=(2.0,),
    starts=lambda setting, residual: [(0.03,), (-0.03,)],
    acceleration=acceleration,
    report=report,
)
