"""When each frame was taken: presentation stamps, dropped and doubled frames, the declared rate."""

from dataclasses import dataclass

import numpy as np

from .errors import RecordingError
from .video import Video

JITTER = 0.02  # of a frame: below it the stamps are a grid
REAL = 0.05  # relative: stamps of so nearly the declared rate are instants of real time
ROUNDED = 0.01  # relative: a declared rate this near to the container's may be a rounded number


@dataclass(frozen=True, eq=False)
class Clock:
    """The frames' instants and what is odd about them."""

    time: np.ndarray  # (T,) s of real time, from the first frame
    warnings: tuple[str, ...] = ()


def check_rate(capture_fps: float) -> None:
    """Raises RecordingError where `capture_fps` cannot be a rate."""
    if not (np.isfinite(capture_fps) and 0 < capture_fps <= 1e7):
        raise RecordingError(
            f"capture_fps = {capture_fps:g} frames/s; more than 0 is needed. Give the rate at "
            "which the camera took the frames, not the one the clip plays at."
        )


def frame_times(stamps: np.ndarray, capture_fps: float) -> Clock:
    """Instants of frames with presentation stamps (T,) s, when most steps last 1/capture_fps.

    Stamps that are a grid, up to the rounding of the container's tick, give frame numbers, so that
    dropped frames leave a gap; stamps that are not give the instants themselves. Without stamps
    (NaN, or standing still) the frames are taken to follow one another evenly.
    """
    stamps = np.asarray(stamps, float)
    steps = np.diff(stamps)
    if not np.isfinite(stamps).all() or not len(steps) or (steps <= 0).any():
        return Clock(np.arange(len(stamps)) / capture_fps)
    step, number = _grid(stamps)
    off = np.abs(stamps - stamps[0] - step * number - np.median(stamps - stamps[0] - step * number))
    if (np.diff(number) > 0).all() and off.max() <= max(JITTER * step, 0.75 * _tick(steps)):
        return Clock(number / capture_fps, _gap_warning(np.diff(number)))
    usual = np.median(steps)
    real = abs(usual * capture_fps - 1) < REAL  # else the clip plays slower than it was filmed
    time = (stamps - stamps[0]) / (1 if real else step * capture_fps)
    spread = np.percentile(steps, [5, 95]) / usual
    warning = (
        f"variable frame rate: steps of {spread[0]:.2f} to {spread[1]:.2f} of the usual one. The "
        "presentation stamps were used; film at a constant rate where you can.",
    )
    return Clock(time, warning + _gap_warning(np.round(steps / usual)))


def rate_warnings(video: Video, capture_fps: float, stamps: np.ndarray) -> tuple[str, ...]:
    """What the container's rate and metadata say against the declared `capture_fps`."""
    says = []
    steps = np.diff(stamps)
    played = 1 / np.mean(steps) if video.pictures == () and (steps > 0).any() else None
    if played is not None and video.rate is not None:
        played = video.rate
    if video.tagged_rate is not None and abs(video.tagged_rate / capture_fps - 1) > ROUNDED:
        says.append(
            f"{video.path.name}: its metadata say it was captured at {video.tagged_rate:g} "
            f"frames/s, capture_fps says {capture_fps:g}. The declared rate was used; every "
            "frequency follows it: check the camera's setting."
        )
    if played is None or (video.tagged_rate is not None and not says):
        return tuple(says)
    ratio = capture_fps / played
    if abs(ratio - 1) > ROUNDED:
        slow = f"played {ratio:.3g} times slower" if ratio > 1 else f"played {1 / ratio:.3g} faster"
        says.append(
            f"{video.path.name}: the container says {played:g} frames/s, which contradicts the "
            f"declared capture_fps of {capture_fps:g} ({slow} than real). The declared rate was "
            f"used; at {played:g} every frequency would be {1 / ratio:.3g} times as high."
        )
    elif abs(ratio - 1) > 1e-4:
        says.append(
            f"{video.path.name}: the container says {played:.6g} frames/s, capture_fps "
            f"{capture_fps:g}: a difference of {100 * abs(ratio - 1):.2g} %. Is the declared one "
            "rounded?"
        )
    return tuple(says)


def _grid(stamps) -> tuple[float, np.ndarray]:
    """The step (s) and the whole frame numbers (T,) nearest to the stamps."""
    step = float(np.median(np.diff(stamps)))
    number = np.concatenate([[0], np.cumsum(np.maximum(np.round(np.diff(stamps) / step), 1))])
    for _ in range(3):
        step = float(np.polyfit(number, stamps, 1)[0])
        number = np.round((stamps - stamps[0]) / step)
    return step, number


def _tick(steps) -> float:
    """s, the container's unit of time, from the smallest difference between two steps."""
    different = np.diff(np.unique(np.round(steps, 6)))
    return float(different.min()) if different.size else 0.0


def _gap_warning(steps) -> tuple[str, ...]:
    lost = int(np.sum(steps - 1))
    if lost <= 0:
        return ()
    places = np.flatnonzero(steps > 1)
    return (
        f"{lost} frames were dropped in {len(places)} places, the first after frame {places[0]}: "
        "their instants are left out, not filled in.",
    )
