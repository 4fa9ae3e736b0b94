"""Laws that are no effects of the library, against which the best effect is weighed."""

from dataclasses import replace

import numpy as np

from .effects import weakening_friction
from .effects.sudden_change import FOIL
from .law import TimeFit
from .residual import NOISY, QUIET, misfit
from .time_layer import EVIDENCE, Candidate, judge, race
from .timefit import best_fit, fit, screen, sharp

HALF = 0.5  # of what the best effect leaves is what a sudden change may leave to be the cause
WEAKENED = 0.7  # the same of a friction's own law, freed to weaken


def is_broken(declared: TimeFit, best: Candidate) -> bool:
    """Whether one sudden change of stiffness accounts for clearly more than the best effect."""
    if best.found.chi2 < NOISY * best.found.samples:
        return False
    begins = FOIL.starts(declared.law.setting, None)
    found = race(declared, FOIL, begins, screen(declared, FOIL, begins))
    rival = judge((FOIL.name,), found, declared)
    more = rival.evidence > best.evidence + EVIDENCE
    return more and 1 - rival.share < HALF * (1 - best.share)


def weakens(declared: TimeFit, best: Candidate) -> bool:
    """Whether the best effect is a rub that clearly weakens with speed, in fine steps."""
    if best.names[-1] != "dry_friction":
        return False
    plain = sharp(best.found)
    if _over(plain) < QUIET - 1:
        return False
    weak = _weakening(plain)
    again = _plain(weak, plain)  # the foil may only have led the way to a better plain one
    plain = min(plain, again, key=lambda found: found.chi2)
    before, after = (judge(best.names, found, declared).evidence for found in (plain, weak))
    return after > before + EVIDENCE and _over(weak) < WEAKENED * _over(plain)


def _over(found: TimeFit) -> float:
    """Misfit beyond noise per sample, of those fitted and those held out."""
    parts = [misfit(found.law.takes, found.predicted, held) for held in (False, True)]
    left, count = (sum(part) for part in zip(*parts, strict=True))
    return left / max(count, 1) - 1


def _weakening(rubbing: TimeFit) -> TimeFit:
    """The fit with its dry friction, the last effect, free to weaken with speed."""
    foil, theta = weakening_friction.FOIL, rubbing.theta[-1][0]
    law = replace(rubbing.law, effects=(*rubbing.law.effects[:-1], foil))
    outer = rubbing.parameters[: len(rubbing.parameters) - len(theta)]
    starts = [np.r_[outer, start] for start in weakening_friction.starts(theta)]
    return best_fit(law, np.array(starts), evaluations=20)


def _plain(weak: TimeFit, plain: TimeFit) -> TimeFit:
    """Dry friction fitted from where the weakening one stands."""
    theta, law = weak.theta[-1][0], plain.law
    outer = weak.parameters[: len(weak.parameters) - len(theta)]
    return fit(law, np.r_[outer, weakening_friction.without(theta)], evaluations=20)
