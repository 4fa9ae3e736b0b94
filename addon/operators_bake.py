"""Bake, Remove, and the vertex that is plucked."""

import json
import re
import tempfile
from pathlib import Path

import bpy
import numpy as np

from ..core import bake
from ..core.data import Motion, Surface
from ..core.errors import CoreError
from ..core.surface import face_areas
from . import keep, read, ready, running, write
from .operators_place import under_mouse


class RINGDOWN_OT_bake(bpy.types.Operator):
    """Bake the wobble; what was baked before is replaced, all that is yours stays"""

    bl_idname = "ringdown.bake"
    bl_label = "Bake"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return ready.refuse(cls, ready.for_bake(context))

    def execute(self, context):
        obj = ready.target(context)
        wanted = obj.ringdown.bake
        span = write.Range(
            first=wanted.first,
            last=None if wanted.to_end else wanted.last,
            count=wanted.count,
            amplitude=wanted.amplitude,
        )
        try:
            surface, motion = kept_motion(context, obj)
            local = write.place(obj, surface, motion, span)
            if wanted.target == "KEYS":
                write.shape_keys(obj, local, span)
            else:
                write.cache(obj, local, cache_path(obj), span)
        except (CoreError, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


def kept_motion(context, obj: bpy.types.Object) -> tuple[Surface, Motion]:
    """The calibrated surface and its motion, as recorded or plucked."""
    wanted, arrays = obj.ringdown.bake, keep.unpack(obj.ringdown.facts.motion)
    surface = Surface(arrays["vertices"], arrays["faces"])
    names = tuple(str(name) for name in arrays["names"])
    motion = Motion(names, arrays["shapes"], arrays["time"], arrays["weights"])
    if wanted.motion == "RECORDED":
        return surface, motion
    found = read.axes(obj, context.scene)
    place = read.rest(obj)[wanted.vertex] @ found.stretch.T
    vertex = int(((surface.vertices - place) ** 2).sum(axis=1).argmin())
    pull = np.array(wanted.pull) * found.unit
    frequency, damping_ratio = ringing(obj.ringdown.facts.report, names)
    mass = arrays.get("modal_mass", surface_mass(surface, motion.shapes))
    pull = (vertex, pull)
    return surface, bake.plucked(motion, frequency, damping_ratio, pull, modal_mass=mass)


def ringing(report: str, names: tuple[str, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Frequency (k,) Hz and damping ratio (k,) of each shape; NaN for one that does not ring.

    Shapes named "mode 2: 7.84 Hz" are the report's mode of that pitch.
    """
    modes = json.loads(report)["modes"]
    pitch = np.array([mode["natural_frequency_hz"]["value"] for mode in modes])
    found = np.full((2, len(names)), np.nan)
    for k, name in enumerate(names):
        told = re.fullmatch(r"mode \d+(?:: ([\d.e+-]+) Hz)?", name)
        if told and len(modes):
            near = k if told[1] is None else int(np.abs(pitch - float(told[1])).argmin())
            mode = modes[min(near, len(modes) - 1)]
            found[:, k] = mode["natural_frequency_hz"]["value"], mode["damping_ratio"]["value"]
    return found[0], found[1]


def surface_mass(surface: Surface, shapes: np.ndarray) -> np.ndarray:
    """(k,) the shapes' mean square over the surface: in proportion to x^T M x, nearly."""
    weight = np.zeros(len(surface.vertices))
    np.add.at(weight, surface.faces, face_areas(surface)[:, None] / 3)
    return np.einsum("v,vdk->k", weight, shapes**2) / weight.sum()


def cache_path(obj: bpy.types.Object) -> Path:
    """Beside the file where it is saved, else in the preferred or the system's cache folder."""
    name = bpy.path.clean_name(obj.name) + ".pc2"
    chosen = running.cache_root()
    if not chosen and bpy.data.filepath:
        chosen = Path(bpy.data.filepath).parent / "ringdown_cache"
    folder = Path(chosen or Path(tempfile.gettempdir(), "ringdown_cache"))
    folder.mkdir(parents=True, exist_ok=True)
    return folder / name


class RINGDOWN_OT_remove(bpy.types.Operator):
    """Take exactly what Ringdown baked away"""

    bl_idname = "ringdown.remove"
    bl_label = "Remove"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return ready.refuse(cls, ready.for_remove(context))

    def execute(self, context):
        write.remove(ready.target(context))
        return {"FINISHED"}


class RINGDOWN_OT_pluck(bpy.types.Operator):
    """Click the vertex that is pulled and let go"""

    bl_idname = "ringdown.pluck"
    bl_label = "Pick Vertex"
    bl_options = {"REGISTER", "UNDO"}
    vertex: bpy.props.IntProperty(name="Vertex", default=-1, min=-1, options={"SKIP_SAVE"})

    @classmethod
    def poll(cls, context):
        return ready.refuse(cls, ready.at_rest(context))

    def execute(self, context):
        obj = ready.target(context)
        chosen = self.vertex
        if chosen < 0:
            chosen = next((v.index for v in obj.data.vertices if v.select), -1)
        if not 0 <= chosen < len(obj.data.vertices):
            self.report({"ERROR"}, "Pluck: no vertex is selected. Select one in Edit Mode.")
            return {"CANCELLED"}
        obj.ringdown.bake.vertex = chosen
        return {"FINISHED"}

    def invoke(self, context, _event):
        if context.area is None or context.area.type != "VIEW_3D":
            return self.execute(context)
        context.window_manager.modal_handler_add(self)
        context.window.cursor_modal_set("EYEDROPPER")
        context.workspace.status_text_set("Click the vertex to pull   |   Esc: Cancel")
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type in {"ESC", "RIGHTMOUSE"}:
            return self._end(context, {"CANCELLED"})
        if event.type != "LEFTMOUSE" or event.value != "PRESS":
            return {"PASS_THROUGH"}
        obj = ready.target(context)
        hit = under_mouse(context, event, obj)
        if hit is None:
            return {"PASS_THROUGH"}
        away = ((read.rest(obj) - np.array(hit[0])) ** 2).sum(axis=1)
        self.vertex = int(away.argmin())
        return self._end(context, self.execute(context))

    def _end(self, context, status):
        context.workspace.status_text_set(None)
        context.window.cursor_modal_restore()
        context.area.tag_redraw()
        return status


CLASSES = (RINGDOWN_OT_bake, RINGDOWN_OT_remove, RINGDOWN_OT_pluck)
