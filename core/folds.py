"""Pitches near half the frame rate, which may be read as what folds to them."""

import numpy as np

from .match import dies_alike

MOST = 3  # such pitches, those nearest to half the rate
APART = 2.0  # ratio of a pitch and what folds to it, up to which the body tells which it is


def folds_of(
    pitches: np.ndarray, damping_ratio: np.ndarray, rate: float, known: tuple[int, ...]
) -> tuple[tuple[int, float], ...]:
    """Which of the natural pitches (K,) Hz, but the `known` ones, may be read as another one that
    looks the same at `rate` frames/s and dies as a mode may, and that other one (Hz).
    """
    first, out = (pitches[0], None, damping_ratio[0]), []
    for k, (f, z) in enumerate(zip(pitches, damping_ratio, strict=True)):
        damped = f * np.sqrt(1 - z**2)  # which is what folds
        if k in known or not 0 < rate - damped < APART * damped < APART**2 * (rate - damped):
            continue
        other = float(np.hypot(rate - damped, z * f))
        if not first[2] or dies_alike(f, z, other, first):
            out.append((abs(np.log(other / f)), k, other))
    return tuple((k, other) for _, k, other in sorted(out)[:MOST])  # twice the readings with each
