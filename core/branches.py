"""The second time of a relaxation, where a recording shows two of those that real rubber has."""

import numpy as np

from .effects.relaxation import BRANCHED, unseen
from .law import TimeFit
from .refit import put
from .residual import NOISY, pays
from .timefit import best_fit, misfits

TIMES = (1 / 8, 1 / 3, 3.0, 8.0)  # of the first time, from which the other one is sought
RUNNERS = 2  # of those
APART = 2.0  # ratio of the times, below which they are one
ALIKE = 0.8  # cosine of their shapes: both are of the pose that it was let go from


def with_branch(found: TimeFit, effects: int) -> TimeFit:
    """The fit with a second time of the relaxation among its last so many effects, where it shows;
    else itself.
    """
    first = len(found.law.effects) - effects
    names = [effect.name for effect in found.law.effects[first:]]
    if BRANCHED.name not in names or found.chi2 < NOISY * found.samples:
        return found
    at = first + names.index(BRANCHED.name)
    slow = found.theta[at][0]
    if len(slow) == len(BRANCHED.low):
        return found
    law, starts = put(found, at, BRANCHED, [np.r_[slow, slow + np.log(f)] for f in TIMES])
    likely = np.argsort(misfits(law, starts, found.samples))[:RUNNERS]
    wider = best_fit(law, starts[likely], evaluations=20)
    return wider if pays(wider, found) and _is_one(wider, at) else found


def _is_one(wider: TimeFit, at: int) -> bool:
    """Whether effect number `at` has two times that show and lie apart, of one creep."""
    theta = wider.theta[at][0]
    if unseen(theta, wider.law.setting) or np.ptp(theta) < np.log(APART):
        return False
    data = wider.law.takes[wider.law.fitted[0]]
    a, b = (wider.column_shapes()[at] / data.sigma[:, None])[~data.support].T
    return float(a @ b) > ALIKE * float(np.linalg.norm(a) * np.linalg.norm(b))
