"""What each step still needs, in one line; empty when it can be taken. Cheap: drawn every frame."""

import bpy

from . import marks
from .job import NOW


def target(context) -> bpy.types.Object | None:
    """The object that the panel is about: the picked one, else the active mesh."""
    picked = context.scene.ringdown_object
    if picked is not None:
        return picked
    obj = context.object
    return obj if obj is not None and obj.type == "MESH" else None


def refuse(operator, why: str) -> bool:
    """For `poll`: tells the reason, and whether there was none."""
    if why:
        operator.poll_message_set(why)
    return not why


def look(obj: bpy.types.Object) -> str:
    """What a cage or a measure was made of, without going through the vertices.

    Blender keeps the box of the evaluated object; with the counts it changes with nearly every
    edit. The calibration itself compares every vertex.
    """
    ours = marks.modifiers(obj)
    stack = ",".join(f"{m.type}{m.show_viewport:d}" for m in obj.modifiers if m not in ours)
    box = " ".join(f"{x:.5g}" for x in obj.dimensions)
    return f"{len(obj.data.vertices)} {len(obj.data.polygons)} {stack}|{box}"


def stale(obj: bpy.types.Object, kept: str) -> bool:
    """Whether the object no longer looks as when `kept` was noted; its wobble does not count."""
    part = 1 if marks.RECORD in obj else 2
    return look(obj).split("|")[:part] != kept.split("|")[:part]


def for_object(context) -> str:
    obj = target(context)
    if obj is None:
        return "Pick a mesh object first"
    if obj.library or obj.data.library:
        return "The object is linked from another file: make it local"
    return ""


def at_rest(context) -> str:
    why = for_object(context)
    if not why and target(context).mode != "OBJECT":
        return "Leave Edit Mode first"
    return why


def idle() -> str:
    return f"{NOW.what} runs: wait, or press Esc" if NOW.child else ""


def for_pins(context) -> str:
    why = for_object(context)
    if why:
        return why
    obj = target(context)
    if not obj.ringdown.pins:
        return "Say what is held: select it in Edit Mode, and assign"
    if obj.ringdown.pins not in obj.vertex_groups:
        return f'The pins\' vertex group "{obj.ringdown.pins}" is gone: assign again'
    return ""


def for_recording(context) -> str:
    """What a recording needs before it can be looked at."""
    why = for_object(context)
    if why:
        return why
    recording = target(context).ringdown.recording
    if recording.source == "CSV":
        return "" if recording.path else "Choose the table of tracks, a .csv"
    if recording.clip is None:
        return "Open the film as a movie clip"
    if not len(recording.clip.tracking.tracks):
        return "The clip has no tracks: Ctrl-click points in the Clip Editor"
    return ""


def for_points(context) -> str:
    why = for_recording(context)
    if why:
        return why
    points = target(context).ringdown.points
    if not points:
        return "Read the recording"
    missing = [point.name for point in points if not point.placed]
    if missing:
        return f'Place "{missing[0]}" on the mesh' + (
            f" and {len(missing) - 1} more" * (len(missing) > 1)
        )
    return ""


def for_calibration(context) -> str:
    return at_rest(context) or for_pins(context) or for_points(context) or idle()


def for_result(context) -> str:
    why = for_object(context)
    if not why and not target(context).ringdown.facts.report:
        return "Calibrate first"
    return why


def for_bake(context) -> str:
    why = at_rest(context) or for_result(context)
    if why:
        return why
    obj = target(context)
    if not obj.ringdown.facts.motion:
        return "Calibrate first"
    bake = obj.ringdown.bake
    if bake.motion == "PLUCKED" and not 0 <= bake.vertex < len(obj.data.vertices):
        return "Pick the vertex to pull"
    return ""


def for_remove(context) -> str:
    why = at_rest(context)
    if not why and marks.RECORD not in target(context):
        return "Nothing of Ringdown's is baked on it"
    return why


def baked(obj: bpy.types.Object, scene: bpy.types.Scene) -> str:
    """What is baked, in one line; empty when nothing is."""
    if marks.RECORD not in obj:
        return ""
    record = obj[marks.RECORD]
    fps = scene.render.fps / scene.render.fps_base
    line = f"Baked: frames {record['first']} to {record['last']} at {record['fps']:g} frames/s"
    if abs(record["fps"] - fps) > 1e-6 * fps:
        line += f"; the scene is at {fps:g}. Bake again"
    return line
