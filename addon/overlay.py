"""What is drawn into the viewport: the cage, the pins, and measured beside predicted markers."""

from functools import lru_cache

import bpy
import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader
from mathutils import Matrix, Vector

from . import keep, read, ready

SKIN, HIDDEN, INSIDE, PINS = (
    (0.1, 0.8, 1.0, 0.7),
    (0.1, 0.8, 1.0, 0.2),
    (0.1, 0.8, 1.0, 0.04),
    (1.0, 0.45, 0.1, 1.0),
)
LIFT = 1.004  # drawn this much larger about the middle, so as not to sink into the surface
MEASURED, PREDICTED = (1.0, 1.0, 1.0, 1.0), (0.2, 1.0, 0.4, 1.0)
SIZE, PIN = 7.0, 4.0  # px
EDGES = ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))
FACES = ((0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3))
_handle = None
_pins: dict = {}  # object -> (what it was made of, batch)


def draw() -> None:
    context = bpy.context
    obj = ready.target(context)
    if obj is None or not obj.visible_get():
        return
    gpu.state.blend_set("ALPHA")
    gpu.state.depth_test_set("LESS_EQUAL")
    with gpu.matrix.push_pop():
        gpu.matrix.multiply_matrix(obj.matrix_world)
        if obj.ringdown.show_cage and obj.ringdown.facts.cage and obj.mode == "OBJECT":
            _cage(context, obj)
        if obj.ringdown.show_pins and obj.ringdown.pins and obj.mode == "OBJECT":
            _pinned(obj)
        if obj.ringdown.show_ghost and obj.ringdown.facts.motion:
            _ghost(context, obj)
    gpu.state.blend_set("NONE")
    gpu.state.depth_test_set("NONE")


def _cage(context, obj: bpy.types.Object) -> None:
    found = read.axes(obj, context.scene)
    shader, skin, inside, middle = _cage_batches(obj.ringdown.facts.cage)
    lift = Matrix.Translation(middle) @ Matrix.Scale(LIFT, 4) @ Matrix.Translation(-middle)
    with gpu.matrix.push_pop():
        gpu.matrix.multiply_matrix(Matrix(found.local.tolist()).to_4x4() @ lift)
        shader.uniform_float("color", SKIN)
        skin.draw(shader)
        gpu.state.depth_test_set("NONE")  # a coarse cage cuts corners: a hint of it shows through
        for colour, edges in ((HIDDEN, skin), (INSIDE, inside)):
            shader.uniform_float("color", colour)
            edges.draw(shader)
        gpu.state.depth_test_set("LESS_EQUAL")


@lru_cache(maxsize=4)
def _cage_batches(text: str):
    """Edges on the skin and all edges, in metres; built when the cage changes, not when drawn."""
    arrays = keep.unpack(text)
    places, tets = arrays["nodes"].astype(np.float32), arrays["tets"]
    faces, seen = np.unique(np.sort(tets[:, FACES].reshape(-1, 3)), axis=0, return_counts=True)
    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    edges = (faces[seen == 1][:, ((0, 1), (0, 2), (1, 2))], tets[:, EDGES])
    edges = (np.unique(np.sort(e.reshape(-1, 2)), axis=0).astype(np.int32) for e in edges)
    skin, inside = (batch_for_shader(shader, "LINES", {"pos": places}, indices=e) for e in edges)
    return shader, skin, inside, Vector((places.min(axis=0) + places.max(axis=0)) / 2)


def _pinned(obj: bpy.types.Object) -> None:
    made_of = (obj.ringdown.facts.pins, obj.ringdown.pins, ready.look(obj))
    kept = _pins.get(obj.session_uid)
    if kept is None or kept[0] != made_of:
        held = read.held(obj, obj.data)
        places = read.rest(obj)[held]
        shader = gpu.shader.from_builtin("UNIFORM_COLOR")
        kept = (made_of, shader, batch_for_shader(shader, "POINTS", {"pos": places}))
        _pins[obj.session_uid] = kept
    gpu.state.point_size_set(PIN)
    gpu.state.depth_test_set("NONE")
    kept[1].uniform_float("color", PINS)
    kept[2].draw(kept[1])
    gpu.state.depth_test_set("LESS_EQUAL")


def _ghost(context, obj: bpy.types.Object) -> None:
    measured, predicted = markers_at(context, obj)
    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    gpu.state.depth_test_set("NONE")
    for places, colour, size in ((measured, MEASURED, 1.5 * SIZE), (predicted, PREDICTED, SIZE)):
        gpu.state.point_size_set(size)
        if len(places):
            shader.uniform_float("color", colour)
            batch_for_shader(shader, "POINTS", {"pos": places}).draw(shader)


def markers_at(context, obj: bpy.types.Object) -> tuple[np.ndarray, np.ndarray]:
    """Measured and predicted places (n, 3) in local units at the scene's frame; none outside it."""
    arrays = _motion(obj.ringdown.facts.motion)
    none = np.zeros((0, 3), np.float32)
    if "marker_time" not in arrays:
        return none, none
    scene = context.scene
    fps = scene.render.fps / scene.render.fps_base
    seconds = (scene.frame_current_final - obj.ringdown.bake.first) / fps
    time = arrays["marker_time"]
    i = int(np.searchsorted(time, seconds + time[0]))
    if not 0 <= i < len(time):
        return none, none
    local = read.axes(obj, scene).local
    found = (arrays[name][i] @ local.T for name in ("marker_measured", "marker_predicted"))
    return tuple(x[np.isfinite(x).all(axis=1)].astype(np.float32) for x in found)


@lru_cache(maxsize=2)
def _motion(text: str) -> dict:
    return keep.unpack(text)


def register() -> None:
    global _handle
    if not bpy.app.background:
        _handle = bpy.types.SpaceView3D.draw_handler_add(draw, (), "WINDOW", "POST_VIEW")


def unregister() -> None:
    global _handle
    if _handle is not None:
        bpy.types.SpaceView3D.draw_handler_remove(_handle, "WINDOW")
        _handle = None
    _pins.clear()
    _cage_batches.cache_clear()
    _motion.cache_clear()
