"""Where the fit of a take begins: once what rings above all computed modes of the body has died, or
a burst of modes that are too many and too brief to be heard one by one.

A blow on a compact body, or a pull at a point of it, rings so many modes that they cannot all be
fitted. High ones die first, so the first frames are left out instead.
"""

import numpy as np

from .all_told import SAME, damps_alike
from .baseline import real_shapes
from .channels import Channels
from .data import RingDown, poles
from .match import ACROSS, mac
from .residual import NOISY, QUIET

FEW = 3  # of them, from which they are waited for; fewer are fitted as further modes
FADED = 3.0  # noise, of all channels together, that such a mode has died to
SPENT = 0.9  # nepers that the strongest mode may die by meanwhile
SHARE = 0.5  # of the fitted part that may be left out
BRIEF = 0.35  # of the strongest mode's period: what has died by then is no mode that can be heard
AFTER = 2.0  # periods that stay at least: less is fitted by almost anything
NEARLY = 0.8  # of what is left beyond noise, that lies within the first third of a swing


def outlived(data: Channels, ring: RingDown, known: RingDown, top: float) -> float:
    """s after the release at which what a take rings above `top` Hz has died away, or the strongest
    mode has died too far; 0 where little rings there. `known`: its modes that were matched.

    What acts in time makes overtones and companions, which move as the strongest mode does; what
    is counted moves otherwise, and is damped as the body's modes are.
    """
    on = ~data.support
    shapes, first = (real_shapes(one.amplitude[:, on])[0] for one in (ring, known))
    above = [
        k
        for k, (f, z) in enumerate(zip(ring.frequency, ring.damping_ratio, strict=True))
        if f > top
        and damps_alike(f, z, known.frequency, known.damping_ratio)
        and mac(shapes[k], first[0]) < SAME
    ]
    if len(above) < FEW:
        return 0.0
    decay = -poles(ring.frequency, ring.damping_ratio).real[above]
    loud = np.linalg.norm(ring.amplitude[above][:, on] / data.sigma[on], axis=1)
    silent = (np.log(np.maximum(loud / FADED, 1.0)) / decay).max()
    dying = -poles(known.frequency[:1], known.damping_ratio[:1]).real[0]
    return float(min(silent, SPENT / dying, SHARE * data.time[data.fit][-1]))


def brief(
    left: np.ndarray, time: np.ndarray, loud: np.ndarray, on: np.ndarray, period: float
) -> float:
    """A third of a swing, s since the release, where nearly all that a fit leaves of a take lies
    within that and is no motion of its `loud` modes; 0 elsewhere, or where too little stays.

    left (T, C): noise units, of the fitted part at `time` (T,) s; loud (m, C): their shapes in
    these units; on (C,) bool: channels on the object; the strongest mode is of `period` s.
    """
    early = time < BRIEF * period
    if not early.any() or time[-1] < (BRIEF + AFTER) * period:
        return 0.0
    over = np.nansum(left[:, on] ** 2 - 1)
    seen = np.isfinite(left[:, on])
    if over < (QUIET - 1) * seen.sum():
        return 0.0
    first, still = left[early][:, on], left[early][:, ~on]
    shaken = np.isfinite(still).any() and np.nanmean(still**2) > NOISY
    if shaken or np.nansum(first**2 - 1) < NEARLY * over:
        return 0.0
    along = sum(_along(frame, loud[:, on]) for frame in first)
    return 0.0 if along > ACROSS * np.nansum(first**2 - 1) else float(BRIEF * period)


def _along(frame: np.ndarray, shapes: np.ndarray) -> float:
    """Energy beyond noise of a frame (C,), some of it unseen, that goes along shapes (m, C)."""
    seen = np.isfinite(frame)
    if seen.sum() <= len(shapes):
        return float(np.nansum(frame**2))
    q, _ = np.linalg.qr(shapes[:, seen].T)
    return float(((q.T @ frame[seen]) ** 2).sum() - len(shapes))
