"""A viscoelastic branch (standard linear solid): the stiffness depends on rate, the mean creeps.

Law         u'' + ... + w^2 (u + r (u - s)) = 0, s' = (u - s)/T: w is the static pitch
Tells       after a release from a held pose the mean returns slowly, in the held shape
Looks like  asymmetric_stiffness, contact, tracker_drift; waiting longer before the release tells
Source      Christensen, Theory of Viscoelasticity (1982), 1.4; the standard linear solid
"""

import numpy as np

from .base import Effect, Parameter


def columns(theta, setting, time, u):
    """The slow return exp(-t/T(1+r)) with a shape of its own; theta = log of its time."""
    slow = np.exp(theta[:, 0])
    return np.exp(-time / slow[:, None])[:, :, None]


def starts(setting, residual):
    """From a period to the length of the record."""
    period = 2 * np.pi / setting.omega[0]
    return [(np.log(t),) for t in np.geomspace(0.7 * period, setting.duration, 4)]


def report(theta, setting, shape):
    """The branch's share of the release and its own time; held long before it was let go."""
    ratio = abs(setting.reference[0] @ shape[:, 0]) / setting.release
    return {"ratio": ratio, "time": np.exp(theta[0]) / (1 + ratio)}


EFFECT = Effect(
    name="relaxation",
    layer="time",
    parameters=(Parameter("ratio", "1", 0.0, 10.0), Parameter("time", "s", 1e-3, 1e3)),
    twins=("asymmetric_stiffness", "contact", "tracker_drift"),
    settle="hold it for a minute before one release and for a moment before the next",
    low=(np.log(5e-3),),
    high=(np.log(60.0),),
    starts=starts,
    columns=columns,
    report=report,
    veto=lambda found: (
        "slower than the record"
        if np.exp(found.theta[-1][0][0]) > found.law.setting.duration
        else ""
    ),
)
