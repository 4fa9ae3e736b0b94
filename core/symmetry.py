"""Whether a body has pairs of modes by its symmetry, not two modes that happen to lie close."""

import numpy as np

from .data import ElasticModel

EVEN = 0.05  # relative, of two principal second moments; they go with the squares of pitches
CENTRED = 0.1  # of the radius of gyration, that the pins may be off the axis


def is_even(model: ElasticModel) -> bool:
    """Whether a held body is as wide one way as the other across a line through its pins.

    So is every body that a turn by less than half a circle brings to itself: its bending modes
    come in pairs of one pitch (Perrin and Charnley, J. Sound Vib. 29, 1973). Second moments are
    exact for any element: they are those of the mass matrix on linear fields.
    """
    mass = model.mass[::3, ::3]
    share = np.asarray(mass.sum(axis=0)).ravel()
    away = model.points - share @ model.points / share.sum()
    moment, axes = np.linalg.eigh(away.T @ (mass @ away) / share.sum())
    pins = away[model.pinned].mean(axis=0) if model.pinned.any() else np.zeros(3)
    for one, two, axis in ((0, 1, 2), (1, 2, 0)):
        if moment[two] <= (1 + EVEN) * moment[one]:
            off = pins - (pins @ axes[:, axis]) * axes[:, axis]
            if np.ptp(moment) <= EVEN * moment[0] or off @ off <= CENTRED**2 * moment.sum():
                return True
    return False
