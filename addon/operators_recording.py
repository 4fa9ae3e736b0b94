"""The recording: its tracks, its clock and its free part."""

import math

import bpy
import numpy as np

from ..core.errors import CoreError, RecordingError
from . import film, ready, windows
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
        recording.own_start, recording.start = True, start
        recording.own_stop, recording.stop = True, stop
        return {"FINISHED"}


def free_part(seen: film.Seen, recording) -> tuple[float, float]:
    """Seconds of the recording's own clock between which the object swings freely."""
    from ..core.ringdown import find_release

    rate = decimal(recording.capture_fps)
    time = seen.time if seen.time is not None else np.arange(len(seen.frames)) / rate
    values = seen.pixels.reshape(len(time), -1)
    moving = np.isfinite(values).all(axis=0)
    if not moving.any():
        raise RecordingError("Free part: every track has gaps. Set Release and Stop by hand.")
    start, stop = find_release(time, values[:, moving])
    # a millisecond's fraction inside, so that single precision does not step over the ends
    return math.ceil(start * 1e4) / 1e4, math.floor(stop * 1e4) / 1e4


class RINGDOWN_OT_clip_editor(bpy.types.Operator):
    """Show the clip in a Movie Clip Editor, where points are added and tracked"""

    bl_idname = "ringdown.clip_editor"
    bl_label = "Show Clip"
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context):
        why = ready.for_object(context)
        if not why and ready.target(context).ringdown.recording.clip is None:
            why = "Open the film as a movie clip"
        return ready.refuse(cls, why)

    def execute(self, context):
        clip = ready.target(context).ringdown.recording.clip
        windows.editor(context, "CLIP_EDITOR", lambda space: setattr(space, "clip", clip))
        return {"FINISHED"}


CLASSES = (
    RINGDOWN_OT_read,
    RINGDOWN_OT_slow_motion,
    RINGDOWN_OT_free_part,
    RINGDOWN_OT_clip_editor,
)
