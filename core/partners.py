"""The other directions of degenerate modes: how far a body parts them, and which of them show."""

import numpy as np

from .body import Body
from .data import replace
from .law import TimeFit
from .match import PAIR, turning
from .pair import with_partner
from .refit import sunk
from .symmetry import unevenness

FAINT = 0.02  # of the strongest mode's swing: below, a partner is not looked for


def gaps_of(modes, body: Body) -> dict[int, float]:
    """How far the partner of each matched degenerate mode lies from it, relatively: as computed,
    but without a load no further than the body is uneven, a pitch going with the root of a moment.
    """
    frequency = body.modes.frequency
    able = turning(modes, frequency, 2 * PAIR)
    if not able:
        return {}
    most = unevenness(body.bare) / 2 if body.model is body.bare else np.inf
    return {
        k: min(float(np.abs(np.delete(frequency, modes) / frequency[modes[k]] - 1).min()), most)
        for k in able
    }


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
