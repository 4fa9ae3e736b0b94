"""What acts on all of the body, or takes energy from all of its modes, or one of each, sought on
the lowest modes that the body has.

A mode that nobody heard, or that was heard amiss because of what damps it, stays in what an effect
leaves, and two effects together hide each other. Few kinds act on all of a body, so that each of
them, each that damps, and each one beside one that damps are begun from where the body has its
modes, on growing shares of the record.
"""

from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from .carried import carrying
from .dragged import DRAG, STRENGTHS
from .effects import TIME_EFFECTS, dry_friction
from .effects.base import Effect
from .foils import is_broken, weakens, weakens_rather
from .joint import Heard
from .law import TimeFit
from .lowest import (
    Lowest,
    explains,
    in_place,
    least_of,
    lowest_of,
    starts_of,
    tells_more,
    with_effects,
)
from .refit import turned, without
from .residual import EVIDENCE, NOISY, bic, excess
from .side_by_side import in_step_by_parts
from .stirred import LESS
from .sufficiency import CLEARLY, CLEARLY_BOTH, bends_the_body
from .time_layer import able, entries, judge, refuted
from .timefit import conclude, walked
from .verdict import Verdict

RUB = dry_friction.EFFECT
RUBS = (0.015, 0.06)  # strengths from which a rub is sought, of those that its file begins with,
SPEED = 0.05  # the speed below which it sticks there,
PLACES, ALONE = 4, 16  # and on how many places of the body, the reference first; without another
# share of the record, looks there, times the least misfit then with which others go on, so many:
# a few looks tell those off that are none, the same share again puts the others in order
STAGES = ((0.3, 8, 4.0, 6), (0.3, 12, 4.0, 6), (0.6, 20, 2.0, 2))
GO_ON = 3  # places of a search
TO_THE_END, AGAIN = 40, 20  # looks at the end, where no phase slips, and from other places
NEAREST = 12  # of these, to where it stands


@dataclass(frozen=True, eq=False)
class _Search:
    """A search for one effect or two, and where it stands."""

    lowest: Lowest  # with these in its law, what damps last
    effects: tuple[Effect, ...]
    places: np.ndarray  # (S, p)
    misfit: float = np.inf

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(effect.name for effect in self.effects)


@dataclass(frozen=True, eq=False)
class _End:
    """What a search found."""

    search: _Search
    found: TimeFit

    @property
    def names(self) -> tuple[str, ...]:
        return self.search.names

    @cached_property
    def alone(self) -> dict[str, TimeFit]:
        """The fit with one of two effects only, by its name."""
        count = len(self.found.law.effects)
        return {name: without(self.found, count - 1 - n) for n, name in enumerate(self.names)}

    def explains(self, declared: TimeFit) -> bool:
        clearly = CLEARLY if len(self.names) < 2 else CLEARLY_BOTH
        return explains(self.found, declared, self.search.lowest.apart, clearly)


def with_all_modes(heard: Heard, verdict: Verdict) -> Verdict | None:
    """The verdict that one such effect on the body's lowest modes explains all, or one beside one
    that damps, or that these are parts of it; where two effects explain, that one of them does so
    alone, and tells more: the other one has stood in for modes. None where none of that is so.
    """
    declared, two = verdict.damped, _two_explain(verdict)
    seeks = two or verdict.verdict == "unexplained"
    lowest = lowest_of(heard, declared) if seeks else None
    if lowest is None:
        return None
    searches = _begun(lowest, declared)
    if two:
        own = verdict.names[verdict.laws :]
        searches = [one for one in searches if len(one.names) < 2 and one.names[0] in own]
    for share, looks, behind, most in STAGES:
        searches = in_step_by_parts([partial(_further, one, share, looks) for one in searches])
        searches = sorted(searches, key=lambda one: one.misfit)[:most]
        searches = [one for one in searches if one.misfit <= behind * searches[0].misfit]
    fits = in_step_by_parts([partial(_ended, one) for one in searches])
    ends = [_End(one, found) for one, found in zip(searches, fits, strict=True)]
    ends = sorted((end for end in ends if _is_one(end)), key=lambda end: bic(end.found))
    alone = {end.names[0]: end.found for end in ends if len(end.names) < 2}
    less = [end for end in ends if tells_more(end.found, verdict)]
    if not two:
        less = [end for end in less if excess(end.found) < LESS * excess(verdict.complete)]
    told = [end for end in less if end.explains(declared)]
    some = told if told or two else less
    needed = (end for end in some if _is_needed(end, lowest, declared, alone))
    best = next((end for end in needed if not _is_a_foil(end, verdict, bool(told))), None)
    return best and _told(verdict, best, told, alone)


def _two_explain(verdict: Verdict) -> bool:
    """Whether two effects explain, by what the heard modes say alone, and one is sought here."""
    own = verdict.names[verdict.laws :]
    sought = {RUB.name, *(e.name for e in TIME_EFFECTS if _acts_on_all(e))}
    two = len(own) > 1 and not sought.isdisjoint(own)
    return two and verdict.verdict == "explained" and not verdict.whole


def _begun(lowest: Lowest, declared: TimeFit) -> list[_Search]:
    """All searches, where they begin."""
    places = lowest.law.setting.places
    rubs = [np.r_[s, np.log(SPEED), place] for place in places[:ALONE] for s in RUBS]
    drags = [np.array([strength]) for strength in STRENGTHS]
    damping = [((e,), begins) for e, begins in [(RUB, rubs), (DRAG, drags)] if able(declared, [e])]
    bodily = entries(declared, [e for e in TIME_EFFECTS if _acts_on_all(e)])
    beside = [((one.effect,), np.array(one.begins[one.promise.argmax()], float)) for one in bodily]
    out = []
    for damps, begins in [*damping, ((), [np.zeros(0)])]:
        for effect, begin in [*beside, ((), np.zeros(0))]:
            effects = effect + damps
            if effects and effects != (DRAG,):  # a drag alone was sought already
                wider = with_effects(lowest, *effects)
                some = begins[: PLACES * len(RUBS)] if effect else begins
                starts = starts_of(wider, declared, [np.r_[begin, b] for b in some])
                out.append(_Search(wider, effects, starts))
    return out


def _acts_on_all(effect: Effect) -> bool:
    """Whether an effect acts on all modes alike, or moves all of the body, and is none that damps,
    that parts a pair, or that is read off the record.
    """
    bodily = effect.layer == "time" and (effect.acceleration or effect.columns)
    local = effect.force or effect.parts or effect.channels or effect.given or effect.free
    return bool(bodily) and not (local or effect.damps or effect.clock or effect.delay)


def _further(one: _Search, share: float, looks: int) -> _Search:
    """The search on so much of the record."""
    walks = walked(one.lowest.law, one.places, (share,), looks, most=GO_ON)
    return replace(one, places=np.array([p for p, _, _ in walks]), misfit=walks[0][2])


def _ended(one: _Search) -> TimeFit:
    """The best fit at the end of a search; from more places on the body, if another body than that
    is all that it lacks.
    """
    best, law = _best_from(one, one.places, TO_THE_END), one.lowest.law
    if not law.effects[-1].force or not bends_the_body(best) or best.chi2 > NOISY * best.samples:
        return best
    p, places, n = best.parameters, law.setting.places, law.modes - 1
    near = np.argsort(((places - p[-n:]) ** 2).sum(axis=1), kind="stable")[:NEAREST]
    other = _best_from(one, np.array([np.r_[p[:-n], places[i]] for i in near]), AGAIN)
    return best if bends_the_body(other) or other.chi2 > NOISY * other.samples else other


def _best_from(one: _Search, places: np.ndarray, looks: int) -> TimeFit:
    p, jacobian, _ = walked(one.lowest.law, places, (1.0,), looks)[0]
    return carrying(conclude(one.lowest.law, p, jacobian))


def _is_one(end: _End) -> bool:
    """Whether each effect of a fit is one, and no plainer one does as well."""
    return not refuted(end.found) and not (len(end.names) > 1 and refuted(turned(end.found)))


def _is_needed(end: _End, lowest: Lowest, declared: TimeFit, alone: dict) -> bool:
    """Whether a fit tells clearly more than its modes do with one of its effects only, or with
    none. alone: fits of one effect, by its name.
    """
    found = end.found
    if len(end.names) < 2:
        return bic(found) < least_of(lowest, declared, [np.zeros(0)]) - EVIDENCE
    rivals = [bic(one) for one in end.alone.values()]
    rivals += [bic(one) for name, one in alone.items() if name in end.names]
    if bic(found) > min(rivals) - EVIDENCE:
        return False
    own = zip(end.search.effects, found.theta[-2:], strict=True)
    rivals = (least_of(with_effects(lowest, e), declared, [theta[0]]) for e, theta in own)
    return bic(found) < min(rivals) - EVIDENCE


def _is_a_foil(end: _End, verdict: Verdict, told: bool) -> bool:
    """Whether a rub that weakens with speed, or a sudden change where the fit does not tell all,
    tells rather what it does; a lone rub that weakens is a part.
    """
    declared, names = verdict.damped, end.names
    if not told and is_broken(declared, judge(names, end.found, declared)):
        return True
    if names == (RUB.name,):
        return told and weakens(declared, judge(names, end.found, declared))
    if RUB.name in names:
        rub = judge((RUB.name,), end.alone[RUB.name], declared)
        return weakens_rather(declared, end.found, rub)
    rubs = [c for c in verdict.ranked[verdict.laws :] if c.names == (RUB.name,)]
    return verdict.names[verdict.laws :] == (RUB.name,) and any(weakens(declared, c) for c in rubs)


def _told(verdict: Verdict, best: _End, told: list[_End], alone: dict) -> Verdict:
    """The verdict with the `best` fit; what tells all beside one of two effects is a twin of the
    other. alone: fits of one effect, by its name.
    """
    heard, names = best.search.lowest.heard, best.names
    said = "explained" if best in told else "unexplained"
    if len(names) < 2:
        return in_place(verdict, heard, [(names[0], best.found)], said=said, alone=alone)
    first, second = sorted(names, key=lambda name: best.alone[name].chi2)

    def beside(kept):
        """What tells all beside the effect that is kept, and is not the other one."""
        likely = [set(other.names) - {kept} for other in told if kept in other.names]
        return tuple(name for some in likely for name in some if name not in names)

    fits = [(first, best.alone[first]), (second, best.found)]
    twins, alone = (beside(second), beside(first)), best.alone | alone
    return in_place(verdict, heard, fits, said=said, twins=twins, alone=alone)
