"""Takes with other loads: which modes they share, and which of them but one load shows."""

import numpy as np

from .match import Match
from .settle import Recorded
from .unheard import NEIGHBOUR


def common(matches: dict[int, Match], heard: dict[int, np.ndarray]) -> dict[int, Match]:
    """The strongest mode of each condition, and the others that every condition shows.

    With other loads the strongest one may be the other of two that lie close together, or have
    another place among the computed ones. Where it is another one altogether, by the poles that
    each condition `heard` (n,) Hz, the one that is strongest in all comes first.
    """
    if len(matches) == 1:
        return matches
    strongest = {m.modes[0] for m in matches.values()}
    first = next(iter(matches.values()))
    if None in strongest:
        return {c: Match(m.poles[:1], m.modes[:1]) for c, m in matches.items()}
    shared = [j for j in first.modes if all(j in m.modes for m in matches.values())]
    pitches = [heard[c][m.poles[0]] for c, m in matches.items()]
    if len(strongest) > 1 and np.ptp(np.log(pitches)) > np.log(NEIGHBOUR) and shared:
        head = min(shared, key=lambda j: sum(m.modes.index(j) for m in matches.values()))
        matches = {c: _led_by(m, head) for c, m in matches.items()}
        strongest = {head}
    others = [j for j in shared if j not in strongest]
    return {
        c: Match((m.poles[0], *(m.poles[m.modes.index(j)] for j in others)), (m.modes[0], *others))
        for c, m in matches.items()
    }


def _led_by(match: Match, mode: int) -> Match:
    at = match.modes.index(mode)
    order = [at, *(k for k in range(len(match.modes)) if k != at)]
    return match.only(order)


def left_out(ground: Recorded, rings: tuple, every: dict, matches: dict) -> list:
    """(fitted take, Hz, damping ratio) of the modes matched in one condition and not in all."""
    out = []
    for take, i in enumerate(ground.fitted):
        c = ground.condition[i]
        if first_take(ground, c) == take and None not in every[c].modes:
            ring = rings[i]
            out += [
                (take, float(ring.frequency[pole]), float(ring.damping_ratio[pole]))
                for pole in every[c].poles
                if pole not in matches[c].poles
            ]
    return out


def shift(ground: Recorded, matches: dict) -> np.ndarray:
    """(K,) relative, how far the pitches of the matched modes lie apart with all loads."""
    own = [ground.bodies[c].modes.frequency[list(m.modes)] for c, m in matches.items()]
    return np.ptp(np.log(own), axis=0)


def first_take(ground: Recorded, condition: int) -> int:
    """The number, among the fitted takes, of the first one of a condition."""
    return [ground.condition[i] for i in ground.fitted].index(condition)
