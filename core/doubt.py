"""How surely a body is not as declared, by its pitches, shapes and sag, and a change mends that."""

import numpy as np
from scipy.stats import chi2 as chi2_law

from .body_error import SHOWN, body_error, mends
from .compare import PIECES, Hypothesis, Measured
from .effects import split_modes
from .ground import Ground, moved
from .law import TimeFit
from .modal_layer import Suspect
from .residual import Error, errors
from .sufficiency import gained
from .twins import creeps
from .unmatched import ADDED, acts
from .verdict import Verdict

DOUBT = 1e-3  # chance below which pitches and shapes do not fit the declared body
FITS = 0.05  # chance from which they fit a changed one
SLIGHT = 0.01  # of the motion, rms, and of a pitch, up to which what acts in time is a trifle
EVIDENCE = 10.0  # gain in BIC (Kass and Raftery 1995: very strong)
ENOUGH = 0.6  # share of the misfit that an effect of the body must take
CLEAR = 6.0  # misfit per piece above which no known effect is a finding in itself


def chance_of(body: Hypothesis, measured: Measured) -> float:
    """That a body as this one shows its pitches so far off, or its sag alone beside them."""
    pull, K = body.pitch_pull, len(measured.frequency)
    known = len(pull) - 1 + np.count_nonzero(body.shifts.pull)
    whole = chi2_law.sf(body.pitch_chi2, max(known, 1))
    if len(pull) == K:
        return float(whole)
    alone = pull[K] ** 2 / body.free[K]
    return float(2 * min(whole, chi2_law.sf(alone, 1)))


def pieces(ground: Ground) -> float:
    """Pieces of what was measured of the body: a misfit of so much is chance."""
    K = len(ground.measured.frequency)
    return K * PIECES + (K - 1) + (ground.pull is not None) + ground.shifted


def least_chance(verdict: Verdict) -> float:
    """Chance below which the body is another one: a second cause needs to be clearer, unless the
    first hardly moves anything, or bends nothing.
    """
    slight = not acts(verdict.damped) and _is_slight(verdict)
    return DOUBT**2 if acts(verdict.final, *ADDED) and not slight else DOUBT


def _is_slight(verdict: Verdict) -> bool:
    """Whether what was found in time hardly shows, moves no pitch, and is no creep, which a sag
    would show more of.
    """
    final, damped = verdict.final, verdict.damped
    little = gained(damped, final) < SLIGHT and moved(final, damped).max() < SLIGHT
    return little and not creeps(verdict)


def moves_otherwise(verdict: Verdict, ground: Ground) -> bool:
    """Whether shapes alone, which nothing that acts in time has bent, are so far off that what was
    recorded shows it.
    """
    if acts(verdict.final) or ground.base.chi2 < CLEAR * pieces(ground):
        return False
    return any(body_error(verdict.damped, ground, ground.base).over(errors(verdict.damped), SHOWN))


def is_able(one: Suspect, ground: Ground) -> bool:
    """Whether it is clear, takes enough of the misfit and is surely not nothing."""
    over = max(ground.base.chi2 - pieces(ground), 0.0)
    takes = ground.base.chi2 - one.hypothesis.chi2 > ENOUGH * over
    return one.evidence > EVIDENCE and takes and not _may_be_nothing(one)


def _may_be_nothing(suspect: Suspect) -> bool:
    """Whether its interval holds the value that changes nothing: not even its sign is known."""
    if suspect.effect.nothing is None:
        return False
    name, value = suspect.effect.nothing
    values = [report[name] for _, report, _ in suspect.near]
    return min(values) < value < max(values)


def mends_all(one: Suspect, base: Hypothesis, measured: Measured) -> bool:
    """Whether it is twice as clear as it must be, and nothing is the matter with it: it leaves no
    more faint modes aside than the declared body does.
    """
    clear = one.evidence > 2 * EVIDENCE and one.hypothesis.strange <= base.strange
    return clear and chance_of(one.hypothesis, measured) > FITS


def bends(final: TimeFit) -> bool:
    """Whether what acts may change shapes and pitches, too: all but what acts on every mode in its
    own shape, as drag and a stiffness that drifts do.
    """
    acting = [e for e in final.law.effects if e.layer in ("time", "camera")]
    return any(e.acceleration is None for e in acting)


def judged(verdict: Verdict, ground: Ground, best: Suspect | None, alike) -> tuple[tuple, tuple]:
    """Errors with the best change of the body, as it is declared, and of free modes: in the
    declared fit's terms, and in those that decide.

    Where what acts in time has bent the declared fit's modes, their shapes say little of the
    body's. Then a change that mends all, shapes too, beside what explains the rest is held against
    the final fit.
    """
    declared, final = verdict.damped, verdict.final

    def in_terms_of(fit: TimeFit) -> tuple[Error | None, Error, Error]:
        with_it = best and body_error(declared, ground, best.hypothesis, fit=fit)
        return with_it, body_error(declared, ground, ground.base, alike, fit), errors(fit)

    seen = in_terms_of(declared)
    if not best or mends(*seen) or verdict.verdict != "explained":
        return seen, seen
    bent = bends(final) and acts(final, split_modes.EFFECT.name, *ADDED)
    whole = mends_all(best, ground.base, ground.measured)
    whole = whole and best.hypothesis.chi2 < pieces(ground)
    return seen, in_terms_of(final) if bent and whole else seen
