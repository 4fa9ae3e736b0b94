"""The markers of a case followed through its video."""

from pathlib import Path

import numpy as np

from .data import Camera, Marker, Recording
from .errors import RecordingError
from .track_clock import check_rate
from .track_points import blur_of_place, check_points
from .video import Video, frame_at, open_video

EDGE = 0.5  # px: a marker told no better than this in one direction would spoil a fit of both


def track_recording(  # noqa: PLR0913  (three of them by keyword only)
    path: str | Path,
    markers: tuple[Marker, ...],
    camera: Camera,
    capture_fps: float,
    *,
    start: float | None = None,
    stop: float | None = None,
    progress=None,
) -> Recording:
    """The video at `path` as a Recording in pixels, its markers followed from their `pixel`.

    Nothing is resampled: a rolling shutter stays in the tracks, `camera.readout` says it, and the
    prediction puts each row at its own instant. Raises RecordingError as `track` does.
    """
    from .track import track  # `track` names this function among its own

    video = open_video(path)
    missing = [marker.name for marker in markers if marker.pixel is None]
    if missing:
        raise RecordingError(
            f"{video.path.name}: marker {missing[0]} has no pixel. Say where it is in the first "
            "frame used."
        )
    points = np.array([marker.pixel for marker in markers], float)
    _check_corners(video, markers, points, start, capture_fps)
    tracks = track(
        video,
        points,
        capture_fps=capture_fps,
        start=start,
        stop=stop,
        progress=progress,
    )
    return Recording(
        tracks.time,
        tracks.values,
        tuple(markers),
        camera=camera,
        sigma=tracks.sigma,
        start=start,
        stop=stop,
        capture_fps=capture_fps,
        warnings=tracks.warnings + _size_warning(video, camera),
    )


def _check_corners(video: Video, markers, points, start, capture_fps) -> None:
    """Raises RecordingError for a marker that is seen in one direction only, or not at all."""
    check_rate(capture_fps)
    opening = frame_at(video, round((start or 0.0) * capture_fps)).grey
    check_points(opening, points)
    _, worst = blur_of_place(opening, points)
    for marker, (u, v), blur in zip(markers, points, worst, strict=True):
        if blur > EDGE:
            raise RecordingError(
                f"{video.path.name}: marker {marker.name} at ({u:g}, {v:g}) px lies on a straight "
                f"edge: along it its place is told to {blur:.2g} px only, {EDGE} px are needed. "
                "Pick a corner, a dot or a speckle."
            )


def _size_warning(video, camera: Camera) -> tuple[str, ...]:
    if not all(camera.image_size) or tuple(camera.image_size) == video.size:
        return ()
    return (
        f"{video.path.name}: its pictures have {video.size[0]} x {video.size[1]} px, [camera] says "
        f"{camera.image_size[0]} x {camera.image_size[1]}. Mend image_size and principal_point.",
    )
