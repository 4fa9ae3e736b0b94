"""What twins say of the body: a recording that does not tell them apart knows it no better."""

import numpy as np

from .effects import relaxation
from .law import TimeFit
from .parameters import as_fitted, parameters
from .verdict import Verdict


def twins(verdict: Verdict) -> list[TimeFit]:
    """What a recording does not tell from what was found, as it was fitted alone."""
    names = {name for names in verdict.twins for name in names}
    return [c.found for c in verdict.ranked if c.names[0] in names]


def bent(final: TimeFit) -> float:
    """How far the pitches of the two sides of an uneven stiffness lie from their middle."""
    return float(np.log(_uneven(final, lambda told: told["value"])) / 4)


def creeps(verdict: Verdict) -> bool:
    """Whether something moves the mean that may be a creep, which goes on after the recording."""
    there = [effect.name for effect in verdict.final.law.effects]
    return "relaxation" in [*there, *(t for ts in verdict.twins for t in ts)]


def softer(final: TimeFit) -> tuple[float, float]:
    """Static over dynamic stiffness where a relaxation was found, and the least that it may be."""
    shapes = final.column_shapes()
    for i, effect in enumerate(final.law.effects):
        if effect.name == "relaxation":
            returned = relaxation.returns(as_fitted(final), shapes[i])
            stiff, time = relaxation.branches(final.theta[i][0], returned)
            turns = (2 * np.pi * final.frequency[0] * time) ** 2
            follows = (stiff * turns / (1 + turns)).sum() / max(stiff.sum(), 1e-300)
            told = parameters(final, i)["ratio"]
            return tuple(1 / (1 + ratio * follows) for ratio in (told["value"], told["ci95"][1]))
    return 1.0, 1.0


def modulus_span(verdict: Verdict, k: int) -> tuple[float, float]:
    """The least and the most that Young's modulus may be over what mode k's pitch says of it.

    By each twin it is another one. And a body that is stiffer one way is by itself as stiff as its
    softer side where something leans on it, as its stiffer side where something in it opens.
    """
    final, out = verdict.final, [1.0]
    for one in [final, *twins(verdict)]:
        if k >= one.law.modes:
            continue
        pitch = (one.frequency[k] / final.frequency[k]) ** 2
        there = pitch * softer(one)[0] / softer(final)[0]
        ratio = _uneven(one, lambda told: told["ci95"][1]) if k == 0 else 1.0  # acts on the first
        out += [there * 2 / (1 + ratio), there * 2 * ratio / (1 + ratio)]
    return min(out), max(out)


def _uneven(found: TimeFit, of) -> float:
    """The stiffer side over the softer one, where it was found; `of` what is told of it."""
    told = [
        of(parameters(found, i)["ratio"])
        for i, effect in enumerate(found.law.effects)
        if effect.name == "asymmetric_stiffness"
    ]
    return max(told, default=1.0)
