"""What is known of a body's stiffness beside what was found in time, and what its twins say."""

from collections.abc import Callable

import numpy as np

from .effects import relaxation, split_modes
from .law import TimeFit
from .parameters import as_fitted, parameters
from .settle import STRAY
from .verdict import Verdict


def twins(verdict: Verdict) -> list[TimeFit]:
    """What a recording does not tell from what was found, as it was fitted alone."""
    names = {name for names in verdict.twins for name in names}
    return [c.found for c in verdict.ranked if c.names[0] in names]


def bent(final: TimeFit) -> float:
    """How far the pitches of the two sides of an uneven stiffness lie from their middle."""
    return float(np.log(max((told["value"] for told in _uneven(final)), default=1.0)) / 4)


def handed_on(frequency: np.ndarray) -> np.ndarray:
    """(K,) share of what bends the first mode's pitch that bends those of `frequency` (K,) Hz, the
    first one's first.

    A spring at one place, here one that acts one way, adds to every mode's squared pitch alike, in
    the mean over places.
    """
    return np.minimum(1.0, (frequency[0] / frequency) ** 2)


def creeps(verdict: Verdict) -> bool:
    """Whether something moves the mean that may be a creep, which goes on after the recording."""
    there = [effect.name for effect in verdict.final.law.effects]
    return "relaxation" in [*there, *(t for ts in verdict.twins for t in ts)]


def softer(final: TimeFit) -> tuple[float, float, float]:
    """Static over dynamic stiffness where a relaxation was found, and the least and most of it."""
    shapes = final.column_shapes()
    for i, effect in enumerate(final.law.effects):
        if effect.name == "relaxation":
            returned = relaxation.returns(final.theta[i][0], as_fitted(final), shapes[i])
            stiff, time = relaxation.branches(final.theta[i][0], returned)
            turns = (2 * np.pi * final.frequency[0] * time) ** 2
            follows = (stiff * turns / (1 + turns)).sum() / max(stiff.sum(), 1e-300)
            told = parameters(final, i)["ratio"]
            low, high = told["ci95"]
            return tuple(1 / (1 + ratio * follows) for ratio in (told["value"], high, low))
    return 1.0, 1.0, 1.0


def twins_span(verdict: Verdict, k: int, true: Callable) -> tuple[float, float]:
    """The least and the most that Young's modulus may be over what mode k's pitch says of it.

    By a twin of the one effect that was found it is another one, if mode k is in its place there.
    And a body that is stiffer one way is by itself as stiff as its softer side where something
    leans on it, as its stiffer side where something in it opens, by as much as it may be stiffer.
    `true` (TimeFit -> (K,)): Hz.
    """
    final, out = verdict.final, [1.0]
    rivals = twins(verdict) if len(verdict.effects) == 1 else []  # they were fitted alone
    for one in [final, *rivals]:
        pitch = (_pitch(one, k, true) / _pitch(final, k, true)) ** 2
        if k and abs(np.log(pitch)) > 2 * STRAY:  # it left its place there
            continue
        softest = softer(one)[:1] if one is final else softer(one)
        ratio = _most_uneven(one) ** handed_on(true(one))[k]
        sides = 2 / (1 + ratio), 2 * ratio / (1 + ratio)
        out += [pitch * soft / softer(final)[0] * side for soft in softest for side in sides]
    return min(out), max(out)


def _pitch(one: TimeFit, k: int, true: Callable) -> float:
    """Hz of mode k, of the middle of a pair that is split."""
    return true(one)[k] * (split_modes.middle(one) if k == one.law.setting.pair else 1.0)


def _most_uneven(found: TimeFit) -> float:
    """The stiffer side over the softer one, at most."""
    return max((told["ci95"][1] for told in _uneven(found)), default=1.0)


def _uneven(found: TimeFit) -> list[dict]:
    """What is told of the stiffer side over the softer one."""
    return [
        parameters(found, i)["ratio"]
        for i, effect in enumerate(found.law.effects)
        if effect.name == "asymmetric_stiffness"
    ]
