"""Two effects at once, for neither may show as long as the other one is missing.

Beside each of the best single effects a second one is sought. Where that does not tell all, and
one mode or two do and few numbers are searched, those of the library are also sought two by two,
from all their strengths, on growing shares of the record: a joint score test tells which two, the
first swings from where.
"""

from dataclasses import replace
from functools import partial
from itertools import combinations

import numpy as np

from .carried import carrying
from .effects import TIME_EFFECTS
from .effects.further_mode import ran_off
from .jumps import jumps
from .law import TimeFit
from .outset import begin, outsets
from .race import TELLS, Try, race, raced, unlike
from .refit import turned
from .residual import AHEAD, EVIDENCE, NOISY, bic, strays
from .side_by_side import in_step_by_parts
from .time_layer import (
    PROMISE,
    Candidate,
    able,
    entries,
    judge,
    outdone,
    refuted,
    seconds,
    stands_in,
)
from .timefit import best_fit, walked

BEAM = 2  # best single effects, held out too and where fitted, with a second beside
CHEAPLY = 3  # of the latter where a march is cheap
FEW = 4  # modes: with many, so many places tie that the first swings tell nothing
MANY = 20  # numbers searched, above which no march is cheap: six further modes beside two
TWOS = 10  # pairs that are begun
FINALISTS = 6  # that go on to the end at most
BEHIND = 1.5  # of the best pair's misfit, from which one does not go on
ALIKE = 1e-6  # squared sine between two effects' changes, below which they are one
HORIZONS = (0.3, 0.6, 1.0)  # shares of the fitted part
LOOKS = 6  # evaluations before the last of them
WALKS = (6, 3)  # searches of a pair that go on from each of the first shares


def pairs(start: TimeFit, ranked: list[Candidate], known: dict) -> list[Candidate]:
    """Candidates of two effects, best evidence first.

    One that was outdone alone may yet be there beside another, where nothing plainer does as well.
    known: what was sought already beside single effects, by their fits (`seconds`).
    """
    best, found = {}, _beside(start, ranked, known)
    if not any(c.found.chi2 < NOISY * c.found.samples for c in found):
        found = [*_of_the_library(start), *found]
    for candidate in found:
        key = tuple(sorted(candidate.names))
        if key not in best or candidate.evidence > best[key].evidence:
            best[key] = candidate
    found = sorted(best.values(), key=lambda c: -c.evidence)
    return [c for c in found if not stands_in(c, found)]


def two_by_two(start: TimeFit) -> bool:
    """Whether what is in the library is sought two by two beside such a fit."""
    return start.law.modes <= FEW and _marches_cheaply(start)


def _marches_cheaply(start: TimeFit) -> bool:
    return len(start.parameters) <= MANY


def _beside(start: TimeFit, ranked: list[Candidate], known: dict) -> list[Candidate]:
    """Candidates of the best single effects and what shows beside each; of the next best too, where
    some of these, alone or by two, tell what was fitted and none of those tells what comes: they
    have bent to do what two others do. So few are worth a search that is dear.
    """
    strong = [single for single in ranked if single.evidence >= EVIDENCE]
    # what foretells badly, for want of another one, may tell most of what was fitted; what is read
    # off the record does so anyway
    telling = [
        single
        for single in ranked
        if bic(single.found) < bic(start) - EVIDENCE and not single.found.law.effects[-1].free
    ]
    some = list(dict.fromkeys([*strong, *telling]))
    fitting = sorted(some, key=lambda single: bic(single.found))
    most = CHEAPLY if _marches_cheaply(start) else BEAM
    first = list(dict.fromkeys([*strong[:BEAM], *fitting[:most]]))
    others = [single for single in fitting if single not in first]
    found = _showing(start, first, known, others)
    tells = [c for c in [*first, *found] if c.found.chi2 < NOISY * c.found.samples]
    if tells and all(strays(c.found, AHEAD) for c in tells):
        found += _showing(start, others[:CHEAPLY], known, [])
    return found


def _showing(
    start: TimeFit, first: list[Candidate], known: dict, others: list[Candidate]
) -> list[Candidate]:
    """Candidates of the `first` effects and what shows beside each, and of the `others` and jumps
    that show beside those.
    """
    new = [single for single in first if single.found not in known]
    beside = list(zip(new, seconds(new, [start] * len(new), start), strict=True))
    for single in first:
        before = known.get(single.found, ())
        again = [replace(judge(c.names, c.found, start), outdone=c.outdone) for c in before]
        # of what is sought here `worth` leaves out the like
        able = [c for c in again if c.found.law.effects[-1].clock or not c.share < TELLS]
        beside.append((single, able))
    beside += _with_jumps(start, others)
    found = [
        (single, candidate)
        for single, some in beside
        for candidate in some
        # more freedom cannot fit worse: else the search went astray
        if not candidate.outdone and candidate.found.chi2 <= single.found.chi2
    ]
    doubtful = [candidate for single, candidate in found if single.outdone]
    dropped = in_step_by_parts([lambda c=c: outdone(turned(c.found)) for c in doubtful])
    gone = {id(c) for c, out in zip(doubtful, dropped, strict=True) if out}
    return [candidate for _, candidate in found if id(candidate) not in gone]


def _with_jumps(start: TimeFit, others: list[Candidate]) -> list:
    """(single effect, the candidates that lost frames make of it) of those that show any.

    Jumps hide what tells little without them, and cost no search.
    """
    others = [one for one in others if not any(e.clock for e in one.found.law.effects)]
    seen = in_step_by_parts([lambda c=c: able(c.found, jumps(c.found)) for c in others])
    tries = [
        (single, Try(single.found, np.zeros(1), effect, [()]))
        for single, effects in zip(others, seen, strict=True)
        for effect in effects
    ]
    done = in_step_by_parts([partial(race, one) for _, one in tries])
    return [
        (single, [judge((*single.names, one.effect.name), found, start)])
        for (single, one), found in zip(tries, done, strict=True)
    ]


def _of_the_library(start: TimeFit) -> list[Candidate]:
    """Candidates of two effects that the library holds."""
    if not two_by_two(start):
        return []
    known = [one for one in entries(start, TIME_EFFECTS) if one.promise.max() > PROMISE]
    strengths = [[o.begins[i] for i in unlike(o.effect, o.begins, o.promise)] for o in known]
    some = in_step_by_parts(
        [partial(begin, start, o.effect, t) for o, t in zip(known, strengths, strict=True)]
    )
    own = [np.vstack([one.there + one.tangent, one.there - one.tangent]) for one in some]
    twos = []
    for i, j in combinations(range(len(known)), 2):
        effects = known[i].effect, known[j].effect
        if effects[0].name != effects[1].name:
            gain = _joint_score(own[i], own[j], start.residuals)
            twos.append((gain, effects, [some[i], some[j]]))
    twos = sorted(twos, key=lambda two: -two[0])[:TWOS]

    def begun(effects, begins):
        law = raced(start, *effects)
        starts = outsets(start, law, begins)
        places = [p for p, _, _ in walked(law, starts, HORIZONS[:1], LOOKS, WALKS[0])]
        return walked(law, places, HORIZONS[1:2], LOOKS, WALKS[1])

    walks = in_step_by_parts([partial(begun, effects, begins) for _, effects, begins in twos])
    order = sorted(range(len(twos)), key=lambda n: walks[n][0][2])
    order = [n for n in order if walks[n][0][2] < BEHIND * walks[order[0]][0][2]][:FINALISTS]

    def ended(effects, walks):
        law = raced(start, *effects)
        found = carrying(best_fit(law, np.array([p for p, _, _ in walks]), HORIZONS[2:]))
        strayed = ran_off(found) and not ran_off(start)
        return None if strayed or refuted(turned(found)) or refuted(found) else found

    found = in_step_by_parts([partial(ended, twos[n][1], walks[n]) for n in order])
    return [
        judge(tuple(e.name for e in twos[n][1]), one, start)
        for n, one in zip(order, found, strict=True)
        if one is not None
    ]


def _joint_score(a: np.ndarray, b: np.ndarray, r: np.ndarray) -> float:
    """Most that a start of each of two effects promises, their changes (n, R) and (m, R) of the
    residuals (R,) scaled as they like: a score test of both (Rao, 1973, 6e).
    """
    aa, bb, ab = (a * a).sum(axis=1)[:, None], (b * b).sum(axis=1), a @ b.T
    ra, rb = (a @ r)[:, None], b @ r
    apart = aa * bb - ab**2
    told = apart > ALIKE * aa * bb
    gain = (bb * ra**2 - 2 * ab * ra * rb + aa * rb**2) / np.where(told, apart, np.inf)
    return float(gain.max())
