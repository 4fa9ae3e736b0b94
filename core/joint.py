"""All takes of a case together: one set of modes and effects, each take with its own start."""

from dataclasses import dataclass

import numpy as np

from .arcs import off_arcs
from .body import Body
from .channels import Channels
from .conditions import common, first_take, left_out, shift
from .data import RingDown, replace
from .declared import with_declared
from .effects.partner import is_of
from .further import with_further, with_left_out, without_runaways
from .law import TimeFit
from .lens import fitted, straightened
from .match import Match, has_twin, match_modes, select
from .outlived import after_bursts, after_outlived
from .partners import FAINT, gaps_of, heard_split, swing_of, with_partners
from .pursuit import pursue
from .recorded import recorded
from .residual import EVIDENCE, NOISY, QUIET, bic, excess
from .seat import seated
from .settle import (
    Recorded,
    amplitudes,
    astray,
    beside,
    moves_its_way,
    settle,
    settle_poles,
    untied,
)
from .timefit import fit
from .unheard import bare, rest_of, weak_modes

WEAK = 0.6  # likeness in shape less twice the difference in pitch that makes a weak mode known
WEAKER = 0.4  # the same, where it takes most of what was left
LESS = 0.5  # of that, rms, is then left at most
SHOWN = 0.7  # of that, rms, is left at most when it shows
AUDIBLE = 0.05  # of the motion, rms, that must be left for that
MORE = 1.1  # times the misfit, from which another seat of the loads leaves more
LADEN = 1.5  # of how far a load parts a pair as computed: its place and width are not sure
SEAT = 0.1  # of how far a load shifts a pitch, that its place and width may part a pair by


@dataclass(frozen=True, eq=False)
class Heard:
    """The takes as channels and ring-downs, the bodies they need, and the declared fit."""

    takes: tuple[Channels, ...]
    rings: tuple[RingDown, ...]
    condition: tuple[int, ...]  # per take: which body
    bodies: tuple[Body, ...]
    match: Match
    turns: tuple[np.ndarray | None, ...]  # per body (m, K): computed modes turned to measured
    free: TimeFit  # every mode with a damping ratio of its own
    declared: TimeFit  # damped as the case declares
    # the same as the camera was declared, where it stands nearer than that
    far: "Heard | None" = None

    @property
    def body(self) -> Body:
        """Of the first take."""
        return self.bodies[0]

    def shapes(self, condition: int = 0) -> np.ndarray:
        """(P, 3, K) kg^-1/2 computed shapes of the measured modes."""
        return self.bodies[condition].modes.shapes @ self.turns[condition]


def damping_law(declared: tuple[str, ...]) -> str:
    """How the declared model loses energy."""
    if "viscous_damping" in declared:
        return "free"
    return "common" if "structural_damping" in declared else "none"


def hear(body: Body, find_release) -> Heard:
    """Listen to every take, match its modes, and fit the declared law to those not held out.

    `body`: with the loads of the first take. Where its pitches tell that these sit otherwise, they
    do, unless that leaves more of what was heard: which modes a load parts hangs on it, too.

    Raises RecordingError as `listen` does of the first take.
    """
    ground = recorded(body, find_release)
    matches = _matches(ground)
    later = after_outlived(ground, matches)
    if later is not ground:
        ground, matches = later, _matches(later)
    heard = _hear(ground, matches)
    ground, heard = _without_arcs(ground, heard)
    ground, heard = _without_bursts(ground, heard)
    sitting = seated(ground, ground.rings)
    if sitting is ground:
        return heard
    other = _hear(sitting, _matches(sitting))
    noise = NOISY * heard.free.samples
    return other if other.free.chi2 < max(MORE * heard.free.chi2, noise) else heard


def _hear(ground: Recorded, matches: dict[int, Match]) -> Heard:
    """The takes heard on these bodies, by modes matched so."""
    condition, rings = ground.condition, ground.rings
    heard = {condition[i]: rings[i].frequency for i in reversed(ground.fitted)}
    every, matches = matches, common(matches, heard)
    loaded = left_out(ground, rings, every, matches)
    chosen = [_same_poles(ground, i, matches) for i in ground.fitted]
    settled = settle(ground, chosen, matches)
    straight = _straightened(ground, settled)
    if straight is ground:
        return heard_by(ground, _whole(ground, settled, loaded))
    chosen = [_same_poles(straight, i, settled[2]) for i in ground.fitted]
    unbent = settle(straight, chosen, settled[2])
    if excess(settled[0]) < SHOWN * excess(unbent[0]):  # swings that cancel bend as if they did not
        return heard_by(ground, _whole(ground, settled, loaded))
    settled = unbent
    whole = _whole(straight, settled, loaded)
    free, _, first = whole
    at = ground.fitted[0]
    loud = len(settled[2][condition[at]].modes)
    if len(first.modes) > loud:  # what was not heard by itself bends, too
        straight = _straightened(ground, whole)
        poles = bare(free.frequency, free.damping_ratio, ground.takes[at].sigma)
        whole = with_all(straight, settle_poles(straight, poles, first, free.law.tied, loud=loud))
    return heard_by(straight, whole)


def heard_by(ground: Recorded, whole: tuple) -> Heard:
    """All that was heard, with the declared fit; `whole`: what `with_all` gave."""
    free, turns, first = whole
    if free.law.tied:
        free = untied(free)
    names = ground.bodies[0].case.declared
    free = with_declared(free, names)
    declared, damping = free, damping_law(names)
    if damping != "free":
        declared = fit(replace(free.law, damping=damping), free.parameters, evaluations=40)
    return Heard(
        ground.takes, ground.rings, ground.condition, ground.bodies, first, turns, free, declared
    )


def _matches(ground: Recorded) -> dict[int, Match]:
    """The match of the first fitted take of every condition."""
    return {
        c: _match(ground.takes[i], ground.rings[i], ground.bodies[c])
        for i, c in reversed([(i, ground.condition[i]) for i in ground.fitted])
    }


def _without_bursts(ground: Recorded, heard: Heard) -> tuple[Recorded, Heard]:
    """The takes, and what was heard, after brief bursts; as they were where more than noise is left
    then, or a mode is heard no more.
    """
    later = after_bursts(ground, heard.free)
    if later is ground:
        return ground, heard
    other = _hear(later, _matches(later))
    quiet = other.free.chi2 < QUIET * other.free.samples
    same = set(heard.match.modes) <= set(other.match.modes)
    return (later, other) if quiet and same else (ground, heard)


def _without_arcs(ground: Recorded, heard: Heard) -> tuple[Recorded, Heard]:
    """The takes, and what was heard, without the arcs that the markers go on; as they were where
    that tells no more.
    """
    straight = off_arcs(ground, heard.takes, heard.free, heard.turns[0])
    if straight is ground:
        return ground, heard
    other = _hear(straight, _matches(straight))
    better = bic(other.free) < bic(heard.free) - EVIDENCE
    return (straight, other) if better else (ground, heard)


def _whole(ground: Recorded, settled: tuple, loaded: list):
    """The settled fit with weak modes, partners and further modes; the turns, the first match.

    A weak mode that leaves its place once the others are there was none. `loaded`: see
    `with_left_out`.
    """
    condition = ground.condition[ground.fitted[0]]
    body = ground.bodies[condition]
    free, _, matches = settled
    first = matches[condition]
    if len(matches) > 1 or None in first.modes:
        return with_all(ground, (with_left_out(free, loaded), *settled[1:]))
    tried, wider, rest = None, None, rest_of(free)
    for alike in (WEAKER, WEAK) if rest else ():
        weak = weak_modes(free, rest, body, first, alike)
        if weak is None:
            break
        if weak[1].modes != tried:
            ring, both, aside = weak
            tried, loud = both.modes, len(first.modes)
            wider = settle_poles(ground, ring, both, loud=loud, aside=aside)
        if alike < WEAK and excess(wider[0]) > LESS * excess(free):
            continue
        wider = _with_neighbour(ground, wider)
        found = with_all(ground, wider)
        if not astray(found[0], wider[0].frequency, wider[0].damping_ratio).any():
            return found
    return with_all(ground, _with_neighbour(ground, settled))


def _with_neighbour(ground: Recorded, settled: tuple) -> tuple:
    """The settled fit with a low mode that was not heard beside a strong one, where it shows."""
    free, _, matches = settled
    condition = ground.condition[ground.fitted[0]]
    match = matches[condition]
    if excess(free) < AUDIBLE:
        return settled
    for wider in beside(ground, free, match):
        more = len(wider[2][condition].modes) > len(match.modes)
        if not more or excess(wider[0]) > SHOWN * excess(free):
            continue
        if moves_its_way(wider[0], ground.bodies[condition], wider[2][condition].modes[-1]):
            return wider
    return settled


def with_all(ground: Recorded, settled: tuple):
    """The settled fit with partners and further modes; the turns, the first match."""
    free, turns, matches = settled
    condition = ground.condition[ground.fitted[0]]
    first, body = matches[condition], ground.bodies[condition]
    gaps = gaps_of(first.modes, body)
    paired, pair = has_twin(first.modes, body.modes.frequency), 0
    if not paired and gaps and body.pairs:  # the strongest of the others with a partner
        swing = swing_of(free)
        pair = max(gaps, key=lambda k: swing[k])
        paired = bool(swing[pair] > FAINT * swing.max())
    setting = replace(
        free.law.setting, paired=paired, symmetric=body.pairs, pair=pair, pair_gap=gaps.get(pair)
    )
    free = replace(free, law=replace(free.law, setting=setting))
    if len(matches) == 1:
        data, ring = ground.takes[ground.fitted[0]], ground.rings[ground.fitted[0]]
        seen, own = body.seen(data), body.modes.frequency
        gaps = {
            k: gap
            for k, gap in gaps.items()
            if not heard_split(ring, ~data.support, first.modes[k], seen, own, gap)
        }
        free = with_partners(free, gaps)
        wider = with_further(free, first, body, ground.rings)
        if len(wider.theta) > len(free.theta) and wider.chi2 > NOISY * wider.samples:
            lone = {
                k: gap
                for k, gap in gaps.items()
                if not any(is_of(effect, k) for effect in wider.law.effects)
            }
            wider = without_runaways(with_partners(wider, lone))  # what further modes hid
        return wider, turns, first
    # what other loads part hides what belongs to one take
    free = with_further(free, first, body, ground.rings)
    for c, match in matches.items():
        if None not in match.modes:
            take = first_take(ground, c)
            parted = gaps_of(match.modes, ground.bodies[c])
            known = all(None not in m.modes for m in matches.values())
            if known and ground.takes[ground.fitted[take]].take.loads:
                apart = shift(ground, matches)
                parted = {k: max(LADEN * gap, SEAT * apart[k]) for k, gap in parted.items()}
            free = with_partners(free, parted, take=take)
    return free, turns, first


def _straightened(ground: Recorded, settled: tuple) -> Recorded:
    """The takes as a lens would show them that bends nothing; the same where none does."""
    free, turns, _ = settled
    straight = []
    for index, data in enumerate(ground.takes):
        turn, body = turns[ground.condition[index]], ground.bodies[ground.condition[index]]
        take = ground.fitted.index(index) if index in ground.fitted else None
        known = None if take is None else fitted(free, take, data)
        straight.append(data if turn is None else straightened(data, body, turn, known))
    if all(new is old for new, old in zip(straight, ground.takes, strict=True)):
        return ground
    return replace(ground, takes=tuple(straight))


def laid_bare(heard: Heard, found: TimeFit, effects: int) -> TimeFit:
    """The fit with the body's modes that its last so many effects lay bare: other directions of
    degenerate modes where none of these is a force (that has `across`) or read off the takes, in
    takes with the first one's loads, and further modes.
    """
    own = found.law.effects[-effects:]
    known = any(e.layer == "pair" for e in found.law.effects)
    forced = any(e.marched or e.given for e in own)
    if None not in heard.match.modes and not known and not forced:
        gaps = gaps_of(heard.match.modes, heard.body)
        found = with_partners(found, gaps, effects)
    return with_further(found, heard.match, heard.body, at=len(found.law.effects) - effects)


def _match(data: Channels, ring: RingDown, body: Body) -> Match:
    chase = pursue(ring, data.time[data.fit], data.values[data.fit], data.sigma, late=data.late)
    computed = body.modes.frequency, body.seen(data)
    return match_modes(ring, chase, *computed, 1 / data.frame, pairs=body.pairs)


def _same_poles(ground: Recorded, index: int, matches) -> RingDown:
    """The chosen poles of a take's condition, with the amplitudes of this take."""
    c = ground.condition[index]
    source = next(i for i in ground.fitted if ground.condition[i] == c)
    ring = select(ground.rings[source], matches[c].poles)
    if source == index:
        return ring
    return amplitudes(ground, index, ring)
