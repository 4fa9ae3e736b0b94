"""Where a search begins with more of the body's modes beside those of a fit: what these may do."""

from collections.abc import Callable

import numpy as np

from .effects.base import Effect
from .law import TimeFit


def begun(found: TimeFit, ratio: np.ndarray, damping: Callable, start: Callable) -> np.ndarray:
    """Pitches, damping ratios and starts of a fit, and of n modes more.

    These ring at the first one's pitch times exp(`ratio`) (n,), damped by what `damping` makes of
    the fit's ratios (K,), and let go from what `start` makes of its starts, m and m/s over omega
    (2, K), of a take.
    """
    K, (a, b, _), out = found.law.modes, found.law.sizes(), []
    for pitch, ratios in found.parameters[:a].reshape(-1, 2, K):
        out += [pitch, pitch[0] + ratio, ratios, np.full(len(ratio), damping(ratios))]
    for own in found.parameters[a : a + b].reshape(-1, 2, K):
        for row, more in zip(own, start(own), strict=True):
            out += [row, np.full(len(ratio), more)]
    return np.concatenate(out)


def placed(
    effect: Effect, theta: np.ndarray, modes: int, places: np.ndarray, most: int
) -> list[np.ndarray]:
    """The numbers `theta` of an effect beside so many `modes`, with what its place shares in more:
    as each of those `places` (Q, K - 1) does that share in the former as nearly as it does, up to
    `most` of them, the nearest first.
    """
    if not effect.force:
        return [theta]
    own, n = len(effect.low), modes - 1
    couples, across = theta[own : own + n], theta[own + n :]
    near = np.argsort(((places[:, :n] - couples) ** 2).sum(axis=1), kind="stable")[:most]
    rest = [across, np.zeros(places.shape[1] - n)] if effect.axes > 1 else []
    return [np.concatenate([theta[: own + n], places[i, n:], *rest]) for i in near]
