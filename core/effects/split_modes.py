"""Two nearly equal modes where the symmetric model has a degenerate pair.

Law         a second mode at f (1 + s) in another direction; the split is the distance over the mean
Tells       slow beating, a motion that turns
Looks like  anything that depends on amplitude, when the second direction is not seen
Source      Rayleigh, The Theory of Sound, vol. 1, 221 a (split modes of bells)
"""

from dataclasses import replace

import numpy as np

from .base import FAINT, Effect, Parameter, companion, ring
from .partner import SPREAD

NOTHING = 1.3  # misfit per sample
ALIKE = 1.5  # ratio of the damping ratios of two modes of one material, at most


def columns(theta, setting, time, u):
    """cos and sin of the second mode with free shapes; theta = (split, damping ratio)."""
    omega = setting.omega[0] * (1 + theta[:, 0])[:, None]
    return ring(omega, theta[:, 1][:, None], time)


def veto(found):
    """A companion of the same shape is no second direction: it mimics what follows amplitude."""
    theta = found.theta[-1][0]
    split = report(theta, replace(found.law.setting, pitch=found.frequency[0]), None)["split"]
    at, own = len(found.parameters) - len(theta), found.covariance
    variance = own[at, at] + own[0, 0] - 2 * own[at, 0]  # of the split: logarithms of pitches
    spread = np.sqrt(max(variance * max(found.chi2 / found.samples, 1.0), 0.0))
    if split - FAINT * spread < SPREAD + (found.law.setting.gap or 0.0):
        return "both may have one pitch"
    return "" if _other_way(found, theta[1]) else companion(found, 0)


def _other_way(found, z: float) -> bool:
    """Whether it may be another direction that one camera sees as the same shape: as a mode of
    the same material it is damped alike, and it leaves nothing.
    """
    alike = abs(np.log(z / max(found.damping_ratio[0], 1e-6))) < np.log(ALIKE)
    flat = found.law.setting.towards is not None
    return flat and alike and found.chi2 < NOTHING * found.samples


def _both(theta, setting, first: float) -> np.ndarray:
    """(2,) Hz"""
    return np.array([first, setting.omega[0] / (2 * np.pi) * (1 + theta[0])])


def report(theta, setting, shape):
    """The distance of the two pitches over their mean."""
    both = _both(theta, setting, setting.pitch or setting.omega[0] / (2 * np.pi))
    return {"split": float(np.ptp(both) / both.mean())}


def middle(found) -> float:
    """Pitch midway between the first mode and its split partner, over the first's; 1 without one.

    A symmetric body's modulus is that of the pair: what parts it puts one up and one down.
    """
    names = [effect.name for effect in found.law.effects]
    if EFFECT.name not in names:
        return 1.0
    theta, first = found.theta[names.index(EFFECT.name)][0], found.frequency[0]
    return float(_both(theta, found.law.setting, first).mean() / first)


EFFECT = Effect(
    name="split_modes",
    layer="time",
    parameters=(Parameter("split", "1", -0.15, 0.15, 0.01),),
    twins=("tracker_drift",),
    settle="pull it along each of its two axes of symmetry and release: each rings alone",
    low=(-0.17, 1e-4),
    high=(0.17, 0.3),
    starts=lambda setting, residual: [
        (s, float(np.clip(setting.zeta[0], 0.003, 0.2))) for s in (-0.08, -0.02, 0.02, 0.08)
    ],
    columns=columns,
    of_release=True,
    veto=veto,
    requires=lambda setting, takes: "" if setting.paired else "no degenerate pair",
    report=report,
)
