"""The support or the camera moves: every marker moves along.

Law         y_m += s(t), the same for all markers, or, before a lens that does not turn, the more
            the nearer they are; where it is the support that moves, the body
            answers along each way a that it goes with q_ka'' + 2 z w q_ka' + w^2 q_ka = -G_ka s_a''
            as well, G_ka in a free shape where markers on it tell s, and as computed where none
            does: its steady answer, line by line, well below the body's pitch
Tells       what is left is common to all markers, those on the support included
Looks like  mode 1 when the markers sit close together; a marker on the support settles it
Source      Ewins, Modal Testing (2000), 3.3: the reference must be measured
"""

from functools import partial

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.signal import lfilter

from ..channels import axes_of
from ..data import poles
from .base import Effect, Parameter, along_modes, as_declared

NAME = "base_motion"
FEWEST = 12  # instants at which a support is seen, to tell how it moves
ALONG, ABOVE = 0.01, 2.0  # power of a way that counts, over that of the largest and of the noise
BESIDE, MARGIN = 4, 1.3  # neighbours either way of a spectrum's line; noise is no less than this
UNSEEN = 1e-6  # of the direction that is seen best, squared: what is seen less is not
SETTLE = "stick a marker on the support, or film something that stands still beside it"


def common_motion(data, residual: np.ndarray, reach: np.ndarray | None = None) -> np.ndarray:
    """(T, C) what the other markers share, per axis; from the support's markers where there are.

    reach (C,): what each channel sees of it, as `reaches` has it; all the same by default.
    """
    axes = axes_of(data)
    reach = np.ones(len(axes)) if reach is None else reach
    residual, sigma = residual / reach, data.sigma / reach
    shared = np.zeros_like(residual)
    some_support = data.support.any()
    for axis in np.unique(axes):
        on = np.flatnonzero(axes == axis)
        for c in on:
            pool = [o for o in on if data.support[o] or not (some_support or o == c)]
            if not pool:
                continue
            weight = np.where(np.isnan(residual[:, pool]), 0, 1 / sigma[pool] ** 2)
            sums, whole = np.nansum(residual[:, pool] * weight, axis=1), weight.sum(axis=1)
            shared[:, c] = reach[c] * clear(
                np.where(whole > 0, sums / np.maximum(whole, 1e-300), np.nan),
                float(np.mean(1 / whole[whole > 0])) if whole.any() else 0.0,
            )
    return shared


def size(data, residual: np.ndarray) -> float:
    """rms of what the markers share, all axes together, without the noise in it; of the support's
    markers where there are.
    """
    pool = data.support if data.support.any() else np.ones(len(data.marker), bool)
    axes = axes_of(data)
    power = 0.0
    for axis in np.unique(axes):
        on = pool & (axes == axis)
        weight = np.where(np.isnan(residual[:, on]), 0, 1 / data.sigma[on] ** 2)
        whole = weight.sum(axis=1)
        known = whole > 0
        if known.any():
            shared = np.nansum(residual[:, on] * weight, axis=1)[known] / whole[known]
            power += max(np.var(shared) - np.mean(1 / whole[known]), 0.0)
    return float(np.sqrt(power))


def clear(path: np.ndarray, variance: float) -> np.ndarray:
    """(T,) a path without what is but noise of that `variance`; gaps (NaN) are bridged.

    A pitch counts by the share of its power that is above the noise's (Wiener, Extrapolation,
    Interpolation and Smoothing of Stationary Time Series, 1949), its neighbours' power taken too.
    """
    known, at = np.isfinite(path), np.arange(len(path))
    if not known.any():
        return np.zeros(len(path))
    whole = np.interp(at, at[known], path[known])
    lines = np.fft.rfft(np.r_[whole, whole[::-1]])  # goes back the way it came: no jump at its end
    lines = lines * _share(lines, variance, len(path))
    return np.fft.irfft(lines, 2 * len(path))[: len(path)]


def answered_motion(data, residual: np.ndarray, seen_at, low: float) -> tuple[np.ndarray, float]:
    """(T, C) what a support that moves makes of every marker, by what the other ones show, and the
    rms, m, of how it moves.

    seen_at: Hz -> (C, 3) what the channels see, as the body answers, per m along each axis; from
    `low` (Hz) on, near its own pitch, it is taken to go along.
    """
    T, step = len(residual), float(np.median(np.diff(data.time)))
    at = np.arange(T)
    whole = np.stack([np.interp(at, at[k], y[k]) if (k := np.isfinite(y)).any() else 0.0 * at
                      for y in residual.T])  # fmt: skip
    ramp = at / (T - 1)
    ends = whole[:, [0, -1]]
    whole = whole - ends[:, :1] - (ends[:, 1:] - ends[:, :1]) * ramp
    # turned about its ends it goes on without a bend, which would look like a blow to the support
    lines = np.fft.rfft(np.hstack([whole, -whole[:, ::-1]]))  # (C, F)
    pitch = np.arange(lines.shape[1]) / (2 * T * step)
    see = np.repeat(seen_at(0.0).real[None], len(pitch), axis=0)  # (F, C, 3)
    for n in np.flatnonzero(pitch < low):
        see[n] = seen_at(pitch[n]).real
    weighed = see / data.sigma[:, None] ** 2
    gram = np.einsum("fci,fcj->fcij", weighed, see)
    right = weighed * lines.T[:, :, None]
    slow = weighed[0][:, :, None] * ends[:, None]  # (C, 3, 2)
    shared, swing = np.zeros_like(residual), np.zeros((T, 3))
    for marker in [None, *np.unique(data.marker)]:
        others = data.marker != marker
        normal = gram[:, others].sum(axis=1)
        size = np.trace(normal, axis1=1, axis2=2)[:, None, None]
        spread = np.linalg.pinv(normal / size, rcond=UNSEEN) / size
        moved = np.einsum("fij,fj->fi", spread, right[:, others].sum(axis=1))
        first, last = (spread[0] @ slow[others].sum(axis=0)).T
        trend = first + ramp[:, None] * (last - first)  # (T, 3)
        if marker is None:
            noise = np.einsum("fii->f", spread)[:, None]
            path = moved * _share(np.linalg.norm(moved, axis=1), noise[:, 0], T)[:, None]
            swing = trend + np.fft.irfft(path, 2 * T, axis=0)[:T]
            continue
        for c in np.flatnonzero(~others):
            line = np.einsum("fi,fi->f", see[:, c], moved)
            noise = np.einsum("fi,fij,fj->f", see[:, c], spread, see[:, c])
            cleared = np.fft.irfft(line * _share(line, noise, T), 2 * T)[:T]
            shared[:, c] = trend @ see[0, c] + cleared
    return shared, float(np.sqrt(np.var(swing, axis=0).sum()))


def _share(line: np.ndarray, variance: np.ndarray, count: int) -> np.ndarray:
    """(F,) of each line's power that is above noise of that `variance`; see `clear`."""
    power = uniform_filter1d(np.abs(line) ** 2, 2 * BESIDE + 1, mode="nearest")
    floor = MARGIN * 2 * count * variance
    return np.clip(1 - floor / np.maximum(power, 1e-300), 0.0, None)


def support_paths(takes) -> list[dict]:
    """Of every take, by `key`, instants (n,) s and the motion (a, n) of the support's markers:
    along where it is largest in all takes, and, where it goes other ways too, along all; none where
    a take shows too little of them.
    """
    seen = [_support_motion(data) for data in takes]
    if min(len(time) for time, _, _ in seen) <= FEWEST:
        return []
    ways, sizes, _ = np.linalg.svd(np.hstack([mean for _, mean, _ in seen]), full_matrices=False)
    noise = sum(len(time) * variance for time, _, variance in seen)
    heard = sizes**2 > max(ALONG * sizes[0] ** 2, ABOVE * noise)
    return [
        {
            key(data.take): (
                time,
                np.array([clear(way @ mean, noise) for way in ways[:, :count].T]),
            )
            for data, (time, mean, noise) in zip(takes, seen, strict=True)
        }
        for count in sorted({1, max(int(heard.sum()), 1)})
    ]


def key(take) -> tuple:
    """What tells a take from another one, which may be of the same file."""
    return take.name, take.recording.start, take.recording.stop


def _support_motion(data) -> tuple[np.ndarray, np.ndarray, float]:
    """Instants (n,) at which it is seen, the mean motion (axes, n) there and its variance."""
    axes = axes_of(data)
    values = [data.values[:, data.support & (axes == a)] for a in np.unique(axes)]
    known = np.all([np.isfinite(one).any(axis=1) for one in values], axis=0)
    if not known.any():
        return data.time[known], np.zeros((len(values), 0)), 0.0
    mean = np.array([np.nanmean(one[known] - np.nanmean(one, axis=0), axis=1) for one in values])
    noise = data.sigma[data.support].mean() ** 2 / data.support.sum() * len(values)
    return data.time[known], mean, noise


def answer(omega: float, zeta: float, time: np.ndarray, path: np.ndarray) -> np.ndarray:
    """(n,) what a mode moves relative to a support that moves along `path` (n,) at `time`.

    With p = q + s the law is p'' + 2 z w p' + w^2 p = 2 z w s' + w^2 s: s needs no second
    derivative, which its noise would drown. The mode's own ringing may be anything.
    """
    # so many instants that a pitch which moves by little hardly ever changes their number
    fine = 2 ** int(np.ceil(np.log2(max(np.ptp(time) * omega * 2, 1.0))))
    even = np.linspace(time[0], time[-1], max(len(time), fine))
    s = np.interp(even, time, path - path[0])
    # p is twice the real part of z, z' = pole z + share s, and s straight between two instants
    pole = poles(omega / (2 * np.pi), zeta)
    share = (2 * zeta * omega * pole + omega**2) / (2j * pole.imag)
    step = even[1] - even[0]
    e, c = np.exp(pole * step), pole * step
    newer, older = (e - 1 - c) / c**2, (e * (c - 1) + 1) / c**2
    z = lfilter(share * step * np.array([newer, older]), np.array([1.0, -e]), s)
    return np.interp(time, even, 2 * z.real - s)


def _answers(at, ways, theta, omega, zeta, time) -> np.ndarray:
    """(B, T, q) what modes at omega, zeta (B, K) move, seen at `time` (B, T), all rows of which are
    one, each for each of the `ways` (a, n) in which the support moves at the instants `at` (n,).
    """
    known = {
        (k, w, z): [np.interp(time[0], at, answer(w, z, at, way)) for way in ways]
        for k in range(omega.shape[1])
        for w, z in {*zip(omega[:, k], zeta[:, k], strict=True)}
    }
    rows = zip(omega, zeta, strict=True)
    return np.array(
        [[q for k, of in enumerate(zip(*row, strict=True)) for q in known[k, *of]] for row in rows]
    ).swapaxes(1, 2)


def carries(found, i, take):
    """The body's answers, each of the mode whose it is and of what else the channels see of it."""
    law, effect = found.law, found.law.effects[i]
    data = law.takes[law.fitted[take]]
    size = along_modes(found, found.column_shapes(take)[i], take)
    answers = effect.beside_in(data.take)
    omega, zeta, theta = 2 * np.pi * found.pitches(take), found.damping_ratios(take), found.theta[i]
    return lambda time: answers(theta, omega[None], zeta[None], time[None])[0] @ size.T


def shaken(shared: tuple[np.ndarray, ...], rms: float, free: int, paths=None) -> Effect:
    """The motion `shared`, per take (T, C), taken off; `rms` of it in m, `free` numbers in it.

    paths: one that `support_paths` gave, where the body answers to it.
    """
    swings = {name: partial(_answers, *path) for name, path in (paths or {}).items()}
    first = next(iter(swings.values()), None)
    return Effect(
        name=NAME,
        layer="camera",
        parameters=(Parameter("rms", "m", 0.0, 10.0),),
        twins=(),
        settle=SETTLE,
        starts=lambda setting, residual: [()],
        given=lambda take: shared[take],
        columns=first and as_declared(first),
        beside=first,
        beside_in=first and (lambda take: swings[key(take)]),
        carries=first and carries,
        channels=lambda setting, data: ~data.support,
        free=free,
        report=lambda theta, setting, shape: {"rms": rms},
    )
