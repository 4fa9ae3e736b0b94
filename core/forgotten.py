"""Whether modes that no model matched are all that a declared fit leaves."""

import numpy as np

from .baseline import real_shapes
from .data import poles
from .harmonic_inversion import invert
from .law import TimeFit
from .match import mac
from .residual import NOISY
from .time_layer import Candidate

COMPANION = 0.7  # MAC from which a line has a known mode's shape
APART = 0.03  # of its pitch that a further mode keeps from those known and their overtones
MOST = 0.8  # share of what is left that further modes must take


def more_modes(declared: TimeFit, strong: list[Candidate]) -> bool:
    """Whether further weak modes, each with a shape of its own, are all that is left, and tell it
    better than the `strong` effects do.

    A body has more modes than a model matches; their pitches and shapes are the modal layer's
    business. A line with the first mode's shape is none of them: it mimics what acts in time.
    """
    data = declared.law.takes[declared.law.fitted[0]]
    on = ~data.support
    left = (data.values - declared.predicted[declared.law.fitted[0]])[data.fit][:, on]
    time = data.time[data.fit]
    ring = invert(time, left, noise=data.sigma[on], max_modes=5)
    shapes, _ = real_shapes(ring.amplitude)
    first, other = declared.frequency[0] * np.arange(1, 4), declared.frequency[1:]
    own = [
        k
        for k, (s, f) in enumerate(zip(shapes, ring.frequency, strict=True))
        if ring.damping_ratio[k] < 0.2
        and mac(s, declared.shapes[0, on]) < COMPANION
        and np.abs(np.log(f / first)).min() > APART
        and not any(
            abs(np.log(f / g)) < APART and mac(s, there[on]) > COMPANION
            for g, there in zip(other, declared.shapes[1:], strict=True)
        )
    ]
    if not own:
        return False
    phase = np.exp(np.outer(time, poles(ring.frequency[own], ring.damping_ratio[own])))
    q, _ = np.linalg.qr(np.hstack([phase.real, phase.imag, np.ones((len(time), 1))]))
    y, known = np.nan_to_num(left) / data.sigma[on], np.isfinite(left)
    rest, whole = (float((z[known] ** 2).sum()) for z in (y - q @ (q.T @ y), y))
    if strong:
        beside = data.values - strong[0].found.predicted[declared.law.fitted[0]]
        if rest > np.nansum((beside[data.fit][:, on] / data.sigma[on]) ** 2):
            return False
    return rest < NOISY * known.sum() or whole - rest > MOST * (whole - known.sum())
