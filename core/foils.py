"""Laws that are no effects of the library, against which the best effect is weighed."""

from .effects import weakening_friction
from .effects.sudden_change import FOIL
from .law import TimeFit
from .race import Try, race
from .refit import swapped
from .residual import AHEAD, EVIDENCE, NOISY, QUIET, misfit, strays
from .screen import screen
from .time_layer import Candidate, judge
from .timefit import best_fit, fit, sharp

HALF = 0.5  # of what the best effect leaves is what a sudden change may leave to be the cause
NEARLY = 0.9  # of what two effects gain over a plain friction, that this law gains
WEAKENED = 0.7  # the same of a friction's own law, freed to weaken


def is_broken(declared: TimeFit, best: Candidate) -> bool:
    """Whether one sudden change of stiffness accounts for clearly more than the best effect."""
    if best.found.chi2 < NOISY * best.found.samples:
        return False
    begins = FOIL.starts(declared.law.setting, None)
    found = race(Try(declared, screen(declared, FOIL, begins), FOIL, begins))
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
    weak = _weakened(plain)
    # the foil may only have led the way to a better plain one
    begins = [weakening_friction.without(weak.theta[-1][0])]
    law, starts = swapped(weak, plain.law.effects[-1], begins)
    again = fit(law, starts[0], evaluations=20)
    plain = min(plain, again, key=lambda found: found.chi2)
    before, after = (judge(best.names, found, declared).evidence for found in (plain, weak))
    # where it comes to rest a rub is hard to foretell, and the fitted part may say it alone
    fitted, whole = (_left(weak, plain, parts) for parts in ((False,), (False, True)))
    less = fitted < WEAKENED or (fitted <= 1 and whole < WEAKENED)
    return after > before + EVIDENCE and less


def weakens_rather(declared: TimeFit, both: TimeFit, rub: Candidate) -> bool:
    """Whether one rub that weakens with speed adds to the plain `rub` what the two effects of a fit
    add, or nearly that: one law that is not known is likelier than two that are, unless only the
    two leave nothing but noise, and foretell the rest.
    """
    plain = sharp(rub.found)
    fits = plain, sharp(both), _weakened(plain)
    noisy = [found.chi2 >= NOISY * found.samples for found in fits[1:]]
    if noisy == [False, True] and not strays(fits[1], AHEAD):
        return False
    alone, pair, weak = (judge(rub.names, found, declared).evidence for found in fits)
    return weak > alone + EVIDENCE and weak - alone > NEARLY * (pair - alone)


def _weakened(plain: TimeFit) -> TimeFit:
    """The fit with a rub that may weaken in place of its last effect, a plain one."""
    begins = weakening_friction.starts(plain.theta[-1][0])
    along = plain.law.effects[-1].axes == 1
    foil = weakening_friction.FOIL if along else weakening_friction.IN_PLANE
    law, starts = swapped(plain, foil, begins)
    return best_fit(law, starts, evaluations=20)


def _left(weak: TimeFit, plain: TimeFit, parts: tuple[bool, ...]) -> float:
    """Share of what a plain rub leaves beyond noise that the other one leaves; all of it where both
    leave next to nothing, which tells no law.
    """
    next_to_nothing = QUIET - 1
    over, left = (_over(one, parts) for one in (plain, weak))
    if max(over, left) <= next_to_nothing:
        return 1.0
    return left / max(over, next_to_nothing)


def _over(found: TimeFit, parts: tuple[bool, ...] = (False, True)) -> float:
    """Misfit beyond noise per sample, of those fitted (False), those held out (True), or both."""
    each = [misfit(found.law.takes, found.predicted, held) for held in parts]
    left, count = (sum(part) for part in zip(*each, strict=True))
    return left / max(count, 1) - 1
