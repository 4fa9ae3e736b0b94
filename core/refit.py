"""A fit's effects left out, put in another order, or one put in another's place; less damping."""

from dataclasses import replace

import numpy as np

from .effects.base import Effect
from .law import Law, TimeFit
from .timefit import as_it_stands, fit

LESS = 6.0  # times, that a damping ratio may be too large for what damps besides
MOVED = 3  # of one whose effects were put in another order


def without(found: TimeFit, i: int) -> TimeFit:
    """Fitted again without effect number `i`, from where the fit with it stands."""
    kept = [k for k in range(len(found.theta)) if k != i]
    return _in_order(found, kept, evaluations=20)


def turned(found: TimeFit) -> TimeFit:
    """Fitted with its last two effects in the other order, from where it stands."""
    *first, one, other = range(len(found.theta))
    return _in_order(found, [*first, other, one])


def led(found: TimeFit) -> TimeFit:
    """Fitted with its last effect before all the others, from where it stands."""
    *others, last = range(len(found.theta))
    return _in_order(found, [last, *others])


def sunk(found: TimeFit, below: int) -> TimeFit:
    """Fitted with its last effect before the `below` ones that stood before it."""
    *others, last = range(len(found.theta))
    at = len(others) - below
    return _in_order(found, [*others[:at], last, *others[at:]])


def _in_order(found: TimeFit, order: list[int], evaluations: int = MOVED) -> TimeFit:
    law = _made_of(found.law, tuple(found.law.effects[i] for i in order))
    return fit(law, _from(found, [found.theta[i][0] for i in order]), evaluations=evaluations)


def _made_of(law: Law, effects: tuple[Effect, ...]) -> Law:
    """The law with other effects, whose forces feel nothing that one did which is gone."""
    gone = any(e.carries and e not in effects for e in law.effects)
    setting = replace(law.setting, carried=()) if gone else law.setting
    return replace(law, effects=effects, setting=setting)


def _from(found: TimeFit, inner: list) -> np.ndarray:
    """(p,) the pitches, damping ratios and starts of a fit, with effects' own numbers."""
    return np.concatenate([found.parameters[: sum(found.law.sizes()[:2])], *inner])


def swapped(found: TimeFit, effect: Effect, thetas: list) -> tuple[Law, np.ndarray]:
    """The law with another effect in the last one's place, and where to start from (S, p)."""
    return put(found, len(found.theta) - 1, effect, thetas)


def put(found: TimeFit, i: int, effect: Effect, thetas: list) -> tuple[Law, np.ndarray]:
    """The law with another effect in the place of number `i`, and where to start from (S, p)."""
    effects = found.law.effects
    law = _made_of(found.law, (*effects[:i], effect, *effects[i + 1 :]))
    own = [theta[0] for theta in found.theta]
    starts = [_from(found, [*own[:i], np.asarray(t, float), *own[i + 1 :]]) for t in thetas]
    return law, np.array(starts)


def lighter(found: TimeFit) -> TimeFit:
    """The fit as it stands where modes that are damped far more than another one are less so; where
    there is no other one, less at any rate.
    """
    p, K = found.parameters.copy(), found.law.modes
    for at in range(K, found.law.sizes()[0], 2 * K):
        z = p[at : at + K]
        least = z.min() if K > 1 and found.law.damping == "free" else 0.0
        p[at : at + K] = np.maximum(least, z / LESS)
    return found if np.array_equal(p, found.parameters) else as_it_stands(found.law, p)
