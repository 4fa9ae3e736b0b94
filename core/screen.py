"""What an effect promises before it is fitted: a score test."""

import numpy as np

from .effects.base import Effect
from .law import TimeFit
from .linear_part import residuals
from .timefit import extend, in_part, within


def screen(found: TimeFit, effect: Effect, thetas: list) -> np.ndarray:
    """Gain in chi2 that each start promises: a score test off the fitted law's tangents (n,).

    The residual's change by the effect, scaled as it likes (Rao, Linear Statistical Inference,
    1973, 6e); the more promising way of one that acts either way.
    """
    ways = (1.0, -1.0) if effect.scales else (1.0,)
    signed = [(way * t[0], *t[1:]) if effect.scales else t for way in ways for t in thetas]
    change = beyond(found, changes(found, effect, signed))
    power = (change**2).sum(axis=1)
    gain = (change @ found.residuals) ** 2 / np.where(power > 0, power, np.inf)
    return gain.reshape(len(ways), -1).max(axis=0)


def changes(found: TimeFit, effect: Effect, thetas: list) -> np.ndarray:
    """(n, R) change of the residuals by the effect at each of `thetas`."""
    law, _ = extend(found, (effect,), [thetas[0]])
    P = np.vstack([np.r_[found.parameters, np.asarray(theta, float)] for theta in thetas])
    return residuals(in_part(law, 1.0), within(law, P)) - found.residuals


def beyond(found: TimeFit, change: np.ndarray) -> np.ndarray:
    """(n, R) changes without what the fitted parameters can take up."""
    q, _, _ = found.tangents
    return change - (change @ q) @ q.T
