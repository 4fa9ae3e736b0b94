"""The recording: its tracks, its clock, its free part, and where its points sit on the mesh."""

import math

import bpy
import numpy as np
from bpy_extras import view3d_utils

from ..core.errors import CoreError, RecordingError
from . import film, read, ready
from .folder import decimal


class RINGDOWN_OT_read(bpy.types.Operator):
    """Look at the recording: its length, its tracks, and where each point is at rest"""

    bl_idname = "ringdown.read"
    bl_label = "Read Recording"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return ready.refuse(cls, ready.for_recording(context))

    def execute(self, context):
        obj = ready.target(context)
        try:
            seen = film.tracks(obj.ringdown.recording)
        except CoreError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        keep_points(obj, seen)
        note(obj.ringdown.recording, seen)
        return {"FINISHED"}


def keep_points(obj: bpy.types.Object, seen: film.Seen) -> None:
    """One point per track; those known already stay. Tracks in metres place themselves."""
    points = obj.ringdown.points
    known = {p.name: (tuple(p.position), p.placed, p.support) for p in points}
    points.clear()
    rest = film.resting(seen)
    for name, place in zip(seen.names, rest, strict=True):
        point = points.add()
        point.name = name
        if name in known:
            point.position, point.placed, point.support = known[name]
        elif len(place) == 3 and np.isfinite(place).all():
            point.position, point.placed = place, True
    obj.ringdown.point = next((i for i, p in enumerate(points) if not p.placed), 0)


def note(recording, seen: film.Seen) -> None:
    """One line of what the recording is."""
    recording.frames = len(seen.frames)
    recording.solid, recording.timed = seen.pixels.shape[2] == 3, seen.time is not None
    if recording.timed:
        recording.capture_fps = 1 / float(np.median(np.diff(seen.time)))
    if recording.source == "VIDEO":
        recording.frames = recording.clip.frame_duration
    recording.seconds = recording.frames / recording.capture_fps
    unit = "metres" if recording.solid else "pixels"
    recording.found = f"{len(seen.names)} points in {unit}, {recording.frames} frames"


class RINGDOWN_OT_slow_motion(bpy.types.Operator):
    """The rate that the camera took frames at; slow motion plays slower"""

    bl_idname = "ringdown.slow_motion"
    bl_label = "Slow Motion"
    bl_options = {"REGISTER", "UNDO"}
    factor: bpy.props.IntProperty(name="Slower", description="Times", default=8, min=1, max=1000)

    @classmethod
    def poll(cls, context):
        return ready.refuse(cls, ready.for_object(context))

    def execute(self, context):
        recording = ready.target(context).ringdown.recording
        recording.capture_fps = playback(context, recording) * self.factor
        return {"FINISHED"}


def playback(context, recording) -> float:
    """Frames per second at which the clip plays."""
    if recording.source != "CSV" and recording.clip and recording.clip.fps > 0:
        return recording.clip.fps
    return context.scene.render.fps / context.scene.render.fps_base


class RINGDOWN_OT_free_part(bpy.types.Operator):
    """Find when the object was let go and until when it swings freely"""

    bl_idname = "ringdown.free_part"
    bl_label = "Find Free Part"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        why = ready.for_recording(context)
        if not why and ready.target(context).ringdown.recording.source == "VIDEO":
            why = "Of a video it is found while calibrating, once the points are followed"
        return ready.refuse(cls, why)

    def execute(self, context):
        recording = ready.target(context).ringdown.recording
        try:
            start, stop = free_part(film.tracks(recording), recording)
        except CoreError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        recording.own_range, recording.start, recording.stop = True, start, stop
        return {"FINISHED"}


def free_part(seen: film.Seen, recording) -> tuple[float, float]:
    """Seconds of the recording's own clock between which the object swings freely."""
    from ..core.ringdown import find_release

    rate = decimal(recording.capture_fps)
    time = seen.time if seen.time is not None else np.arange(len(seen.frames)) / rate
    values = seen.pixels.reshape(len(time), -1)
    moving = np.isfinite(values).all(axis=0)
    if not moving.any():
        raise RecordingError("Free part: every track has gaps. Set it by hand.")
    start, stop = find_release(time, values[:, moving])
    # a millisecond's fraction inside, so that single precision does not step over the ends
    return math.ceil(start * 1e4) / 1e4, math.floor(stop * 1e4) / 1e4


class RINGDOWN_OT_place(bpy.types.Operator):
    """Click on the mesh where the point sits; the next one follows. Enter or right click ends"""

    bl_idname = "ringdown.place"
    bl_label = "Place on Mesh"
    bl_options = {"REGISTER", "UNDO"}
    index: bpy.props.IntProperty(name="Point", default=-1, min=-1, options={"SKIP_SAVE"})
    position: bpy.props.FloatVectorProperty(name="Place", precision=5, options={"SKIP_SAVE"})

    @classmethod
    def poll(cls, context):
        why = ready.at_rest(context)
        if not why and not ready.target(context).ringdown.points:
            why = "Read the recording"
        return ready.refuse(cls, why)

    def execute(self, context):
        points = ready.target(context).ringdown.points
        index = ready.target(context).ringdown.point if self.index < 0 else self.index
        if index >= len(points):
            self.report({"ERROR"}, f"Points: there is no point {index}. Read the recording.")
            return {"CANCELLED"}
        points[index].position, points[index].placed = self.position, True
        return {"FINISHED"}

    def invoke(self, context, _event):
        if context.area is None or context.area.type != "VIEW_3D":
            return self.execute(context)
        self._before = [
            (tuple(p.position), p.placed) for p in ready.target(context).ringdown.points
        ]
        context.window_manager.modal_handler_add(self)
        context.window.cursor_modal_set("EYEDROPPER")
        self._show(context)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        settings = ready.target(context).ringdown
        if event.type == "ESC":
            for point, (place, placed) in zip(settings.points, self._before, strict=True):
                point.position, point.placed = place, placed
            return self._end(context, "CANCELLED")
        if event.type in {"RIGHTMOUSE", "RET", "NUMPAD_ENTER"} and event.value == "PRESS":
            return self._end(context, "FINISHED")
        if event.type != "LEFTMOUSE" or event.value != "PRESS":
            return {"PASS_THROUGH"}
        hit = under_mouse(context, event, ready.target(context))
        if hit is None:
            return {"PASS_THROUGH"}
        found = read.axes(ready.target(context), context.scene)
        place = found.stretch @ np.array(hit[0])
        point = settings.points[settings.point]
        point.position, point.placed = place, True
        settings.point = next(
            (i for i, p in enumerate(settings.points) if not p.placed), settings.point
        )
        if all(p.placed for p in settings.points):
            return self._end(context, "FINISHED")
        self._show(context)
        return {"RUNNING_MODAL"}

    def _show(self, context):
        settings = ready.target(context).ringdown
        name = settings.points[settings.point].name
        context.workspace.status_text_set(
            f'Click where "{name}" sits   |   Enter: Done   Esc: Cancel'
        )
        context.area.tag_redraw()

    def _end(self, context, status):
        context.workspace.status_text_set(None)
        context.window.cursor_modal_restore()
        context.area.tag_redraw()
        return {status}


def under_mouse(context, event, obj: bpy.types.Object):
    """(place in the object's local coordinates, face) under the mouse, or None."""
    area = context.area
    region = next((r for r in area.regions if r.type == "WINDOW"), None)
    at = (event.mouse_x - region.x, event.mouse_y - region.y)
    if not (0 <= at[0] < region.width and 0 <= at[1] < region.height):
        return None
    view = area.spaces.active.region_3d
    origin = view3d_utils.region_2d_to_origin_3d(region, view, at)
    toward = view3d_utils.region_2d_to_vector_3d(region, view, at)
    inverse = obj.matrix_world.inverted()
    hit, place, _, face = obj.ray_cast(
        inverse @ origin,
        (inverse.to_3x3() @ toward).normalized(),
        depsgraph=context.evaluated_depsgraph_get(),
    )
    return (place, face) if hit else None


CLASSES = (
    RINGDOWN_OT_read,
    RINGDOWN_OT_slow_motion,
    RINGDOWN_OT_free_part,
    RINGDOWN_OT_place,
)
