"""The same takes heard by other modes of the body than at first."""

from collections.abc import Iterator

import numpy as np

from .joint import Heard, heard_by, with_all
from .match import ALIKE, Match
from .settle import Recorded, beside, settle_poles
from .unheard import NEIGHBOUR, bare


def nearby(heard: Heard) -> Iterator[Heard]:
    """With one more low mode of the body beside the strongest, one after another."""
    ground = whole_ground(heard)
    if ground is None:
        return
    condition = ground.condition[ground.fitted[0]]
    for wider in beside(ground, heard.free, heard.match):
        if wider[2][condition].modes[:-1] == heard.match.modes:
            yield heard_by(ground, with_all(ground, wider))


def without_mimics(heard: Heard) -> Heard | None:
    """Without the modes beside the strongest that were not heard by themselves and die otherwise;
    None where there are none.

    What bends the pitch of one mode makes it sound as two that beat, of which one dies sooner.
    """
    ground = whole_ground(heard)
    if ground is None:
        return None
    free, match = heard.free, heard.match
    mimics = weak_beside(match, free.frequency, free.damping_ratio)
    if not mimics.any():
        return None
    first = ground.fitted[0]
    ring, kept = heard.rings[first], np.flatnonzero(~mimics)
    f, z = free.frequency.copy(), free.damping_ratio.copy()
    # as it was heard: beside a mimic it is what is left of it
    f[0], z[0] = (one[match.poles[0]] for one in (ring.frequency, ring.damping_ratio))
    poles = bare(f[kept], z[kept], heard.takes[first].sigma)
    settled = settle_poles(ground, poles, match.only(kept))
    return heard_by(ground, with_all(ground, settled))


def weak_beside(match: Match, frequency: np.ndarray, damping_ratio: np.ndarray) -> np.ndarray:
    """(K,) bool: modes not heard by themselves that lie, by their frequency (K,) Hz, beside
    the strongest, with a damping ratio (K,) more than `ALIKE` times as large or as small.
    """
    near = np.abs(np.log(frequency / frequency[0])) < np.log(NEIGHBOUR)
    unlike = np.abs(np.log(damping_ratio / damping_ratio[0])) > np.log(ALIKE)
    weak = np.array(match.poles) == match.poles[0]
    return near & unlike & weak


def whole_ground(heard: Heard) -> Recorded | None:
    """What the modes of one body are fitted on; None where loads part them or one is unknown."""
    ground = Recorded(heard.takes, heard.condition, heard.bodies, heard.rings)
    parted = len({ground.condition[i] for i in ground.fitted}) > 1
    return None if parted or None in heard.match.modes else ground
