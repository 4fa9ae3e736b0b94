"""The search for one effect: from where it begins, on growing shares of the record, to its end.

Searches from one fit race each other: one that by half of the record gains far less than the best
one is not ended (successive halving: Jamieson and Talwalkar, AISTATS 2016).
"""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from .carried import carrying
from .effects.base import FINE, PLACES, Effect
from .law import TRUST, Law, TimeFit
from .outset import begin, outsets
from .pair import across, opened
from .residual import NOISY
from .side_by_side import in_step_by_parts
from .simulate import COARSE
from .timefit import best_fit, extend, misfits, walked

RUNNERS = 2  # starting places of an effect that are fitted
HALF = 0.5  # share of the record up to which all go
HORIZONS = (0.15, 0.3, HALF, 0.7, 1.0)  # shares of the fitted part: a phase must not slip
APART = 8  # places on the body, the reference first, then those that are farthest apart
PERIODS = 2.0  # of the first mode that a share must hold
MORE = 1.3  # times as much as another share, that one holds which is worth a look of its own
WORTH = 0.6  # of the best one's gain by half of the record
TELLS = 0.4  # share, by then, of all that two effects must tell: one of them may show later
LEAST = 0.02  # of the misfit beyond noise there, that it gains
EARLY = 0.25  # of all that is to be told, from which half of the record shows who tells it
TOLD = (
    20.0  # misfit that the best one gains there at least; less, and half does not tell them apart
)
CLOSE = 3.0  # misfit that a last look of a search gains; what is found is sharpened
CLOSELY, LOOSELY = 1e-5, 3e-4  # the same as a share: of an effect that is marched, and beside one
LOST = 0.5  # of its gain, that finer steps take from a search that coarse ones led astray
LOOKS, CHEAP = 10, 30  # of a search, at most: with forces to march, and without
FIRST = 3  # looks of one from many places on the whole record, after which the best few go on
HINT = 0.3  # as WORTH, of what the first looks of a search without a march gain
GLANCES = 8  # of one without, after which those that lag behind end
NAMESAKES = 2  # of those of one effect, of as many markers, the best that go on


@dataclass(frozen=True, eq=False)
class Try:
    """A search for one effect, beside those of a fit, from its most promising starting places."""

    start: TimeFit
    promise: np.ndarray
    effect: Effect
    begins: list
    runners: int = RUNNERS
    horizons: tuple = HORIZONS
    outset: TimeFit | None = None  # from where, if not from the start
    every: bool = False  # from all places, not only from the best one of each strength
    anew: bool = False  # once more, from more starts than at first

    @property
    def law(self) -> Law:
        return raced(self.start, self.effect)

    @property
    def strides(self) -> float:
        """Steps of its march in a period; 0 where it has none."""
        law = self.law
        return float(law.setting.steps if any(e.marched for e in law.effects) else 0)


@dataclass(frozen=True, eq=False)
class Begun:
    """Where a search stands by half of the record."""

    places: np.ndarray  # (S, p)
    misfit: float  # on the record so far; NaN where none of its shares ends by then
    whole: bool = False  # whether that is all of it


def race(one: Try) -> TimeFit:
    """The best fit with the effect."""
    return ended(one, begun(one))


def begun(one: Try) -> Begun:
    """The search on the first shares of the record; the first looks of one without a march, and of
    one that has only the whole record and many places to begin.
    """
    effect, places = one.effect, _places(one)
    first = _shares(one, HALF) if effect.marched else [1.0]
    if not first:
        if len(places) > RUNNERS:  # on the whole of it, so that few go on
            places = np.array([p for p, _, _ in walked(one.law, places, [1.0], FIRST, RUNNERS)])
        return Begun(places, np.nan)
    looks = LOOKS if effect.marched else GLANCES
    walks = walked(one.law, places, first, looks)
    return Begun(np.array([p for p, _, _ in walks]), walks[0][2], not effect.marched)


def _shares(one: Try, most: float) -> list[float]:
    """Of the record, up to `most`, of a few periods at least; of a search from all places just so
    few first, where the next share holds far more: what bends a pitch far slips on that.
    """
    setting = one.start.law.setting
    least = min(PERIODS * 2 * np.pi / (setting.omega[0] * setting.duration), 1.0)
    shares = [h for h in one.horizons if h >= least]
    if one.every and one.horizons[0] < least < shares[0] / MORE:
        shares = [least, *shares]
    return [h for h in shares if h <= most]


def _places(one: Try) -> np.ndarray:
    """(S, p) where the search begins."""
    start, effect = one.outset or one.start, one.effect
    begins = one.begins if one.every else _likeliest(one)
    if effect.marched:
        return outsets(start, one.law, [begin(start, effect, begins)])[: one.runners]
    some = begins[: one.runners]
    return np.array([extend(start, (effect,), [theta])[1] for theta in some])


def _likeliest(one: Try) -> list:
    """Of each strength the place that promises most, and the one among a few that does."""
    effect, begins, promise = one.effect, one.begins, one.promise
    out = [begins[i] for i in unlike(effect, begins, promise)]
    if effect.force and effect.places > PLACES:  # of so many the best may be one by chance
        firsts = {tuple(place) for place in one.start.law.setting.places[:APART]}
        near = [i for i, b in enumerate(begins) if tuple(b[len(effect.low) :]) in firsts]
        some = [begins[i] for i in near]
        out += [some[i] for i in unlike(effect, some, promise[near])]
    return list(dict.fromkeys(out))


def ended(one: Try, begun: Begun, anew: bool = True) -> TimeFit | None:
    """The best fit with the effect, from where its search stands; where coarse steps have led that
    astray, from its begin in fine ones, or None if it is not to begin `anew`.
    """
    effect = one.effect
    rest = [h for h in one.horizons if h > HALF] if effect.marched else (1.0,)
    marched = any(e.marched for e in one.law.effects)
    looks = LOOKS if marched else CHEAP - GLANCES
    close = (CLOSELY if effect.marched else LOOSELY, CLOSE) if marched else (CLOSELY, 0.0)
    found = best_fit(one.law, begun.places, rest, evaluations=looks, close=close)
    if effect.marched and _is_unsteady(found, one.start):
        if not anew:
            return None
        shares = _shares(one, 1.0)
        found = best_fit(_finely(one.law), _places(one), shares, evaluations=looks, close=close)
    found = across(found) if effect.force else found
    return carrying(opened(found) if effect.parts else found)


def _finely(law: Law) -> Law:
    return replace(law, setting=replace(law.setting, steps=2 * FINE))


def _is_unsteady(found: TimeFit, start: TimeFit) -> bool:
    """Whether finer steps lose most of what a search gained: a force that softens may let a motion
    escape, which coarse steps pass over.
    """
    gain = start.chi2 - found.chi2
    if gain < TOLD:
        return False
    finely = misfits(_finely(found.law), found.parameters[None])[0]
    return bool(finely - found.chi2 > LOST * gain)


def begun_all(tries: list[Try]) -> list[tuple[Try, Begun]]:
    """The searches with where they stand; of those without a march that are of one effect and from
    the same fit, the few best.
    """
    stand = in_step_by_parts(
        [partial(begun, one) for one in tries], strides=[one.strides for one in tries]
    )
    pairs = list(zip(tries, stand, strict=True))
    alike = {}
    for one, now in pairs:
        if now.whole:
            alike.setdefault((one.start, one.effect.name), []).append(now.misfit)
    last = {kind: sorted(misfits)[:NAMESAKES][-1] for kind, misfits in alike.items()}
    return [
        (one, now)
        for one, now in pairs
        if not now.whole or now.misfit <= last[one.start, one.effect.name]
    ]


def worth(begun: list[tuple[Try, Begun]], bare: TimeFit | None = None) -> tuple[list, list]:
    """Those of the searches, with where they stand, that are worth their end, and the others: worth
    it is what gains a fair share of what the best one from the same fit does by then, where enough
    of what is left stands there; a clock; and what grows with time, where it promises most of them.

    bare: the fit without either effect where two are to tell all that it leaves beyond noise; what
    tells too little of that by then does not go on, where enough of it stands there.
    """
    least = {}
    for one, now in begun:
        if np.isfinite(now.misfit):
            key = one.start, now.whole
            least[key] = min(now.misfit, least.get(key, np.inf))
    part = list(dict.fromkeys(start for start, whole in least if not whole))
    part += [bare] if bare and part and bare not in part else []
    halves = in_step_by_parts([partial(_half, start) for start in part])
    before = dict(zip(part, halves, strict=True))

    def stands(start, whole):
        """Misfit of the fit by then, and what of it is noise."""
        share = 1.0 if whole else HALF
        return (start.chi2 if whole else before[start]), share * start.samples

    def tells(now):
        if bare is None:
            return True
        was, noise = stands(bare, now.whole)
        over, whole = was - NOISY * noise, bare.chi2 - NOISY * bare.samples
        return over < max(EARLY * whole, TOLD) or was - now.misfit > TELLS * over

    growing = _growing([one for one, _ in begun])

    def goes_on(one, now):
        # a clock may show where it was not fitted
        if one.effect.clock or one in growing or not np.isfinite(now.misfit):
            return True
        if not tells(now):
            return False
        was, noise = stands(one.start, now.whole)
        most, over = was - least[one.start, now.whole], was - noise
        if now.whole:  # or what the best of the others will gain, as it has begun
            most = max(most, over * share_of_others(one.start))
        late = over < EARLY * (one.start.chi2 - one.start.samples)
        if late or most < TOLD:
            return True
        fair = HINT if now.whole else WORTH
        return was - now.misfit >= max(fair * most, LEAST * over)

    def share_of_others(start):
        if (start, False) not in least:
            return 0.0
        was, noise = stands(start, False)
        if was - noise < EARLY * (start.chi2 - start.samples):
            return 0.0
        return (was - least[start, False]) / (was - noise)

    going = [pair for pair in begun if goes_on(*pair)]
    return going, [pair for pair in begun if pair not in going]


def _growing(tries: list[Try]) -> list[Try]:
    """Of the searches those for what grows with time, where none from the same fit promises more:
    half of a record hardly shows it.
    """
    most = {}
    for one in tries:
        most[one.start] = max(most.get(one.start, 0.0), one.promise.max())
    return [one for one in tries if one.effect.grows and one.promise.max() >= most[one.start]]


def _half(start: TimeFit) -> float:
    """Misfit that no further effect leaves on half of the record."""
    return walked(raced(start), [start.parameters], (HALF,), LOOKS)[0][2]


def raced(start: TimeFit, *effects: Effect) -> Law:
    """The law of `start` with `effects`, as they are searched for."""
    law = replace(start.law, effects=(*start.law.effects, *effects))
    # with misfit beyond noise a weight in noise units would be too weak
    trust = TRUST * max(np.sqrt(start.chi2 / start.samples), 1.0)
    steps = FINE if any(e.sudden for e in law.effects) else COARSE
    if start.law.setting.steps > FINE:  # what is there already needs them
        steps = start.law.setting.steps
    return replace(law, trust=trust, setting=replace(start.law.setting, steps=steps))


def unlike(effect: Effect, begins: list, promise: np.ndarray) -> list[int]:
    """The most promising starting places first, of each strength only the best place on the body:
    the search moves a place more easily than it turns a law round.
    """
    out, seen = [], set()
    for i in np.argsort(-promise):
        own = tuple(begins[i][: len(effect.low)])
        if own not in seen:
            out.append(int(i))
            seen.add(own)
    return out
