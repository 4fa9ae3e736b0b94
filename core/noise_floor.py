"""A recording's own noise, whatever moves in it and whatever model is believed.

Motion fills a part of the spectrum: its modes, their harmonics, drifts. Noise fills all of it. So
the level is read where the spectrum is lowest, through tapers whose leakage stays below the noise
(Thomson, Proc. IEEE 70 (1982) 1055), the edge found by clipping upwards until it stands still.
"""

from functools import lru_cache

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal.windows import dpss
from scipy.special import gammaincinv

from .pencil import evenly

# time-bandwidth product and tapers: the second leaks less and resolves less, for very clean tracks
TAPERS = ((5.0, 4), (8.0, 4))
LEAKED = 0.8  # of the first estimate: when the second is below it, the first had motion in it
PIECE = 96  # samples that are looked at together where the instants are uneven, or jump
FEWEST = 3  # pieces of even samples, two of which, or a quarter, are without a jump
JUMPED = 0.7  # of the whole's estimate, rms: when such pieces are below it, time may have jumped
EVEN = 1e-3  # of a step, that one between neighbours may be other than the usual one
OVER = 0.3  # of them that the band must leave
STILL = 1e-3  # of the same: a piece below it stands still
FEW = 3  # steps that must all be whole ones
ROUNDED, WHOLE = 1e-12, 0.01  # of the largest number, that is none; of a step, that is a whole one
FINE = 4  # points of a sequence per sample
CLIP = 0.02  # of bins of pure noise, taken for motion
CLIP_ONE = 0.01  # the same, in one channel


def noise_floor(time: np.ndarray, signals: np.ndarray) -> np.ndarray:
    """(C,) rms of the white noise under a motion; time (T,) s, signals (T, C), NaN missing.

    Noise that is not white counts at its lowest density. Zero where a channel stands still.
    """
    time, signals = np.asarray(time, float), np.asarray(signals, float)
    _, even = evenly(time, signals)
    if even.shape == signals.shape and np.array_equal(even, signals, equal_nan=True):
        return _even_floor(even)
    slepian = lru_cache(maxsize=None)(dpss)  # pieces of one length share their sequences
    known = np.isfinite(signals)
    masks, kind = np.unique(known, axis=1, return_inverse=True)
    out = np.empty(signals.shape[1])
    for k, mask in enumerate(masks.T):  # channels with the same gaps share the band
        alike = kind.ravel() == k
        out[alike] = _patchy_floor(time[mask], signals[mask][:, alike], slepian)
    return out


def rounding_noise(signals: np.ndarray) -> np.ndarray:
    """(C,) rms of what rounding has put into signals (T, C); nought where they are not rounded.

    Written in whole steps, every sample is off by up to half of one: q / sqrt(12), as long as more
    than a step moves (Bennett, Bell Syst. Tech. J. 27 (1948) 446). Where less does, the samples
    stand still, and no spectrum shows it.
    """
    out = np.zeros(signals.shape[1])
    for c, one in enumerate(signals.T):
        steps = np.diff(np.unique(one[np.isfinite(one)]))
        steps = steps[steps > ROUNDED * np.abs(one[np.isfinite(one)]).max(initial=0.0)]
        if len(steps) >= FEW:
            whole = steps / steps.min()
            if (np.abs(whole - np.rint(whole)) < WHOLE).all():
                out[c] = steps.min() / np.sqrt(12)
    return out


def _even_floor(even: np.ndarray) -> np.ndarray:
    """(C,) rms, of even samples (T, C) without gaps."""
    even = _straight(even)
    first, second = (_level(even, *tapers) for tapers in TAPERS)
    whole = np.where(second < LEAKED**2 * first, second, first)
    if len(even) < FEWEST * PIECE:
        return np.sqrt(whole)
    pieces = np.array_split(even, len(even) // PIECE)
    each = np.array([_level(_straight(piece), *TAPERS[0]) for piece in pieces])
    apart = np.sort(each, axis=0)[max(1, len(each) // 4)]
    # noise that falls as the motion dies has no quiet piece before a loud one
    loud = each > apart / JUMPED**2
    jumps = (loud & np.maximum.accumulate(~loud, axis=0)).any(axis=0)
    jumps &= (apart > STILL**2 * whole) & (apart < JUMPED**2 * whole)
    return np.sqrt(np.where(jumps, apart, whole))


def _straight(even: np.ndarray) -> np.ndarray:
    """Even samples (T, C) without the straight line that is nearest to them."""
    ramp = np.polynomial.chebyshev.chebvander(np.linspace(-1, 1, len(even)), 1)
    return even - ramp @ np.linalg.lstsq(ramp, even, rcond=None)[0]


def _patchy_floor(time: np.ndarray, y: np.ndarray, slepian) -> np.ndarray:
    """(k,) rms noise of channels (n, k) at uneven instants (n,): beside the band, or in the longest
    whole stretch where that shows that the motion reaches beyond the band.
    """
    beside = _beside_band(time, y, slepian)
    steps = np.diff(time)
    breaks = np.flatnonzero(np.abs(steps / np.median(steps) - 1) > EVEN)
    ends = np.r_[-1, breaks, len(y) - 1]
    longest = int(np.argmax(np.diff(ends)))
    stretch = y[ends[longest] + 1 : ends[longest + 1] + 1]
    if len(stretch) < PIECE:
        return beside
    whole = _even_floor(stretch)
    return np.where(whole < LEAKED * beside, whole, beside)


def _beside_band(time: np.ndarray, y: np.ndarray, slepian) -> np.ndarray:
    """(k,) rms noise of channels (n, k) at uneven instants: what no band-limited motion takes up.

    Piece by piece, least squares on Slepian's sequences for as wide a band as leaves a share of
    the samples over (Slepian, Bell Syst. Tech. J. 57 (1978) 1371), read between their points.
    """
    step = float(np.median(np.diff(time)))
    left, free = 0.0, 0
    for part in np.array_split(np.arange(len(time)), max(1, len(time) // PIECE)):
        t, v = time[part] - time[part[0]], y[part]
        count = int((1 - OVER) * len(t))
        points = max(FINE * int(np.ceil(t[-1] / step) + 1), 2 * count)
        product = max((count - 6) / 2, 1.0)
        waves = slepian(points, min(product, points / 2 - 1), count).T
        basis = CubicSpline(np.linspace(0, t[-1], points), waves)(t)
        q, _ = np.linalg.qr(np.hstack([basis, np.ones((len(t), 1)), t[:, None]]))
        left = left + ((v - q @ (q.T @ v)) ** 2).sum(axis=0)
        free += len(t) - q.shape[1]
    return np.sqrt(left / max(free, 1))


def _level(even: np.ndarray, bandwidth: float, count: int) -> np.ndarray:
    """(C,) variance of the noise."""
    windows = dpss(len(even), min(bandwidth, len(even) / 4), count)
    spectra = np.fft.rfft(windows[:, :, None] * even, axis=1)
    power = (np.abs(spectra) ** 2).mean(axis=0)[1:-1]
    channels = power.shape[1]
    cut_all = gammaincinv(count * channels, 1 - CLIP) / (count * channels)
    cut_one = gammaincinv(count, 1 - CLIP_ONE) / count
    level = 2 * np.sort(power, axis=0)[: max(1, len(power) // 4)].mean(axis=0)
    if not (level > 0).all():
        return np.where(level > 0, level, 0.0)
    for _ in range(30):
        pooled = (power / level).mean(axis=1)
        clean = power[pooled <= max(cut_all, np.sort(pooled)[min(3, len(pooled) - 1)])]
        low = clean < np.maximum(cut_one * level, clean.min(axis=0) * (1 + 1e-12))
        now = np.sum(clean * low, axis=0) / low.sum(axis=0) / (1 - CLIP_ONE)
        if np.allclose(now, level, rtol=1e-3, atol=0):
            break
        level = now
    return now
