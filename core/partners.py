"""The other directions of degenerate modes: how far a body parts them, and which of them show."""

from itertools import combinations

import numpy as np

from .baseline import real_shapes
from .body import Body
from .data import RingDown, replace
from .law import TimeFit
from .match import ACROSS, CREEPING, PAIR, SPLIT, STRONG, SURE, likeness, mac, turning
from .pair import with_partner
from .refit import sunk

APART = 0.01  # relative, beyond what the body parts a pair by, from which that is split
FAINT = 0.02  # of the strongest mode's swing: below, a partner is not looked for


def gaps_of(modes, body: Body) -> dict[int, float]:
    """How far the partner of each matched degenerate mode lies from it, relatively: as computed,
    but no further than the body parts a pair.
    """
    frequency = body.modes.frequency
    able = turning(modes, frequency, 2 * PAIR)
    if not able:
        return {}
    nearest = (np.abs(np.delete(frequency, modes) / frequency[modes[k]] - 1).min() for k in able)
    return {k: min(float(gap), body.parts) for k, gap in zip(able, nearest, strict=True)}


def heard_split(ring: RingDown, on, mode: int, seen: np.ndarray, computed: np.ndarray, gap: float):
    """Whether two strong poles of a ring-down move as both directions of the computed `mode`'s pair
    and across each other, further apart than the body parts them: no partner has one's pitch then.

    on: (C,) bool, the object's channels. seen: (m, C) of the computed modes, at `computed` (m,) Hz.
    """
    shapes, seen = real_shapes(ring.amplitude)[0][:, on], seen[:, on]
    size = np.linalg.norm(shapes, axis=1)
    own = [
        n
        for n in np.flatnonzero((size > STRONG * size.max()) & (ring.damping_ratio < CREEPING))
        if likeness(shapes[n], seen, computed, mode) > SURE
    ]
    return any(
        gap + APART < abs(np.log(ring.frequency[a] / ring.frequency[b])) < SPLIT
        and mac(shapes[a], shapes[b]) < ACROSS
        for a, b in combinations(own, 2)
    )


def with_partners(found: TimeFit, gaps: dict[int, float], below: int = 0, take: int = 0) -> TimeFit:
    """The fit with the other direction of those degenerate modes that show it.

    below: how many effects, the last ones, stay the last. take: as for `with_partner`.
    """
    swing = swing_of(found)
    for k, gap in gaps.items():
        if swing[k] < FAINT * swing.max():
            continue
        setting = replace(
            found.law.setting, omega=2 * np.pi * found.frequency, zeta=found.damping_ratio
        )
        found = replace(found, law=replace(found.law, setting=setting))
        wider = with_partner(found, k, gap, take)
        found = wider if wider is found or not below else sunk(wider, below)
    return found


def swing_of(found: TimeFit) -> np.ndarray:
    """(K,) the most that each mode moves its reference in any fitted take."""
    return np.array([np.abs(u).max(axis=0) for u in found.motions]).max(axis=0)
