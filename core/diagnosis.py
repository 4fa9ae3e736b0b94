"""From a declared fit to a verdict: what is missing, how sure that is, and what to film next.

adequate      what is left is noise, or less than half a per cent of the motion
explained     one or two effects take nearly all of it, on held-out data too
unexplained   something is there, and nothing known takes enough of it, or what is no effect of
              the library takes clearly more
refused       the recording cannot decide
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from .damping import find_damping
from .decidable import undecidable
from .effects import DAMPING
from .exchange import exchanged
from .foils import is_broken, weakens, weakens_rather
from .forgotten import more_modes
from .law import TimeFit
from .ready import RIVALS, polished, to_their_end, widened
from .refit import turned
from .residual import NOISY, QUIET, excess, misfit
from .side_by_side import in_step_by_parts
from .sufficiency import (
    AHEAD,
    ENOUGH,
    ENOUGH_BOTH,
    beats_single,
    counts_second,
    fails,
    gained,
    one_of,
    owes,
    shows,
    strays,
    sufficient,
)
from .time_layer import (
    EVIDENCE,
    MATERIAL,
    NEARLY,
    Candidate,
    judge,
    passed_over,
    seconds,
    singles,
    vetoed,
)
from .timefit import sharp
from .together import FEW, pairs

WEAK = 0.05  # of the motion, rms: more than that is no forgotten weak mode
MOST = 0.5  # of what one effect leaves, that two take which stand in its place


@dataclass(frozen=True, eq=False)
class Verdict:
    """What the time layer found. `chain[0]` is the declared fit; the last is the final one."""

    verdict: str
    chain: tuple[tuple[str | None, TimeFit], ...]
    effects: tuple[Candidate, ...]  # one a found effect, in the order of the chain
    twins: tuple[tuple[str, ...], ...]  # of each found effect
    ranked: tuple[Candidate, ...]
    minor: tuple[tuple[str, float], ...]
    why: str = ""  # a refusal's reason, and what to film instead

    @property
    def final(self) -> TimeFit:
        return self.chain[-1][1]

    @property
    def laws(self) -> int:
        """Laws of damping that were found; they come first in the chain."""
        return sum(name in DAMPING for name, _ in self.chain)

    @property
    def damped(self) -> TimeFit:
        """The declared fit, with the law of damping that was found."""
        return self.chain[self.laws][1]


def diagnose(
    declared: TimeFit,
    free: TimeFit,
    *,
    widen: Callable = lambda found, effects: found,
    start: TimeFit | None = None,
) -> Verdict:
    """Name what the declared fit lacks: a law of damping first, then an effect, or two.

    `widen` (TimeFit, number of effects -> TimeFit) adds the body's modes that a fit with that
    many effects, its last ones, lays bare. `start`: the declared law at other pitches and damping
    ratios, from where effects are sought.
    """
    why = undecidable(free)
    if why:
        return Verdict("refused", ((None, declared),), (), (), (), (), why)
    lacking = find_damping(declared, free)
    if lacking is None:
        return _if_all_told(_sharpened(_diagnose(declared, widen, start or declared)))
    damping, twins = lacking
    then = _if_all_told(_sharpened(_diagnose(damping.found, widen, damping.found)))
    first = ((None, declared), (damping.names[0], damping.found))
    return replace(
        then,
        verdict="explained" if then.verdict == "adequate" else then.verdict,
        chain=first + then.chain[1:],
        effects=(damping, *then.effects),
        twins=(twins, *then.twins),
        ranked=(damping, *then.ranked),
    )


def _if_all_told(verdict: Verdict) -> Verdict:
    """The verdict; "unexplained", with the same names as its parts, where they leave too much."""
    if verdict.verdict != "explained" or not owes(verdict.final, verdict.chain[0][1]):
        return verdict
    return replace(verdict, verdict="unexplained")


def _sharpened(verdict: Verdict) -> Verdict:
    """The same, with what was found in coarse steps fitted and judged in fine ones."""
    declared = verdict.chain[0][1]
    coarse = list(dict.fromkeys(found for _, found in verdict.chain))
    sharper = in_step_by_parts([partial(sharp, found) for found in coarse])
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


def _diagnose(declared: TimeFit, widen: Callable, start: TimeFit) -> Verdict:
    chain = ((None, declared),)
    over = excess(declared)
    if over < MATERIAL and declared.chi2 < QUIET * declared.samples and not fails(declared):
        return Verdict("adequate", chain, (), (), (), ())
    found, left = singles(start, declared)
    able = to_their_end(found, declared)
    ranked = tuple(c for c in able if not c.outdone)
    seen = [c for c in ranked if c.evidence > EVIDENCE]
    strong = [c for c in seen if gained(declared, c.found) >= MATERIAL or shows(c, declared)]
    # where so little is left, here and ahead, it must be all of it
    if declared.chi2 < QUIET * declared.samples and not fails(declared):
        strong = [c for c in strong if c.share >= ENOUGH]
    shown = any(shows(c, declared) for c in strong)
    little = (not strong and declared.chi2 < NOISY * declared.samples) or over < MATERIAL
    if little and not shown and not strays(declared):
        minor = tuple((c.names[0], gained(declared, c.found)) for c in seen)
        return Verdict("adequate", chain, (), (), ranked, minor)
    if over < WEAK and not fails(declared) and more_modes(declared, strong):
        return Verdict("adequate", chain, (), (), ranked, ())
    strong = widened(strong, declared, widen)
    alone, known = None, {}
    if strong and sufficient(strong[0], ENOUGH):
        if is_broken(declared, strong[0]):
            return Verdict("unexplained", chain, (), (), ranked, ())
        if weakens(declared, strong[0]):
            return _partly(chain, strong[0], strong, ranked)
        single, known = _add_second(chain, strong, ranked, over)
        alone = _unless_it_weakens(single, able)
        if not owes(alone.final, declared) and not _loud(alone):
            return alone
    able = [*able, *passed_over(left, able, declared)]
    both = _by_two(chain, (able, ranked, strong, known), over, widen)
    told = both.verdict == "explained" and not owes(both.final, declared)
    if told and alone and _is_read_off(both) and not _is_read_off(alone):
        told = _takes_most(both, alone)
    if told and alone and not owes(alone.final, declared):  # all that one leaves, or nothing
        told = _does_more(both, alone)
    return both if alone is None or told else alone


def _is_read_off(verdict: Verdict) -> bool:
    """Whether all of its effects are read off the record: so free, two of them tell anything."""
    names = {c.names[-1] for c in verdict.effects}
    return bool(names) and all(e.free for e in verdict.final.law.effects if e.name in names)


def _loud(alone: Verdict) -> bool:
    """Whether one effect leaves more than noise where two are sought cheaply: it may bend itself to
    do nearly what two others do.
    """
    final = alone.final
    few = len(alone.effects) == 1 and final.law.modes <= FEW
    return few and final.chi2 > NOISY * final.samples


def _does_more(both: Verdict, alone: Verdict) -> bool:
    """Whether what was found together leaves noise, and takes most of what one effect leaves."""
    return both.final.chi2 < NOISY * both.final.samples and _takes_most(both, alone)


def _takes_most(both: Verdict, alone: Verdict) -> bool:
    """Whether what was found together takes most of what the other leaves."""
    pair = judge(tuple(c.names[0] for c in both.effects), both.final, alone.final)
    material = gained(alone.final, both.final) >= MATERIAL and pair.evidence > EVIDENCE
    return material and pair.share > MOST and not pair.held_share < MOST


def _by_two(chain, candidates: tuple, over: float, widen: Callable) -> Verdict:
    """What two effects found together say, or the one of them that does without the other.

    candidates: single effects: all, those that may be there alone, and the strong ones; and what
    was sought beside some already, as `pairs` has it.
    """
    declared, (able, ranked, strong, known) = chain[0][1], candidates
    others = [c for c in able if c.outdone or c not in ranked]
    beam = sorted([*strong, *others], key=lambda c: -c.evidence)
    found = exchanged(to_their_end(pairs(declared, beam, known), declared), declared)
    found = polished(found, declared, widen)
    both = _stand([c for c in found if sufficient(c, ENOUGH_BOTH)])
    if both and is_broken(declared, both[0]):
        return Verdict("unexplained", chain, (), (), ranked, ())
    least = strong[0].evidence if strong else 0.0
    one = one_of(declared, both[0].found, over, least) if both else None
    if one and weakens(declared, one):
        return _partly(chain, one, strong, ranked)
    if one:
        return Verdict(
            "explained",
            (*chain, (one.names[0], one.found)),
            (one,),
            (twins_of(one, strong),),
            ranked,
            (),
        )
    nearly = _stand([c for c in found if sufficient(c, ENOUGH_BOTH, nearly=True)])
    if both:
        # where the best itself is off ahead, being so tells nothing against its rivals
        rivals = nearly if strays(both[0].found) else both
        return _unless_it_weakens(_two(chain, both[0], rivals, ranked, able), able)
    if nearly and beats_single(nearly[0], strong, over):
        return replace(_two(chain, nearly[0], nearly, ranked, able), verdict="unexplained")
    part = [c for c in strong[:1] if c.share > 0.3 and not c.held_share < 0.3]
    if part:
        return _partly(chain, part[0], strong, ranked)
    return Verdict("unexplained", chain, (), (), ranked, ())


def _unless_it_weakens(verdict: Verdict, able: list[Candidate]) -> Verdict:
    """The verdict; a plain rub as a part where two effects stand in for one that weakens."""
    rubs = [c for c in able if c.names == ("dry_friction",)]
    named = [name for name, _ in verdict.chain]
    if len(verdict.effects) < 2 or "dry_friction" not in named or not rubs:
        return verdict
    declared = verdict.chain[0][1]
    if not weakens_rather(declared, verdict.final, rubs[0]):
        return verdict
    return _partly(verdict.chain[:1], rubs[0], [], verdict.ranked)


def _stand(found: list[Candidate]) -> list[Candidate]:
    """The candidates of two effects from the first on where each is one beside the other."""
    while found and (vetoed(found[0].found) or vetoed(turned(found[0].found))):
        found = found[1:]
    return found


def _partly(chain, best: Candidate, strong: list[Candidate], ranked) -> Verdict:
    """Not explained, but `best` takes its part."""
    chain += ((best.names[0], best.found),)
    return Verdict("unexplained", chain, (best,), (twins_of(best, strong),), ranked, ())


def twins_of(candidate: Candidate, others) -> tuple[str, ...]:
    """Names of single effects whose evidence comes near the candidate's."""
    name = candidate.names[-1]
    return tuple(
        c.names[-1]
        for c in others
        if c.names[-1] != name
        and c.evidence >= NEARLY * candidate.evidence
        and not c.held_share < NEARLY * min(candidate.held_share, 1.0)
    )


def _add_second(chain, strong: list[Candidate], ranked, over: float) -> tuple[Verdict, dict]:
    """The single effect, and a second one where what is left is material and one effect's; and what
    was sought beside single effects, by their fits.

    Where others come near the best single effect, each is tried with a second one: which of them
    is there may show only beside the right companion.
    """
    best, more, known = strong[0], [], {}
    more_left = excess(best.found) > MATERIAL and best.found.chi2 > NOISY * best.found.samples
    if more_left or strays(best.found, AHEAD):
        left = _left(best.found)  # no pair can gain more than this over the best
        firsts = [c for c in strong[:RIVALS] if c.evidence >= best.evidence - left]
        found = [c.found for c in firsts]
        known = dict(zip(found, seconds(firsts, found), strict=True))
        tries = [
            (first, [c for c in known[first.found] if c.evidence > EVIDENCE and not c.outdone])
            for first in firsts
        ]
        able = [t for t in tries if t[1] and counts_second(t[0], t[1][0], over)]
        best, more = max(able, key=lambda t: t[0].evidence + t[1][0].evidence, default=tries[0])
    if more and counts_second(best, more[0], over):
        one = one_of(chain[0][1], more[0].found, over, best.evidence)
        best, more = (best, more) if one is None else (one, [])
    chain += ((best.names[0], best.found),)
    effects, twins, minor = (best,), (twins_of(best, strong),), ()
    for c in more[:1]:
        if counts_second(best, c, over):
            chain += ((c.names[-1], c.found),)
            effects += (c,)
            twins += (twins_of(c, more),)
        elif gained(best.found, c.found) < MATERIAL:
            minor = ((c.names[-1], gained(best.found, c.found)),)
    return Verdict("explained", chain, effects, twins, ranked, minor), known


def _left(found: TimeFit) -> float:
    """Misfit beyond noise, where it was fitted and held out."""
    ahead, count = misfit(found.law.takes, found.predicted, True)
    return max(found.chi2 - found.samples, 0.0) + max(ahead - count, 0.0)


def _two(chain, best: Candidate, rivals: list[Candidate], ranked, able: list) -> Verdict:
    """Two effects found together, the one that does more alone first.

    `rivals`: candidates of two effects that may be its twins. `able`: single effects, those
    included that a plainer one outdoes as long as they are alone.
    """
    alone = {c.names[0]: c for c in able}
    names = sorted(best.names, key=lambda n: -alone[n].evidence if n in alone else 0)
    declared = chain[0][1]
    middle = alone[names[0]].found if names[0] in alone else best.found
    chain += ((names[0], middle), (names[1], best.found))
    twins = tuple(
        tuple(
            {
                n
                for c in rivals
                if other in c.names and c.evidence >= 0.9 * best.evidence
                for n in c.names
                if n not in names
            }
        )
        for name, other in ((names[0], names[1]), (names[1], names[0]))
    )
    effects = tuple(judge((n,), best.found, declared) for n in names)
    return Verdict("explained", chain, effects, twins, ranked, ())


def probabilities(ranked, declared: TimeFit) -> list[float]:
    """Of each candidate, tempered: a misfit's independent pieces are its cycles, not its samples.

    The likelihood of a fit whose own error is unknown falls as its misfit to the power -n/2, with
    n the cycles of the first mode in the fitted part.
    """
    if not ranked:
        return []
    cycles = declared.law.setting.omega[0] / (2 * np.pi) * declared.law.setting.duration
    misfits = np.array([c.found.chi2 for c in ranked])
    weight = (misfits / misfits.min()) ** (-max(cycles, 4) / 2)
    return list(weight / weight.sum())
