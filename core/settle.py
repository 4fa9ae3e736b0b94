"""Chosen modes fitted to all takes at once, without those that were none."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from .baseline import build_law, real_shapes, with_body
from .body import Body
from .channels import Channels
from .data import RingDown, poles, replace
from .elsewhere import elsewhere, unsure
from .gaps import bridged
from .law import Law, TimeFit
from .match import Match, align, likeness, mac, select, turning
from .pursuit import is_driven
from .residual import EVIDENCE, NOISY, QUIET
from .shutter import at_once, rung
from .timefit import as_it_stands, fit, resized
from .unheard import PARTED, bare, neighbours

STRAY = 0.15  # of its pitch that a mode may move when all are fitted together
CLOSE = 0.06  # the same, however near the next mode is
ONE = 0.1  # of its damping ratio, from the pitch that a weak mode ran into
NEARER = 5.0  # times as far it was heard from there
MUCH = 0.3  # damping ratio beyond which it has run off, unless it was heard so
AS_ONE = 0.03  # relative distance of two computed pitches that may sound as one
OFF = 0.05  # of its size in the body, from which a linear mode was left at a wrong one
OWN = 0.7  # MAC with its computed shape from which a mode beside the strongest is one
CANCELS = 0.1  # of what either of two close modes moves, that both together move at most


@dataclass(frozen=True, eq=False)
class Recorded:
    """What every trial of modes is fitted on."""

    takes: tuple[Channels, ...]
    condition: tuple[int, ...]
    bodies: tuple[Body, ...]
    rings: tuple[RingDown, ...]  # per take, as each was heard by itself

    @property
    def fitted(self) -> list[int]:
        """Which takes are not held out."""
        return [i for i, data in enumerate(self.takes) if not data.take.held_out]


def settle(
    ground: Recorded,
    chosen: list[RingDown],
    matches: dict[int, Match],
    tied=(),
    *,
    loud: int | None = None,
    aside=(),
):
    """The fit, the turns and the matches, without modes that leave the pitch they were heard at.

    `tied`: as `Law.tied`. loud: how many modes, the first ones, were heard by themselves; the
    others only in what these leave, and what is left `aside` (q,) Hz with them.

    A pole that runs off when all are fitted together was no mode of the body: it takes up some
    slow or strongly damped motion that a physical effect must explain. Nor is one that does not
    die away while the first mode does.
    """
    while True:
        condition = ground.condition[ground.fitted[0]]
        first, computed = matches[condition], ground.bodies[condition].modes.frequency
        found, turns = _fitted(ground, chosen, matches, tied)
        for ring in _opened(found, first, computed) if len(matches) == 1 else ():
            again = _in_each(ground, ring)
            other, turned = _fitted(ground, again, matches, tied)
            if other.chi2 < found.chi2 - EVIDENCE:
                found, turns, chosen = other, turned, again
        strayed = np.zeros(found.law.modes, bool)
        for take in _otherwise_pitched(found.law):
            ring = chosen[take]
            strayed |= astray(found, ring.frequency, ring.damping_ratio, loud, aside, take)
        if not strayed.any():
            return found, turns, matches
        kept, tied = np.flatnonzero(~strayed), ()
        loud = loud and int((kept < loud).sum())
        chosen = [select(ring, tuple(kept)) for ring in chosen]
        matches = {c: match.only(kept) for c, match in matches.items()}


def _fitted(
    ground: Recorded, chosen: list[RingDown], matches: dict[int, Match], tied
) -> tuple[TimeFit, tuple]:
    """The fit of the chosen modes and the turns of every condition."""
    first = matches[ground.condition[ground.fitted[0]]]
    body = ground.bodies[ground.condition[ground.fitted[0]]]
    computed, seen = body.modes.frequency, body.seen(ground.takes[ground.fitted[0]])
    turns_too = turning(first.modes, computed)
    apart = ground.condition
    if turns_too and len(ground.fitted) > 1:  # each release has a direction of its own
        apart = _apart(ground)
    law, start = build_law(chosen, ground.takes, apart, ground.condition)
    law, turns = _informed(law, ground, matches, chosen)
    law = replace(law, turning=turns_too, ways=_ways(first, computed, seen))
    law = replace(law, damping="free", tied=tied)
    found = _once_more(fit(law, start, evaluations=60), start)
    return resized(found) if (found.sizes_off > OFF).any() else found, turns


def _opened(found: TimeFit, match: Match, computed: np.ndarray) -> Iterator[RingDown]:
    """The poles with two that ran into one another as far apart again as `computed` (m,) Hz.

    Two modes at one pitch, of huge swings that cancel, tell almost any slow beat of two others.
    """
    known = [k for k, mode in enumerate(match.modes) if mode is not None]
    for k, j in combinations(known, 2):
        f, z = found.frequency.copy(), found.damping_ratio.copy()
        gap = np.log(computed[match.modes[k]] / computed[match.modes[j]])
        now = abs(np.log(f[k] / f[j]))
        apart = max(NEARER * now, PARTED) < abs(gap) < STRAY
        if now > ONE * min(z[k], z[j]) or not apart:
            continue
        f[[k, j]] = np.sqrt(f[k] * f[j]) * np.exp([gap / 2, -gap / 2])
        z[[k, j]] = np.sqrt(z[k] * z[j])
        yield bare(f, z, found.law.takes[found.law.fitted[0]].sigma)


def settle_poles(ground: Recorded, ring: RingDown, match: Match, tied=(), **how):
    """What `settle` returns of the poles of a ring-down, whose `match` is that of the first fitted
    take's body, with the amplitudes that they have in every take.
    """
    matches = {ground.condition[ground.fitted[0]]: match}
    return settle(ground, _in_each(ground, ring), matches, tied, **how)


def _ways(match: Match, frequency: np.ndarray, seen: np.ndarray) -> tuple[np.ndarray, ...]:
    """(C, w) of every matched mode: how it, and what sounds as one with it, are seen (m, C)."""
    out = []
    for mode in match.modes:
        near = [] if mode is None else np.abs(frequency / frequency[mode] - 1) < AS_ONE
        free = [j for j in np.flatnonzero(near) if j == mode or j not in match.modes]
        out.append(seen[free].T)
    return tuple(out)


def _once_more(found: TimeFit, start: np.ndarray) -> TimeFit:
    """The fit, or a better one from the pitches that were heard, with the swings that it found.

    Two modes close together trade their swings, which are badly known at the start, for pitches.
    """
    near = _to_nearest(found.frequency) < CLOSE
    if found.law.tied or not near.any() or found.chi2 < QUIET * found.samples:
        return found
    at = found.law.sizes()[0]
    again = fit(found.law, np.r_[start[:at], found.parameters[at:]], evaluations=40)
    return min(found, again, key=lambda one: one.chi2)


def astray(
    found: TimeFit,
    heard: np.ndarray,
    z: np.ndarray,
    loud: int | None = None,
    aside=(),
    take: int = 0,
) -> np.ndarray:
    """(K,) bool: modes that, in the fitted `take` of that number, have left the pitch (Hz) or
    damping ratio that they were heard at, or that no longer die away while the first one does, or
    that have taken the place of the first one, which has left it, or weak ones, those after the
    first `loud`, that have run into another one's pitch: they take but a share of what that one
    does. Nor is it theirs what was left `aside` (q,) Hz, if they end `NEARER` by it than to where
    they were heard.
    """
    frequency, damping_ratio = found.pitches(take), found.damping_ratios(take)
    away, nearest = np.abs(np.log(frequency / heard)), _to_nearest(frequency)
    strayed = (away > STRAY) | (away > np.maximum(nearest, CLOSE))
    strayed |= damping_ratio > np.maximum(MUCH, 2 * z)
    pole = poles(frequency, damping_ratio)
    strayed |= is_driven(pole, found.law.setting.duration, pole[:1])
    if away[0] > STRAY:
        strayed |= np.abs(np.log(frequency / heard[0])) < np.minimum(away, away[0])
    strayed[0] = False
    aside = np.asarray(aside, float)
    for k in range(len(heard) if loud is None else loud, len(heard)):
        near, others = ONE * damping_ratio[k], np.flatnonzero(~strayed[:k])
        then, now = (np.abs(np.log(f[k] / f[others])).min() for f in (heard, frequency))
        strayed[k] |= now < near and then > NEARER * near and away[k] > near
        from_them = np.abs(np.log(frequency[k] / aside)).min(initial=np.inf)
        strayed[k] |= NEARER * from_them < away[k]
    return strayed


def _otherwise_pitched(law: Law) -> list[int]:
    """The number of the first fitted take of each set of pitches."""
    return list({law.pitch[i]: n for n, i in reversed(list(enumerate(law.fitted)))}.values())


def displaced(wider: TimeFit, found: TimeFit) -> bool:
    """Whether one of a fit's modes has left its place in a wider one: what that gains is no gain of
    what was added.
    """
    heard = found.frequency, found.damping_ratio
    return bool((astray(wider, *heard) & ~astray(found, *heard)).any())


def cancels(found: TimeFit) -> bool:
    """Whether the last mode and one close to it swing against each other, so that hardly anything
    of them is seen: such two tell almost any slow beat.
    """
    on = ~found.law.takes[found.law.fitted[0]].support
    last = found.law.modes - 1
    close = np.abs(np.log(found.frequency[:last] / found.frequency[last])) < CLOSE
    return any(_share_seen(found, [k, last], on) < CANCELS for k in np.flatnonzero(close))


def _share_seen(found: TimeFit, both: list[int], on: np.ndarray) -> float:
    """The most that these modes move any channel, over the most that one of them does."""
    takes = [(u[:, both], found.shapes_of(n)[both][:, on]) for n, u in enumerate(found.motions)]
    together = max(np.abs(u @ shapes).max() for u, shapes in takes)
    alone = [np.abs(u).max(axis=0) * np.abs(shapes).max(axis=1) for u, shapes in takes]
    return float(together / max(np.max(alone), 1e-300))


def _to_nearest(frequency: np.ndarray) -> np.ndarray:
    """(K,) how far each mode's pitch lies from the nearest other one, in logarithms."""
    gap = np.abs(np.log(frequency[:, None] / frequency))
    np.fill_diagonal(gap, np.inf)
    return gap.min(axis=1)


def _informed(law: Law, ground: Recorded, matches, chosen):
    """The law told of the first condition's body; the turns of every fitted condition."""
    bodies, condition = ground.bodies, ground.condition
    turns = [None] * len(bodies)
    told = False
    for ring, i in zip(chosen, ground.fitted, strict=True):
        c = condition[i]
        if turns[c] is not None or None in matches[c].modes:
            continue
        seen = bodies[c].seen(law.takes[i])
        measured, _ = real_shapes(ring.amplitude)
        turns[c] = align(matches[c].modes, seen, bodies[c].modes.frequency, measured)
        if not told:
            law = with_body(law, law.takes[i], bodies[c], turns[c])
            told = True
            if i == ground.fitted[0]:
                law = told_elsewhere(ground, law, turns[c])
    return law, tuple(turns)


def told_elsewhere(ground: Recorded, law: Law, turn: np.ndarray) -> Law:
    """The law told by the bodies how takes that no fitted one is like differ from the first one."""
    known, first = {ground.condition[i] for i in ground.fitted}, ground.fitted[0]
    both = [(t, ground.bodies[c]) for t, c in zip(ground.takes, ground.condition, strict=True)]
    unlike = tuple(
        None if c in known else elsewhere(both[first], there, turn, law.reference)
        for there, c in zip(both, ground.condition, strict=True)
    )
    takes = tuple(
        replace(data, doubt=unsure(one, data, law.setting.omega[0])) if one else data
        for one, data in zip(unlike, law.takes, strict=True)
    )
    return replace(law, elsewhere=unlike, takes=takes)


def _apart(ground: Recorded) -> tuple[int, ...]:
    """A condition of its own for every fitted take; a held-out one keeps that of its loads."""
    fitted, condition = ground.fitted, ground.condition
    first = {condition[i]: n for n, i in reversed(list(enumerate(fitted)))}
    return tuple(
        fitted.index(i) if i in fitted else first.get(condition[i], len(fitted))
        for i in range(len(condition))
    )


def _in_each(ground: Recorded, ring: RingDown) -> list[RingDown]:
    """The ring-down with the amplitudes that its poles have in each of the fitted takes."""
    return [amplitudes(ground, index, ring) for index in ground.fitted]


def amplitudes(ground: Recorded, index: int, ring: RingDown) -> RingDown:
    """The ring-down with the amplitudes that its poles have in a take, beside means that wander as
    they were heard to there.
    """
    data = ground.takes[index]
    heard, late = ground.rings[index], 0.0 if data.late is None else data.late
    told = rung(heard, data.time, late)
    values, whole = bridged(data.values, told, data.fit, heard.slow(data.time))
    use = data.fit & whole
    pole = poles(ring.frequency, ring.damping_ratio)
    phase = np.exp(np.outer(data.time[use], pole))
    slow = heard.slow(data.time[use])
    basis = np.hstack([phase.real, -phase.imag, slow])
    x, *_ = np.linalg.lstsq(basis, values[use], rcond=None)
    K = len(ring.frequency)
    amplitude = at_once(x[:K] + 1j * x[K : 2 * K], pole, data.late)
    return replace(ring, amplitude=amplitude, offset=x[2 * K], t0=0.0)


def beside(ground: Recorded, free: TimeFit, match: Match):
    """What is settled with one of the strongest mode's neighbours, for each of them."""
    condition = ground.condition[ground.fitted[0]]
    heard, body = ground.rings[ground.fitted[0]], ground.bodies[condition]
    for ring, both, tied in neighbours(free, heard, match, body):
        yield settle_poles(ground, ring, both, tied)


def moves_its_way(found: TimeFit, body: Body, mode: int) -> bool:
    """Whether the last mode of a fit moves as computed `mode` does, and not as another one's mimic.

    Two free modes of one shape tell almost anything that acts on one.
    """
    data = found.law.takes[found.law.fitted[0]]
    on = ~data.support
    seen, shape = body.seen(data)[:, on], found.shapes[-1, on]
    own = likeness(shape, seen, body.modes.frequency, mode)
    return own > OWN and mac(shape, found.shapes[0, on]) < OWN


def untied(found: TimeFit) -> TimeFit:
    """The fit without ties: at its best where that leaves noise, else as it stands.

    Two free modes mimic what acts in time by drawing together; what is sought from there goes
    astray.
    """
    law = replace(found.law, tied=())
    best = fit(law, found.parameters, evaluations=40)
    return best if best.chi2 < NOISY * best.samples else as_it_stands(law, found.parameters)
