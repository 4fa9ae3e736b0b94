"""From a declared fit to a verdict: what is missing, how sure that is, and what to film next.

adequate      what is left is noise, or less than half a per cent of the motion
explained     one or two effects take nearly all of it, on held-out data too
unexplained   something is there, and nothing known takes enough of it, or what is no effect of
              the library takes clearly more
refused       the recording cannot decide
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from .alone import add_second
from .by_two import by_two, or_their_twins, unless_it_weakens
from .carried import carrying
from .damping import find_damping, is_needless
from .decidable import undecidable
from .effects import air_drag
from .exchange import exchanged_alone
from .foils import is_broken, weakens
from .forgotten import more_modes
from .law import TimeFit
from .pair import opened
from .ready import to_their_end, widened
from .residual import AHEAD, EVIDENCE, NOISY, QUIET, excess, strays
from .side_by_side import in_step_by_parts
from .sufficiency import (
    CLEARLY,
    CLEARLY_BOTH,
    ENOUGH,
    adds,
    at_a_bound,
    bends_the_body,
    fails,
    gained,
    is_read_off,
    owes,
    shows,
    sufficient,
)
from .time_layer import (
    MATERIAL,
    Candidate,
    judge,
    passed_over,
    singles,
)
from .timefit import sharp
from .together import two_by_two
from .verdict import Verdict, partly

WEAK = 0.05  # of the motion, rms: more than that is no forgotten weak mode
AT_ITS_END = 0.01  # of how far a law's number may go, from there
MOST = 0.5  # of what one effect leaves, that two take which stand in its place


def diagnose(
    declared: TimeFit,
    free: TimeFit,
    *,
    widen: Callable = lambda found, effects: found,
    start: TimeFit | None = None,
    bodily: Callable = lambda verdict: None,
) -> Verdict:
    """Name what the declared fit lacks: a law of damping first, then an effect, or two.

    `widen` (TimeFit, number of effects -> TimeFit) adds the body's modes that a fit with that
    many effects, its last ones, lays bare. `start`: the declared law at other pitches and damping
    ratios, from where effects are sought. `bodily` (Verdict -> Verdict or None): what one effect
    explains with the body's low modes that nobody heard.
    """
    why = undecidable(free)
    if why:
        return Verdict("refused", ((None, declared),), (), (), (), (), why)
    as_declared = partial(_told, declared, widen, start or declared, bodily)
    lacking = find_damping(declared, free)
    if lacking is None:
        return as_declared()
    damping, twins = lacking
    if _is_noise(declared):
        minor = ((damping.names[0], gained(declared, damping.found)),)
        return replace(as_declared(), minor=minor)
    then = _told(damping.found, widen, damping.found, bodily)
    if then.effects and is_needless(then.complete, declared):
        plain = as_declared()
        if plain.verdict == then.verdict and plain.names == then.names:
            return plain
    first = ((None, declared), (damping.names[0], damping.found))
    return replace(
        then,
        verdict="explained" if then.verdict == "adequate" else then.verdict,
        chain=first + then.chain[1:],
        effects=(damping, *then.effects),
        twins=(twins, *then.twins),
        ranked=(damping, *then.ranked),
    )


def _is_noise(declared: TimeFit) -> bool:
    """Whether what the declared fit leaves is noise, or hardly more, and a trifle of the motion."""
    quiet = declared.chi2 < QUIET * declared.samples and excess(declared) < MATERIAL
    return quiet and not fails(declared)


def _told(declared: TimeFit, widen: Callable, start: TimeFit, bodily: Callable) -> Verdict:
    verdict = _diagnose(declared, widen, start, bodily)
    return verdict if verdict.whole else _if_all_told(_sharpened(verdict))


def with_both(verdict: Verdict) -> Verdict | None:
    """Of a verdict of one effect that stays unexplained, whatever else was tried, that of the two
    which explain it; None where there are none.
    """
    if verdict.verdict != "unexplained" or verdict.rather is None or verdict.laws:
        return None
    both = _if_all_told(_sharpened(verdict.rather))
    return both if both.verdict == "explained" else None


def _if_all_told(verdict: Verdict) -> Verdict:
    """The verdict; "unexplained", with the same names as its parts, where they leave too much."""
    if verdict.verdict == "explained" and _lacks(verdict):
        return replace(verdict, verdict="unexplained")
    return verdict


def _lacks(verdict: Verdict) -> bool:
    """Whether what was found owes an explanation of what it leaves, two effects sooner, or tells
    that only in another body, or as strong as nothing is.
    """
    clearly = CLEARLY if len(verdict.effects) < 2 else CLEARLY_BOTH
    final, declared = verdict.final, verdict.chain[0][1]
    otherwise = bends_the_body(final) or bool(at_a_bound(final, declared))
    return otherwise or owes(final, declared, clearly)


def _sharpened(verdict: Verdict) -> Verdict:
    """The same, with what was found in coarse steps fitted and judged in fine ones."""
    declared = verdict.chain[0][1]
    coarse = list(dict.fromkeys(found for _, found in verdict.chain))
    sharper = in_step_by_parts([partial(sharpened, found) for found in coarse])
    fine = dict(zip(coarse, sharper, strict=True))
    return replace(
        verdict,
        chain=tuple((name, fine[found]) for name, found in verdict.chain),
        effects=tuple(judge(c.names, fine[c.found], declared) for c in verdict.effects),
        ranked=tuple(
            judge(c.names, fine[c.found], declared) if c.found in fine else c
            for c in verdict.ranked
        ),
    )


def sharpened(found: TimeFit) -> TimeFit:
    """The fit in fine steps, a pair's two pitches opened, with what its forces feel of the rest."""
    return carrying(opened(sharp(found)))


def _diagnose(declared: TimeFit, widen: Callable, start: TimeFit, bodily: Callable) -> Verdict:
    chain = ((None, declared),)
    over = excess(declared)
    if _is_noise(declared):
        return Verdict("adequate", chain, (), (), (), ())
    found, left = singles(start, declared)
    able = to_their_end(exchanged_alone(found, declared), declared)
    ranked = tuple(c for c in able if not c.outdone)
    seen = [c for c in ranked if c.evidence > EVIDENCE]
    strong = _strong(seen, declared)
    shown = any(shows(c, declared) for c in strong)
    little = (not strong and declared.chi2 < NOISY * declared.samples) or over < MATERIAL
    if little and not shown and not strays(declared):
        minor = tuple((c.names[0], gained(declared, c.found)) for c in seen)
        return Verdict("adequate", chain, (), (), ranked, minor)
    if over < WEAK and not fails(declared) and more_modes(declared, strong):
        return Verdict("adequate", chain, (), (), ranked, ())
    drags = bool(strong) and strong[0].names == (air_drag.EFFECT.name,)
    if drags and _is_noisy(strong[0].found):
        told = "explained" if sufficient(strong[0], ENOUGH) else "unexplained"
        drag = bodily(replace(partly(chain, strong[0], strong, ranked), verdict=told))
        if drag:
            return drag
    strong = widened(strong, declared, widen)
    alone, known, done = _one(chain, (able, ranked, strong), over)
    if done:
        return alone
    ringing = alone and _with_what_it_rings(alone, bodily)
    if ringing:  # one effect goes before two
        return ringing
    late = passed_over(left, able, declared)
    able = [*able, *late]
    most = max((c.evidence for c in strong), default=EVIDENCE)
    leaders = [c for c in _strong(late, declared) if not c.outdone and c.evidence > most]
    if leaders and alone is None:  # what one tells alone stands; else these only began badly
        leaders = widened(leaders, declared, widen)
        ranked = tuple(sorted([*leaders, *ranked], key=lambda c: -c.evidence))
        strong = [*leaders, *strong]
        alone, known, done = _one(chain, (able, ranked, strong), over)
        if done:
            return alone
    both = by_two(chain, (able, ranked, strong, known), over, widen)
    # such two as owe a little are named all the same: they tell more than one of them
    told = both.verdict == "explained" and not owes(both.final, declared)
    if told and alone and _is_read_off(both) and not _is_read_off(alone):
        told = _takes_most(both, alone)
    if told and alone and not _lacks(alone):  # all that one leaves, or nothing
        told = _does_more(both, alone)
    if both.verdict == "unexplained" and both.effects and alone and _lacks(alone):
        told = _pair(both, alone).evidence > EVIDENCE  # none explains: the likelier parts
    return both if alone is None or told else replace(alone, rather=both.rather)


def _strong(seen: list[Candidate], declared: TimeFit) -> list[Candidate]:
    """Those of the candidates that matter; where so little is left, here and ahead, that take all
    of it.
    """
    strong = [c for c in seen if gained(declared, c.found) >= MATERIAL or shows(c, declared)]
    if declared.chi2 < QUIET * declared.samples and not fails(declared):
        strong = [c for c in strong if c.share >= ENOUGH]
    return strong


def _one(chain, singles: tuple, over: float) -> tuple[Verdict | None, dict, bool]:
    """What the best single effect says, and a second one beside it where that shows, or None where
    it is not enough; what was sought beside single effects, by their fits; whether that is all.
    singles: all, those that may be there alone, and the strong ones.
    """
    declared, (able, ranked, strong) = chain[0][1], singles
    if not strong or not sufficient(strong[0], ENOUGH):
        return None, {}, False
    if is_broken(declared, strong[0]):
        return Verdict("unexplained", chain, (), (), ranked, ()), {}, True
    if weakens(declared, strong[0]):
        return partly(chain, strong[0], strong, ranked), {}, True
    single, known = add_second(chain, strong, ranked, over)
    if len(single.effects) > 1:
        single = or_their_twins(single, (able, ranked), over)
    alone = unless_it_weakens(single, able)
    return alone, known, not _lacks(alone) and not _loud(alone, known)


def _with_what_it_rings(alone: Verdict, bodily: Callable) -> Verdict | None:
    """What one effect that is a force explains with the body's low modes, where that leaves noise;
    else None. Whether it explains is asked anew: that it did without them is not enough.
    """
    if len(alone.effects) > 1 or not alone.effects[0].found.law.effects[-1].force:
        return None
    told = bodily(replace(_sharpened(alone), verdict="unexplained"))
    return told if told and told.verdict == "explained" else None


def _is_noisy(found: TimeFit) -> bool:
    """Whether a fit leaves more than noise where it was fitted."""
    return found.chi2 > NOISY * found.samples


def _is_read_off(verdict: Verdict) -> bool:
    effects = verdict.final.law.effects
    return is_read_off([e for e in effects if e.name in verdict.names])


def _loud(alone: Verdict, known: dict) -> bool:
    """Whether one effect leaves more than noise where all are sought two by two, or another one
    takes most of that beside it; or clearly more ahead; or a little, with a law that is bent as far
    as it may be: it may bend itself to do nearly what two others do. known: what was sought beside
    single effects, by their fits.
    """
    final = alone.final
    if len(alone.effects) > 1:
        return False
    first, beside = alone.effects[0], known.get(final, ())
    seen = [c for c in beside if c.evidence > EVIDENCE and not c.outdone]
    more = two_by_two(alone.chain[0][1]) or any(adds(first, c) for c in seen)
    return (_is_noisy(final) and more) or strays(final, AHEAD) or _is_bent(final)


def _is_bent(found: TimeFit) -> bool:
    """Whether what bends a pitch leaves more than noise, and how its force grows with the way, its
    second number, is as far from where it is sought as it may be.
    """
    effect = found.law.effects[-1]
    if found.chi2 < QUIET * found.samples or not (effect.bends and effect.scales):
        return False
    low, high, own = (x[1] for x in (effect.low, effect.high, found.theta[-1][0]))
    begins = np.array([begin[1] for begin in effect.starts(found.law.setting, None)])
    near = AT_ITS_END * (high - low)
    at_its_end = own < low + near or own > high - near
    return bool(at_its_end and (np.abs(begins - own) > near).all())


def _does_more(both: Verdict, alone: Verdict) -> bool:
    """Whether what was found together leaves noise, and takes most of what one effect leaves; or
    nearly all, here and ahead, of what one leaves that is off there.
    """
    if both.final.chi2 >= NOISY * both.final.samples:
        pair = _pair(both, alone)
        nearly_all = pair.share > ENOUGH and pair.held_share > ENOUGH
        return strays(alone.final, AHEAD) and nearly_all
    return _takes_most(both, alone) or _mends_ahead(both, alone)


def _mends_ahead(both: Verdict, alone: Verdict) -> bool:
    """Whether what was found together takes most of what one effect leaves that is off ahead,
    however little of it shows where it was fitted.
    """
    pair, final = _pair(both, alone), alone.final
    fitted = final.chi2 < NOISY * final.samples or pair.share > MOST
    return strays(final, AHEAD) and fitted and pair.held_share > MOST and pair.evidence > EVIDENCE


def _takes_most(both: Verdict, alone: Verdict) -> bool:
    """Whether what was found together takes most of what the other leaves."""
    pair = _pair(both, alone)
    material = gained(alone.final, both.final) >= MATERIAL and pair.evidence > EVIDENCE
    return material and pair.share > MOST and not pair.held_share < MOST


def _pair(both: Verdict, alone: Verdict) -> Candidate:
    """What was found together, beside the fit with the other."""
    return judge(tuple(c.names[0] for c in both.effects), both.final, alone.final)
