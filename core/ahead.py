"""What a fit says of a take that it has never seen, but for how that take began."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import null_space

from .channels import cut
from .law import Elsewhere, Law, unpack, widths, with_columns
from .linear_part import delays, regressors
from .shutter import later
from .simulate import free_swing

STEPS, STILL = 12, 1e-6  # at most, and the share of the start that a last one moves it by
NEARLY = 2.0  # times the sag, within which it was let go from where the body does not sag
FORM = 0.98  # squared cosine of a measured sag and a computed one, from which the one is the other
WIDE = 3.0  # times what it was in the fitted take, that the start of what rings along may be


def ahead(law: Law, p: np.ndarray, coefficients: np.ndarray, index: int) -> np.ndarray:
    """(T, C) of a whole held-out take: all is known but its start, fitted where `fit` says.

    Its offsets are those of the first fitted take of its condition, the shapes of further modes
    those of the take that shows each most. Where there is none, pitches, shapes and offsets are
    those of the first fitted take of all, changed as the body says. Fitted are place and speed of
    every mode, those of what sounds as one with it and of further modes included, and the phase of
    what drives it. A creep goes with how far the object was held. What an effect reads off the take
    is known.
    """
    condition, pitch, other = law.condition[index], law.pitch[index], None
    same = [i for i in law.fitted if law.condition[i] == condition]
    if not same:
        same, other = law.fitted, law.elsewhere[index] if law.elsewhere else None
        condition, pitch = law.condition[same[0]], law.pitch[same[0]]
    model, take = law.fitted.index(same[0]), law.takes[index]
    given = sum(e.given(index) for e in law.effects if e.given)
    data = replace(take, take=replace(take.take, held_out=False), values=take.values - given)
    # what its forces feel beside the ring-down began otherwise than in any other take
    own = replace(law.setting, carried=())
    one = replace(law, takes=(data,), condition=(0,), pitch=(0,), setting=own)
    a, b, _ = law.sizes()
    K, at = law.modes, 2 * law.modes * pitch
    lead = np.r_[p[at : at + 2 * K], np.zeros(2 * K), p[a + b :]]
    each = 1 + sum(widths(law))
    own = coefficients[:, law.own * condition : law.own * (condition + 1)]
    begin = law.own * law.conditions + each * model
    known = np.hstack([own, coefficients[:, begin : begin + each]])
    swings, creeps, lines = _kinds(law)
    for j in swings:
        known[:, j : j + 2] = _most_shown(law, coefficients, j, pitch, ~take.support)
    first = p[a + 2 * K * model : a + 2 * K * (model + 1)]
    size = np.hypot(*first.reshape(2, -1)).max()
    alike, hung = pitch == law.pitch[law.fitted[0]], False  # whose body the ways are of
    if other is not None:
        lead[:K] += other.pitch
        sag = np.where(take.support, 0.0, known[:, law.own] - law.takes[same[0]].rest)
        # what was seen some time after its release swung as far the other way before
        pose = np.copysign(np.hypot(*first.reshape(2, -1)), first[:K])
        softer = 1 + np.abs(_crept(known, K, creeps, pose)).sum()
        modulus = (2 * np.pi * np.exp(p[at]) / other.omega) ** 2
        away = np.linalg.norm(known[:, :K] @ pose) / max(np.linalg.norm(sag), 1e-300)
        shown = other.held and _is_of_form(sag, other.sag)
        hung = shown and 1 / NEARLY < away < NEARLY
        known[:, :K], more = _changed(known[:, :K], other, sag if shown else None)
        known[:, law.own] += more * (1 if shown else softer / modulus)
        alike = alike and other.rings_alike
    across = _across(one if alike else replace(one, ways=()), lead, known, creeps, first[:K])

    def strength(start):  # of a release from the other side it is negative
        if hung:
            return other.strength
        return np.copysign(np.hypot(*start.reshape(2, -1)).max() / size, start @ first)

    def guess(x, part):
        """(B, T, C) at starts x (B, n), and how far what rings along is from the fitted take's."""
        there = replace(one, takes=(part,))
        start, beside, turns = np.split(x, [2 * K, 2 * K + 2 * across.count], axis=1)
        P = np.tile(lead, (len(x), 1))
        P[:, 2 * K : 4 * K] = start
        basis = regressors(there, unpack(there, P, 0), 0)[0]
        late = delays(there, unpack(there, lead[None], 0)[3], part)
        now = np.repeat(known[None], len(x), axis=0)
        of_release = [*creeps, *swings, *(j + 1 for j in swings)]
        now[:, :, of_release] *= np.array([strength(one) for one in start])[:, None, None]
        for n, j in enumerate([*swings, *lines]):  # times 1 + turn, as cosine's part - i sine's
            (cos, sin), (re, im) = known[:, [j, j + 1]].T, turns[:, 2 * n : 2 * n + 2].T[:, :, None]
            now[:, :, j] += re * cos + im * sin
            now[:, :, j + 1] += re * sin - im * cos
        y = np.swapaxes((basis @ now[:, :, :, None])[..., 0], 1, 2)
        y = y + across.motion(beside, part.time, late, basis[:, 0][:, :, creeps])
        return y, np.hstack([beside / (WIDE * size), turns / WIDE])

    steps = np.full(2 * K + 2 * across.count, law.setting.amplitude)
    steps = 1e-4 * np.r_[steps, np.ones(2 * len([*swings, *lines]))]
    return _started(guess, data, steps) + given


def _most_shown(law: Law, coefficients: np.ndarray, column: int, pitch: int, on) -> np.ndarray:
    """(C, 2) a free swing's columns, the first one `column` in a take's, in that take of a body's
    `pitch` which shows it most on the channels `on` (C,): each release stirs other modes, and where
    one is not stirred its shape is noise.
    """
    each, seen = 1 + sum(widths(law)), []
    for n, i in enumerate(law.fitted):
        if law.pitch[i] == pitch:
            at = law.own * (law.conditions - 1) + each * n + column
            loud = np.linalg.norm(coefficients[on, at : at + 2].T / law.takes[i].sigma[on])
            seen.append((loud, at))
    at = max(seen)[1]
    return coefficients[:, at : at + 2]


def _changed(shapes: np.ndarray, other: Elsewhere, sag: np.ndarray | None):
    """The shapes (C, K) as they are there, and what the offsets (C,) have more: in the channels'
    unit where the first take shows its `sag` (C,), else at 1 Pa.
    """
    computed, own = other.shapes
    bent = shapes.T - computed
    if sag is None:
        return (own + bent).T, other.more
    # what a body swings about that sags bends its shapes, the other way where it is turned over
    yields = sag @ other.sag / (other.sag @ other.sag)
    return (own + other.strength * bent).T, yields * other.more


def _is_of_form(sag: np.ndarray, computed: np.ndarray) -> bool:
    """Whether a measured sag (C,) is the computed one, but for its size."""
    along = sag @ computed
    return bool(along > 0 and along**2 > FORM * (sag @ sag) * (computed @ computed))


def _crept(known, modes: int, creeps: list, pose: np.ndarray) -> np.ndarray:
    """(q,) of each creep's column, over how far it was held."""
    held = known[:, :modes] @ pose
    return held @ known[:, creeps] / max(held @ held, 1e-300)


def _kinds(law: Law) -> tuple[list, list, list]:
    """Columns of a take: the first of each free swing, those of creeps, the first of each line."""
    wide, at, kinds = dict(zip(law.effects, widths(law), strict=True)), law.own + 1, ([], [], [])
    for effect in with_columns(law):
        if effect.phased:
            kinds[0 if effect.of_release else 2].append(at)
        elif effect.of_release:
            kinds[1].extend(range(at, at + wide[effect]))
        at += wide[effect]
    return kinds


@dataclass(frozen=True, eq=False)
class _Across:
    """Free swings of what sounds as one with a mode, such as its pair's other direction."""

    omega: np.ndarray  # (1, n) rad/s
    zeta: np.ndarray  # (1, n)
    shapes: np.ndarray  # (n, C)
    creep: np.ndarray  # (q,) of each creep's column, over how far it was held

    @property
    def count(self) -> int:
        return len(self.shapes)

    def motion(self, start: np.ndarray, time: np.ndarray, late, creeps: np.ndarray) -> np.ndarray:
        """(B, T, C) from places and speeds over the pitch (B, 2n), with the creeps (B, T, q).

        late: as `delays` has it, how much after `time` (T,) each channel is seen.
        """
        place, speed = np.split(start, 2, axis=1)
        omega, zeta = (np.broadcast_to(one, place.shape) for one in (self.omega, self.zeta))
        begun = np.stack([place, speed * omega], axis=1)
        time = np.broadcast_to(time, (len(start), len(time)))
        u, v = (one[:, None] for one in free_swing(omega, zeta, begun, time))
        if late is not None and self.count:
            u, v = later(omega, zeta, (u, v), late)
        swing = np.swapaxes((u * self.shapes.T[None, :, None]).sum(axis=3), 1, 2)
        crept = (creeps @ self.creep)[:, :, None] * place[:, None]
        return swing + crept @ self.shapes


def _across(law: Law, lead, known: np.ndarray, creeps: list, pose: np.ndarray) -> _Across:
    """`lead`: parameters of the take; `known` (C, nb): the model's coefficients; pose (K,) m."""
    omega, zeta, _, _ = unpack(law, lead[None], 0)
    modes, shapes = [], [np.zeros((0, len(known)))]
    for k, way in enumerate(law.ways):
        if way.shape[1] < 2:
            continue
        along = np.linalg.lstsq(way, known[:, k], rcond=None)[0]
        shapes.append((way @ null_space(along[None])).T * np.linalg.norm(along))
        modes += [k] * len(shapes[-1])
    shapes = np.vstack(shapes)
    creep = _crept(known, law.modes, creeps, pose)
    return _Across(omega[:, modes], zeta[:, modes], shapes, creep)


def _started(guess, data, steps: np.ndarray) -> np.ndarray:
    """(T, C) with the start (n,) that fits the used samples best, by Gauss-Newton."""
    first = cut(data, 1 + int(np.flatnonzero(data.fit).max(initial=0)))
    use = first.fit[:, None] & first.known & ~first.support

    def off(x):
        y, far = guess(x, first)
        left = np.where(use, (first.values - y) / first.sigma, 0.0).reshape(len(y), -1)
        return np.hstack([left, -far])

    x = np.zeros(len(steps))
    for _ in range(STEPS):
        r = off(np.vstack([x, x + np.diag(steps)]))
        slope = (r[1:] - r[0]).T
        move = steps * np.linalg.lstsq(slope, r[0], rcond=1e-8)[0]
        x = x - move
        if np.linalg.norm(move / steps) < STILL * np.linalg.norm(x / steps):
            break
    return guess(x[None], data)[0][0]
