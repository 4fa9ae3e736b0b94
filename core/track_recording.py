"""The markers of a case followed through its video."""

from pathlib import Path

import numpy as np

from .data import Camera, Marker, Recording
from .errors import RecordingError
from .video import open_video


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


def _size_warning(video, camera: Camera) -> tuple[str, ...]:
    if not all(camera.image_size) or tuple(camera.image_size) == video.size:
        return ()
    return (
        f"{video.path.name}: its pictures have {video.size[0]} x {video.size[1]} px, [camera] says "
        f"{camera.image_size[0]} x {camera.image_size[1]}. Mend image_size and principal_point.",
    )
