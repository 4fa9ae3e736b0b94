"""A viscoelastic branch (standard linear solid): the stiffness depends on rate, the mean creeps.

Law         u'' + ... + w^2 (u + r (u - s)) = 0, s' = (u - s)/T: w is the static pitch; real rubber
            has many times, of which a record may show two (`BRANCHED`)
Tells       after a release from a held pose the mean returns slowly, in the held shape
Looks like  asymmetric_stiffness, contact, tracker_drift; waiting longer before the release tells
Source      Christensen, Theory of Viscoelasticity (1982), 1.4; the standard linear solid
"""

from dataclasses import replace

import numpy as np

from .base import Effect, Parameter, along_modes

SLOWEST = 2.0  # times the record that the return may take: an offset, beyond
LEAST = 1e-9  # of the pose that returns slowly
ALONE, MOSTLY = 0.95, 0.6  # of the return that is one marker's, where less of the swing is
SHORT = 0.5  # of its time that it was held before the release at least; who knows?


def columns(theta, setting, time, u):
    """The slow return exp(-t/T(1+r)) with a shape of its own; theta = log of its time, or times."""
    return np.exp(-time[:, :, None] / np.exp(theta)[:, None])


def carries(found, i, take):
    """How far the body still is from rest."""
    size, theta = along_modes(found, found.column_shapes(take)[i], take), found.theta[i]
    return lambda time: columns(theta, None, time[None], None)[0] @ size.T


def starts(setting, residual):
    """From a period to the length of the record."""
    period = 2 * np.pi / setting.omega[0]
    return [(np.log(t),) for t in np.geomspace(0.7 * period, setting.duration, 4)]


def veto(found):
    why = unseen(found.theta[-1][0], found.law.setting)
    if not why and _of_one_marker(found):
        return "one marker alone returns: it slides on the object"
    return why


def _of_one_marker(found) -> bool:
    """Whether nearly all of the return, in all takes together, is one marker's, and neither the
    swing nor the pose at the release is: a body returns in the shape that it was held in.
    """
    law = found.law
    count = max(int(law.takes[i].marker.max()) for i in law.fitted) + 1
    returned, swung, held = np.zeros((3, count))
    for take, index in enumerate(law.fitted):
        data = law.takes[index]
        weight = np.where(data.support, 0.0, data.sigma**-2.0)
        shapes, motion = found.shapes_of(take), found.motions[take]
        back = (found.column_shapes(take)[-1] ** 2).sum(axis=1)
        for total, square in (
            (returned, back),
            (swung, (motion.std(axis=0) @ np.abs(shapes)) ** 2),
            (held, (motion[0] @ shapes) ** 2),
        ):
            total += np.bincount(data.marker, weight * square, count)
    one = int(np.argmax(returned))
    alone = returned[one] > ALONE * returned.sum()
    return bool(alone and all(t[one] < MOSTLY * t.sum() for t in (swung, held)))


def unseen(theta, setting) -> str:
    """Why no record shows such times, or "": faster than it swings it is damping; much slower than
    the record it is an offset.
    """
    time = np.exp(theta)
    if time.max() > SLOWEST * setting.duration:
        return "much slower than the record"
    return "it is damping" if time.min() * setting.omega[0] < 1 else ""


def report(theta, setting, shape):
    """The branches' stiffness over the static one, and the time of the stiffest."""
    return _told(theta, returns(theta, setting, shape))


def alike(theta, setting, shape):
    """What was not held for long has crept but a part of its way."""
    if setting.blow is not None:
        return []
    return [_told(theta, returns(theta, setting, shape) / (1 - np.exp(-SHORT)))]


def returns(theta, setting, shape):
    """(q,) the slow returns over what swings at once, where the pose was held long before; a blow
    makes as much creep as that force in its moment, the rate of creep times what it does.

    A slow return has the shape of that pose, all modes in it.
    """
    if setting.blow is None:
        return np.abs(setting.pose @ shape) / (setting.pose @ setting.pose)
    return np.abs(setting.blow @ shape) / (setting.blow @ setting.blow) * np.exp(theta)


def branches(theta, returned):
    """Stiffnesses over the static one (q,) and times (q,) s of Maxwell's branches beside a spring.

    What returns by `returned` with the times exp(theta) is the creep 1 + sum returned_i /
    (1 + s exp(theta_i)), in Laplace's s; its inverse is that of the branches (Tschoegl, The
    Phenomenological Theory of Linear Viscoelastic Behavior, 1989, 4.1).
    """
    times, returned = np.exp(theta), np.maximum(returned, LEAST)
    rate = np.linalg.eigvals(np.diag(1 / times) + (returned / times)[:, None]).real
    slope = (returned * times / (1 - np.outer(rate, times)) ** 2).sum(axis=1)
    return (1 + returned.sum()) / (rate * slope), 1 / rate


def _told(theta, returned):
    stiff, time = branches(theta, returned)
    return {"ratio": stiff.sum(), "time": time[np.argmax(stiff)]}


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
    carries=carries,
    of_release=True,
    report=report,
    alike=alike,
    veto=veto,
)

BRANCHED = replace(EFFECT, low=2 * EFFECT.low, high=2 * EFFECT.high)
