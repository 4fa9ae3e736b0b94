"""What the body says of a held-out take with loads or a gravity that no fitted take has.

Law         each mode's pitch and shape change as computed; its offsets by what the body yields more
            under the other weight, its stiffness being what the first mode's pitch says
Cannot      tell how a force acts on a body of another mass, nor follow further modes, partners and
            a pair's other direction there
"""

import numpy as np
from scipy.optimize import linear_sum_assignment

from .body import Body
from .channels import Channels
from .elasticity import loose_motions
from .law import Elsewhere
from .match import PAIR

SAGS = 0.05  # of what a sag is more: error of geometry, density and linear elasticity
SWINGS = 0.1  # of the motion: computed modes are known to five per cent, their pitches to less


def elsewhere(
    first: tuple[Channels, Body], there: tuple[Channels, Body], turn: np.ndarray, reference
) -> Elsewhere:
    """How a take differs from the first fitted one, both with their bodies.

    turn (m, K): of the first one's computed modes to the measured ones. reference (K, C): weights
    of the channels that give a mode's motion at its reference.
    """
    (data, body), (other, changed) = first, there
    before, pitch = turn.T @ body.seen(data), _pitch(body, turn)
    after, now = before, pitch
    if changed.model is not body.model:
        become = _followed(body, turn, changed)
        after, now = become.T @ changed.seen(other), _pitch(changed, become)
        size = np.linalg.norm(before, axis=1) / np.maximum(np.linalg.norm(after, axis=1), 1e-300)
        way = np.where((after * before).sum(axis=1) < 0, -1.0, 1.0)
        after = after * (way * size)[:, None]  # how far a mode goes is fitted
    unit = (reference * before).sum(axis=1)[:, None]
    sag, more, held = np.zeros(len(data.sigma)), np.zeros(len(other.sigma)), False
    known = data.take.gravity is not None and other.take.gravity is not None
    if known and not loose_motions(body.model):
        sag = body.sag(data)
        more = changed.sag(other) - sag
        held = body.case.shape == "unloaded" and bool(sag.any())
    both = before / unit, after / unit
    return Elsewhere(np.log(now / pitch), both, sag, more, held, 2 * np.pi * pitch[0])


def unsure(one: Elsewhere, data: Channels, omega: float) -> np.ndarray:
    """(C,) by how much what is foretold of such a take may be off, rms, whichever way it goes:
    what turns with the body goes across. The first mode has the pitch `omega` rad/s in the first.
    """
    own = ~data.support
    values, sag = data.values[:, own], one.more[own] / (omega / one.omega) ** 2
    moved = np.nanmean((values - np.nanmean(values, axis=0)) ** 2)
    return np.where(own, np.sqrt(SAGS**2 * np.mean(sag**2) + SWINGS**2 * moved), 0.0)


def _pitch(body: Body, turn: np.ndarray) -> np.ndarray:
    """(K,) Hz of modes made of computed ones."""
    return np.sqrt(body.modes.frequency**2 @ turn**2)


def _followed(body: Body, turn: np.ndarray, changed: Body) -> np.ndarray:
    """(m, K) of the changed body's modes those that the measured ones have become, alike within
    what is degenerate.
    """
    own = body.modes.shapes.reshape(-1, len(turn)) @ turn
    others = changed.modes.shapes.reshape(len(own), -1)
    alike = others.T @ (body.bare.mass @ own)
    modes, of = linear_sum_assignment(-np.abs(alike))
    out = np.zeros_like(alike)
    for j, k in zip(modes, of, strict=True):
        near = np.abs(changed.modes.frequency / changed.modes.frequency[j] - 1) < PAIR
        out[near, k] = alike[near, k] / np.linalg.norm(alike[near, k])
    return out
