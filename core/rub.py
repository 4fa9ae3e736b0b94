"""A rub in a plane, where what rubs along a line leaves that a place also moves sideways."""

import numpy as np

from .effects.dry_friction import IN_PLANE
from .law import TimeFit
from .refit import put
from .residual import NOISY, bic
from .timefit import best_fit, misfits

SIDEWAYS = (0.5, 2.0)  # share of a higher mode across the line, from which the search begins
RUNNERS = 2  # of those places
SHARE = 0.2  # of what is left that it must take
EVIDENCE = 20.0  # gain in BIC that it must bring


def in_plane(found: TimeFit, effects: int) -> TimeFit:
    """The fit with the rub among its last so many effects in a plane, where that shows; else
    itself.
    """
    law = found.law
    at = [
        i
        for i in range(len(law.effects) - effects, len(law.effects))
        if law.effects[i].name == IN_PLANE.name and law.effects[i].ways == 1
    ]
    if not at or law.modes == 1 or found.chi2 < NOISY * found.samples:
        return found
    across = [size * row for row in np.eye(law.modes - 1) for size in SIDEWAYS]
    thetas = [np.r_[found.theta[at[0]][0], one] for one in across]
    law, starts = put(found, at[0], IN_PLANE, thetas)
    likely = np.argsort(misfits(law, starts, found.samples))[:RUNNERS]
    wider = best_fit(law, starts[likely], evaluations=20)
    less = found.chi2 - wider.chi2 > SHARE * (found.chi2 - found.samples)
    return wider if less and bic(wider) < bic(found) - EVIDENCE else found
