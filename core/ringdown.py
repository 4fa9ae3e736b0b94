"""When the free motion begins and where it has sunk into the noise."""

import numpy as np
from scipy.ndimage import maximum_filter1d, median_filter

from . import varpro
from .data import poles
from .errors import RecordingError
from .harmonic_inversion import invert
from .noise_floor import noise_floor
from .pencil import evenly

FEWEST_FRAMES = 16
STANDS_OUT = 4.0  # energy of the loudest period over that of noise, below which nothing moves
RISES = 3.0  # energy over the least since the release, above which something struck again
SUNK = 0.1  # energy over that of noise at which a ring-down has ended
TAIL = 2  # periods that are kept after it has
GLITCH = 6.0  # of the median speed squared about it: more is a tracker's jump, not motion
LISTENED = 8  # periods that show what the free motion is like
DRIVEN = 10.0  # of the energy: what never falls so far is driven
BRIEF = 4  # periods, fewer than which are no ring-down where the record is longer
MOST_MODES = 6  # that tell free motion from held
ROUNDS = 3  # of looking for an earlier beginning with the poles that the last one showed
PERIODS = 3  # after an instant, that must look like ringing for it to be free
ROUGH = 2.5  # misfit over that of motion surely free, above which an instant is not
COARSE = 0.03  # of the motion: a misfit below it may be modes too brief to be known
STEEP = 1.8  # growth of a misfit from a frame to the one before it, where an object was held still
SIGMAS = 4.0  # the same where the misfit is no more than noise
TURNING = 0.05  # of a swing's power, half of what the quiet half of it about a turning point has
SURE = 30  # numbers, at least, by which nothing is seen to move


def find_release(time: np.ndarray, signals: np.ndarray) -> tuple[float, float]:
    """Instants (s) between which the object rings freely; time (T,) s, signals (T, C).

    The loudest ring-down of the record, by speed, so that a slow pull before the release does not
    count. It begins with the earliest frame from which on the motion is one of damped sinusoids
    with the poles that the later motion has, after the last rest before it, and ends where
    something strikes again or where nothing but noise is left. Raises RecordingError where nothing
    moves.
    """
    time, signals = np.asarray(time, float), np.asarray(signals, float)
    signals = signals[:, np.isfinite(signals).sum(axis=0) >= FEWEST_FRAMES]
    if len(time) < FEWEST_FRAMES or not signals.shape[1]:
        raise RecordingError(
            f"Release: {len(time)} frames with {signals.shape[1]} usable channels; "
            f"{FEWEST_FRAMES} frames are needed. Record longer."
        )
    floor = np.maximum(noise_floor(time, signals), 1e-9 * np.nanstd(signals) + 1e-300)
    dt, even = evenly(time, signals)
    even = even / floor
    lag, period = _period(even)
    energy = _energy(even, lag, period)
    half = min(period // 2, (len(even) - 1) // 3)
    peak = int(np.argmax(energy[: len(even) - half]))  # in half a period nothing could fall
    if energy[peak] < STANDS_OUT:
        raise RecordingError(
            "Release: nothing moves beyond the recording's noise. Release it from further out, or "
            "come closer with the camera."
        )
    last = _end(energy, peak, period, max(SUNK, 3 * np.sqrt(3 / (period * even.shape[1]))))
    first = _begin(even, energy, peak, last, period)
    loud = int(np.argmax(energy > energy[peak] / 4))
    brief, lasts = last - first < BRIEF * period, len(even) - 1 - loud - half >= BRIEF * period
    if brief and lasts and (energy[loud:] > energy[peak] / DRIVEN).all():
        last = len(even) - 1  # something drives it on: there is no fall to find
        first = _begin(even, energy, loud + half, last, period)
    if last - first < FEWEST_FRAMES:
        first, last = max(0, min(first, len(even) - FEWEST_FRAMES)), len(even) - 1
    return float(time[0] + first * dt), float(min(time[0] + last * dt, time[-1]))


def _period(even: np.ndarray) -> tuple[int, int]:
    """Frames in half a period of the strongest oscillation, and in a period or a beat.

    Sampled near twice or four times a period, its squares beat: that long they must be averaged.
    """
    speed = np.diff(even, axis=0)
    count = len(speed)
    window = np.hanning(count)[:, None]
    power = (np.abs(np.fft.rfft(speed * window, 4 * count, axis=0)) ** 2).sum(axis=1)
    k = np.arange(len(power))
    power = power / (2 - 2 * np.cos(2 * np.pi * k / (4 * count)) + (2 / count) ** 2) ** 0.5
    power[:6] = 0  # less than two periods in the record
    f = int(np.argmax(power)) / (4 * count)  # per frame
    beat = max(abs(2 * f - round(2 * f)), 8 / count)
    return max(1, round(0.5 / f)), max(2, round(1 / f), round(1 / beat))


def _energy(even: np.ndarray, lag: int, period: int) -> np.ndarray:
    """(T,) mean square speed over one period around each frame, over that of noise, less 1."""
    before, after = lag // 2, lag - lag // 2
    speed = np.zeros_like(even)
    speed[before : len(even) - after] = even[lag:] - even[:-lag]
    square = np.mean(speed**2, axis=1) / 2
    usual = median_filter(square, max(5, 3 * period // 2))
    square = np.minimum(square, GLITCH * np.maximum(usual, 1.0))
    kernel = np.ones(period) / period
    padded = np.pad(square, (period, period))
    known = np.pad(np.ones(len(square) - lag), (before + period, after + period))
    inside = np.convolve(known, kernel, "same")
    smooth = np.convolve(padded, kernel, "same")[period:-period]
    return smooth / np.maximum(inside[period:-period], 0.3) - 1


def _end(energy: np.ndarray, peak: int, period: int, sunk: float) -> int:
    """The last frame of the ring-down."""
    least = np.minimum.accumulate(energy[peak:])
    # what a drive keeps up rises within a period or two what it fell, and nothing struck
    beats = np.minimum.accumulate(maximum_filter1d(energy, 2 * period + 1)[peak:])
    least = np.where(least > STANDS_OUT, beats, least)
    again = np.flatnonzero(energy[peak:] > RISES * np.maximum(least, 1.0) + 1)
    stop = len(energy) - 1
    if len(again):
        stop = peak + int(np.argmin(energy[peak : peak + again[0] + 1]))
        stop = max(peak, stop - period // 2)
    loud = np.flatnonzero(energy[peak : stop + 1] > sunk)
    return min(stop, peak + int(loud[-1]) + TAIL * period)


def _begin(even: np.ndarray, energy: np.ndarray, peak: int, last: int, period: int) -> int:
    """The first frame of the ring-down: from there on it rings as it does later.

    What rings briefly is only known once the beginning is, so the step is repeated.
    """
    first = min(peak + period // 2, max(peak, last - 4 * period))
    for _ in range(ROUNDS):
        earlier = _earlier(even, first, last, period)
        if earlier >= first:
            break
        first = earlier
    return max(first, _held_until(even, energy, peak, period))


def _held_until(even: np.ndarray, energy: np.ndarray, peak: int, period: int) -> int:
    """The last frame before `peak` at which nothing moves, 0 where that is not seen: half a period
    of rest is no ringing, whatever its pitch may do later. What rang before is no rest: it beats.
    """
    C = even.shape[1]
    length = max(period // 2, 1 + -(-SURE // C))
    chance = SIGMAS * np.sqrt(2 / C / (length - 1))
    if peak < length or chance > TURNING * energy[peak]:
        return 0
    parts = np.lib.stride_tricks.sliding_window_view(even[: peak + 1], length, axis=0)
    still = np.flatnonzero(parts.var(axis=2, ddof=1).mean(axis=1) < 1 + chance)
    if not len(still):
        return 0
    begin = still[-1]
    off = even[begin : begin + length] - np.median(even[begin : begin + length], axis=0)
    at_rest = np.flatnonzero((off**2).mean(axis=1) < 1 + SIGMAS * np.sqrt(2 / C))
    held = int(begin + at_rest[-1]) if len(at_rest) else int(begin)
    rang = energy[: max(0, held - period)] > energy[peak] / DRIVEN
    return 0 if rang.any() else held


def _earlier(even: np.ndarray, settled: int, last: int, period: int) -> int:
    """The earliest frame from which on the motion rings as it does after the frame `settled`."""
    free = even[settled : min(last, settled + max(LISTENED * period, 4 * FEWEST_FRAMES)) + 1]
    if len(free) < FEWEST_FRAMES:
        return settled
    found = invert(np.arange(len(free)) + 0.0, free, max_modes=MOST_MODES)
    if not len(found.frequency):
        return settled
    p = poles(found.frequency, found.damping_ratio)
    ringing = varpro.Poles(-p.real, p.imag, np.zeros(0))
    reach = min(PERIODS * period, last - settled)
    t = np.arange(reach + 1.0)
    phi = np.hstack([varpro.basis(t, ringing), np.ones((reach + 1, 1)), t[:, None]])
    u, s, _ = np.linalg.svd(phi / np.linalg.norm(phi, axis=0), full_matrices=False)
    u = u[:, s > 1e-9 * s[0]]
    starts = np.arange(max(0, settled - 3 * period), min(settled + period, last - reach) + 1)
    near = max(3, period // 4)
    misfit = np.array([_misfit(even[k : k + reach + 1], u, near) for k in starts])
    sure = starts >= settled
    usual = max(np.median(misfit[sure]) if sure.any() else misfit.min(), 1.0)
    chance = 1 + SIGMAS / np.sqrt(2 * near * even.shape[1])
    allowed = chance if usual < chance else ROUGH * usual
    coarse = COARSE * float(np.sqrt(np.mean(np.var(free[:reach], axis=0))))
    over = (misfit > allowed) & (starts < settled)
    held = over & (misfit > coarse)
    sudden = over & np.r_[misfit[:-1] > STEEP * misfit[1:], False]
    last_held = np.flatnonzero(held)[-1] if held.any() else -1
    sudden[last_held + near // 2 + 1 :] = False
    bad = np.flatnonzero(held | sudden)
    return int(starts[bad[-1] + 1]) if len(bad) else int(starts[0])


def _misfit(part: np.ndarray, u: np.ndarray, near: int) -> float:
    """Root mean square of what ringing leaves of the first frames, in units of the noise."""
    left = part - u @ (u.T @ part)
    return float(np.sqrt(np.mean(left[:near] ** 2)))
