"""A case folder as an object of the scene, ready to calibrate."""

import tomllib
from pathlib import Path

import bpy
import numpy as np

from ..core.case_fields import read_table
from ..core.case_schema import CASE_FIELDS
from ..core.errors import CaseError, CoreError
from ..core.pins import HAIR, Box, Sphere, held_vertices, vertices_region
from ..core.surface import diagonal, read_surface
from . import film
from .mesh import new_object
from .operators_object import measure
from .operators_recording import keep_points, note


def open_case(context, path: Path) -> bpy.types.Object:
    """Raises CoreError, one line, for a case that cannot be read."""
    path = path / "case.toml" if path.is_dir() else path
    try:
        fields = read_table(tomllib.loads(path.read_text(encoding="utf-8")), CASE_FIELDS, path.name)
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise CaseError(f"{path}: cannot be read ({error}). Choose a case.toml.") from error
    body = fields["object"]
    surface = read_surface(path.parent / body["mesh"], body["length_unit"])
    pinned = held_vertices(surface, tuple(_region(pin, surface) for pin in fields["pin"]))
    obj = new_object(context, Path(body["mesh"]).stem, surface)
    try:
        _fill(obj, fields, path, pinned)
    except (CoreError, RuntimeError) as error:
        bpy.data.meshes.remove(obj.data)
        raise error if isinstance(error, CoreError) else CaseError(str(error).strip()) from error
    for other in context.selected_objects:
        other.select_set(False)
    obj.select_set(True)
    context.view_layer.objects.active = obj
    context.scene.ringdown_object = obj
    measure(context, obj)
    return obj


def _region(pin: dict, surface):
    hair = HAIR * diagonal(surface)
    if pin["box"] is not None:
        return Box(**pin["box"], hair=hair)
    if pin["sphere"] is not None:
        return Sphere(**pin["sphere"], hair=hair)
    if pin["vertices"] is None:
        raise CaseError("[[pin]]: box, sphere or vertices is needed. Give one of them.")
    return vertices_region(surface, pin["vertices"], "[[pin]]")


def _fill(obj: bpy.types.Object, fields: dict, path: Path, pinned: np.ndarray) -> None:
    settings, body = obj.ringdown, fields["object"]
    settings.material.density = body["density"]
    settings.material.poisson_ratio = body["poisson_ratio"]
    settings.material.modulus = (body["youngs_modulus"] or 0) / 1000
    group = obj.vertex_groups.new(name="Pins")
    group.add(np.flatnonzero(pinned).tolist(), 1.0, "REPLACE")
    settings.pins = group.name
    recording, given = settings.recording, fields["recording"]
    recording.case_file = _kept(path)
    recording.gravity = body["gravity"] is not None
    recording.unloaded = body["shape"] == "unloaded"
    if given["video"]:
        recording.source = "VIDEO"
        recording.clip = _clip(path.parent / given["video"], fields["marker"])
    else:
        recording.source, recording.path = "CSV", _kept(path.parent / given["tracks"])
    seen = film.tracks(recording)
    keep_points(obj, _only(seen, [marker["name"] for marker in fields["marker"]]))
    for point, marker in zip(settings.points, fields["marker"], strict=True):
        point.position, point.placed = marker["position"], True
        point.support = marker["on"] == "support"
    note(recording, seen)
    if given["capture_fps"]:
        recording.capture_fps = given["capture_fps"]
    for end in ("start", "stop"):
        if given[end] is not None:
            setattr(recording, f"own_{end}", True)
            setattr(recording, end, given[end])


def _kept(path: Path) -> str:
    """As a file browser keeps it: relative to a saved file, where that is preferred."""
    wanted = bpy.data.filepath and bpy.context.preferences.filepaths.use_relative_paths
    try:
        return bpy.path.relpath(str(path)) if wanted else str(path)
    except ValueError:  # on another drive
        return str(path)


def _only(seen: film.Seen, names: list[str]) -> film.Seen:
    missing = [name for name in names if name not in seen.names]
    if missing:
        raise CaseError(
            f'Recording: it has no track "{missing[0]}". Known: {", ".join(seen.names)}.'
        )
    rows = [seen.names.index(name) for name in names]
    return film.Seen(names, seen.frames, seen.pixels[:, rows], seen.time)


def _clip(path: Path, markers: list[dict]) -> bpy.types.MovieClip:
    """The film with a track at each marker's first pixel."""
    if not path.exists():
        raise CaseError(f"{path}: there is no such film. Put it beside case.toml.")
    first = path if path.is_file() else min(path.iterdir())
    clip = bpy.data.movieclips.load(str(first))
    width, height = clip.size
    for marker in markers:
        if marker["pixel"] is None:
            raise CaseError(f"[[marker]] {marker['name']} lacks the field pixel. Add it.")
        u, v = marker["pixel"]
        track = clip.tracking.tracks.new(name=marker["name"], frame=1)
        track.markers[0].co = ((u + 0.5) / width, 1 - (v + 0.5) / height)
    return clip


class RINGDOWN_OT_case_open(bpy.types.Operator):
    """Open a case folder: its mesh as a new object with pins, points, recording and camera"""

    bl_idname = "ringdown.case_open"
    bl_label = "Open Case"
    bl_options = {"REGISTER", "UNDO"}
    filepath: bpy.props.StringProperty(subtype="FILE_PATH")
    filter_glob: bpy.props.StringProperty(default="*.toml", options={"HIDDEN"})

    def invoke(self, context, _event):
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        try:
            open_case(context, Path(bpy.path.abspath(self.filepath)))
        except CoreError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


CLASSES = (RINGDOWN_OT_case_open,)
