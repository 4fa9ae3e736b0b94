"""Points of a clip followed to sub-pixel, each against the first picture, so that nothing drifts.

Lucas-Kanade pyramids from the last position find the neighbourhood, an affine refinement the
place; a point whose window no longer looks like itself is lost, and found again where it does.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from .data import seal
from .errors import RecordingError
from .noise_floor import noise_floor
from .track_clock import check_rate, frame_times, rate_warnings
from .track_copies import copies_warning, doubled_frames, first_hole, without_copies
from .track_follow import State, begin, follow
from .track_points import check_points
from .track_recording import track_recording
from .track_template import (
    LAGS,
    Templates,
    make_templates,
    noise_gain,
    positions,
    residual_products,
)
from .video import FEWEST_FRAMES, Video, ended_early, frame_at, open_video, read_frames

__all__ = ["Tracks", "track", "track_recording"]

SAMPLED = 7  # every so many frames the residuals' correlation is looked at
LEAST_SIGMA = 1e-4  # px
ENOUGH = 48  # frames in which the noise floor of a track can be told
REPORT = 20  # frames between two calls of progress


@dataclass(frozen=True, eq=False)
class Tracks:
    """Points over time, in pixels."""

    time: np.ndarray  # (T,) s of real time, from the clip's first frame
    values: np.ndarray  # (T, n, 2) px, u right, v down; NaN = lost
    sigma: np.ndarray  # (T, n) px, standard deviation of a sample (mean of the two axes); NaN
    points: np.ndarray  # (n, 2) px in the first frame used
    frames: np.ndarray  # (T,) index in the clip
    warnings: tuple[str, ...] = ()

    def __post_init__(self):
        seal(self, "time", float, (None,))
        seal(self, "points", float, (None, 2))
        T, n = len(self.time), len(self.points)
        seal(self, "values", float, (T, n, 2), finite=False)
        seal(self, "sigma", float, (T, n), finite=False)
        seal(self, "frames", int, (T,))


def track(
    video: Video | str | Path,
    points: np.ndarray,
    *,
    capture_fps: float,
    start: float | None = None,
    stop: float | None = None,
    progress=None,
) -> Tracks:
    """Positions of `points` (n, 2) px, given in the frame at `start` s, in all frames until `stop`.

    Frames before `start` are followed too: they show the object at rest. `capture_fps` is the real
    rate of the camera. `progress(fraction, text)` is called now and then, and may raise Cancelled.
    Raises RecordingError for a point outside the picture or without features, a clip too short,
    and when all points are lost.
    """
    check_rate(capture_fps)
    video = video if isinstance(video, Video) else open_video(video)
    opening = frame_at(video, round((start or 0.0) * capture_fps))
    warnings = check_points(opening.grey, points)
    first = make_templates(opening.grey, points)
    report = _reporter(video, capture_fps, stop, progress)
    seen = _follow_all(video, first, opening.grey, (capture_fps, stop), report)
    return _tracks(video, first, seen, capture_fps, warnings)


@dataclass(frozen=True, eq=False)
class _Seen:
    """What one pass through the clip leaves behind, frame by frame."""

    index: list
    stamp: list
    change: list
    position: list
    residual: list
    products: list
    ended: bool = True  # read until no frame came


def _follow_all(video, first: Templates, opening, limits, report) -> _Seen:
    capture_fps, stop = limits
    seen = _Seen(*([] for _ in range(6)))
    state = begin(first, opening)
    for frame in read_frames(video):
        state = follow(first, opening, frame.grey, state)
        _keep(seen, frame, first, state)
        report(frame.index)
        if stop is not None and frame.index > stop * capture_fps + 1:
            return replace(seen, ended=False)
    return seen


def _keep(seen: _Seen, frame, first, state: State) -> None:
    seen.index.append(frame.index)
    seen.stamp.append(frame.stamp)
    seen.change.append(frame.change)
    lost = ~state.found
    seen.position.append(np.where(lost[:, None], np.nan, positions(first, state.fit)))
    seen.residual.append(np.where(lost, np.nan, state.fit.residual))
    if frame.index % SAMPLED == 1 and state.found.any():
        which = state.found
        left = state.fit.left[which] / np.maximum(state.fit.residual[which, None], 1e-3)
        seen.products.append(residual_products(first.subset(which), left))


def _tracks(video, first, seen: _Seen, capture_fps, warnings) -> Tracks:
    cut = ended_early(video, seen.index[-1] + 1) if seen.ended and seen.index else None
    if cut:
        cut = _whole_part(video, seen, cut)
    if len(seen.index) < FEWEST_FRAMES:
        raise RecordingError(
            f"{video.path.name}: {len(seen.index)} frames; {FEWEST_FRAMES} are needed at least, "
            "and several periods to learn something. Film longer."
        )
    values, stamps = np.array(seen.position), np.array(seen.stamp)
    _check_lost(video, values)
    clock = frame_times(stamps, capture_fps)
    warnings += clock.warnings + rate_warnings(video, capture_fps, stamps)
    if cut:
        warnings += (cut,)
    warnings += _lost_warnings(values)
    white = 1e-12 * np.outer(*[np.arange(-LAGS, LAGS + 1) == 0] * 2)
    total = np.sum([white, *seen.products], axis=0)
    gain = noise_gain(first, total / total[LAGS, LAGS])
    sigma = np.array(seen.residual) * gain / np.sqrt(2)  # the template's own half stays constant
    sigma = _at_least_the_floor(clock.time, values, np.maximum(sigma, LEAST_SIGMA))
    tracks = Tracks(clock.time, values, sigma, first.points, np.array(seen.index), warnings)
    return _without_copies(tracks, np.array(seen.change))


def _whole_part(video, seen: _Seen, cut: str) -> str:
    """Drop what follows a hole in a damaged clip, else its last frame, which may be a part."""
    count = len(seen.index)
    hole = first_hole(np.array(seen.change), np.array(seen.position))
    for column in (seen.index, seen.stamp, seen.change, seen.position, seen.residual):
        del column[hole - 1 :]
    if hole == count:
        return cut
    return (
        f"{video.path.name}: the file is damaged: only {count} of {video.count} frames could be "
        f"read, and some are missing after frame {hole - 2}. What comes before was used; copy the "
        "clip again."
    )


def _at_least_the_floor(time, values, sigma) -> np.ndarray:
    """`sigma` (T, n) raised where the tracks themselves are noisier than their pictures.

    A codec's errors are smooth over a window, so that what is left there does not show them.
    """
    seen = np.isfinite(values[..., 0]).sum(0) >= ENOUGH
    if not seen.any():
        return np.where(np.isnan(values[..., 0]), np.nan, sigma)
    ratio = np.ones(values.shape[1])
    floor = noise_floor(time, values[:, seen].reshape(len(time), -1)).reshape(-1, 2)
    ratio[seen] = np.sqrt((floor**2).mean(1)) / np.nanmedian(sigma[:, seen], axis=0)
    return np.where(np.isnan(values[..., 0]), np.nan, sigma * np.maximum(ratio, 1))


def _without_copies(tracks: Tracks, change) -> Tracks:
    """The tracks without doubled frames, their clock mended."""
    copies, stood_still = doubled_frames(tracks.time, tracks.values, change)
    if not copies.any():
        return tracks
    kept = ~copies
    return replace(
        tracks,
        time=without_copies(tracks.time, copies, stood_still),
        values=tracks.values[kept],
        sigma=tracks.sigma[kept],
        frames=tracks.frames[kept],
        warnings=(*tracks.warnings, copies_warning(copies, stood_still)),
    )


def _check_lost(video, values) -> None:
    seen = np.isfinite(values[..., 0])
    if seen.sum(0).max() < FEWEST_FRAMES:
        last = int(np.flatnonzero(seen.any(1))[-1]) if seen.any() else 0
        raise RecordingError(
            f"{video.path.name}: all {values.shape[1]} points were lost after frame {last}. Pick "
            "points with more texture that stay in sight, or film with a shorter exposure."
        )


def _lost_warnings(values) -> tuple[str, ...]:
    share = np.isnan(values[..., 0]).mean(0)
    return tuple(
        f"point {k + 1} was lost in {100 * share[k]:.2g} % of the frames; they are left out."
        for k in np.flatnonzero(share > 0)
    )


def _reporter(video, capture_fps, stop, progress):
    expected = video.count or 0
    if stop is not None:
        expected = min(expected or 10**9, int(stop * capture_fps) + 1)

    def report(index: int) -> None:
        if progress is not None and index % REPORT == 0:
            share = min(index / expected, 1.0) if expected else 0.0
            progress(share, f"Tracking {video.path.name}")

    return report
