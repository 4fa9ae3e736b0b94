"""Which shape keys, curves and modifiers are ours, whatever the artist renames."""

from contextlib import contextmanager

import bpy

RECORD = "ringdown_bake"  # on the object: how it was baked
MARK = "ringdown"  # on our action, and on a Key block that began with our Basis
GROUP = "Ringdown"  # the group of our curves, also inside an action that the artist went on keying


def actions(obj: bpy.types.Object) -> list[bpy.types.Action]:
    """Our actions that play on the object's shape keys."""
    keys = obj.data.shape_keys if obj.type == "MESH" else None
    data = keys.animation_data if keys else None
    if data is None:
        return []
    strips = [strip.action for track in data.nla_tracks for strip in track.strips]
    found = [action for action in [data.action, *strips] if action and MARK in action]
    return list(dict.fromkeys(found))


def curves(action: bpy.types.Action) -> list[tuple]:
    """(channelbag, curve) of every curve that is ours."""
    return [
        (bag, curve)
        for layer in action.layers
        for strip in layer.strips
        for bag in strip.channelbags
        for curve in bag.fcurves
        if curve.group and curve.group.name == GROUP
    ]


def shape_keys(obj: bpy.types.Object) -> list[bpy.types.ShapeKey]:
    """Our shape keys: those that our curves move. Renaming one changes its curve's path too."""
    found = []
    for action in actions(obj):
        for _, curve in curves(action):
            try:
                found.append(
                    obj.data.shape_keys.path_resolve(curve.data_path.removesuffix(".value"))
                )
            except ValueError:  # the artist took the shape key away
                continue
    return found


def modifiers(obj: bpy.types.Object) -> list[bpy.types.Modifier]:
    """Our Mesh Cache modifiers: those that play the file that we wrote."""
    path = obj[RECORD].get("path", "") if RECORD in obj else ""
    if not path:
        return []
    whole = bpy.path.abspath(path)
    caches = [m for m in obj.modifiers if m.type == "MESH_CACHE"]
    return [m for m in caches if bpy.path.abspath(m.filepath) == whole]


@contextmanager
def silenced(obj: bpy.types.Object):
    """What Ringdown baked plays no part meanwhile; every switch is put back after."""
    keys = [(key, key.mute) for key in shape_keys(obj)]
    caches = [(m, m.show_viewport, m.show_render) for m in modifiers(obj)]
    try:
        for key, _ in keys:
            key.mute = True
        for cache, *_ in caches:
            cache.show_viewport = cache.show_render = False
        yield
    finally:
        for key, mute in keys:
            key.mute = mute
        for cache, viewport, render in caches:
            cache.show_viewport, cache.show_render = viewport, render
