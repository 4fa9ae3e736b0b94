"""Which effect in time explains what the declared modes leave: race, fit, confirm.

1. every effect is started from several places, on growing shares of the record (race.py)
2. an effect counts when the evidence is strong (BIC), when it is material, when it accounts for
   most of what was left, and when it also predicts what was held out
3. one that does nearly as well as the best is its twin
"""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from .effects import TIME_EFFECTS, steady_drive
from .effects.base import Effect
from .law import TimeFit
from .pursuit import DEAD
from .race import Begun, Try, begun_all, ended, worth
from .read_off import read_off
from .refit import lighter, swapped
from .residual import AHEAD, NOISY, bic, misfit, strays
from .screen import screen
from .side_by_side import in_step_by_parts
from .timefit import FURTHEST, fit

MATERIAL = 0.005  # least share of the motion's RMS
NEARLY = 0.80  # of the best one's gain makes a twin
SAME = 0.99  # of a line's gain, with which a rub tells as much
PROMISE = 8.0  # least gain in chi2 that a score test must see before an effect is fitted
FEEBLE = 0.2  # the same over what a quiet fit leaves beyond noise
SETTLED = 0.95  # share of the excess from which what comes later gets one start only
BESIDE = 4  # names that are tried beside another effect, at most; alone all that promise enough
EDGE = 0.98  # of how far a pitch or a strength may go, from which it is at the bound
AT_ONCE = 2  # the most promising effects, which race each other only and may settle the rest
MANY = 24  # starts of a search that is made anew from everywhere
ABREAST = 2.0  # times the least misfit by half of the record, up to which a second search leads too
MOSTLY = 0.6  # share that the best one must take, for which it is sought anew
APART = 40  # looks, after which two modes of nearly one pitch have come apart


@dataclass(frozen=True, eq=False)
class Candidate:
    """A fit with effects added, and how much of the declared fit's excess it takes away."""

    names: tuple[str, ...]
    found: TimeFit
    evidence: float  # gain in BIC over the declared fit, held-out misfit included
    share: float  # of the excess over noise, fitted part; NaN where there is none
    held_share: float  # of the excess over noise, held-out part; NaN where there is none
    outdone: bool = False  # a plainer effect does as well, as things stand
    anew: bool = False  # its search was made anew already

    @property
    def confirmed(self) -> bool:
        """Accounts for most of the excess where it was fitted and where it was not."""
        return not (self.share < 0.8 or self.held_share < 0.7)


def judge(names, found: TimeFit, start: TimeFit) -> Candidate:
    """Compare `found` with the declared fit `start`.

    The evidence is the gain in BIC where it was fitted, and in misfit where it only predicted.
    """
    parameters = found.unknowns - start.unknowns
    parameters += sum(e.free for e in found.law.effects) - sum(e.free for e in start.law.effects)
    evidence = start.chi2 - found.chi2 - parameters * np.log(max(found.samples, 2))
    ahead, count = misfit(found.law.takes, found.predicted, True)
    evidence += misfit(start.law.takes, start.predicted, True)[0] - max(ahead, count)
    share = _taken(found, start, False)
    return Candidate(names, found, float(evidence), share, _taken(found, start, True))


def _taken(found: TimeFit, start: TimeFit, held: bool) -> float:
    before, count = misfit(start.law.takes, start.predicted, held)
    after, _ = misfit(found.law.takes, found.predicted, held)
    over = before - count
    if over <= (0.5 * count if held else 0):
        return np.nan
    return float((before - max(after, 0)) / max(over, 1e-9))


def able(start: TimeFit, effects) -> list[Effect]:
    """Those of the effects that this recording can show and that are not there yet."""
    law = start.law
    there = {e.name for e in law.effects}
    return [
        e
        for e in effects
        if e.name not in there and not (e.requires and e.requires(law.setting, law.takes))
    ]


def entries(start: TimeFit, effects) -> list[Try]:
    """Searches for those that this recording can show, best promise first."""
    data = start.law.takes[start.law.fitted[0]]
    residual = (data.time[data.fit], start.missed(0)[data.fit])
    known = [(effect, begins_of(effect, start, residual)) for effect in able(start, effects)]
    known = [(effect, begins) for effect, begins in known if begins]
    promises = in_step_by_parts([partial(screen, start, *one) for one in known])
    tries = [Try(start, promise, *one) for promise, one in zip(promises, known, strict=True)]
    return sorted(tries, key=lambda one: -one.promise.max())


def begins_of(effect: Effect, start: TimeFit, residual, most: int = 10**6) -> list:
    """Where a search for an effect may begin: of a force, at each of so many places on the body as
    it has, `most` at most.
    """
    begins = effect.starts(start.law.setting, residual)
    if not effect.force:
        return begins
    places = start.law.setting.places[: 1 + min(effect.places, most)]
    return list(dict.fromkeys((*b, *place) for b in begins for place in places))


def singles(start: TimeFit, against: TimeFit | None = None) -> tuple[list[Candidate], list]:
    """The best candidate of every name that a score test promises something, best first; and the
    searches that are not worth their end as long as others tell more, with where they stand.
    """
    chosen = _chosen(start)
    best, left = {}, []
    for some in (chosen[:AT_ONCE], chosen[AT_ONCE:]):
        settled = any(c.share > SETTLED for c in best.values())
        if settled:
            some = [replace(one, runners=1) for one in some]
        going, others = worth(begun_all(some))
        left += others
        _gather(best, (_ended if settled else _ended_at_last)(going), against or start)
    return _again([(_ranked(best), chosen, against or start)])[0], left


def passed_over(left: list, known: list[Candidate], against: TimeFit) -> list[Candidate]:
    """Candidates of the searches that `singles` left, of names that are not among the `known`; what
    coarse steps led astray gains too little to begin anew.
    """
    names, best = {c.names[0] for c in known}, {}
    left = [(one, begun) for one, begun in left if one.effect.name not in names]
    _gather(best, _ended(left, anew=False), against)
    return _ranked(best)


def seconds(
    firsts: list[Candidate], against: list[TimeFit], bare: TimeFit | None = None
) -> list[list[Candidate]]:
    """For each of the `firsts` the candidates that a second effect makes of it, best first.

    against: fits that these are compared with. bare: see `worth`.
    """
    chosen = in_step_by_parts([partial(_chosen, first.found, BESIDE) for first in firsts])
    going, _ = worth(begun_all([one for some in chosen for one in some]), bare)
    done = _ended_at_last(going)
    out = []
    for first, some, declared in zip(firsts, chosen, against, strict=True):
        best = {}
        own = [row for row in done if row[0].start is first.found]
        _gather(best, own, declared, first.names)
        out.append((_ranked(best), some, declared))
    return _again(out)


def _gather(best: dict, done, against: TimeFit, before: tuple[str, ...] = ()) -> None:
    """Keep of every name the best one of those that are `done` (Try, fit or None, outdone)."""
    for one, found, plainer in done:
        name = one.effect.name
        if found is not None:
            candidate = judge((*before, name), found, against)
            if name not in best or candidate.evidence > best[name].evidence:
                best[name] = replace(candidate, outdone=plainer, anew=one.anew)


def _ranked(best: dict) -> list[Candidate]:
    """The candidates, best evidence first; a line that stands in for a rub as one outdone."""
    found = sorted(best.values(), key=lambda c: -c.evidence)
    return [replace(c, outdone=c.outdone or stands_in(c, found)) for c in found]


def stands_in(candidate: Candidate, others: list[Candidate]) -> bool:
    """Whether a line at a pitch stands in for a rub that tells as much of what was fitted, or all.

    Swings that a rub ends in a straight line are nearly an exponential and a line that it meets.
    """
    if not steady_drive.is_resonant(candidate.found):
        return False
    rather = {"dry_friction" if n == "steady_drive" else n for n in candidate.names}
    return any(
        set(c.names) == rather
        and (bic(c.found) <= bic(candidate.found) or _tells_all(c, candidate))
        and not c.held_share < NEARLY
        for c in others
    )


def _tells_all(rub: Candidate, line: Candidate) -> bool:
    """Whether a rub leaves noise, or hardly more, and the line that little less."""
    return rub.found.chi2 < NOISY * rub.found.samples and rub.evidence > SAME * line.evidence


def _again(asked: list) -> list[list[Candidate]]:
    """The candidates of each (candidates, tries, fit to compare with), best first; the best one of
    all, and that which leaves least where it was fitted, or better ones of their effects, sought
    anew: an effect that is nearly right tells little of what comes.
    """
    tries = []
    for n, best in _nearest([ranked for ranked, _, _ in asked]):
        if best.anew or best.share < MOSTLY:
            continue
        if best.found.chi2 < NOISY * best.found.samples and not strays(best.found, AHEAD):
            continue
        effect = best.found.law.effects[-1]
        for one in asked[n][1]:
            if one.effect is effect and effect.marched:
                tries += [(n, best, other) for other in _anew(one)]
    stand = begun_all([one for _, _, one in tries])
    whose = {id(one): (n, best) for n, best, one in tries}
    going, better = [], {}
    for each in dict.fromkeys(best for _, best, _ in tries):
        going += worth([pair for pair in stand if whose[id(pair[0])][1] is each])[0]
    for one, found, plainer in _ended(going):
        n, best = whose[id(one)]
        if found is not None and not plainer:
            other = judge(best.names, found, asked[n][2])
            better[best] = max(better.get(best, best), other, key=lambda c: c.evidence)
    return [_ranked({c.names: better.get(c, c) for c in ranked}) for ranked, _, _ in asked]


def _nearest(some: list[list[Candidate]]) -> list[tuple[int, Candidate]]:
    """Of lists of candidates, best first, the number of one and the best of its own: of the first
    ones, and of all that no plainer one outdoes, that which leaves least.
    """
    firsts = [(n, ranked[0]) for n, ranked in enumerate(some) if ranked]
    others = [(n, c) for n, ranked in enumerate(some) for c in ranked if not c.outdone]
    least = [min(found, key=lambda one: one[1].found.chi2) for found in (firsts, others) if found]
    return list(dict.fromkeys(least))


def _anew(one: Try) -> list[Try]:
    """The search from many starts, for two modes close together make a short part of the record
    look like what it is not; and, of a force or what damps, from everywhere, where the damping is
    less if the effect damps.
    """
    out, effect = [_from_all(one)], one.effect
    if effect.force or effect.damps:
        damps = effect.damps and one.start.law.damping != "none"
        outset = lighter(one.start) if damps else one.start
        out += [replace(one, outset=outset, every=True, runners=MANY, anew=True)]
    return out


def _from_all(one: Try) -> Try:
    """The search on the whole record, from as many starts as there are strengths."""
    strengths = {begin[: len(one.effect.low)] for begin in one.begins}
    return replace(one, runners=len(strengths), horizons=(1.0,), anew=True)


def _chosen(start: TimeFit, most: float = np.inf) -> list[Try]:
    """Searches for the names that a score test promises something, `most` at most, best first."""
    names, out = set(), []
    raced_for = entries(start, [*TIME_EFFECTS, *read_off(start)])
    least = max([PROMISE, *(0.01 * one.promise.max() for one in raced_for[:1])])
    if start.chi2 < NOISY * start.samples:  # near enough for the test to be nearly exact
        least = max(least, FEEBLE * (start.chi2 - start.samples))
    for one in raced_for:
        # a clock may show where it was not fitted
        if one.promise.max() < least and not one.effect.clock:
            continue
        if one.effect.clock or one.effect.name in names or len(names) < most:
            names.add(one.effect.name)
            out.append(one)
    return out


def _ended(going: list[tuple[Try, Begun]], anew: bool = True) -> list:
    """(Try, fit or None where it is vetoed, whether it is outdone) of each search, at its end; see
    `ended`.
    """

    def tried(one, begun):
        found = ended(one, begun, anew)
        return None if found is None or vetoed(found) else (found, outdone(found))

    done = in_step_by_parts(
        [partial(tried, *pair) for pair in going],
        strides=[one.strides for one, _ in going],
    )
    return [(one, *(some or (None, False))) for (one, _), some in zip(going, done, strict=True)]


def _ended_at_last(going: list[tuple[Try, Begun]]) -> list:
    """The same; those that led by half of the record and came to nothing are made anew."""
    done = _ended(going)
    failed = [n for n in _leaders(going) if _gained_nothing(*done[n][:2])]
    anew = {other: n for n in failed for other in _anew(going[n][0])}
    for row in _ended(worth(begun_all(list(anew)))[0]):
        n, (_, found, plainer) = anew[row[0]], row
        before, worse = done[n][1:]
        if found is not None and (before is None or (plainer, found.chi2) < (worse, before.chi2)):
            done[n] = row
    return done


def _gained_nothing(one: Try, found: TimeFit | None) -> bool:
    """Whether a search came to nothing, or to less than the fit that it was to mend."""
    return found is None or found.chi2 >= one.start.chi2


def _leaders(going: list[tuple[Try, Begun]]) -> list[int]:
    """Numbers of the searches with a march that leave the least by half of the record, of those
    from the same fit, and of a next one that is abreast; where none has got so far, of the one that
    promises most.
    """
    known = {}
    for n, (one, begun) in enumerate(going):
        if one.effect.marched:
            misfit = begun.misfit if np.isfinite(begun.misfit) else np.inf
            known.setdefault(one.start, []).append((misfit, -one.promise.max(), n))
    leaders = []
    for some in known.values():
        (least, _, first), *others = sorted(some)
        leaders += [first, *(n for misfit, _, n in others[:1] if misfit < ABREAST * least < np.inf)]
    return leaders


def refuted(found: TimeFit) -> bool:
    """Whether the last effect is none by what was fitted, or a plainer one does as well."""
    return vetoed(found) or outdone(found)


def vetoed(found: TimeFit) -> bool:
    """Whether the last effect is none by what was fitted, or stands in for the swing itself."""
    effect = found.law.effects[-1]
    return _rings_no_more(found) or bool(effect.veto and effect.veto(found))


def _rings_no_more(found: TimeFit) -> bool:
    """Whether the strongest mode, which was heard to ring, is damped as none that rings, or as far
    from where it was heard as it may go.
    """
    k = found.loudest
    moved = np.log(2 * np.pi * found.frequency[k] / found.law.setting.omega[k])
    return bool(found.damping_ratio[k] > DEAD or abs(moved) > EDGE * FURTHEST)


def outdone(found: TimeFit) -> bool:
    """Whether a plainer effect in the last one's place does as well."""
    effect = found.law.effects[-1]
    plain = effect.rival and effect.rival(found)
    if not plain:
        return False
    law, starts = swapped(found, plain, plain.starts(None, None)[:1])
    return fit(law, starts[0], evaluations=APART).chi2 < found.chi2 + PROMISE
