"""What two effects found together say, each of them beside the other."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from .effects.further_mode import ran_off
from .exchange import exchanged
from .foils import is_broken, weakens, weakens_rather
from .law import TimeFit
from .ready import polished, to_their_end
from .refit import turned, without
from .residual import AHEAD, EVIDENCE, NOISY, QUIET, excess, strays
from .side_by_side import in_step_by_parts
from .sufficiency import (
    CLEARLY_BOTH,
    ENOUGH_BOTH,
    adds,
    bends_the_body,
    one_of,
    owes,
    sufficient,
)
from .time_layer import NEARLY, Candidate, judge, refuted, vetoed
from .together import pairs
from .verdict import Verdict, partly, twins_of

SHOWN = 0.3  # share of the excess, here and ahead, that a part of what stays unexplained takes
MOSTLY = 0.6  # share where it was fitted, from which a part need but do no harm ahead
LESS = 0.7  # of what two effects leave, rms, that others leave which tell far more
LEADING = 2  # best two of two effects, from which each of them alone is sought again


def by_two(chain, candidates: tuple, over: float, widen: Callable) -> Verdict:
    """What two effects found together say, or the one of them that does without the other.

    candidates: single effects: all, those that may be there alone, and the strong ones; and what
    was sought beside some already, as `pairs` has it.
    """
    declared, (able, ranked, strong, known) = chain[0][1], candidates
    there = {c.names for c in strong}
    others = [c for c in able if c.names not in there]
    beam = sorted([*strong, *others], key=lambda c: -c.evidence)
    found = exchanged(to_their_end(pairs(declared, beam, known), declared), declared)
    found = [c for c in polished(found, declared, widen) if c.evidence > EVIDENCE]
    found = _line_first(found)
    both = _stand([c for c in found if sufficient(c, ENOUGH_BOTH)])
    if both and is_broken(declared, both[0]):
        return Verdict("unexplained", chain, (), (), ranked, ())
    if both and both[0].found.chi2 >= QUIET * both[0].found.samples:
        more = [c for c in found if c not in both and c.evidence > both[0].evidence + EVIDENCE]
        if _need_another_body(more) or _miss_less(more, both[0].found):
            both = []
    least = strong[0].evidence if strong else 0.0
    one = one_of(declared, both[0].found, over, least) if both else None
    if found and not both:  # these may have led to one that is, if it tells as much
        one = one_of(declared, found[0].found, over, max(least, found[0].evidence - EVIDENCE))
        if one and is_broken(declared, one):
            return Verdict("unexplained", chain, (), (), ranked, ())
    if one and both and _is_owed(one, both[0], declared):
        one = None
    if one and weakens(declared, one):
        return partly(chain, one, strong, ranked)
    told = None
    if both and (not one or _may_be_both(one, both[0], declared)):
        # where the best itself is off ahead, being so tells nothing against its rivals
        nearly = _stand([c for c in found if sufficient(c, ENOUGH_BOTH, nearly=True)])
        rivals = nearly if strays(both[0].found) else both
        told = unless_it_weakens(_two(chain, both[0], rivals, ranked, able), [*strong, *able])
    if one:
        return Verdict(
            "explained",
            (*chain, (one.names[0], one.found)),
            (one,),
            (twins_of(one, strong),),
            ranked,
            (),
            rather=told,
        )
    if told:
        return told
    return _parts(chain, found, (able, ranked, strong))


def or_their_twins(verdict: Verdict, candidates: tuple, over: float) -> Verdict:
    """The verdict of two effects, the second of them sought beside the first; or that of two that a
    twin of one of them makes beside the other, where these tell clearly more and neither does
    without the other. candidates: single effects: all, and those that may be there alone.
    """
    (_, declared), *_ = chain = verdict.chain[:-2]
    able, ranked = candidates
    pair = judge(verdict.names, verdict.final, declared)
    best, *_ = found = _stand(exchanged([pair], declared)) or [pair]
    clearly = best.evidence > pair.evidence + EVIDENCE and sufficient(best, ENOUGH_BOTH)
    if set(best.names) == set(pair.names) or not clearly:
        return verdict
    if one_of(declared, best.found, over, verdict.effects[0].evidence):
        return verdict
    rivals = [c for c in found if sufficient(c, ENOUGH_BOTH)]
    return _two(chain, best, rivals, ranked, able)


def _is_owed(one: Candidate, both: Candidate, declared: TimeFit) -> bool:
    """Whether the one owes an explanation of what it leaves, which is the other one of two that
    leave nothing but noise where they were fitted, and hardly more ahead, however small that is
    beside the first.
    """
    nothing = both.found.chi2 < NOISY * both.found.samples and not strays(both.found, AHEAD)
    second = judge(both.names, both.found, one.found)
    return nothing and owes(one.found, declared) and adds(one, second)


def _may_be_both(one: Candidate, both: Candidate, declared: TimeFit) -> bool:
    """Whether the one owes an explanation and the two do not, of which the other one shows in most
    of what the first leaves, ahead too: unless another reason of that is found.
    """
    second = judge(both.names, both.found, one.found)
    told = second.share > MOSTLY and not second.held_share < SHOWN and _shows(second)
    return told and owes(one.found, declared) and not owes(both.found, declared, CLEARLY_BOTH)


def _line_first(found: list[Candidate]) -> list[Candidate]:
    """The candidates, best first; before a shared motion, which is read off what was held out, too,
    a line that foretells as much of that.
    """
    best = found[0] if found else None
    if not best or "base_motion" not in best.names:
        return found
    rather = {"steady_drive" if name == "base_motion" else name for name in best.names}
    lines = [
        c
        for c in found[1:]
        if set(c.names) == rather and c.share > MOSTLY and c.held_share >= best.held_share
    ]
    return [*lines, *(c for c in found if c not in lines)]


def _need_another_body(more: list[Candidate]) -> bool:
    """Whether two effects that tell clearly more than those which may be the explanation do so in
    another body: then these are none.
    """
    return any(bends_the_body(c.found) for c in _stand(more)[:1])


def _miss_less(more: list[Candidate], best: TimeFit) -> bool:
    """Whether two effects that tell clearly more than the `best` ones which may be the explanation,
    and are not read off the record, leave far less of what was fitted: then the best ones foretell
    by chance what they do.
    """
    told = [c for c in more if not any(e.free for e in c.found.law.effects[-2:])]
    return any(
        best.chi2 > NOISY * best.samples and excess(c.found) < LESS * excess(best)
        for c in _stand(told)[:1]
    )


def _parts(chain, found: list[Candidate], singles: tuple) -> Verdict:
    """What two effects, or one, tell of what stays unexplained. singles: all, those that may be
    there alone, and the strong ones. Two that add to the best single one count, and whatever tells
    more than they do.
    """
    declared, (able, ranked, strong) = chain[0][1], singles
    more = [c for c in found if _shows(c)]
    if strong:
        best = strong[0]
        adding = [c for c in more if adds(best, judge(c.names, c.found, best.found))]
        least = max((c.evidence for c in adding), default=np.inf)
        more = [c for c in more if c in adding or c.evidence >= least]
    more = _stand(more)
    if more:
        return replace(_two(chain, more[0], more, ranked, able), verdict="unexplained")
    first = strong[:1] or ranked[:1]
    alone = [c for c in [*first, *_led_to(found[:LEADING], declared)] if _shows(c)]
    if alone:
        return partly(chain, max(alone, key=lambda c: c.evidence), strong, ranked)
    return Verdict("unexplained", chain, (), (), ranked, ())


def _shows(part: Candidate) -> bool:
    """Whether it surely takes so much that it is a part of what was off."""
    ahead = 0.0 if part.share > MOSTLY else SHOWN
    much = part.share > SHOWN and not part.held_share < ahead
    return much and part.evidence > EVIDENCE


def _led_to(twos: list[Candidate], declared: TimeFit) -> list[Candidate]:
    """Each one of two effects without the other, from where the two stand: a search for it alone
    may have gone astray.
    """

    def led(both, at):
        one = without(both.found, len(both.found.law.effects) - 1 - at)
        strayed = ran_off(one) and not ran_off(both.found)
        return None if strayed or refuted(one) else judge((both.names[at],), one, declared)

    jobs = [partial(led, both, at) for both in twos for at in (0, 1)]
    return list(filter(None, in_step_by_parts(jobs)))


def unless_it_weakens(verdict: Verdict, able: list[Candidate]) -> Verdict:
    """The verdict; a plain rub as a part where two effects stand in for one that weakens."""
    rubs = [c for c in able if c.names == ("dry_friction",)]
    named = [name for name, _ in verdict.chain]
    if len(verdict.effects) < 2 or "dry_friction" not in named or not rubs:
        return verdict
    declared = verdict.chain[0][1]
    if not weakens_rather(declared, verdict.final, rubs[0]):
        return verdict
    return partly(verdict.chain[:1], rubs[0], [], verdict.ranked)


def _stand(found: list[Candidate]) -> list[Candidate]:
    """The candidates of two effects from the first on where each is one beside the other."""
    while found and (vetoed(found[0].found) or vetoed(turned(found[0].found))):
        found = found[1:]
    return found


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

    def twins_beside(other):
        """What does nearly as much beside the other one, which does the rest."""
        rest = max(alone[other].evidence, 0.0) if other in alone else 0.0
        least = rest + NEARLY * (best.evidence - rest)
        likely = [c for c in rivals if other in c.names and c.evidence >= least]
        return tuple({n for c in likely for n in c.names if n not in names})

    twins = tuple(twins_beside(other) for other in (names[1], names[0]))
    effects = tuple(judge((n,), best.found, declared) for n in names)
    return Verdict("explained", chain, effects, twins, ranked, ())
