"""A second hearing: a mode that only shows once it is known what acts in time."""

from collections.abc import Callable

import numpy as np

from .diagnosis import Verdict
from .effects.base import Effect
from .joint import Heard, nearby
from .law import TimeFit
from .residual import NOISY, excess
from .timefit import extend, fit

SHOWN = 0.7  # of what is left, rms, is left at most with the further mode


def second_hearing(
    heard: Heard, verdict: Verdict, diagnose: Callable[[Heard], Verdict]
) -> tuple[Heard, Verdict]:
    """The takes and the verdict, both anew where one more low mode takes most of what is left.

    Two modes of a body that lie close together sound as one while something bends their pitches;
    what bends them is known now, and what one of them is like follows from the other.
    """
    best = verdict.final if verdict.effects else None
    if best is None and verdict.ranked:
        best = verdict.ranked[0].found
    if best is None or best.chi2 < NOISY * best.samples:
        return heard, verdict
    for near in nearby(heard):
        if excess(_with_effects(near.declared, best, heard)) > SHOWN * excess(best):
            continue
        again = diagnose(near)
        if excess(again.final) < SHOWN * excess(verdict.final):
            return near, again
    return heard, verdict


def _with_effects(near: TimeFit, found: TimeFit, heard: Heard) -> TimeFit:
    """`near` with the effects of `found` that the declared law had not, from where they stand."""
    declared = {e.name for e in heard.declared.law.effects}
    pairs = [(e, t[0]) for e, t in zip(found.law.effects, found.theta, strict=True)]
    new = [(e, _wider(e, t, near)) for e, t in pairs if e.name not in declared]
    law, p = extend(near, tuple(e for e, _ in new), [t for _, t in new])
    return fit(law, p, evaluations=15)


def _wider(effect: Effect, theta: np.ndarray, near: TimeFit) -> np.ndarray:
    """The effect's numbers, with its place's share in the further mode."""
    if not effect.force:
        return theta
    couples, places = theta[len(effect.low) :], near.law.setting.places
    nearest = np.argmin(((places[:, : len(couples)] - couples) ** 2).sum(axis=1))
    return np.r_[theta, places[nearest, len(couples) :]]
