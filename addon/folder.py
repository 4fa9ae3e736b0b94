"""The panel's settings as a case folder: the one road to a calibration, from here or a terminal."""

import csv
import shutil
import tomllib
from pathlib import Path

import bpy
import numpy as np

from ..core.data import Surface
from ..core.errors import CaseError
from . import film, read, toml

MESH, TRACKS, CASE = "mesh.ply", "tracks.csv", "case.toml"
FACE = np.dtype([("count", "u1"), ("corners", "<i4", 3)])


def write_case(context, obj: bpy.types.Object, folder: Path, whole: bool = False) -> Surface:
    """Everything that calibrates `obj`, as files in `folder`; the surface that they hold.

    `whole`: copy the film too, so that the folder can travel; else its path is named.
    Raises CoreError for what a case cannot be without.
    """
    folder.mkdir(parents=True, exist_ok=True)
    settings = obj.ringdown
    depsgraph = context.evaluated_depsgraph_get()
    surface = read.surface(obj, depsgraph)
    found = read.axes(obj, context.scene)
    write_ply(folder / MESH, surface)
    given = _given(settings.recording.case_file, folder, whole)
    body = given.setdefault("object", {})
    body |= {"mesh": MESH, "length_unit": "m"}
    body |= {
        "density": decimal(settings.material.density),
        "poisson_ratio": decimal(settings.material.poisson_ratio),
    }
    if settings.material.modulus:
        body["youngs_modulus"] = decimal(settings.material.modulus) * 1000
    if settings.recording.gravity and "gravity" not in body:
        body["gravity"] = (found.turn.T @ np.array(context.scene.gravity)).tolist()
    if not settings.recording.case_file:
        body["shape"] = "unloaded" if settings.recording.unloaded else "equilibrium"
    held = read.pinned(obj, depsgraph)
    if not held.any():
        raise CaseError(f'Pins: the group "{settings.pins}" holds no vertex. Assign pins again.')
    given["pin"] = [{"vertices": np.flatnonzero(held).tolist()}]
    given.setdefault("model", {"declared": ["viscous_damping"]})
    _write_recording(context, obj, folder, given, whole)
    order = ("name", "object", "pin", "load", "model", "recording", "take", "camera", "marker")
    given["name"] = obj.name
    text = toml.dump({key: given[key] for key in order if key in given})
    (folder / CASE).write_text(text, encoding="utf-8")
    return surface


def write_ply(path: Path, surface: Surface) -> None:
    """Binary, in doubles: what is read back is what was written."""
    faces = np.zeros(len(surface.faces), FACE)
    faces["count"], faces["corners"] = 3, surface.faces
    head = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(surface.vertices)}\n"
        "property double x\nproperty double y\nproperty double z\n"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    data = surface.vertices.astype("<f8").tobytes()
    path.write_bytes(head.encode("ascii") + data + faces.tobytes())


def _given(case_file: str, folder: Path, whole: bool) -> dict:
    """What a case.toml beside the panel brings: loads, takes, camera, declared effects."""
    if not case_file:
        return {}
    path = Path(bpy.path.abspath(case_file))
    try:
        fields = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise CaseError(f"{path}: cannot be read ({error}). Choose a case.toml.") from error
    for take in fields.get("take", []):
        for key in ("tracks", "video"):
            if key in take:
                take[key] = _beside(path.parent / take[key], folder, whole)
    return fields


def _write_recording(context, obj, folder: Path, given: dict, whole: bool) -> None:
    settings = obj.ringdown
    recording = settings.recording
    found = {"capture_fps": decimal(recording.capture_fps)}
    film_path = None
    if recording.source == "CSV":
        path = Path(bpy.path.abspath(recording.path))
        found["tracks"] = _beside(path, folder, whole)
    elif recording.source == "CLIP":
        seen = film.clip_tracks(recording.clip, [p.name for p in settings.points])
        write_tracks(folder / TRACKS, seen, recording.capture_fps)
        found["tracks"] = TRACKS
    else:
        film_path = Path(bpy.path.abspath(recording.clip.filepath))
        found["video"] = _beside(film.film_of(recording.clip, film_path), folder, whole)
    if recording.own_start:
        found["start"] = decimal(recording.start)
    if recording.own_stop:
        found["stop"] = decimal(recording.stop)
    given["recording"] = found
    pixels = film.rest_pixels(obj)
    given["marker"] = [
        _marker(p, pixels.get(p.name) if film_path else None) for p in settings.points
    ]
    if pixels and "camera" not in given:
        given["camera"] = film.camera(context, obj, pixels)


def _marker(point, pixel: np.ndarray | None) -> dict:
    found = {"name": point.name, "position": [decimal(x) for x in point.position]}
    if point.support:
        found["on"] = "support"
    if pixel is not None:
        found["pixel"] = [float(x) for x in pixel]
    return found


def write_tracks(path: Path, seen: film.Seen, rate: float) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file)
        table.writerow(["time", *(f"{name}.{axis}" for name in seen.names for axis in "uv")])
        for i, frame in enumerate(seen.pixels):
            cells = ["" if np.isnan(x) else repr(float(x)) for x in frame.ravel()]
            table.writerow([repr(float(seen.frames[i] - seen.frames[0]) / rate), *cells])


def _beside(path: Path, folder: Path, whole: bool) -> str:
    """How case.toml in `folder` names the file: by its full path, or copied next to it."""
    if not path.exists():
        raise CaseError(f"{path}: there is no such file. Choose the recording again.")
    if not whole:
        return path.resolve().as_posix()
    if path.is_dir():
        shutil.copytree(path, folder / path.name, dirs_exist_ok=True)
    elif path.resolve() != (folder / path.name).resolve():
        shutil.copyfile(path, folder / path.name)
    return path.name


def decimal(value: float) -> float:
    """Blender keeps properties in single precision: the decimal number that was meant."""
    return float(f"{value:.7g}")
