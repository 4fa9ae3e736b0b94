"""Which motions stand out of their noise, by the lines of their spectrum."""

import numpy as np

from .video import FEWEST_FRAMES

CHANCE = 1e-3  # that noise alone is taken for motion, once in a picture
OCTAVE = 1.6  # frequencies within this factor are the neighbourhood of a line
NEIGHBOURS = 8  # lines in it at least
FIRST = 1  # line that counts: the one below is less than two periods of the whole


def clarity(values: np.ndarray) -> np.ndarray:
    """(m,) strongest line of the motions (T, m) over its neighbourhood's noise; 0 where noise.

    Amplitudes. The noise at a line is the median of the lines near it in frequency, so that a slow
    wander is not a vibration.
    """
    lines = _lines(values)
    noise = np.empty_like(lines)
    for k in range(len(lines)):
        low, high = int((k + 1) / OCTAVE) - 1, max(int((k + 1) * OCTAVE), NEIGHBOURS)
        noise[k] = np.median(lines[max(low, 0) : high], axis=0) / np.log(2)
    return _outstanding(lines[FIRST:], noise[FIRST:])


def commotion(values: np.ndarray) -> np.ndarray:
    """(m,) the same over the quietest quarter of the whole spectrum: any motion, wander too."""
    lines = _lines(values)
    # the mean of the lower quarter of exponential lines is 0.137 of the mean of all
    quiet = np.sort(lines, axis=0)[: max(len(lines) // 4, 1)].mean(axis=0) / 0.137
    return _outstanding(lines, np.broadcast_to(quiet, lines.shape))


def _lines(values) -> np.ndarray:
    """(L, m) power of the spectrum without the mean."""
    T = len(values)
    if T < FEWEST_FRAMES:
        return np.zeros((T // 2 + 1, values.shape[1]))
    about = np.where(np.isfinite(values), values - np.nanmean(values, axis=0), 0)
    return np.abs(np.fft.rfft(about * np.hanning(T)[:, None], axis=0)[1:]) ** 2


def _outstanding(lines, noise) -> np.ndarray:
    """(m,) amplitude of the strongest line over `noise`; 0 below what noise reaches by chance.

    The strongest of L lines of noise stays below ln(L / chance) times their mean, of m channels
    below ln(L m / chance); the noise itself is known to a factor of about two.
    """
    over = np.max(lines / np.maximum(noise, 1e-12 * lines.max() + 1e-30), axis=0)
    return np.where(over > 2 * np.log(lines.size / CHANCE), np.sqrt(over), 0)
