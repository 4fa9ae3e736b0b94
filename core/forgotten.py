"""Whether modes that no model matched are all that a declared fit leaves."""

import numpy as np

from .baseline import real_shapes
from .data import poles
from .harmonic_inversion import invert
from .law import TimeFit
from .linear_part import fitted_instants
from .match import mac
from .residual import NOISY
from .time_layer import Candidate

COMPANION = 0.7  # MAC from which a line has a known mode's shape
APART = 0.03  # of its pitch that a further mode keeps from those known and their overtones
MOST = 0.8  # share of what is left that further modes must take
MODES = 5  # that are sought in a take


def more_modes(declared: TimeFit, strong: list[Candidate]) -> bool:
    """Whether further weak modes, each with a shape of its own, are all that is left, and tell it
    better than the `strong` effects do.

    A body has more modes than a model matches; their pitches and shapes are the modal layer's
    business. A line with the first mode's shape is none of them: it mimics what acts in time.
    """
    rest = whole = beside = 0.0
    samples, found = 0, False
    for take, index in enumerate(declared.law.fitted):
        data = declared.law.takes[index]
        on = ~data.support
        left, other = (
            fit.missed(take)[data.fit][:, on]
            for fit in (declared, strong[0].found if strong else declared)
        )
        count = np.isfinite(left).sum()
        all_of_it, effects = (float(np.nansum((z / data.sigma[on]) ** 2)) for z in (left, other))
        told = _told_by_modes(declared, take, left) if all_of_it > NOISY * count else 0.0
        found |= told > 0
        whole, rest = whole + all_of_it, rest + all_of_it - told
        beside, samples = beside + effects, samples + int(count)
    if not found or (strong and rest > beside):
        return False
    return rest < NOISY * samples or whole - rest > MOST * (whole - samples)


def _told_by_modes(declared: TimeFit, take: int, left: np.ndarray) -> float:
    """Misfit that further modes take of what is `left` (n, C) of a fitted take."""
    data = declared.law.takes[declared.law.fitted[take]]
    on = ~data.support
    time, use = fitted_instants(declared.law, declared.theta, data)
    left = left[use[data.fit]]
    ring = invert(time, left, noise=data.sigma[on], max_modes=MODES)
    shapes, _ = real_shapes(ring.amplitude)
    pitches = declared.pitches(take)
    first, other = pitches[0] * np.arange(1, 4), pitches[1:]
    there = declared.shapes_of(take)[:, on]
    own = [
        k
        for k, (s, f) in enumerate(zip(shapes, ring.frequency, strict=True))
        if ring.damping_ratio[k] < 0.2
        and mac(s, there[0]) < COMPANION
        and np.abs(np.log(f / first)).min() > APART
        and not any(
            abs(np.log(f / g)) < APART and mac(s, shape) > COMPANION
            for g, shape in zip(other, there[1:], strict=True)
        )
    ]
    if not own:
        return 0.0
    phase = np.exp(np.outer(time, poles(ring.frequency[own], ring.damping_ratio[own])))
    q, _ = np.linalg.qr(np.hstack([phase.real, phase.imag, np.ones((len(time), 1))]))
    y, known = np.nan_to_num(left) / data.sigma[on], np.isfinite(left)
    after = (y - q @ (q.T @ y))[known]
    return float((y**2).sum() - (after**2).sum())
