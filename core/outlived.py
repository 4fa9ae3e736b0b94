"""Where the fit of a take begins: once what rings above all computed modes of the body has died, or
what so many of them ring that none of it is heard by itself.

A blow on a compact body, or a pull at a point of it, rings so many modes that they cannot all be
fitted. High ones die first, so the first frames are left out instead.
"""

import numpy as np

from .all_told import SAME, damps_alike
from .baseline import real_shapes
from .channels import Channels
from .data import RingDown, poles
from .match import ACROSS, mac

FEW = 3  # of them, from which they are waited for; fewer are fitted as further modes
FADED = 3.0  # noise, of all channels together, that such a mode has died to
SPENT = 0.9  # nepers that the strongest mode may die by meanwhile
SHARE = 0.5  # of the fitted part that may be left out
BRIEF = 0.35  # of the strongest mode's period: before it is on the far side, where a stop may be
NEARLY = 0.8  # of what is left beyond noise, that lies within it


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


def brief(left: np.ndarray, time: np.ndarray, shape: np.ndarray, period: float) -> float:
    """s after the release at which what a fit leaves has died away, where it does so within part of
    a swing and moves otherwise than that; 0 elsewhere.

    left (T, C): noise units, of the fitted part at `time` (T,) s since the release; shape (C,): the
    strongest mode's in these units, of `period` s.
    """
    early = time < BRIEF * period
    if not early.any() or time[-1] * SHARE < BRIEF * period:
        return 0.0
    first, all_of_it = left[early], left
    over = [np.nansum(part**2 - 1) for part in (first, all_of_it)]
    known = np.nan_to_num(first)
    along = ((known @ shape) ** 2).sum() / (shape @ shape) / (known**2).sum()
    if over[1] <= 0 or over[0] < NEARLY * over[1] or along > ACROSS:
        return 0.0
    return float(BRIEF * period)
