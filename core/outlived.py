"""Where the fit of a take begins: once what rings above all computed modes of the body has died, or
a burst of modes that are too many and too brief to be heard one by one.

A blow on a compact body, or a pull at a point of it, rings so many modes that they cannot all be
fitted. High ones die first, so the first frames are left out instead.
"""

import numpy as np

from .all_told import SAME, damps_alike
from .baseline import real_shapes
from .channels import Channels
from .data import RingDown, poles, replace
from .law import TimeFit
from .listen import listen_from
from .match import ACROSS, Match, mac, select
from .recorded import first_periods
from .residual import NOISY, QUIET
from .settle import Recorded

FEW = 3  # of them, from which they are waited for; fewer are fitted as further modes
FADED = 3.0  # noise, of all channels together, that such a mode has died to
SPENT = 0.9  # nepers that the strongest mode may die by meanwhile
SHARE = 0.5  # of the fitted part that may be left out
THIRD = 0.35  # of the strongest mode's period: what has died by then is no mode that can be heard
AFTER = 2.0  # periods that stay at least: less is fitted by almost anything
NEARLY = 0.8  # of what is left beyond noise, that lies within the first third of a swing
LASTING = 0.1  # damping ratio from which a swing is so brief itself
LOUD = 0.2  # of the strongest mode's swing, from which another one's is no trifle


def after_outlived(ground: Recorded, matches: dict[int, Match]) -> Recorded:
    """The takes and their ring-downs from where what rings above all computed modes has died."""
    whens = {}
    for i, (data, ring) in enumerate(zip(ground.takes, ground.rings, strict=True)):
        c = ground.condition[i]
        if c not in matches or None in matches[c].modes:
            continue
        source = next(j for j in ground.fitted if ground.condition[j] == c)
        known = select(ground.rings[source], matches[c].poles)
        computed = ground.bodies[c].modes.frequency
        top = computed[-1] * known.frequency[0] / computed[matches[c].modes[0]]
        whens[i] = outlived(data, ring, known, top)
    return _from(ground, whens)


def after_bursts(ground: Recorded, free: TimeFit) -> Recorded:
    """The takes and their ring-downs from where a brief burst has died that no mode of the fit
    tells. Held-out takes stay whole.
    """
    if free.chi2 < QUIET * free.samples:
        return ground
    whens = {}
    for take, i in enumerate(ground.fitted):
        data, K, own = ground.takes[i], free.law.modes, free.law.own
        at = own * free.law.condition[i]
        shapes = free.coefficients[:, at : at + own].T / data.sigma
        left = (free.missed(take) / data.sigma)[data.fit]
        swing = np.linalg.norm(shapes[:K, ~data.support], axis=1) * free.motions[take].std(axis=0)
        loud, first = np.ones(own, bool), int(np.argmax(swing))  # a pair's other way, too
        loud[:K] = swing > LOUD * swing.max()
        if free.damping_ratios(take)[first] < LASTING:
            period = 1 / free.pitches(take)[first]
            whens[i] = burst(left, data.time[data.fit], shapes[loud], ~data.support, period)
    return _from(ground, whens)


def _from(ground: Recorded, whens: dict[int, float]) -> Recorded:
    """The same, takes by their number from so many s after their release; itself if none is."""
    takes, rings = list(ground.takes), list(ground.rings)
    for i, when in whens.items():
        if when > 0:
            data, ring = takes[i], rings[i]
            takes[i], rings[i] = listen_from(data, ring, when)
            if data.take.held_out:
                takes[i] = first_periods(takes[i], ring)
    if all(new is old for new, old in zip(takes, ground.takes, strict=True)):
        return ground
    return replace(ground, takes=tuple(takes), rings=tuple(rings))


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


def burst(
    left: np.ndarray, time: np.ndarray, loud: np.ndarray, on: np.ndarray, period: float
) -> float:
    """A third of a swing, s since the release, where nearly all that a fit leaves of a take lies
    within that and is no motion of its `loud` modes; 0 elsewhere, or where too little stays.

    left (T, C): noise units, of the fitted part at `time` (T,) s; loud (m, C): their shapes in
    these units; on (C,) bool: channels on the object; the strongest mode is of `period` s.
    """
    early = time < THIRD * period
    if time[-1] < (THIRD + AFTER) * period:
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
    return 0.0 if along > ACROSS * np.nansum(first**2 - 1) else float(THIRD * period)


def _along(frame: np.ndarray, shapes: np.ndarray) -> float:
    """Energy beyond noise of a frame (C,), some of it unseen, that goes along shapes (m, C)."""
    seen = np.isfinite(frame)
    if seen.sum() <= len(shapes):
        return float(np.nansum(frame**2))
    q, _ = np.linalg.qr(shapes[:, seen].T)
    return float(((q.T @ frame[seen]) ** 2).sum() - len(shapes))
