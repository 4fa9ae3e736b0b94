"""A recording's own noise, whatever moves in it and whatever model is believed.

Motion fills a part of the spectrum: its modes, their harmonics, drifts. Noise fills all of it. So
the level is read where the spectrum is lowest, through tapers whose leakage stays below the noise
(Thomson, Proc. IEEE 70 (1982) 1055), the edge found by clipping upwards until it stands still.
"""

import numpy as np
from scipy.signal.windows import dpss
from scipy.special import gammaincinv

from .pencil import evenly

# time-bandwidth product and tapers: the second leaks less and resolves less, for very clean tracks
TAPERS = ((5.0, 4), (8.0, 4))
LEAKED = 0.8  # of the first estimate: when the second is below it, the first had motion in it
CLIP = 0.02  # of bins of pure noise, taken for motion
CLIP_ONE = 0.01  # the same, in one channel


def noise_floor(time: np.ndarray, signals: np.ndarray) -> np.ndarray:
    """(C,) rms of the white noise under a motion; time (T,) s, signals (T, C), NaN missing.

    Noise that is not white counts at its lowest density. Zero where a channel stands still.
    """
    signals = np.asarray(signals, float)
    _, even = evenly(np.asarray(time, float), signals)
    missing = 1 - np.isfinite(signals).mean(axis=0)
    ramp = np.polynomial.chebyshev.chebvander(np.linspace(-1, 1, len(even)), 1)
    even = even - ramp @ np.linalg.lstsq(ramp, even, rcond=None)[0]
    first, second = (_level(even, *tapers) for tapers in TAPERS)
    level = np.where(second < LEAKED**2 * first, second, first)
    return np.sqrt(level / (1 - missing / 2))  # a bridged gap has about half the noise


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
