"""A rub that weakens as it moves faster, so that it sticks and slips: no effect of the library.

Law         f = -F z (1 - w + w exp(-(x' / s)^2)), z as in dry_friction, s a speed
Tells       the dead stop of dry_friction, but it comes sooner than the fall of the envelope says
Looks like  dry_friction: what it is weighed against, being no effect to bake
Source      Armstrong-Helouvry, Dupont and Canudas de Wit, Automatica 30 (1994) 1083: Stribeck
"""

from dataclasses import replace

import numpy as np

from . import dry_friction
from .base import Effect


def force(theta, setting):
    """theta = (those of dry_friction, share that speed takes away, log of speed over omega A)."""
    return _weaker(theta, setting, dry_friction.force(theta, setting))


def force_in_plane(theta, setting):
    """The same, of a rub in a plane."""
    return _weaker(theta, setting, dry_friction.force_in_plane(theta, setting))


def _weaker(theta, setting, plain):
    pace = np.exp(theta[:, 3]) * setting.omega[0] * setting.amplitude

    def push(state):
        square = np.atleast_2d(state.dx / pace) ** 2
        return plain(state) * (1 - theta[:, 2] * (1 - np.exp(-square.sum(axis=0))))

    return push


FOIL = Effect(
    name="friction that weakens with speed",
    layer="time",
    parameters=(),
    twins=("dry_friction",),
    settle="oil the rubbing place, or lift it, and film again",
    low=(*dry_friction.EFFECT.low, 0.0, np.log(0.05)),
    high=(*dry_friction.EFFECT.high, 0.98, np.log(0.5)),
    force=force,
    sudden=True,
)

IN_PLANE = replace(FOIL, force=force_in_plane, axes=2)


def starts(theta: np.ndarray) -> list[np.ndarray]:
    """Where the search begins, from the fitted dry friction `theta` (p,), its place included."""
    own, place = theta[:2], theta[2:]
    return [
        np.r_[own[0] * more, own[1], share, np.log(pace), place]
        for more, share, pace in (
            (1.5, 0.4, 0.1),
            (1.5, 0.4, 0.2),
            (3.0, 0.7, 0.1),
            (3.0, 0.7, 0.3),
        )
    ]


def without(theta: np.ndarray) -> np.ndarray:
    """The dry friction that is as strong at speed, at the same place."""
    return np.r_[theta[0] * (1 - theta[2]), theta[1], theta[4:]]
