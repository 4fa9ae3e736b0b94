"""A viscoelastic branch (standard linear solid): the stiffness depends on rate, the mean creeps.

Law         u'' + ... + w^2 (u + r (u - s)) = 0, s' = (u - s)/T: w is the static pitch; real rubber
            has many times, of which a record may show two (`BRANCHED`)
Tells       after a release from a held pose the mean returns slowly, in the held shape
Looks like  asymmetric_stiffness, contact, tracker_drift; waiting longer before the release tells
Source      Christensen, Theory of Viscoelasticity (1982), 1.4; the standard linear solid
"""

from dataclasses import replace

import numpy as np

from .base import Effect, Parameter

SLOWEST = 2.0  # times the record that the return may take: an offset, beyond
SHORT = 0.5  # of its time that it was held before the release at least; who knows?


def columns(theta, setting, time, u):
    """The slow return exp(-t/T(1+r)) with a shape of its own; theta = log of its time, or times."""
    return np.exp(-time[:, :, None] / np.exp(theta)[:, None])


def starts(setting, residual):
    """From a period to the length of the record."""
    period = 2 * np.pi / setting.omega[0]
    return [(np.log(t),) for t in np.geomspace(0.7 * period, setting.duration, 4)]


def veto(found):
    """Faster than it swings it is damping; much slower than the record it is an offset."""
    time = np.exp(found.theta[-1][0])
    if time.max() > SLOWEST * found.law.setting.duration:
        return "much slower than the record"
    return "it is damping" if time.min() * found.law.setting.omega[0] < 1 else ""


def report(theta, setting, shape):
    """The branch's share of the pose it was let go from, held long before, and its own time.

    The slow return has that pose's shape, all modes in it, r to what swings back at once. Of two
    branches it is the stiffness of both, and the time of the stiffer one.
    """
    return _told(theta, _ratios(setting, shape))


def alike(theta, setting, shape):
    """What was not held for long has crept but a part of its way."""
    return [_told(theta, _ratios(setting, shape) / (1 - np.exp(-SHORT)))]


def _ratios(setting, shape):
    return np.abs(setting.pose @ shape) / (setting.pose @ setting.pose)


def _told(theta, ratios):
    first = np.argmax(ratios)
    return {"ratio": ratios.sum(), "time": np.exp(theta[first]) / (1 + ratios[first])}


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
    of_release=True,
    report=report,
    alike=alike,
    veto=veto,
)

BRANCHED = replace(EFFECT, low=2 * EFFECT.low, high=2 * EFFECT.high)
