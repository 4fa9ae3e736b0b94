"""From where effects are sought: as strong as what is left asks for, the rest moved with them.

To first order the residual is r + sum a c with a times each effect: the best a are those of least
squares, c without what the other parameters take up (Rao, Linear Statistical Inference, 1973, 6e).
"""

from itertools import product

import numpy as np

from .effects.base import Effect
from .law import Law, TimeFit
from .timefit import beyond, changes, extend, misfits

PARTS = (1.0, 0.5, 0.25, 0.1)  # of the strength that is asked for: an effect bends as it grows
SMALL = 0.01  # of a strength, at which what it changes goes with it


def tangents(found: TimeFit, effect: Effect, thetas: list) -> np.ndarray:
    """(n, R) change of the residuals by the effect at each of `thetas`, as if it went with its
    strength; as it is where that cannot be scaled.
    """
    if not effect.scales:
        return changes(found, effect, thetas)
    return changes(found, effect, [(SMALL * t[0], *t[1:]) for t in thetas]) / SMALL


def outsets(found: TimeFit, law: Law, some: list[tuple[Effect, list, np.ndarray]]) -> np.ndarray:
    """(S, p) where to begin, the least misfit first: one for every choice of a theta of each of
    `some` effects (effect, thetas, their `tangents`), as it is or with strengths asked for.

    `law`: that of the search, with those effects last.
    """
    choices = list(product(*([*zip(thetas, raw, strict=True)] for _, thetas, raw in some)))
    effects = tuple(effect for effect, _, _ in some)
    tries = [_asked(found, effects, choice) for choice in choices]
    if not any(effect.scales for effect in effects):
        return np.concatenate(tries)
    left = misfits(law, np.concatenate(tries)).reshape(len(tries), -1)
    order = np.argsort(left.min(axis=1))
    return np.array([tries[i][left[i].argmin()] for i in order])


def _asked(found: TimeFit, effects: tuple[Effect, ...], choice: tuple) -> np.ndarray:
    """(1 + parts, p) where to begin with the chosen thetas, and with parts of what is asked for."""
    thetas, raw = zip(*choice, strict=True)
    _, nominal = extend(found, effects, list(thetas))
    able = np.array([effect.scales for effect in effects])
    if not able.any():
        return nominal[None]
    raw = np.array(raw)
    own = beyond(found, raw)
    rest = found.residuals + own[~able].sum(axis=0)
    times = np.ones(len(effects))
    times[able] = -np.linalg.lstsq(own[able].T, rest, rcond=1e-10)[0]
    scale = np.linalg.norm(found.jacobian, axis=0)
    scale = np.where(scale > 0, scale, 1.0)
    moved = np.linalg.lstsq(found.jacobian / scale, -times @ raw, rcond=1e-10)[0] / scale
    firsts = len(nominal) - np.cumsum([len(theta) for theta in thetas][::-1])[::-1]
    tries = [nominal]
    for part in PARTS:
        p = nominal.copy()
        p[: len(moved)] += part * moved
        for at, effect, much in zip(firsts, effects, times, strict=True):
            if effect.scales:
                p[at] = np.clip(part * much * p[at], effect.low[0], effect.high[0])
        tries.append(p)
    return np.array(tries)
