"""From where effects are sought: as strong as what is left asks for, the rest moved with them.

To first order the residual is r + sum a c with a times each effect: the best a are those of least
squares, c without what the other parameters take up (Rao, Linear Statistical Inference, 1973, 6e).
A force has a column of a free shape besides, however weak it is: that is in r.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np

from .effects.base import Effect
from .law import Law, TimeFit
from .screen import beyond, changes
from .timefit import extend, misfits, within

PARTS = (1.0, 0.5, 0.25, 0.1)  # of the strength that is asked for: an effect bends as it grows
SMALL = 0.01  # of a strength, at which what it changes goes with it


@dataclass(frozen=True, eq=False)
class Begin:
    """Where an effect may begin, and what the residuals do there that the fit cannot take up."""

    effect: Effect
    thetas: list
    there: np.ndarray  # (n, R) what does not go with the strength
    tangent: np.ndarray  # (n, R) what does, as if it went with it all the way
    taken: np.ndarray  # (2, n, p) by how much the fit's own parameters move against either


def begin(found: TimeFit, effect: Effect, thetas: list) -> Begin:
    """The effect at each of `thetas`, beside a fit."""
    if effect.scales:
        ways = [[(way * SMALL * t[0], *t[1:]) for t in thetas] for way in (1, -1)]
        one, other = (changes(found, effect, some) for some in ways)
        parts = (one + other) / 2, (one - other) / (2 * SMALL)
    else:
        change = changes(found, effect, thetas)
        parts = change, np.zeros_like(change)
    whole = np.concatenate(parts)
    q, r, scale = found.tangents
    taken = np.linalg.lstsq(r, -q.T @ whole.T, rcond=1e-10)[0].T / scale
    there, tangent = beyond(found, whole).reshape(2, len(thetas), -1)
    return Begin(effect, thetas, there, tangent, taken.reshape(2, len(thetas), -1))


def outsets(found: TimeFit, law: Law, some: list[Begin]) -> np.ndarray:
    """(S, p) where to begin, the least misfit first: one for every choice of a theta of each of
    `some` effects, as it is or with strengths asked for.

    `law`: that of the search, with those effects last.
    """
    choices = product(*(range(len(one.thetas)) for one in some))
    tries = [_asked(found, law, some, choice) for choice in choices]
    left = misfits(law, np.concatenate(tries), found.samples).reshape(len(tries), -1)
    order = np.argsort(left.min(axis=1))
    return np.array([tries[i][left[i].argmin()] for i in order])


def _asked(found: TimeFit, law: Law, some: list[Begin], choice: tuple[int, ...]) -> np.ndarray:
    """(n, p) where to begin with the chosen thetas: with the rest as it is, and moved along, with
    parts of the strengths that are asked for.
    """
    effects = tuple(one.effect for one in some)
    thetas = [one.thetas[n] for one, n in zip(some, choice, strict=True)]
    _, nominal = extend(found, effects, thetas)
    able = [i for i, effect in enumerate(effects) if effect.scales]
    picked = list(zip(some, choice, strict=True))
    if not able:
        moved = nominal.copy()
        moved[: len(found.parameters)] += sum(one.taken[0, n] for one, n in picked)
        return within(law, np.array([nominal, moved]))
    rest = found.residuals + sum(one.there[n] for one, n in picked)
    tangent = np.array([some[i].tangent[choice[i]] for i in able])
    times = -np.linalg.lstsq(tangent.T, rest, rcond=1e-10)[0]
    own = np.array([thetas[i][0] for i in able])
    low, high = (np.array([getattr(effects[i], side)[0] for i in able]) for side in ("low", "high"))
    strengths = np.clip(np.outer(PARTS, times * own), low, high)
    moved = sum(one.taken[0, n] for one, n in picked)
    moved = moved + strengths / own @ np.array([some[i].taken[1, choice[i]] for i in able])
    firsts = len(nominal) - np.cumsum([len(theta) for theta in thetas][::-1])[::-1]
    tries = np.tile(nominal, (1 + len(PARTS), 1))
    tries[1:, : len(found.parameters)] += moved
    tries[1:, firsts[able]] = strengths
    return within(law, tries)
