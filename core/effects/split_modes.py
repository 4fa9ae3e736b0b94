"""Two nearly equal modes where the symmetric model has a degenerate pair.

Law         a second mode at f (1 + s) in another direction; the split is the distance over the mean
Tells       slow beating, a motion that turns
Looks like  anything that depends on amplitude, when the second direction is not seen
Source      Rayleigh, The Theory of Sound, vol. 1, 221 a (split modes of bells)
"""

from dataclasses import replace

import numpy as np

from ..harmonic_inversion import invert
from .base import FAINT, Effect, Parameter, companion, ring
from .partner import SPREAD, another_motion

NOTHING = 1.1  # misfit per sample
OTHERS = 6  # swings at other pitches that may be left
WHIRL = 0.2  # of the second mode's motion, that it makes a quarter of a period off the rest


def columns(theta, setting, time, u):
    """cos and sin of the second mode with free shapes; theta = (split, damping ratio)."""
    omega = setting.omega[setting.pair] * (1 + theta[:, 0])[:, None]
    return ring(omega, theta[:, 1][:, None], time)


def veto(found):
    """A companion of the same shape is no second direction: it mimics what follows amplitude."""
    theta, k = found.theta[-1][0], found.law.setting.pair
    split = report(theta, replace(found.law.setting, pitches=found.frequency), None)["split"]
    at, own = len(found.parameters) - len(theta), found.covariance
    variance = own[at, at] + own[k, k] - 2 * own[at, k]  # of the split: logarithms of pitches
    spread = np.sqrt(max(variance * max(found.chi2 / found.samples, 1.0), 0.0))
    if split - FAINT * spread < SPREAD + (found.law.setting.pair_gap or 0.0):
        return "both may have one pitch"
    why = another_motion(found, k)
    if why:
        return why
    if _whirls(found):
        return "its second direction turns by itself: none of a body at rest does"
    return "" if _other_way(found) else companion(found, k)


def _whirls(found) -> bool:
    """Whether the last effect's motion is an ellipse: a spin parts a pair into two that turn."""
    data = found.law.takes[found.law.fitted[0]]
    size = np.linalg.svd(found.column_shapes()[-1] / data.sigma[:, None], compute_uv=False)
    return bool(size[1] ** 2 > WHIRL * (size**2).sum())


def _other_way(found) -> bool:
    """Whether it may be another direction that one camera sees as the same shape: it is damped
    alike, and it leaves nothing, or but what rings at other pitches.
    """
    flat = found.law.setting.towards is not None
    return flat and (found.chi2 < NOTHING * found.samples or _leaves_others(found))


def _leaves_others(found) -> bool:
    """Whether all that is left beside noise are swings at pitches beyond those of such a pair."""
    left, count = 0.0, 0
    for take, index in enumerate(found.law.fitted):
        data = found.law.takes[index]
        on, time = ~data.support, data.time[data.fit]
        rest = found.missed(take)[data.fit][:, on]
        rings = invert(time, rest, noise=data.sigma[on], max_modes=OTHERS)
        own = found.pitches(take)[found.law.setting.pair]
        if (np.abs(np.log(rings.frequency / own)) < EFFECT.high[0]).any():
            return False
        left += float(np.nansum(((rest - rings.predict(time)) / data.sigma[on]) ** 2))
        count += int(np.isfinite(rest).sum())
    return left < NOTHING * count


def _both(theta, setting, first: float) -> np.ndarray:
    """(2,) Hz"""
    return np.array([first, setting.omega[setting.pair] / (2 * np.pi) * (1 + theta[0])])


def report(theta, setting, shape):
    """The distance of the two pitches over their mean."""
    pitches = setting.omega / (2 * np.pi) if setting.pitches is None else setting.pitches
    both = _both(theta, setting, pitches[setting.pair])
    return {"split": float(np.ptp(both) / both.mean())}


def middle(found) -> float:
    """Pitch midway between a mode and its split partner, over that mode's; 1 without one.

    A symmetric body's modulus is that of the pair: what parts it puts one up and one down.
    """
    names = [effect.name for effect in found.law.effects]
    if EFFECT.name not in names:
        return 1.0
    theta, first = found.theta[names.index(EFFECT.name)][0], found.frequency[found.law.setting.pair]
    return float(_both(theta, found.law.setting, first).mean() / first)


def doubt(found) -> float:
    """Standard deviation, relative, of the pair's pitch: it may lie anywhere between the two."""
    return abs(middle(found) - 1) / np.sqrt(3)


EFFECT = Effect(
    name="split_modes",
    layer="time",
    parameters=(Parameter("split", "1", -0.15, 0.15, 0.01),),
    twins=("tracker_drift",),
    settle="pull it along each of its two axes of symmetry and release: each rings alone",
    low=(-0.17, 1e-4),
    high=(0.17, 0.3),
    starts=lambda setting, residual: [
        (s, float(np.clip(setting.zeta[setting.pair], 0.003, 0.2)))
        for s in (-0.08, -0.02, 0.02, 0.08)
    ],
    columns=columns,
    of_release=True,
    phased=True,
    parts=True,
    veto=veto,
    requires=lambda setting, takes: (
        "" if setting.paired and setting.symmetric else "no degenerate pair"
    ),
    report=report,
)
