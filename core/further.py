"""Modes of the body that the recording shows beside the matched ones."""

from contextlib import nullcontext
from functools import partial

import numpy as np

from .all_told import (
    ALIKE,
    APART,
    BESIDE,
    FEWEST,
    LOWEST,
    NEAR,
    SAME,
    Told,
    as_heard,
    cleared,
    foretells,
    modes_of,
    tells_all,
)
from .baseline import real_shapes
from .body import Body
from .channels import Channels
from .data import poles
from .effects.further_mode import (
    as_it_is,
    further_mode,
    heard_anew,
    is_a_mode,
    is_further,
    of_take,
    pitch_of,
)
from .harmonic_inversion import invert
from .law import Law, TimeFit
from .linear_part import fitted_instants
from .match import ACROSS, HARMONIC, Match, likeness, mac
from .pursuit import is_driven
from .refit import without
from .residual import EVIDENCE, QUIET, bic
from .settle import displaced
from .side_by_side import meanwhile
from .timefit import extend, fit

TWIN = 0.25  # relative, from a mode whose degenerate partner was not matched
BODILY = 0.8  # share of its shape within those of the body's low modes
SPAN = 12  # of them
OVERTONE = 0.3  # of the swing of a mode, at most, that its overtone has
NEARLY, SURE = 0.05, 0.9  # of a computed pitch, and MAC: a mode even where an overtone would lie
ROUNDS = 2
MOST = 6  # modes that are sought at a time


def with_further(
    found: TimeFit, match: Match, body: Body, rings: tuple = (), at: int | None = None
) -> TimeFit:
    """The fit with those further modes that are the body's own beyond doubt.

    A further mode that stays in the residual hides what acts in time, and no body has as few
    modes as were matched. What might be an overtone, a combination, a split pair, a steady line
    or a companion of the strongest mode is left for the effects; but where the `rings` (one a
    take), or what is heard without what the fit's effects do, foretell what was held out, their
    poles are the body's. Where one of these takes off a known motion, no others are sought.
    `at`: the place among the law's effects where they go, the last by default.
    """
    if None in match.modes:
        return found
    read = any(effect.given for effect in found.law.effects)
    after = 0 if at is None else len(found.law.effects) - at
    for attempt in range(ROUNDS):
        if found.chi2 < QUIET * found.samples:
            break
        effects, known, start, law = [], {}, found, found.law
        for take in range(len(law.fitted)):
            clear = []
            rest = partial(_poles, found, take, match, body)
            with nullcontext(rest) if attempt or read else meanwhile(rest) as of_the_rest:
                told = None if attempt else _all_told(found, take, match, rings)
                if told:
                    begun = as_heard(found, told) if len(law.fitted) == 1 else found
                    clear = modes_of(begun, take, match, body, told.ring)
                    start = begun if clear else found
                heard = clear or ([] if read else of_the_rest())
            effects += _new(law, take, heard, known)
        if not effects:
            break
        wider = _worth_it(start, effects, len(law.effects) - after)
        if wider is start:
            break
        found = wider
    return found


def with_overtones_of(found: TimeFit, match: Match, body: Body) -> TimeFit:
    """The fit with those modes of the body that lie and move as an overtone of another one does."""
    effects, known = [], {}
    for take in range(len(found.law.fitted)):
        effects += _new(found.law, take, _poles(found, take, match, body, overtones=True), known)
    return _worth_it(found, effects, len(found.law.effects)) if effects else found


def _new(law: Law, take: int, heard: list[tuple[float, float]], known: dict) -> list:
    """Further modes of those `heard` (Hz, damping ratio) in a take, but for those that are `known`
    from another one of the same pitches; these are known from then on.
    """
    before = known.setdefault(law.pitch[law.fitted[take]], [])
    new = [(f, z) for f, z in heard if all(abs(np.log(f / g)) > APART for g in before)]
    before += [f for f, _ in new]
    return [further_mode(f, z, law.loaded_alike(take)) for f, z in new]


def _all_told(found: TimeFit, take: int, match: Match, rings: tuple) -> Told | None:
    """A ring-down that tells all of a fitted take: as it was heard, but for a small effect perhaps,
    or with trifles and without what the effects do.
    """
    if rings:
        index = found.law.fitted[take]
        data = found.law.takes[index]
        told = Told(rings[index], data.time, data.values, match.poles)
        if tells_all(found, take, told) or foretells(found, take, told):
            return told
    told = cleared(found, take)
    return told if told and tells_all(found, take, told) else None


def with_left_out(found: TimeFit, heard: list[tuple[int, float, float]]) -> TimeFit:
    """The fit with modes that were matched in the takes of one load and are not seen in those of
    another: each the number of its first fitted take, its pitch (Hz) and damping ratio.
    """
    if not heard or found.chi2 < QUIET * found.samples:
        return found
    effects = [further_mode(f, z, found.law.loaded_alike(take)) for take, f, z in heard]
    return _worth_it(found, effects, len(found.law.effects))


def with_modes_of(found: TimeFit, other: TimeFit, after: int) -> TimeFit:
    """The fit with the further modes of another one that it lacks, as they are there, before its
    last `after` effects, if they bring what modes must.
    """
    if found.chi2 < QUIET * found.samples:
        return found
    known, new = set(found.law.effects), {}
    for take in range(len(found.law.fitted)):
        own = [*found.pitches(take), *(pitch_of(e, t) for _, e, t in of_take(found, take))]
        for _, effect, theta in of_take(other, take):
            pitch = pitch_of(effect, theta)
            if effect not in known and all(abs(np.log(pitch / f)) > APART for f in own):
                new[effect] = as_it_is(effect, theta)
    if not new:
        return found
    return _worth_it(found, list(new.values()), len(found.law.effects) - after)


def _worth_it(found: TimeFit, effects: list, at: int) -> TimeFit:
    """The fit with those of the modes that stay what they are, if they bring what modes must."""
    wider, kept = _staying(found, effects, at)
    price = max((wider.unknowns - found.unknowns) * np.log(wider.samples), 0.0)
    gain = found.chi2 - wider.chi2
    if not kept or gain < price + EVIDENCE * kept or displaced(wider, found):
        return found
    less = without_runaways(wider)
    return found if bic(less) >= bic(found) or displaced(less, found) else less


def without_runaways(found: TimeFit) -> TimeFit:
    """The fit without those further modes that others have pushed to a bound: they stood in."""
    while runaways := [
        i
        for i, (effect, theta) in enumerate(zip(found.law.effects, found.theta, strict=True))
        if is_further(effect) and not is_a_mode(effect, theta[0])
    ]:
        found = without(found, runaways[-1])
    return found


def _staying(found: TimeFit, effects: list, at: int) -> tuple[TimeFit, int]:
    """The fit with those of the modes that stay what they are, and how many those are.

    Heard in what a fit without them leaves, their pitches are off: one that reaches its bound is
    heard anew there, if it stays clear of all that is known and brings what a mode must.
    """

    def with_those(some, fitted, stay):
        kept = [e for e, theta in zip(some, fitted.theta[at:], strict=False) if stay(e, theta[0])]
        if len(kept) == len(some):
            return fitted, len(kept)
        return (_fitted(found, kept, at) if kept else found), len(kept)

    pole, span = poles(found.frequency, found.damping_ratio), found.law.setting.duration

    def is_one(e, theta):  # and no line that something drives
        own = poles(pitch_of(e, theta), theta[1])
        return is_a_mode(e, theta) and not is_driven(own, span, pole)

    wider = _fitted(found, effects, at)
    thetas = [theta[0] for theta in wider.theta[at : at + len(effects)]]
    best, count = with_those(effects, wider, is_one)
    anew = [heard_anew(e, theta) for e, theta in zip(effects, thetas, strict=True)]
    if anew == effects:
        return best, count
    again = _fitted(found, anew, at)
    pitches = [pitch_of(e, theta[0]) for e, theta in zip(anew, again.theta[at:], strict=False)]
    known = [f for take in range(len(found.law.fitted)) for f in again.pitches(take)]

    def stays(e, theta):
        f = pitch_of(e, theta)
        others = known + [g for g in pitches if g != f]
        own = e in effects or _clear(f, others, False, known[:2])
        return is_one(e, theta) and own

    other, more = with_those(anew, again, stays)
    price = (other.unknowns - best.unknowns) * np.log(found.samples)
    price += EVIDENCE * max(more - count, 0)
    return (other, more) if more and best.chi2 - other.chi2 > max(price, 0.0) else (best, count)


def _fitted(found: TimeFit, effects: list, at: int) -> TimeFit:
    law, p = extend(found, tuple(effects), [e.starts(None, None)[0] for e in effects], at)
    return fit(law, p, evaluations=15)


def _poles(
    found: TimeFit, take: int, match: Match, body: Body, overtones: bool = False
) -> list[tuple[float, float]]:
    """(Hz, damping ratio) of the poles of what is left of a take that are modes of the body;
    `overtones`: those too that lie and move as an overtone does.
    """
    law = found.law
    index = law.fitted[take]
    data: Channels = law.takes[index]
    on = ~data.support
    time, use = fitted_instants(law, found.theta, data)
    left = found.missed(take)[use][:, on]
    if np.isfinite(left).sum(axis=0).min() < FEWEST:
        return []
    for count in (MOST, MOST // 2):  # so many close together may hide one another
        ring = invert(time, left, noise=data.sigma[on], max_modes=count)
        if len(ring.frequency):
            break
    own = found.pitches(take)
    scale = own[0] / body.modes.frequency[match.modes[0]]
    known = list(own)
    pair = own[law.setting.pair]
    usual = np.median(found.damping_ratio)
    # no force acts on a further mode, so that it is damped by what these take away as well
    most = max(usual, np.median(law.setting.zeta)) if any(e.marched for e in law.effects) else usual
    seen, frequency = body.seen(data)[:, on], body.modes.frequency
    q, _ = np.linalg.qr(seen[:SPAN].T)
    shapes = found.shapes_of(take)[:, on]
    pairs = zip(match.modes, shapes, strict=True)
    # one that has become another mode leaves its own free
    moved = [j for j, s in pairs if likeness(s, seen, frequency, j) < ACROSS]
    # but not where as many are known as there are: free poles mix what acts in time into shapes
    known_beside = np.abs(np.log(own / own[0])) < BESIDE
    beside = np.abs(np.log(frequency / frequency[match.modes[0]])) < BESIDE
    if known_beside.sum() >= beside.sum():
        moved = [j for j in moved if not beside[j]]
    free = [j for j in range(len(seen)) if j in moved or j not in match.modes]
    out = []
    for f, z, amplitude in zip(ring.frequency, ring.damping_ratio, ring.amplitude, strict=True):
        shape = real_shapes(amplitude[None])[0][0]
        bodily = float(((q.T @ shape) ** 2).sum() / (shape @ shape))
        own_way = overtones or mac(shape, shapes[0]) < ACROSS
        beyond_doubt = own_way and any(
            abs(np.log(f / scale / frequency[j])) < NEARLY
            and likeness(shape, seen, frequency, j) > SURE
            for j in free
        )
        if (
            f > LOWEST * scale * frequency[0]
            and ALIKE[0] * usual < z < ALIKE[1] * most
            and (
                mac(shape, shapes[0]) < SAME
                or any(
                    abs(np.log(f / scale / frequency[j])) < APART
                    and likeness(shape, seen, frequency, j) > BODILY
                    for j in free
                )
            )
            and (bodily > BODILY or beyond_doubt)
            and (
                abs(np.log(f / own[0])) > BESIDE
                or any(abs(np.log(f / scale / frequency[j])) < NEAR for j in free)
            )
            and not (law.setting.paired and abs(np.log(f / pair)) < TWIN)
            and _clear(f, known, beyond_doubt, _bases(found, take, (f, z, amplitude), on))
        ):
            out.append((float(f), float(z)))
            known.append(f)
    return out


def _bases(found: TimeFit, take: int, line: tuple, on: np.ndarray) -> list[float]:
    """Hz of those of the first two modes that swing far more, rms over the fitted part, than a line
    (Hz, damping ratio, (C,) amplitudes): it may be their overtone, or of both a combination.
    """
    f, z, amplitude = line
    data = found.law.takes[found.law.fitted[take]]
    wave = np.exp((data.time[data.fit] - data.time[0]) * poles(f, z))
    own = wave.std() / np.sqrt(2) * np.linalg.norm(amplitude)
    swing = found.motions[take][data.fit].std(axis=0)
    swing = swing * np.linalg.norm(found.shapes_of(take)[:, on], axis=1)
    pairs = zip(found.pitches(take)[:2], swing, strict=False)
    return [pitch for pitch, most in pairs if own < OVERTONE * most]


def _clear(f: float, known: list, beyond_doubt: bool, bases: list) -> bool:
    """Whether a pitch is none of the known ones, nor an overtone or a combination of the `bases`
    that is not `beyond_doubt` a mode of the body too.
    """
    if any(abs(np.log(f / k)) < APART for k in known):
        return False
    if beyond_doubt:
        return True
    overtones = [n * k for n in (2, 3) for k in bases]
    sums = [abs(a + sign * b) for a in bases for b in bases for sign in (1, -1) if a != b]
    return all(abs(f - t) > HARMONIC * f for t in overtones) and all(
        abs(f - t) > HARMONIC / 2 * f for t in sums
    )
