"""Which computed mode is which measured one: by frequency and by shape at the markers (MAC)."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.stats import beta

from .data import RingDown, replace
from .effects.aliasing import is_folded, unfolded
from .pursuit import HEARD

PAIR = 0.015  # relative distance below which two computed modes count as a degenerate pair
SPLIT = 0.15  # relative, up to which a degenerate pair is one that `split_modes` parts
TURNED = 0.1  # relative, of two computed modes that a body which is a little other turns so
PARTED = 0.006  # relative, of a computed pair: less may be what meshing makes of one pitch
ACROSS = 0.3  # MAC below which two motions have other directions
CREEPING = 0.25  # damping ratio from which a pole may be a mean that wanders
ALIKE = 2.0  # ratio of damping ratios of two modes of one body, less than which is usual
UNLIKE = 8.0  # the same, more than which is none but where it goes with the pitch
CHANCE = 0.05  # that a motion that is none of a body's modes moves as one of them
SURE = 0.7  # likeness in shape from which a mode is known by its fold
FOLDED = 5.0  # likeness in shape that one of relative pitch weighs, for a folded mode
LOWEST = 0.9  # of the lowest computed pitch: what is heard below is none of the body's modes
DEEPEST = 0.3  # of it, below which no mass of the body's own brings one: a mean that wanders
STRONG = 0.2  # of the strongest pole, from which one is surely there
LEAST = 0.35  # likeness, less the difference in pitch, from which a mode is known
HARMONIC = 0.04  # relative distance below which a pole is an overtone of a nonlinear mode
COMBINED = 0.005  # the same, of an overtone of any shape, or a sum or difference of two pitches
FITS = 0.05  # relative, of a computed pitch, within which such a one is a mode all the same


@dataclass(frozen=True)
class Match:
    """Measured poles that are modes of the body, and the computed mode of each."""

    # into the ring-down, the strongest first where one take is heard, or one below it that must be
    # the lowest; that of a mode which was not heard by itself is the first one's
    poles: tuple[int, ...]
    modes: tuple[int | None, ...]  # into the computed modes; None = no computed mode fits

    def only(self, kept) -> "Match":
        """Its modes `kept` (m,), in that order."""
        return Match(tuple(self.poles[k] for k in kept), tuple(self.modes[k] for k in kept))


def mac(a: np.ndarray, b: np.ndarray) -> float:
    """Modal assurance criterion |a.b|^2 / (a.a b.b), 0 to 1 (Allemang, Sound Vib. 37, 2003)."""
    power = (a @ a) * (b @ b)
    return float((a @ b) ** 2 / power) if power > 0 else 0.0


@dataclass(frozen=True, eq=False)
class _Computed:
    """Computed modes at one modulus."""

    frequency: np.ndarray  # (m,) Hz
    shapes: np.ndarray  # (m, C)
    rate: float  # Hz, the frame rate
    pairs: bool  # whether near ones may be two ways of one symmetric body

    def likeness(self, shape: np.ndarray, j: int) -> float:
        """That of `likeness`; where no pair is one by symmetry, mode j's own counts for half."""
        alike = likeness(shape, self.shapes, self.frequency, j)
        return alike if self.pairs else (alike + mac(shape, self.shapes[j])) / 2

    def turned(self, shape: np.ndarray, j: int) -> float:
        return _turned(shape, self.shapes, self.frequency, j)


def likeness(shape: np.ndarray, modes: np.ndarray, frequency: np.ndarray, j: int) -> float:
    """MAC of `shape` (C,) with mode j of `modes` (m, C), or with the pair that j belongs to."""
    pair = modes[np.abs(frequency / frequency[j] - 1) < PAIR]
    q, _ = np.linalg.qr(pair.T)
    return float(((q.T @ shape) ** 2).sum() / (shape @ shape))


def match_modes(
    ring: RingDown,
    chase: tuple,
    frequency: np.ndarray,
    shapes: np.ndarray,
    rate: float = np.inf,
    *,
    pairs: bool = True,
) -> Match:
    """Match `ring` to computed modes at any one modulus: frequency (m,), shapes (m, C).

    `rate` is the frame rate: a computed mode above half of it is known by its fold. `pairs` is
    `Body.pairs`.

    `chase` is what `pursue` gave. The modulus is unknown, so every computed mode is tried as the
    strongest measured one; the assignment with the best likeness in shape and in ratio of
    frequencies, weighted by strength, wins. Overtones and same-shape companions of a stronger
    pole are no modes of the body. No body has a mode below its lowest: what is heard there, strong
    and moving as a mode does, is tried as the first one instead, whatever the strongest is then,
    but as no mode above the one that the strongest was matched to.
    Where that is like no computed mode, another one that surely is leads, if its pitch tells it.
    """
    computed = _Computed(frequency, shapes, rate, pairs)
    answer = _matched(ring, chase, computed, computed.likeness)
    if None in answer.modes:  # it and one that lies near may have turned into one another
        answer = _matched(ring, chase, computed, computed.turned)
        if None in answer.modes:
            answer = _led_by_another(ring, chase, computed) or answer
        return answer
    for lower in _below(answer, ring, chase, frequency, shapes):
        other = _matched(ring, _led(chase, lower), computed, computed.likeness)
        if None not in other.modes and frequency[other.modes[0]] <= frequency[answer.modes[0]]:
            return other
    return answer


def _led(chase: tuple, n: int) -> tuple:
    """The chase with its pole number n first."""
    order = [n, *(i for i in range(len(chase[0])) if i != n)]
    return tuple([one[i] for i in order] for one in chase)


def _led_by_another(ring: RingDown, chase: tuple, computed: _Computed) -> Match | None:
    """The match by the strongest pole that is surely a mode and by whose pitch the strongest of all
    is one, too, which is like none clearly enough to lead; that one first. None if there is none.

    What bends one mode's shape beyond knowing, as a heavy mass does, may leave the others theirs.
    """
    order, measured, strength = chase
    for n in np.argsort(-strength):
        sure = max(computed.likeness(measured[n], j) for j in range(len(computed.frequency)))
        if n == 0 or strength[n] < HEARD * strength[0] or sure < SURE:
            continue
        other = _matched(ring, _led(chase, n), computed, computed.likeness)
        if order[0] in other.poles:
            k = other.poles.index(order[0])
            return other.only([k, *(i for i in range(len(other.poles)) if i != k)])
    return None


def _below(found: Match, ring: RingDown, chase: tuple, frequency, shapes) -> Iterator[int]:
    """Poles, the strongest first, that lie below all modes, as the strongest one was matched, and
    move as one of them and not as that one does: so the body is another, its lowest mode such a
    pole.
    """
    order, measured, strength = chase
    pitch, z = ring.frequency[list(order)], ring.damping_ratio[list(order)]
    scale = pitch[0] / frequency[found.modes[0]]
    for n in np.argsort(strength)[::-1]:
        if strength[n] < STRONG * strength[0]:
            break
        if order[n] in found.poles:  # as a fold, perhaps
            continue
        low = pitch[n] / (scale * frequency.min())
        if DEEPEST < low < LOWEST and z[n] < CREEPING:
            alike = max(likeness(measured[n], shapes, frequency, j) for j in range(len(frequency)))
            if alike > SURE and mac(measured[n], measured[0]) < SURE:
                yield int(n)


def _turned(shape: np.ndarray, modes: np.ndarray, frequency: np.ndarray, j: int) -> float:
    """MAC of `shape` (C,) with mode j and the one next to it, where it is more like j and where by
    chance no motion would be so like any two of the modes (m, C), else 0.
    """
    gap = np.abs(frequency / frequency[j] - 1)
    gap[j] = np.inf
    near, channels = int(np.argmin(gap)), (np.abs(modes) > 0).any(axis=0).sum()
    if gap[near] > TURNED or channels <= 2 or mac(shape, modes[near]) > mac(shape, modes[j]):
        return 0.0
    q, _ = np.linalg.qr(modes[[j, near]].T)
    alike = float(((q.T @ shape) ** 2).sum() / (shape @ shape))
    return alike if len(modes) * beta.sf(alike, 1, (channels - 2) / 2) < CHANCE else 0.0


def _matched(ring, chase, computed: _Computed, alike_first) -> Match:
    """`match_modes` where `alike_first` says how like the strongest pole is to a computed mode."""
    order, measured, strength = chase
    frequency = computed.frequency
    heard = [
        (ring.frequency[k], shape, ring.damping_ratio[k])
        for k, shape in zip(order, measured, strict=True)
    ]
    best, answer = -np.inf, Match((order[0],), (None,))
    for first in range(min(len(frequency), 8)):
        alike = alike_first(measured[0], first)
        if alike < 0.5:
            continue
        scaled = replace(computed, frequency=frequency * (heard[0][0] / frequency[first]))
        taken, modes, score = [0], [first], strength[0] * (alike - 0.03 * first)
        halves = {}  # of pairs that are split, by the matched mode: each has one other half
        for k in range(1, len(order)):
            some = [heard[i] for i in taken]
            j, quality = _partner(heard[k], some, modes, scaled)
            if j is not None:
                taken.append(k)
                modes.append(j)
                score += strength[k] * quality
                continue
            other, fit = _as_other_half(heard[k], some, modes, scaled)
            halves[other] = max(halves.get(other, 0.0), strength[k] * fit)
        score += sum(halves.values())
        if score > best:
            best, answer = score, Match(tuple(order[k] for k in taken), tuple(modes))
    return answer


def _partner(one, taken, modes, computed: _Computed):
    """The free computed mode of a measured (frequency, shape, damping ratio), and how good it is,
    or None.
    """
    f, shape, z = one
    frequency, rate = computed.frequency, computed.rate
    for g, other, _ in taken:
        overtone = any(abs(f / g / n - 1) < HARMONIC for n in (2, 3, 4, 5))
        if mac(shape, other) > 0.9 and (overtone or abs(f / g - 1) < 0.4):
            return None, 0.0
    free = [j for j in range(len(frequency))
            if j not in modes and _may_pair(one, j, taken, modes, computed)]  # fmt: skip
    if _is_nonlinear_tone(f, [g for g, _, _ in taken]):
        free = [j for j in free if abs(f / frequency[j] - 1) < FITS]
    alike = {j: computed.likeness(shape, j) for j in free}
    if f > (1 + PAIR) * frequency.max():  # it may be a mode that was not computed
        free = [j for j in free if alike[j] > SURE]
    plain = {j: alike[j] - abs(np.log(f / frequency[j])) for j in free}
    known = max(plain.values(), default=0.0) > LEAST
    # a split pair's other half is left for the effects; else a fold may be like it
    if not known and not _may_be_partner(f, taken, modes, computed):
        plain = {
            j: alike[j] - FOLDED * abs(unfolded(f, frequency[j], rate) / frequency[j] - 1)
            for j in free
            if is_folded(f, frequency[j], rate)
            and alike[j] > SURE
            and dies_alike(f, z, unfolded(f, frequency[j], rate), taken[0])
        }
    found = max(plain, key=plain.get, default=None)
    if found is None or plain[found] <= LEAST:
        return None, 0.0
    return found, plain[found]


def _as_other_half(one, taken, modes, computed: _Computed) -> tuple[int | None, float]:
    """The matched mode of which a pole is the split partner, which is left for the effects, and how
    well it is told so; None and nought where it is none.
    """
    f, shape, _ = one
    fits = {
        m: computed.likeness(shape, m) - abs(np.log(f / g))
        for (g, _, _), m in zip(taken, modes, strict=True)
        if _may_be_partner(f, [(g, None, None)], [m], computed)
    }
    best = max(fits, key=fits.get, default=None)
    return (None, 0.0) if best is None or fits[best] <= SURE else (best, fits[best])


def _is_nonlinear_tone(f: float, pitches: list[float]) -> bool:
    """Whether f is the sum or the difference of two pitches, or twice or three times one, as what
    is not linear sounds.
    """
    pairs = [tone for a, b in combinations(pitches, 2) for tone in (a + b, abs(a - b))]
    tones = pairs + [n * pitch for pitch in pitches for n in (2, 3)]
    return any(abs(f / tone - 1) < COMBINED for tone in tones if tone > 0)


def dies_alike(f: float, z: float, pitch: float, first) -> bool:
    """Whether a pole seen at f Hz with a damping ratio z, the fold of `pitch`, dies as a mode there
    may beside the `first` one (Hz, its shape, damping ratio): no less damped by far, and no more
    than where the n-fold pitch is damped n-fold. Near nought a fold looks heavily damped, as a mean
    that wanders does.
    """
    true, most = max(z, 1e-9) * f / pitch / first[2], UNLIKE * max(pitch / first[0], 1.0)
    if z > CREEPING:
        return abs(np.log(true)) < np.log(ALIKE)
    return bool(1 / UNLIKE < true < most)


def _may_pair(one, j: int, taken, modes, computed: _Computed) -> bool:
    """Whether mode j is no partner of a matched one, or one that is pulled far off its pitch, or
    as far from it as was computed. Where no symmetry makes pairs, and the two are as far apart as a
    coarse mesh may have it, whether each goes its own way.
    """
    f, shape, _ = one
    frequency, shapes = computed.frequency, computed.shapes

    def apart(g, other, m):
        seen, gap = np.log(f / g), np.log(frequency[j] / frequency[m])
        if not computed.pairs and abs(seen - gap) < 2 * PAIR:
            own, across = (mac(shape, shapes[i]) - mac(other, shapes[i]) for i in (j, m))
            return own > 0 > across
        foretold = abs(gap) > PARTED and abs(seen / gap - 1) < 0.5
        return foretold or (abs(seen) > SPLIT and mac(shape, other) < ACROSS)

    return all(
        apart(g, other, m)
        for (g, other, _), m in zip(taken, modes, strict=True)
        if abs(frequency[m] / frequency[j] - 1) < PAIR
    )


def _may_be_partner(f: float, taken, modes, computed: _Computed) -> bool:
    """Whether a pole at f is near enough to a matched mode of a pair to be its split partner."""
    frequency = computed.frequency
    return computed.pairs and any(
        abs(np.log(f / g)) <= SPLIT and (np.abs(frequency / frequency[m] - 1) < PAIR).sum() > 1
        for (g, _, _), m in zip(taken, modes, strict=True)
    )


def true_pitches(
    seen: np.ndarray, modes: tuple[int | None, ...], frequency: np.ndarray, rate: float
) -> np.ndarray:
    """(K,) Hz of the matched modes with those unfolded that the frame rate folded."""
    if None in modes:
        return seen
    computed = frequency[list(modes)] * (seen[0] / frequency[modes[0]])
    return np.array([
        unfolded(f, c, rate) if is_folded(f, c, rate) else f
        for f, c in zip(seen, computed, strict=True)
    ])  # fmt: skip


def has_twin(modes: tuple[int | None, ...], frequency: np.ndarray) -> bool:
    """Whether the first matched mode is one of a nearly degenerate pair, the other not matched."""
    if modes[0] is None:
        return True
    near = np.flatnonzero(np.abs(frequency / frequency[modes[0]] - 1) < 2 * PAIR)
    return any(j not in modes for j in near)


def turning(
    modes: tuple[int | None, ...], frequency: np.ndarray, apart: float = PAIR
) -> tuple[int, ...]:
    """Which matched modes are one of a degenerate pair: their motion may turn in an ellipse.

    `apart`: how far, relatively, the other one may lie.
    """
    return tuple(
        k
        for k, j in enumerate(modes)
        if j is not None
        and any(
            i not in modes for i in np.flatnonzero(np.abs(frequency / frequency[j] - 1) < apart)
        )
    )


def align(modes, seen: np.ndarray, frequency: np.ndarray, measured: np.ndarray):
    """Coefficients (m, K) that turn computed modes, within degenerate pairs, to measured (K, C)."""
    turn = np.zeros((len(seen), len(modes)))
    for k, j in enumerate(modes):
        pair = np.flatnonzero(np.abs(frequency / frequency[j] - 1) < PAIR)
        part, *_ = np.linalg.lstsq(seen[pair].T, measured[k], rcond=None)
        turn[pair, k] = part / max(np.linalg.norm(part), 1e-300)
    return turn


def select(ring: RingDown, kept: tuple[int, ...]) -> RingDown:
    """The ring-down with these poles only."""
    k = list(kept)
    both = k + [len(ring.frequency) + i for i in k]
    return replace(
        ring,
        frequency=ring.frequency[k],
        damping_ratio=ring.damping_ratio[k],
        amplitude=ring.amplitude[k],
        covariance=ring.covariance[np.ix_(both, both)],
    )
