"""[recording] and [[take]] of case.toml -> Recording, from tracks or from a video."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .case_fields import suggestion
from .data import Camera, Marker, Recording
from .errors import CaseError
from .glitches import without_glitches
from .import_tracks import foreign, tracks_of
from .tracks_csv import Tracks, read_tracks

ASTRAY = 2.0  # of the object's diagonal: no track of the object can be so far from its rest place
HAIR = 0.2  # of a frame, by which a written instant may be off its own
CLOCK_AGREES = 0.01  # relative: the column `time` against capture_fps


@dataclass(frozen=True, eq=False)
class Scene:
    """What all recordings of a case share."""

    folder: Path
    markers: tuple[Marker, ...]
    camera: Camera | None
    size: float  # m, the object's diagonal


def read_recording(fields: dict, where: str, scene: Scene, progress=None) -> Recording:
    """The recording that the checked `fields` of the table `where` name.

    Raises CaseError for fields that contradict each other or the tracks, RecordingError for a
    video that cannot be tracked.
    """
    if (fields["tracks"] is None) == (fields["video"] is None):
        has = "nothing" if fields["tracks"] is None else "both"
        raise CaseError(
            f"{where} has {has} of tracks and video; exactly one of them is needed. Name one."
        )
    start, stop = fields["start"], fields["stop"]
    if start is not None and stop is not None and start >= stop:
        raise CaseError(
            f"{where} start = {start:g} s, stop = {stop:g} s; start before stop is needed. "
            "Swap them."
        )
    if fields["tracks"] is not None:
        return _from_tracks(fields, where, scene)
    return _from_video(fields, where, scene, progress)


def _from_tracks(fields: dict, where: str, scene: Scene) -> Recording:
    path = beside(scene.folder, fields["tracks"], f"{where} tracks")
    names, rate = tuple(marker.name for marker in scene.markers), fields["capture_fps"]
    if foreign(path):  # Blender's, Tracker's or DeepLabCut's own form
        size = scene.camera.image_size if scene.camera else None
        tracks = tracks_of(path, names, size, rate)
    else:
        tracks = read_tracks(path, names)
    flat = tracks.values.shape[2] == 2
    if flat and scene.camera is None:
        raise CaseError(f"{path.name} is in pixels and the table [camera] is missing. Add it.")
    if rate is None and (flat or tracks.time is None):
        why = "the tracks are in pixels" if flat else f"{path.name} has no column time"
        raise CaseError(
            f"{where} lacks the field capture_fps; {why}. Give the frames per second of real "
            "time that the camera took."
        )
    time = np.arange(len(tracks.values)) / rate if tracks.time is None else tracks.time
    values, jumps = without_glitches(time, tracks.values)
    recording = Recording(
        time,
        values,
        scene.markers,
        camera=scene.camera if flat else None,
        start=fields["start"],
        stop=fields["stop"],
        capture_fps=rate,
        warnings=(
            *tracks.warnings,
            *_clock_warning(path.name, tracks, rate),
            *_jump_warning(path.name, names, jumps),
        ),
    )
    _check_limits(recording, where)
    _check_astray(recording, path.name, scene.size)
    return recording


def _from_video(fields: dict, where: str, scene: Scene, progress) -> Recording:
    path = beside(scene.folder, fields["video"], f"{where} video")
    if scene.camera is None:
        raise CaseError(f"{where} is a video and the table [camera] is missing. Add it.")
    if fields["capture_fps"] is None:
        raise CaseError(
            f"{where} lacks the field capture_fps; a video file only knows its playback "
            "rate. Give the frames per second of real time that the camera took."
        )
    width, height = scene.camera.image_size
    for marker in scene.markers:
        if marker.pixel is None:
            raise CaseError(
                f"[[marker]] {marker.name} lacks the field pixel; a video needs to know where"
                " the point is in the first frame used. Add it."
            )
        if not (0 <= marker.pixel[0] < width and 0 <= marker.pixel[1] < height):
            raise CaseError(
                f"[[marker]] {marker.name} pixel = {list(marker.pixel)} is outside the image of "
                f"{width} x {height} px. Read it off the first frame, or mend [camera] image_size."
            )
    from .track import track_recording  # OpenCV takes its time to import, tracks do not need it

    return track_recording(
        path,
        scene.markers,
        scene.camera,
        fields["capture_fps"],
        start=fields["start"],
        stop=fields["stop"],
        progress=progress,
    )


def _check_limits(recording: Recording, where: str) -> None:
    """Raises CaseError where start or stop is outside the recording."""
    first, last = recording.time[0], recording.time[-1]
    hair = HAIR * (recording.time[1] - first)  # instants are written rounded
    for name, instant in (("start", recording.start), ("stop", recording.stop)):
        if instant is not None and not first - hair <= instant <= last + hair:
            raise CaseError(
                f"{where} {name} = {instant:g} s; it must be within the recording, {first:g} to "
                f"{last:g} s. Correct it, or leave it out."
            )


def _clock_warning(name: str, tracks: Tracks, rate: float | None) -> tuple[str, ...]:
    if rate is None or tracks.time is None:
        return ()
    found = 1 / float(np.median(np.diff(tracks.time)))
    if abs(found / rate - 1) <= CLOCK_AGREES:
        return ()
    return (
        f"{name}: its column time runs at {found:.4g} frames per second, capture_fps says "
        f"{rate:g}. The column is believed.",
    )


def _jump_warning(name: str, markers: tuple[str, ...], jumps: np.ndarray) -> tuple[str, ...]:
    if not jumps.any():
        return ()
    whose = ", ".join(marker for marker, count in zip(markers, jumps, strict=True) if count)
    count = jumps.sum()
    samples = f"{count} samples jump" if count > 1 else "1 sample jumps"
    gone = "They are" if count > 1 else "It is"
    return (f"{name}: {samples} out of place for one frame ({whose}). {gone} left out.",)


def _check_astray(recording: Recording, name: str, size: float) -> None:
    """Raises CaseError where metres cannot be metres: the track is nowhere near the object."""
    if recording.values.shape[2] == 2:
        return
    for k, marker in enumerate(recording.markers):
        place = np.nanmedian(recording.values[:, k], axis=0)
        away = float(np.linalg.norm(place - marker.position))
        if away > ASTRAY * size:
            raise CaseError(
                f"{name}: the marker {marker.name} is tracked {away:.3g} m from its position in "
                f"the case, the object's diagonal is {size:.3g} m. Give the tracks in metres and "
                "in object axes."
            )


def beside(folder: Path, name: str, where: str) -> Path:
    """The file `name` in the case's folder. Raises CaseError when it is not there."""
    file = folder / name
    if not file.is_file():
        near = suggestion(name, [one.name for one in folder.iterdir() if one.is_file()])
        raise CaseError(f'{where} = "{name}": there is no such file beside the case. {near}')
    return file
