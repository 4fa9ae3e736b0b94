"""Into Blender: the motion as shape keys with curves, or as a cache, beside what the artist has."""

from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np

from ..core import bake
from ..core.data import Motion, Surface
from ..core.errors import CoreError
from . import marks, read

BEZIER, FREE = 2, 0  # Blender's numbers of an interpolation and of a handle type
SLIDER = (
    2.0  # a key of value 1 is the mode's largest displacement; twice that is room to exaggerate
)


class BlenderError(CoreError):
    """The file is in a state that a bake cannot be added to."""


@dataclass(frozen=True)
class Range:
    """When the wobble plays."""

    first: int = 1  # frame of the release
    last: int | None = None  # None: to the motion's end
    count: int | None = None  # modes; None: all that move
    amplitude: float = 1.0


def frames_per_second(scene: bpy.types.Scene) -> float:
    return scene.render.fps / scene.render.fps_base


def place(obj: bpy.types.Object, calibrated: Surface, motion: Motion, span: Range) -> Motion:
    """The motion at the object's own vertices, in its local units, strongest shapes first."""
    found = read.axes(obj, bpy.context.scene)
    rows, share = read.attachment(obj, calibrated, found)
    here = bake.carried(motion, rows, share, found.local)
    return bake.strongest(here, span.count, span.amplitude)


def shape_keys(obj: bpy.types.Object, motion: Motion, span: Range = Range()) -> bpy.types.Action:
    """One shape key per mode and an action with a slot of its own; what we baked before goes.

    `motion` is in the mesh's own vertices and units. Raises BlenderError when the shape keys
    are absolute, linked from another file, or their NLA is off or soloed.
    """
    scene = bpy.context.scene
    keys = bake.keys(motion, frames_per_second(scene), first=span.first, last=span.last)
    _check(obj)
    remove(obj)
    ours = obj.data.shape_keys is None
    active = obj.active_shape_key_index
    rest = read.rest(obj).astype(float)
    if ours:
        obj.shape_key_add(name="Basis", from_mix=False)
        obj.data.shape_keys[marks.MARK] = "basis"
    places = np.moveaxis(motion.shapes, 2, 0) + rest
    blocks = [_block(obj, *one) for one in zip(motion.names, places, strict=True)]
    action = _action(obj, blocks, keys)
    _play(obj, action, span.first)
    obj.active_shape_key_index = active
    _record(obj, "keys", span, last=int(np.ceil(keys.frame[-1])))
    return action


def cache(obj: bpy.types.Object, motion: Motion, path: Path, span: Range = Range()):
    """A PC2 file and a Mesh Cache modifier ahead of the artist's own; what we baked before goes.

    `motion` is in the mesh's own vertices and units. The artist's shape keys add to it.
    """
    fps = frames_per_second(bpy.context.scene)
    whole = int(np.ceil((motion.time[-1] - motion.time[0]) * fps)) + 1
    count = whole if span.last is None else span.last - span.first + 1
    if count < 2:
        raise BlenderError(f"Bake: frames {span.first} to {span.last} hold no motion. End later.")
    remove(obj)
    bake.write_pc2(path, read.rest(obj).astype(float), motion, (count, fps))
    modifier = obj.modifiers.new("Ringdown", "MESH_CACHE")
    modifier.cache_format = "PC2"
    modifier.filepath = str(path)
    modifier.frame_start = span.first
    modifier.interpolation = "LINEAR"
    mine = obj.data.shape_keys is not None and len(obj.data.shape_keys.key_blocks) > 1
    modifier.deform_mode = "INTEGRATE" if mine else "OVERWRITE"
    obj.modifiers.move(len(obj.modifiers) - 1, 0)
    _record(obj, "cache", span, last=span.first + count - 1, path=modifier.filepath)
    return modifier


def remove(obj: bpy.types.Object) -> bool:
    """Take exactly ours away. True when there was something."""
    had = marks.RECORD in obj
    for modifier in marks.modifiers(obj):
        obj.modifiers.remove(modifier)
    active, blocks = obj.active_shape_key_index, marks.shape_keys(obj)
    for action in marks.actions(obj):
        _forget(obj.data.shape_keys, action)
    for block in blocks:
        obj.shape_key_remove(block)
    keys = obj.data.shape_keys if obj.type == "MESH" else None
    if keys and keys.get(marks.MARK) == "basis":
        if len(keys.key_blocks) == 1 and keys.animation_data is None:
            obj.shape_key_clear()
        elif blocks:
            del keys[marks.MARK]
    if obj.data.shape_keys:
        obj.active_shape_key_index = min(active, len(obj.data.shape_keys.key_blocks) - 1)
    if had:
        del obj[marks.RECORD]
    return had


def _check(obj: bpy.types.Object) -> None:
    keys = obj.data.shape_keys
    if obj.library or obj.data.library or (keys and keys.library):
        raise BlenderError(f'Bake: "{obj.name}" is linked from another file. Make it local first.')
    if keys and not keys.use_relative:
        raise BlenderError(
            f'Bake: the shape keys of "{obj.name}" are absolute; modes need relative ones. '
            "Switch Relative on, or bake to a cache."
        )
    data = keys.animation_data if keys else None
    theirs = data and (data.action is None or marks.MARK not in data.action)
    if theirs and data.nla_tracks and not data.use_nla:
        raise BlenderError(f'Bake: the NLA of "{keys.name}" is switched off. Switch it on.')
    if theirs and any(track.is_solo for track in data.nla_tracks):
        raise BlenderError(f'Bake: an NLA track of "{keys.name}" plays solo. End that first.')
    if data and data.use_tweak_mode:
        raise BlenderError(f'Bake: an NLA strip of "{keys.name}" is being edited. Leave it (Tab).')


def _block(obj: bpy.types.Object, name: str, places: np.ndarray) -> bpy.types.ShapeKey:
    block = obj.shape_key_add(name=f"Ringdown {name}", from_mix=False)
    block.points.foreach_set("co", places.astype(np.float32).ravel())
    block.slider_min, block.slider_max = -SLIDER, SLIDER
    return block


def _action(obj: bpy.types.Object, blocks: list, keys: bake.Keys) -> bpy.types.Action:
    """Curves through the keys, each with its exact slope: handles a third of the way along it."""
    action = bpy.data.actions.new(f"{obj.name} Ringdown")
    action[marks.MARK] = 1
    slot = action.slots.new(id_type="KEY", name=obj.name)
    bag = action.layers.new("Layer").strips.new(type="KEYFRAME").channelbag(slot, ensure=True)
    group = bag.groups.new(marks.GROUP)
    count = len(keys.frame)
    third = (keys.frame[1] - keys.frame[0]) / 3  # a cubic's handles; the keys are evenly spaced
    for i, block in enumerate(blocks):
        curve = bag.fcurves.new(f'key_blocks["{bpy.utils.escape_identifier(block.name)}"].value')
        curve.group = group
        points = curve.keyframe_points
        points.add(count)
        co = np.stack([keys.frame, keys.value[:, i]], axis=1)
        arm = third * np.stack([np.ones(count), keys.slope[:, i]], axis=1)
        points.foreach_set("co", co.ravel())
        points.foreach_set("handle_left", (co - arm).ravel())
        points.foreach_set("handle_right", (co + arm).ravel())
        points.foreach_set("interpolation", np.full(count, BEZIER, np.int32))
        points.foreach_set("handle_left_type", np.full(count, FREE, np.int32))
        points.foreach_set("handle_right_type", np.full(count, FREE, np.int32))
        curve.update()
    return action


def _play(obj: bpy.types.Object, action: bpy.types.Action, first: int) -> None:
    """As the action, where none is in the way; else as a strip below the artist's own action."""
    keys = obj.data.shape_keys
    data = keys.animation_data or keys.animation_data_create()
    if data.action is None:
        data.action = action
        data.action_slot = action.slots[0]
        return
    track = data.nla_tracks.new()
    track.name = marks.GROUP
    strip = track.strips.new(action.name, first, action)
    strip.action_slot = action.slots[0]
    data.use_nla = True


def _forget(keys: bpy.types.Key, action: bpy.types.Action) -> None:
    """Take our curves away, and the action too unless the artist has keyed in it."""
    for bag, curve in marks.curves(action):
        bag.fcurves.remove(curve)
    bags = [b for layer in action.layers for strip in layer.strips for b in strip.channelbags]
    for bag in bags:
        for group in [g for g in bag.groups if g.name == marks.GROUP]:
            bag.groups.remove(group)
    if any(len(bag.fcurves) for bag in bags):
        del action[marks.MARK]
        return
    data = keys.animation_data
    for track in [t for t in data.nla_tracks if any(s.action == action for s in t.strips)]:
        for strip in [s for s in track.strips if s.action == action]:
            track.strips.remove(strip)
        if not track.strips:
            data.nla_tracks.remove(track)
    if data.action == action:
        data.action = None
    if not (data.action or data.nla_tracks or data.drivers):
        keys.animation_data_clear()
    if action.users == 0:
        bpy.data.actions.remove(action)


def _record(obj: bpy.types.Object, kind: str, span: Range, last: int, path: str = "") -> None:
    fps = frames_per_second(bpy.context.scene)
    obj[marks.RECORD] = {
        "kind": kind,
        "first": span.first,
        "last": last,
        "fps": fps,
        "path": path,
    }
