"""What the film shows, in pixels: u right, v down, (0, 0) the middle of the first; its camera."""

import csv
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np

from ..core.errors import CaseError, RecordingError
from ..core.import_tracks import blender_pixels, foreign, import_tracks
from . import read

REST = 0.1  # of a recording: its last part, where the object has come to rest
VIEWS = {  # picture's right and down in the world's axes
    "FRONT": ((1, 0, 0), (0, 0, -1)),
    "BACK": ((-1, 0, 0), (0, 0, -1)),
    "RIGHT": ((0, 1, 0), (0, 0, -1)),
    "LEFT": ((0, -1, 0), (0, 0, -1)),
    "TOP": ((1, 0, 0), (0, -1, 0)),
}


@dataclass(frozen=True, eq=False)
class Seen:
    """Tracks of a film."""

    names: list[str]
    frames: np.ndarray  # (T,)
    pixels: np.ndarray  # (T, n, d) px or m; NaN = missing
    time: np.ndarray | None = None  # (T,) s, where the recording says it


def clip_tracks(clip: bpy.types.MovieClip, names: list[str] | None = None) -> Seen:
    """The clip's tracks by name, all when None. Raises RecordingError for one that is not there."""
    tracks = clip.tracking.tracks
    names = [track.name for track in tracks] if names is None else names
    for name in names:
        if name not in tracks:
            raise RecordingError(f'Clip "{clip.name}": it has no track "{name}". Read it again.')
    samples = [(k, m) for k, name in enumerate(names) for m in tracks[name].markers if not m.mute]
    if not samples:
        raise RecordingError(f'Clip "{clip.name}": its tracks are empty. Track the points first.')
    frames = np.array([marker.frame for _, marker in samples])
    first = frames.min()
    pixels = np.full((frames.max() - first + 1, len(names), 2), np.nan)
    width, height = clip.size
    for k, marker in samples:
        pixels[marker.frame - first, k] = marker.co
    pixels = blender_pixels(pixels, (width, height))
    return Seen(names, np.arange(first, frames.max() + 1), pixels)


def table_tracks(path: Path) -> Seen:
    """All tracks of a .csv; two axes are pixels, three metres. Raises RecordingError, one line."""
    if foreign(path):
        found = import_tracks(path)
        at = np.arange(len(found.values)) if found.frames is None else found.frames.astype(int)
        values = np.full((at[-1] - at[0] + 1, len(found.names), 2), np.nan)
        values[at - at[0]] = found.values
        return Seen(list(found.names), np.arange(len(values)), values, found.time)
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            rows = [row for row in csv.reader(file) if row]
        head = [cell.strip() for cell in rows[0]]
        numbers = np.array([[float(c) if c.strip() else np.nan for c in row] for row in rows[1:]])
    except (OSError, UnicodeDecodeError, ValueError, IndexError) as error:
        raise RecordingError(f"{path.name}: not a table of tracks ({error}).") from error
    names = list(dict.fromkeys(c.rsplit(".", 1)[0] for c in head if "." in c))
    axes = "xyz" if names and f"{names[0]}.x" in head else "uv"
    wanted = [f"{name}.{axis}" for name in names for axis in axes]
    if not names or any(column not in head for column in wanted):
        raise RecordingError(
            f"{path.name}: columns NAME.x, NAME.y, NAME.z or NAME.u, NAME.v are needed."
        )
    values = numbers[:, [head.index(c) for c in wanted]].reshape(len(numbers), len(names), -1)
    time = numbers[:, head.index("time")] if "time" in head else None
    return Seen(names, np.arange(len(values)), values, time)


def tracks(recording) -> Seen:
    """Whatever the recording's source holds; for a video, where its points begin."""
    if recording.source == "CSV":
        return table_tracks(Path(bpy.path.abspath(recording.path)))
    return clip_tracks(recording.clip)


def resting(seen: Seen) -> np.ndarray:
    """(n, d) where each point is at rest: the median of its last tenth."""
    found = []
    for track in np.moveaxis(seen.pixels, 1, 0):
        there = track[~np.isnan(track).any(axis=1)]
        if not len(there):
            found.append(np.full(track.shape[1], np.nan))
            continue
        found.append(np.median(there[-max(1, int(len(there) * REST)) :], axis=0))
    return np.array(found)


def rest_pixels(obj: bpy.types.Object) -> dict[str, np.ndarray]:
    """(2,) px of each point; a video's at its first frame. Empty for tracks in metres."""
    recording = obj.ringdown.recording
    seen = tracks(recording)
    if seen.pixels.shape[2] == 3:
        return {}
    if recording.source == "VIDEO":
        begin = [t[~np.isnan(t).any(axis=1)] for t in np.moveaxis(seen.pixels, 1, 0)]
        return {n: t[0] for n, t in zip(seen.names, begin, strict=True) if len(t)}
    return dict(zip(seen.names, resting(seen), strict=True))


def film_of(clip: bpy.types.MovieClip, path: Path) -> Path:
    """The file, or for an image sequence the folder of its pictures."""
    return path.parent if clip.source == "SEQUENCE" else path


def camera(context, obj: bpy.types.Object, pixels: dict[str, np.ndarray]) -> dict:
    """The table [camera], in object axes. Raises CaseError for what is not known yet."""
    recording, found = obj.ringdown.recording, read.axes(obj, context.scene)
    if recording.scale == "CAMERA":
        return _scene_camera(context.scene, found, recording.clip)
    right, down = (found.turn.T @ np.array(axis, float) for axis in VIEWS[recording.view])
    points = [p for p in obj.ringdown.points if p.name in pixels]
    places = np.array([p.position for p in points]) @ np.stack([right, down], axis=1)
    seen = np.array([pixels[p.name] for p in points])
    if recording.scale == "LENGTH":
        metres = recording.length * found.unit / recording.length_px
    else:
        metres = _metres_per_pixel(places, seen)
    principal = np.nanmean(seen - places / metres, axis=0)
    table = {"kind": "orthographic", "metres_per_pixel": float(metres)}
    table |= {"right": right.tolist(), "down": down.tolist()}
    table["principal_point"] = principal.tolist()
    if recording.clip:
        table["image_size"] = list(recording.clip.size)
    return table


def _metres_per_pixel(places: np.ndarray, seen: np.ndarray) -> float:
    """Least squares of the points' distances from their middle, on the mesh and in the picture."""
    a, b = places - places.mean(axis=0), seen - seen.mean(axis=0)
    if len(a) < 2 or not (a * b).sum() > 1e-9 * (b * b).sum() * np.abs(a).max():
        raise CaseError(
            "Scale: two points apart in the picture are needed, seen from the right side. "
            "Place another point, choose another view, or give a known length."
        )
    return float((a * a).sum() / (a * b).sum())


def _scene_camera(scene: bpy.types.Scene, found: read.Axes, clip) -> dict:
    if scene.camera is None:
        raise CaseError("Scale: the scene has no camera. Add one, or scale by the points.")
    matrix, lens = np.array(scene.camera.matrix_world), scene.camera.data
    axes = matrix[:3, :3] / np.linalg.norm(matrix[:3, :3], axis=0)
    right, up, back = (found.turn.T @ axes[:, i] for i in range(3))
    percent = scene.render.resolution_percentage / 100
    film = (scene.render.resolution_x * percent, scene.render.resolution_y * percent)
    width, height = clip.size if clip else film
    wide = lens.sensor_fit == "HORIZONTAL" or (lens.sensor_fit == "AUTO" and width >= height)
    side = width if wide else height
    middle = np.array([width, height]) / 2 + np.array([-lens.shift_x, lens.shift_y]) * side - 0.5
    place = found.from_world(matrix[:3, 3])
    size = [int(width), int(height)]
    if lens.type == "ORTHO":
        scale = lens.ortho_scale * found.unit / side
        origin = middle - np.array([right @ place, -up @ place]) / scale
        table = {"kind": "orthographic", "metres_per_pixel": float(scale)}
        table |= {"right": right.tolist(), "down": (-up).tolist()}
        return table | {"principal_point": origin.tolist(), "image_size": size}
    sensor = lens.sensor_height if lens.sensor_fit == "VERTICAL" else lens.sensor_width
    table = {"kind": "pinhole", "position": place.tolist(), "look": (-back).tolist()}
    table |= {"focal_px": float(lens.lens / sensor * side), "down": (-up).tolist()}
    return table | {"principal_point": middle.tolist(), "image_size": size}
