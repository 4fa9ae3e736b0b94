"""When effects are the explanation: what they must take, where it was fitted and held out."""

import numpy as np

from .effects.further_mode import is_further, ran_off
from .foretold import doubt
from .law import TRUST, TimeFit
from .refit import without
from .residual import AHEAD, NOISY, errors, excess, misfit, noise_share, strays
from .settle import MUCH
from .time_layer import EDGE, MATERIAL, Candidate, judge, refuted

ENOUGH = 0.80  # share of the excess that one effect must take to be the explanation
ENOUGH_HELD = 0.70  # the same on held-out samples
ALL = 0.95  # as ENOUGH, where it is read off the record and has to take nearly everything
ENOUGH_BOTH = 0.88  # for two effects, which have more freedom
SECOND_SIZE = 0.25  # of the declared fit's excess, rms, that a second effect must take
SECOND, SECOND_HELD = 0.6, 0.5  # share of what the first leaves that a second must take
NEARLY_ALL = 0.97  # share of the excess where what was held out is still far off
ASTRAY = 5.0  # times its noise, from which a held-out prediction is no explanation
CLEARLY = 1.4  # times its noise, from which what was held out is clearly off
CLEARLY_BOTH = 1.25  # the same of two effects, which bend themselves to more than they are
TRIFLE, PART = 0.1, 0.25  # rms, of what was off before, that an explanation may leave: held, fitted
WHOLE = 1.0  # error of a prediction that nothing moves
BENT = 2.0 / TRUST  # of a mode's size, from which it is another body's: two standard deviations
LOUD = 0.05  # of the strongest mode, from which another one's size shows


def fails(declared: TimeFit, much: float = NOISY) -> bool:
    """Whether what was held out is predicted worse, `much` times, than its noise allows, and what
    the fitted part cannot tell.
    """
    left, count = misfit(declared.law.takes, declared.predicted, True)
    return left > much * count and left > much * (count + doubt(declared))


def bends_the_body(found: TimeFit) -> bool:
    """Whether a fit needs modes of other sizes, and so of other masses, than the body's: what acts
    on that is none of what was fitted, however little is left.
    """
    return bool((found.sizes_off[loud(found)] > BENT).any())


def at_a_bound(found: TimeFit, declared: TimeFit) -> list[str]:
    """Names of the effects, beyond the declared ones, that may act either way and are as strong as
    they may be: what needs more of one is something else.
    """
    return [
        effect.name
        for effect, theta in zip(found.law.effects, found.theta, strict=True)
        if effect.scales
        and effect not in declared.law.effects
        and not EDGE * effect.low[0] < theta[0][0] < EDGE * effect.high[0]
    ]


def is_drowned(found: TimeFit) -> bool:
    """Whether the strongest mode hardly rings beside what was found: what stops it is not told."""
    return bool(found.damping_ratio[found.loudest] > MUCH)


def loud(found: TimeFit) -> np.ndarray:
    """(K,) bool: modes whose size shows."""
    swings = np.array(found.swings)
    return swings > LOUD * swings.max()


def owes(found: TimeFit, declared: TimeFit, clearly: float = CLEARLY) -> bool:
    """Whether effects that take most of what was off leave clearly more than noise, and more than a
    trifle of it: what they lack has a cause too. So has what stops the swings beside them.

    What is read off the record is there as it was, so that what it leaves is no trifle; nor is an
    error as large as the motion itself, which nothing at all would have predicted better.
    """
    if is_drowned(found):
        return True
    noise = noise_share(declared.law.takes, True, doubted=True)
    after, before = (errors(one).held_out for one in (found, declared))
    read = is_read_off([e for e in found.law.effects if e not in declared.law.effects])
    trifle = 0.0 if read else TRIFLE * _beyond(before, noise)
    if after > clearly * noise > 0 and (_beyond(after, noise) > trifle or after > WHOLE):
        return True
    noisy = found.chi2 > NOISY * found.samples
    return noisy and excess(found) > PART * excess(declared)


def is_read_off(effects) -> bool:
    """Whether all of the effects, but the further modes, are read off the record: so free, two of
    them tell anything.
    """
    own = [e for e in effects if not is_further(e)]
    return bool(own) and all(e.free for e in own)


def _beyond(error: float, noise: float) -> float:
    return float(np.sqrt(max(error**2 - noise**2, 0.0)))


def shows(candidate: Candidate, declared: TimeFit) -> bool:
    """Small beside the first swings, but what the dying motion cannot be predicted without."""
    return fails(declared) and candidate.confirmed


def gained(before: TimeFit, after: TimeFit) -> float:
    """RMS that a fit takes away, as a share of the motion's RMS."""
    return float(np.sqrt(max(excess(before) ** 2 - excess(after) ** 2, 0)))


def sufficient(candidate: Candidate, enough: float, *, nearly: bool = False) -> bool:
    """Takes nearly all of the excess, where it was fitted and where it was held out.

    `nearly`: what was held out may still be predicted worse than noise, by far.
    """
    if bends_the_body(candidate.found):
        return False
    takes = candidate.found.chi2 < NOISY * candidate.found.samples
    found = candidate.found.law.effects[-len(candidate.names) :]
    takes |= candidate.share >= (ALL if all(e.free for e in found) else enough)
    if nearly:
        return takes and not candidate.held_share < ENOUGH_HELD
    ahead = NEARLY_ALL if strays(candidate.found) else ENOUGH_HELD
    return takes and not candidate.held_share < ahead and not strays(candidate.found, ASTRAY)


def one_of(declared: TimeFit, both: TimeFit, over: float, least: float) -> Candidate | None:
    """The one of two effects that does without the other, with more evidence than `least`.

    The search for it may have missed it; the second one then only led the way there.
    """
    effects = both.law.effects
    for dropped, kept in ((-2, -1), (-1, -2)):
        alone = without(both, len(effects) + dropped)
        one = judge((effects[kept].name,), alone, declared)
        strayed = ran_off(alone) and not ran_off(both)
        if one.evidence <= least or strayed or not sufficient(one, ENOUGH):
            continue
        pair = judge((effects[kept].name, effects[dropped].name), both, alone)
        if not (refuted(alone) or counts_second(one, pair, over)):
            return one
    return None


def adds(first: Candidate, second: Candidate) -> bool:
    """Whether a second effect is material, and takes most of what the first leaves, held out too.

    So it may be a part of what stays unexplained, however little that is. A clock that goes wrong
    after the fitted part takes nothing there.
    """
    before = {e.name for e in first.found.law.effects}
    own = [e for e in second.found.law.effects if e.name not in before]
    late = any(e.clock for e in own) and strays(first.found, AHEAD)
    if late and second.held_share >= ENOUGH_BOTH:
        return True
    most = second.share >= SECOND and not second.held_share < SECOND_HELD
    return most and gained(first.found, second.found) >= MATERIAL


def counts_second(first: Candidate, second: Candidate, over: float) -> bool:
    """Whether a second effect is material, and takes most of what the first leaves, in this body.

    It may be small beside the first where it leaves nothing but noise, held out too. Where the
    first is off ahead, what mends that, or nearly all of it where it is far off, counts, however
    little it is: if the first tells what was fitted, or the second all that it leaves there. So
    does what leaves noise ahead where a first that tells what was fitted leaves more: that may have
    bent itself to nearly what two others do.
    """
    if bends_the_body(second.found):
        return False
    size = gained(first.found, second.found)
    nothing = second.found.chi2 < NOISY * second.found.samples and not fails(second.found)
    all_of_it = nothing and second.share >= ENOUGH_BOTH
    ahead = strays(first.found, AHEAD) and (not fails(second.found) or strays(first.found))
    quiet = first.found.chi2 < NOISY * first.found.samples
    if ahead and (quiet or all_of_it) and second.held_share >= ENOUGH_BOTH:
        return True
    if quiet and _mends(first.found, second.found):
        return True
    return adds(first, second) and (size >= SECOND_SIZE * over or all_of_it)


def _mends(first: TimeFit, second: TimeFit) -> bool:
    """Whether a fit leaves noise of what was held out where another one leaves more, and takes
    nearly all of that.
    """
    if not fails(first) or fails(second):
        return False
    (before, count), (after, _) = (misfit(f.law.takes, f.predicted, True) for f in (first, second))
    return before - after > ENOUGH_BOTH * (before - count)
