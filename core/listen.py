"""From a take to its free motion and its ring-down, with the noise it was recorded in."""

from functools import partial

import numpy as np

from .channels import Channels, free_motion
from .data import RingDown, Take, poles, replace
from .errors import RecordingError
from .harmonic_inversion import invert
from .noise_floor import noise_floor, rounding_noise
from .pursuit import DEAD
from .shaken import without_shared
from .shutter import at_once
from .side_by_side import meanwhile

FINEST = 1e-3  # of the usual channel's noise: one that has less stands still, and tells nothing
ROUNDED = 0.01  # of a frame that a written instant may be beside one
ENOUGH = 12  # samples of a channel that an inversion needs
FIRST = 3  # frames at most that have still seen the object held
OFF, HELD = 3.0, 0.5  # noise, rms, that such a frame is off by; share of what is left that it makes
NEXT = 8  # frames after it, that it is compared with
BRIEF = 1.0  # decay (nepers) in a frame of a pole that stands for it
PERIODS = 2.0  # of the lowest mode that a recording must hold


def listen(take: Take, find_release) -> tuple[Channels, RingDown]:
    """Channels and ring-down (t0 = release) of `take`; find_release(time, signals) where unknown.

    Raises RecordingError where nothing moves, no mode is found, or fewer than two periods are left.
    """
    recording = take.recording
    window = release(take, find_release)
    T = len(recording.time)
    inside = (recording.time >= window[0] - 1e-9) & (recording.time <= window[1] + 1e-9)
    values = recording.values.reshape(T, -1)[inside]
    time = recording.time[inside]
    if inside.sum() < 12:
        free_motion(take, window, np.ones(values.shape[1]))
    noise = np.maximum(noise_floor(time, values), rounding_noise(values))
    noise = np.maximum(noise, FINEST * np.median(noise[noise > 0])) if noise.any() else noise
    noise = np.maximum(noise, 1e-12 * np.nanstd(values) + 1e-300)
    data = free_motion(take, window, noise)
    data, ring = _all_free(data)
    ring = without_shared(ring, data)
    if not len(ring.frequency):
        raise RecordingError(
            f"recording {take.name}: no oscillation stands out of the noise. "
            "Release it from further out, come closer with the camera, or record sooner."
        )
    if ring.damping_ratio.min() > DEAD:
        raise RecordingError(
            f"recording {take.name}: the motion dies within one swing (damping ratio "
            f"{ring.damping_ratio.min():.2g}; below {DEAD:g} is needed), so it has no pitch to "
            "calibrate by. Take away what holds or rubs it, and film it swinging freely."
        )
    # a mean that creeps is no mode of which periods could be wanted
    span, period = data.time[-1], 1 / ring.frequency[ring.damping_ratio <= DEAD][0]
    if span < PERIODS * period:
        raise RecordingError(
            f"recording {take.name}: it lasts {span:.3g} s after the release, "
            f"{span / period:.2g} periods of the lowest mode; {PERIODS:g} are needed. "
            "Record longer."
        )
    return data, _at_release(ring, data)


def listen_from(data: Channels, ring: RingDown, when: float) -> tuple[Channels, RingDown]:
    """The same take from the instant `when` (s) on; as it was where no mode is heard then."""
    late = data.time >= when
    later = _without(data, int((~late).sum()))
    if not _is_enough(later):
        return data, ring
    other = without_shared(_inverted(later), later)
    if not len(other.frequency) or other.damping_ratio.min() > DEAD:
        return data, ring
    return later, _at_release(other, later)


def _at_release(ring: RingDown, data: Channels) -> RingDown:
    """The ring-down of the moving channels as that of all, with the amplitudes at the release, for
    the first sample may be later.
    """
    ring = spread(ring, ~data.support, data.sigma)
    pole = poles(ring.frequency, ring.damping_ratio)
    amplitude = at_once(ring.amplitude, pole, data.late)
    return replace(ring, amplitude=amplitude * np.exp(-pole * ring.t0)[:, None], t0=0.0)


def _inverted(data: Channels) -> RingDown:
    use = data.fit if not data.take.held_out else np.ones(len(data.time), bool)
    on = ~data.support
    return invert(data.time[use], data.values[use][:, on], noise=data.sigma[on])


def _all_free(data: Channels) -> tuple[Channels, RingDown]:
    """The same without the first frames that have still seen the object held, and its ring-down.

    Exposed around the release, a frame is half of what was before; and a release is seen only once
    the object has moved by more than noise. No sum of swings that last reaches such a frame.
    """
    later = _without(data, 1)
    with meanwhile(partial(_inverted, later)) as inverted:
        ring, brief = _inverted(data), _brief(data)
        left, seen = _left(data, ring, brief)
        for _ in range(FIRST):
            if left.sum() - seen.sum() < (OFF**2 - 1) * seen[0] or not _is_enough(later):
                break
            other = inverted()
            less, fewer = _left(later, other, brief)
            gain, samples = left.sum() - less.sum(), seen.sum() - fewer.sum()
            # what acts in time leaves much, but no more in the first frame than in the next ones
            usual = max(less[:NEXT].sum() / max(fewer[:NEXT].sum(), 1), 1.0) * samples
            if gain - samples < (OFF**2 - 1) * samples:
                break
            if gain - samples < HELD * (left.sum() - seen.sum()) and gain < OFF**2 * usual:
                break
            data, ring, left, seen, later = later, other, less, fewer, _without(later, 1)
            inverted = partial(_inverted, later)
    return data, ring


def _is_enough(data: Channels) -> bool:
    """Whether every channel is seen often enough to be inverted."""
    seen = np.isfinite(data.values[data.fit][:, ~data.support]).sum(axis=0)
    return len(seen) > 0 and seen.min() >= ENOUGH


def _brief(data: Channels) -> float:
    """Decay (nepers) in a frame of a pole without a swing that tells held frames: where nothing
    moves from the first to the second, one that dies in as many as may be held.
    """
    on = ~data.support
    step = np.diff(data.values[:2][:, on], axis=0) / data.sigma[on]
    stands = np.nansum(step**2) < OFF**2 * np.isfinite(step).sum()
    return BRIEF / FIRST if stands else BRIEF


def _left(data: Channels, ring: RingDown, brief: float) -> tuple[np.ndarray, np.ndarray]:
    """Misfit, in noise squared, of each fitted frame to the swings that last, and its samples."""
    on = ~data.support
    pole = poles(ring.frequency, ring.damping_ratio)
    lasting = -pole.real * data.frame < np.where(ring.damping_ratio > DEAD, brief, BRIEF)
    phase = np.exp(np.outer(data.time - ring.t0, pole[lasting]))
    left = (data.values[:, on] - (phase @ ring.amplitude[lasting]).real - ring.offset)[data.fit]
    return np.nansum((left / data.sigma[on]) ** 2, axis=1), np.isfinite(left).sum(axis=1)


def _without(data: Channels, first: int) -> Channels:
    """The same without the first so many frames."""
    return replace(
        data,
        time=data.time[first:],
        values=data.values[first:],
        fit=data.fit[first:],
        rows=data.rows[first:],
    )


def release(take: Take, find_release) -> tuple[float, float]:
    """Instants (s) between which the object moves freely: as declared, or as seen."""
    recording = take.recording
    start, stop = (
        None if when is None else _on_a_frame(recording.time, when)
        for when in (recording.start, recording.stop)
    )
    if start is None:
        values = recording.values.reshape(len(recording.time), -1)
        on = np.repeat([m.on == "object" for m in recording.markers], recording.values.shape[2])
        start, end = find_release(recording.time, values[:, on])
    else:
        end = float(recording.time[-1])
    return start, end if stop is None else stop


def _on_a_frame(time: np.ndarray, when: float) -> float:
    """`when`, or the frame that it was rounded from."""
    nearest = float(time[np.argmin(np.abs(time - when))])
    return nearest if abs(nearest - when) < ROUNDED * np.median(np.diff(time)) else when


def spread(ring: RingDown, moving: np.ndarray, noise: np.ndarray) -> RingDown:
    """The ring-down with still channels put back as zeros."""
    amplitude = np.zeros((len(ring.frequency), len(moving)), complex)
    amplitude[:, moving] = ring.amplitude
    offset = np.zeros(len(moving))
    offset[moving] = ring.offset
    return replace(ring, amplitude=amplitude, offset=offset, noise=noise)
