"""A rub in a plane, where what rubs along a line leaves that a place also moves sideways."""

import numpy as np

from .effects.dry_friction import IN_PLANE
from .law import TimeFit
from .refit import lighter, put
from .residual import NOISY, pays
from .timefit import best_fit, misfits, within

SIDEWAYS = (0.5, 2.0)  # share of a higher mode across the line, from which the search begins
STRONGER = (1.0, 3.0)  # times as strong as along a line, elsewhere on the body
RUNNERS = 2  # of those beside the line, and of those elsewhere


def in_plane(found: TimeFit, effects: int) -> TimeFit:
    """The fit with the rub among its last so many effects in a plane, where that shows; else
    itself.
    """
    law = found.law
    at = [
        i
        for i in range(len(law.effects) - effects, len(law.effects))
        if law.effects[i].name == IN_PLANE.name and law.effects[i].axes == 1
    ]
    if not at or law.modes == 1 or found.chi2 < NOISY * found.samples:
        return found
    own = found.theta[at[0]][0]
    beside = [np.r_[own, size * row] for row in np.eye(law.modes - 1) for size in SIDEWAYS]
    size, *travel = own[: len(IN_PLANE.low)]
    elsewhere = [
        np.r_[size * more, travel, one.ravel()] for one in law.setting.planes for more in STRONGER
    ]
    starts = []
    for thetas in filter(None, (beside, elsewhere)):
        # what rubs sideways was put down to the damping of what swings that way
        ones = (found,) if law.damping == "none" else (found, lighter(found))
        both = [put(one, at[0], IN_PLANE, thetas) for one in ones]
        law = both[0][0]
        some = np.unique(within(law, np.vstack([some for _, some in both])), axis=0)
        starts += [*some[np.argsort(misfits(law, some, found.samples))[:RUNNERS]]]
    wider = best_fit(law, np.array(starts), evaluations=20)
    return wider if pays(wider, found) else found
