"""The recording's own noise, whatever moves in it."""

import numpy as np
from scipy.signal.windows import dpss
from scipy import stats

from .pencil import evenly

BANDWIDTH = 3.0
TAPERS = 4


def noise_floor(time: np.ndarray, signals: np.ndarray) -> np.ndarray:
    """(C,) rms of white noise under any smooth motion; time (T,) s, signals (T, C), NaN missing."""
    dt, even = evenly(np.asarray(time, float), np.asarray(signals, float))
    return _floor(even, BANDWIDTH, TAPERS)


def _floor(even, bandwidth, tapers):
    count = len(even)
    ramp = np.linspace(-1, 1, count)
    even = even - np.polynomial.polynomial.polyval(ramp, np.polynomial.polynomial.polyfit(ramp, even, 1)).T.reshape(even.shape)
    windows = dpss(count, bandwidth, tapers)
    spectra = np.abs(np.fft.rfft(windows[:, :, None] * even, axis=1)) ** 2
    power = spectra.mean(axis=0)[1:-1]
    order = np.sort(power, axis=0)
    start = order[: len(order) // 4].mean(axis=0)
    C = even.shape[1]
    law = stats.gamma(tapers, scale=1 / tapers)
    level = start / 0.5
    for _ in range(30):
        pooled = (power / level).mean(axis=1)
        lawC = stats.gamma(tapers * C, scale=1 / tapers / C)
        clean = pooled < lawC.isf(0.02)
        if clean.sum() < 4: clean = pooled <= np.sort(pooled)[3]
        part = power[clean]
        cut = law.isf(0.01)
        new = np.array([p[p < cut * l].mean() if (p < cut * l).any() else p.min() for p, l in zip(part.T, level)])
        new /= 0.98
        if np.allclose(new, level, rtol=1e-3): break
        level = new
    return np.sqrt(level)
