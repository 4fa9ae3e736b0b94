"""The part of the law that is linear: shapes, offsets and columns for given searched parameters.

Law         y_c(t) = offset_c + sum_k S_kc u_k(t - delay_c) + columns with shapes of their own
Source      Golub and Pereyra, Inverse Problems 19 (2003) R1 (variable projection)
"""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from .channels import Channels
from .effects.base import Effect
from .law import Law, unpack, widths, with_columns
from .normal_equations import coefficients_of, normal
from .shutter import later
from .simulate import swing

WILD = 1e7  # noise units; a motion that runs away is a bad fit, not an error
PIN = 1e3  # weight that keeps S at the reference at one, so that u is in metres there
TIE = 1e5  # weight that keeps a tied mode's pitch, and its damping, near the first mode's
LOOSE = np.array([0.03, np.log(2)])  # logarithms by which these may be off
STILL = 0.01  # frames, by which a sample must be later than those before it
NEARER = 0.5  # of their distance, at most, that two modes' pitches may come nearer


def march(law: Law, unpacked, data: Channels, take: int = 0):
    """u, u' (B, T, K), None for u' where it does not show, the columns (B, T, q), the delays
    (B, C, T) or None. take: of the fitted ones, what goes on in which the forces feel.
    """
    omega, zeta, start, thetas = unpacked
    time = np.broadcast_to(instants(law, thetas, data), (len(omega), len(data.time)))
    pairs = list(zip(law.effects, thetas, strict=True))
    forces = [(e, th) for e, th in pairs if e.acceleration or e.force]
    delay = delays(law, thetas, data)
    speeds = bool(law.turning) or delay is not None
    carried = law.setting.carried if any(e.carries for e in law.effects) else ()
    beside = carried[take] if carried else None
    u, v, traces = swing(omega, zeta, start, time, forces, law.setting, speeds, beside)
    # modes above those that were measured answer a force at once, in a shape of their own
    traced = [e for e, _ in forces if e.force]
    ends = np.cumsum([0, *(e.axes for e in traced)])
    columns = [(e, traces[:, :, a:b]) for e, (a, b) in zip(traced, pairwise(ends), strict=True)]
    for effect, theta in pairs:
        if effect.beside:
            own = effect.beside_in(data.take) if effect.beside_in else effect.beside
            columns.append((effect, own(theta, omega, zeta, time)))
        elif effect.columns:
            columns.append((effect, effect.columns(theta, law.setting, time, u)))
    return u, v, columns, delay


def instants(law: Law, thetas, data: Channels) -> np.ndarray:
    """(B, T) s, when each sample was taken as the effects have it."""
    time = np.broadcast_to(data.time, (len(thetas[0]) if thetas else 1, len(data.time)))
    for effect, theta in zip(law.effects, thetas, strict=True):
        if effect.clock:
            time = np.maximum(effect.clock(theta, law.setting, time, data.take), 0)
    return time


def fitted_instants(law: Law, thetas, data: Channels) -> tuple[np.ndarray, np.ndarray]:
    """(n,) s and (T,) bool: the instants of the samples to be fitted, and which those are, without
    those at which the time of the effects stands still.
    """
    time = instants(law, [theta[:1] for theta in thetas], data)[0]
    goes_on = time > np.r_[-np.inf, np.maximum.accumulate(time)[:-1]] + STILL * data.frame
    use = data.fit & goes_on
    return time[use], use


def delays(law: Law, thetas, data: Channels) -> np.ndarray | None:
    """(B, C, T) s, how much after its instant each sample was taken; None where nothing says so."""
    out = None if data.late is None else data.late.T[None]
    for effect, theta in zip(law.effects, thetas, strict=True):
        if effect.delay:
            out = effect.delay(theta, law.setting, data.rows.T) + (0 if out is None else out)
    return out


def regressors(law: Law, unpacked, take: int):
    """Basis (B, 1 or C, T, nb) of the fitted take number `take`, who may not use it (C, nb), and u
    (B, T, K).
    """
    data = law.takes[law.fitted[take]]
    u, v, columns, delay = march(law, unpacked, data, take)
    omega, zeta = unpacked[:2]
    motion = u
    if delay is None:
        u, v = u[:, None], None if v is None else v[:, None]
    else:
        u, v = later(omega, zeta, (u, v), delay)
    B, D, T, K = u.shape
    widths = [c.shape[2] for _, c in columns]
    each = 1 + sum(widths)
    head = law.own * law.conditions
    nb = head + each * len(law.fitted)
    basis = np.zeros((B, D, T, nb))
    at = law.own * law.condition[law.fitted[take]]
    basis[:, :, :, at : at + K] = u
    if law.turning:
        speed = v / omega[:, None, None]
        basis[:, :, :, at + K : at + law.own] = speed[..., list(law.turning)]
    at = head + each * take
    basis[:, :, :, at] = 1
    barred = np.zeros((len(data.sigma), nb), bool)
    barred[data.support, :head] = True
    at += 1
    for (effect, values), width in zip(columns, widths, strict=True):
        basis[:, :, :, at : at + width] = values[:, None]
        if effect.channels:
            barred[~effect.channels(law.setting, data), at : at + width] = True
        at += width
    return basis, barred, motion


def _given(law: Law, take: int):
    """Values (T, C) of the fitted take without what effects subtract as known motion."""
    values = law.takes[law.fitted[take]].values
    known = [e.given(law.fitted[take])[: len(values)] for e in law.effects if e.given]
    return values - sum(known)


@dataclass(frozen=True, eq=False)
class Solved:
    """The linear part for a batch of parameters; bases, uses and motions: one a fitted take."""

    coefficients: np.ndarray  # (B, C, nb)
    bases: tuple  # (B, 1 or C, T, nb)
    uses: list  # (T, C) bool
    motions: tuple  # (B, T, K)
    barred: np.ndarray  # (C, nb) bool


def solve(law: Law, P: np.ndarray) -> Solved:
    """The linear part for parameters P (B, p). Takes share coefficients within a condition."""
    bases, barred, motions = zip(
        *(regressors(law, unpack(law, P, take), take) for take in range(len(law.fitted))),
        strict=True,
    )
    uses = [law.takes[i].known & law.takes[i].fit[:, None] for i in law.fitted]
    barred = sum(barred) > 0
    return Solved(_coefficients(law, bases, uses, barred), bases, uses, motions, barred)


def without_columns(law: Law, solved: Solved, effect: Effect) -> Solved:
    """The same, solved without the columns of an effect."""
    each, at = widths(law), 1
    for other in with_columns(law):
        width = each[law.effects.index(other)]
        if other is effect:
            break
        at += width
    barred, head = solved.barred.copy(), law.own * law.conditions
    for take in range(len(law.fitted)):
        first = head + (1 + sum(each)) * take + at
        barred[:, first : first + width] = True
    coefficients = _coefficients(law, solved.bases, solved.uses, barred)
    return replace(solved, coefficients=coefficients, barred=barred)


def _coefficients(law: Law, bases: tuple, uses: list, barred: np.ndarray) -> np.ndarray:
    """(B, C, nb)"""
    data = [law.takes[index] for index in law.fitted]
    coefficients = np.zeros((len(bases[0]), *barred.shape))
    for condition in range(law.conditions):
        group = [n for n, i in enumerate(law.fitted) if law.condition[i] == condition]
        columns = _columns(law, condition, group, barred.shape[1])
        gram = right = 0
        for n in group:
            values = np.where(uses[n], _given(law, n), 0.0)
            basis = bases[n] if law.conditions == 1 else np.take(bases[n], columns, axis=3)
            own, theirs, of = normal(basis, values, uses[n])
            if len(group) > 1:  # each take has its own patterns, and its own weight
                weight = data[n].sigma ** -2.0
                own, theirs = own[:, of] * weight[:, None, None], theirs * weight[:, None]
                of = np.arange(len(weight))
            gram, right = gram + own, right + theirs
        if group:
            coefficients[:, :, columns] = coefficients_of(gram, right, of, barred[:, columns])
    return coefficients


def _columns(law: Law, condition: int, group: list[int], count: int) -> np.ndarray:
    """Indices of the basis' columns that a condition's takes share, or have for themselves."""
    head = law.own * law.conditions
    each = (count - head) // len(law.fitted)
    own = [np.arange(head + each * n, head + each * (n + 1)) for n in group]
    return np.concatenate([np.arange(law.own * condition, law.own * (condition + 1)), *own])


def residuals(law: Law, P: np.ndarray) -> np.ndarray:
    """(B, R) noise units, with the rows that keep the reference at one and what is tied."""
    return left_over(law, P, solve(law, P))


def _ties(law: Law, P: np.ndarray) -> np.ndarray:
    """(B, r) how much further than `LOOSE` tied modes are from where the first mode puts them."""
    out = [np.zeros((len(P), 0))]
    K = law.modes
    for at in range(0, law.sizes()[0], 2 * K):
        for k, ratio in law.tied:
            z = np.log(np.maximum(P[:, [at + K + k, at + K]], 1e-4))
            off = np.stack([P[:, at + k] - P[:, at] - ratio, z[:, 0] - z[:, 1]], axis=1)
            loose = np.minimum(LOOSE, [NEARER * abs(ratio), np.inf])
            out.append(TIE * np.maximum(np.abs(off) - loose, 0))
    return np.hstack(out)


def left_over(law: Law, P: np.ndarray, solved: Solved) -> np.ndarray:
    """(B, R) as `residuals`, of what is solved at P."""
    held = _held(law, P, solved.coefficients)
    ends = np.cumsum([0, *(use.sum() for use in solved.uses)])
    r = np.empty((len(P), ends[-1] + held.shape[1]))
    r[:, ends[-1] :] = held
    for take, index in enumerate(law.fitted):
        here = r[:, ends[take] : ends[take + 1]]
        _left(here, _given(law, take), law.takes[index].sigma, solved, take)
    # one by one, for what is worked out of a row is still near at hand
    if not all(np.abs(row).max() < WILD for row in r):  # else no number is wild, nor NaN
        r = np.nan_to_num(np.clip(r, -WILD, WILD), nan=WILD)
    return r


def _left(out, given: np.ndarray, sigma: np.ndarray, solved: Solved, take: int) -> None:
    """Put what the linear part leaves of values (T, C), in noise units, into `out` (B, n)."""
    use = solved.uses[take]
    of = None if use.all() else np.flatnonzero(use)
    some = np.empty(given.shape)
    for row, basis, own in zip(out, solved.bases[take], solved.coefficients, strict=True):
        left = row.reshape(given.shape) if of is None else some  # a view
        if len(basis) == 1:
            np.matmul(basis[0], own.T, out=left)
        else:
            left[:] = np.matmul(basis, own[:, :, None])[..., 0].T
        np.subtract(given, left, out=left)
        np.divide(left, sigma, out=left)
        if of is not None:
            np.take(some, of, out=row, mode="clip")


def _held(law: Law, P: np.ndarray, coefficients: np.ndarray) -> np.ndarray:
    """(B, r) what keeps the references at one, and what is tied."""
    out, K = [], law.modes
    for c in range(law.conditions):
        own = coefficients[:, :, c * law.own : (c + 1) * law.own]
        hold = np.r_[PIN, np.full(K - 1, law.trust)]
        out.append(hold * (1 - np.einsum("kc,bck->bk", law.gauge(c), own[:, :, :K])))
        if law.turning:
            across = law.gauge(c)[list(law.turning)]
            out.append(PIN * np.einsum("kc,bck->bk", across, own[:, :, K:]))
    return np.concatenate([*out, _ties(law, P)], axis=1)
