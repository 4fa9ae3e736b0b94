"""Modes of a ring-down that tells all of a take, or all but what the effects of a fit do."""

from dataclasses import dataclass

import numpy as np

from .baseline import real_shapes
from .body import Body
from .channels import Channels
from .data import RingDown, poles
from .effects.further_mode import of_take, pitch_of
from .harmonic_inversion import invert
from .law import TimeFit, replace, unpack
from .linear_part import fitted_instants, instants
from .listen import spread
from .match import HARMONIC, PAIR, SPLIT, Match, mac, turning
from .shutter import at_once, height, later, overtone, rung
from .simulate import free_swing

APART = 0.03  # relative, from every known pitch
PARTED = 0.003  # the same, of a pair that a load on the body parts
BESIDE = 0.25  # relative, from the strongest mode: nearer, what acts in time makes lines too
NEAR = 0.1  # of a computed pitch, that a mode beside the strongest one has
SAME = 0.7  # share along a mode above which it mimics that, or what acts in time on it
LOWEST = 0.9  # of the body's lowest pitch
ALIKE = (0.3, 3.0)  # damping ratio over that of the known modes
STEEPER = 1.5  # damping ratio over pitch, over the same of the known modes
LIVELY = 0.25  # damping ratio up to which a mode so far above them may be one
QUIETLY = 1.3  # misfit per sample, held out too, up to which a ring-down tells all of a take
LEFT, LOUDEST = 0.02, 3.0  # the same beside loud modes: of what those leave, and at most
SMALL = 10.0  # the same at most, of poles beside a small effect; and
FORETOLD = 0.5  # of the misfit that those leave of what was held out
ROWS = 0.8  # MAC from which a line at twice a pitch moves as late rows make it
LOUDER = 1.5  # times what a readout as long as a frame makes, up to which such a line is theirs
TONES = 6  # the highest overtone that is looked for
FEWEST = 24  # samples of each channel in which something is heard


@dataclass(frozen=True, eq=False)
class Told:
    """A ring-down, and of what."""

    ring: RingDown
    time: np.ndarray  # (T,) s, the instants of its samples
    values: np.ndarray  # (T, C) that it is of
    at: tuple[int, ...]  # the pole of each mode that is fitted


def cleared(found: TimeFit, take: int) -> Told | None:
    """The fitted take's modes, as they swing without what the effects do, and all that is left.

    None where one of them is not heard in that. Two modes close together, which what is left alone
    does not tell apart, are heard beside the others.
    """
    law = found.law
    data: Channels = law.takes[law.fitted[take]]
    time = instants(law, found.theta, data)[0]
    omega, zeta, start, _ = unpack(law, found.parameters[None], take)
    motion = free_swing(omega, zeta, start, time[None])
    if data.late is None:
        u, v = (one[0][:, None] for one in motion)
    else:
        u, v = (np.swapaxes(one[0], 0, 1) for one in later(omega, zeta, motion, data.late.T[None]))
    both = np.concatenate([u, (v / omega[0])[..., list(law.turning)]], axis=-1)  # (T, 1 or C, n)
    at = law.own * law.condition[law.fitted[take]]
    swings = (both * found.coefficients[:, at : at + law.own]).sum(axis=-1)
    values = found.missed(take) + swings
    on, use = ~data.support, fitted_instants(law, found.theta, data)[1]
    if np.isfinite(values[use][:, on]).sum(axis=0).min() < FEWEST:
        return None
    ring = invert(time[use], values[use][:, on], noise=data.sigma[on], faintest=0.0)
    apart = np.abs(np.log(ring.frequency[:, None] / found.pitches(take)))
    if not len(apart) or apart.min(axis=0).max() > APART:
        return None
    ring, pole = spread(ring, on, data.sigma), poles(ring.frequency, ring.damping_ratio)
    ring = replace(ring, amplitude=at_once(ring.amplitude, pole, data.late))
    return Told(ring, time, values, tuple(apart.argmin(axis=0)))


def as_heard(found: TimeFit, told: Told) -> TimeFit:
    """The fit with its modes at the poles that they were matched to: fitted without some of the
    others, close ones run into one another.
    """
    at, p, K = list(told.at), found.parameters.copy(), found.law.modes
    if len(set(at)) < K:  # some were never heard by themselves
        return found
    p[:K] = np.log(told.ring.frequency[at])
    if found.law.damping == "free":
        p[K : 2 * K] = told.ring.damping_ratio[at]
    return replace(found, parameters=p)


def tells_all(found: TimeFit, take: int, told: Told) -> bool:
    """Whether a ring-down leaves no more than noise, or than a trifle of what the fit leaves where
    that is louder, of what was fitted and of what was held out.
    """
    left, rest = zip(*_left(found, take, told), strict=True)
    return max(left) <= max(QUIETLY, min(LOUDEST, 1 + LEFT * max(rest)))


def foretells(found: TimeFit, take: int, told: Told) -> bool:
    """Whether a ring-down leaves no more than a trifle of the misfit that the fit leaves where it
    was fitted, and no more than half of that of what was held out: it lacks a small effect, but no
    mode. What mimics one that bends a pitch foretells badly. Never where nothing was held out.
    """
    (left, rest), *ahead = _left(found, take, told)
    trifle = left <= min(SMALL, 1 + LEFT * rest)
    return bool(ahead) and trifle and all(a <= FORETOLD * b for a, b in ahead)


def _left(found: TimeFit, take: int, told: Told) -> list[tuple[float, float]]:
    """What a ring-down leaves, and what the fit does, in noise squared per sample: of what was
    fitted, and of what was held out, if anything.
    """
    ring, data = told.ring, found.law.takes[found.law.fitted[take]]
    on, late = ~data.support, 0.0 if data.late is None else data.late
    left = ((told.values - rung(ring, told.time, late)) / data.sigma)[:, on] ** 2
    rest = (found.missed(take) / data.sigma)[:, on] ** 2
    parts = [part for part in (data.fit, ~data.fit) if part.any()]
    return [(float(np.nanmean(left[part])), float(np.nanmean(rest[part]))) for part in parts]


def modes_of(
    found: TimeFit, take: int, match: Match, body: Body, ring: RingDown
) -> list[tuple[float, float]]:
    """(Hz, damping ratio) of the unmatched poles of a ring-down that tells all of a take.

    Empty where one of them is no mode of a body; what late rows make is passed over.
    """
    law = found.law
    data: Channels = law.takes[law.fitted[take]]
    on = ~data.support
    own = found.pitches(take)
    paired, pair = law.setting.paired, law.setting.pair
    loaded = bool(data.take.loads) and len({law.pitch[i] for i in law.fitted}) > 1
    computed = body.modes.frequency * own[0] / body.modes.frequency[match.modes[0]]
    lowest, unmatched = LOWEST * computed[0], np.delete(computed, match.modes)
    apart = np.abs(np.log(ring.frequency[:, None] / own))
    theirs = apart.argmin(axis=0)  # the pole of each mode that is fitted
    pairs = turning(match.modes, body.modes.frequency, 2 * PAIR)
    there = [pitch_of(effect, theta) for _, effect, theta in of_take(found, take)]
    shapes, out = found.shapes_of(take)[:, on], []
    moves = real_shapes(ring.amplitude)[0][:, on]
    for n, (f, z, amplitude) in enumerate(
        zip(ring.frequency, ring.damping_ratio, ring.amplitude, strict=True)
    ):
        if any(abs(np.log(f / k)) < PARTED for k in there):
            continue
        # a pair, by the load: where all takes have it, one that was computed, too
        near = bool(data.take.loads) and (np.abs(np.log(unmatched / f)) < NEAR).any()
        # or another pair than the one that is left to what parts it
        other = paired and apart[n, pair] > SPLIT and apart[n].argmin() in pairs
        left = paired and apart[n, pair] < SPLIT
        beside = not left and mac(moves[n], moves[theirs[apart[n].argmin()]]) < SAME
        parted = (loaded or near or other or beside) and n not in theirs and apart[n].min() > PARTED
        if not parted and (apart[n].min() < APART or left):
            continue
        swings = zip(own, found.damping_ratio, ring.amplitude[theirs], strict=True)
        if any(_rows_sound_so(data, (f, amplitude), swing) for swing in swings):
            continue
        if not (
            damps_alike(f, z, own, found.damping_ratio)
            # a load lowers what is heard first by less than what lies below
            and (loaded or f > lowest)
            and (near or not _mimics(moves[n], f, shapes, own, 1 / data.frame))
        ):
            return []
        out.append((float(f), float(z)))
    return out


def _rows_sound_so(data: Channels, line: tuple, swing: tuple) -> bool:
    """Whether a line (Hz, (C,) complex amplitudes) is what rows of a camera whose readout is not
    known make of a swing (Hz, damping ratio, amplitudes) at half its pitch.
    """
    (f, amplitude), (base, z, own) = line, swing
    camera, on = data.take.recording.camera, ~data.support
    if camera is None or camera.readout is not None or abs(f - 2 * base) > HARMONIC * f:
        return False
    foretold = overtone(own, complex(poles(base, z)), data.frame / height(camera))
    a, b = amplitude[on], foretold[on]
    like = abs(np.vdot(a, b)) ** 2 > ROWS * np.vdot(a, a).real * np.vdot(b, b).real
    return bool(like and np.linalg.norm(a) < LOUDER * np.linalg.norm(b))


def _mimics(shape: np.ndarray, f: float, known: np.ndarray, own: np.ndarray, rate: float) -> bool:
    """Whether a motion (C,) at `f` Hz goes as the strongest of the `known` modes (K, C) or the pair
    that it is one of, as what acts in time makes it: beside that one, or where it has an overtone,
    or that one's fold at `rate` frames/s.
    """
    tones = own[0] * np.arange(2, TONES + 1)
    tones = np.r_[tones, np.abs(tones - rate * np.round(tones / rate))]
    if abs(np.log(f / own[0])) > BESIDE and np.abs(f / np.maximum(tones, 1e-300) - 1).min() > APART:
        return False
    near = (np.abs(np.log(f / own)) < BESIDE) & (np.abs(np.log(own[0] / own)) < SPLIT)
    near[0] = True
    q, _ = np.linalg.qr(known[near].T)
    return bool(((q.T @ shape) ** 2).sum() > SAME * (shape @ shape))


def damps_alike(f: float, z: float, own: np.ndarray, damping_ratio: np.ndarray) -> bool:
    """Whether a mode of `f` Hz may be damped by `z` in a body with modes (K,) Hz and their ratios.

    Stiffness that loses energy damps the n-fold pitch n-fold (Rayleigh damping).
    """
    usual, steep = np.median(damping_ratio), np.median(damping_ratio / own)
    most = max(ALIKE[1] * usual, min(STEEPER * steep * f, LIVELY))
    return bool(ALIKE[0] * usual < z < most)
