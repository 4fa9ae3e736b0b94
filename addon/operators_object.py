"""Object, resolution and pins."""

from pathlib import Path

import bpy
import numpy as np

from ..core.data import Surface
from ..core.errors import CoreError
from ..core.surface import enclosed_volume, face_areas, is_closed
from . import job, keep, read, ready, running, words
from .folder import decimal

SMALL = (
    0.005  # of the surface: pins below this are a few triangles, and the answer follows the mesh
)
CHILD = Path(__file__).with_name("cage_child.py")


class RINGDOWN_OT_use(bpy.types.Operator):
    """Work on the active mesh, and measure it"""

    bl_idname = "ringdown.use"
    bl_label = "Use Active"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        obj = context.object
        good = obj is not None and obj.type == "MESH"
        return ready.refuse(cls, "" if good else "Make a mesh object the active one")

    def execute(self, context):
        context.scene.ringdown_object = context.object
        return measured(self, context)


class RINGDOWN_OT_measure(bpy.types.Operator):
    """Work out volume, mass and the pins' area of the object as it is now"""

    bl_idname = "ringdown.measure"
    bl_label = "Measure"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return ready.refuse(cls, ready.at_rest(context))

    def execute(self, context):
        return measured(self, context)


class RINGDOWN_OT_pins(bpy.types.Operator):
    """Hold the selected vertices: a vertex group that the object does not let go"""

    bl_idname = "ringdown.pins"
    bl_label = "Assign from Selection"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return ready.refuse(cls, ready.for_object(context))

    def execute(self, context):
        obj = ready.target(context)
        editing = obj.mode == "EDIT"
        if editing:
            obj.update_from_editmode()
        chosen = [v.index for v in obj.data.vertices if v.select]
        if not chosen:
            self.report({"ERROR"}, "Pins: no vertex is selected. Select what is held in Edit Mode.")
            return {"CANCELLED"}
        if editing:
            bpy.ops.object.mode_set(mode="OBJECT")
        name = obj.ringdown.pins or "Pins"
        group = obj.vertex_groups.get(name) or obj.vertex_groups.new(name=name)
        group.remove(range(len(obj.data.vertices)))
        group.add(chosen, 1.0, "REPLACE")
        obj.ringdown.pins = group.name
        done = measured(self, context)
        if editing:
            bpy.ops.object.mode_set(mode="EDIT")
        return done


class RINGDOWN_OT_cage(running.Running, bpy.types.Operator):
    """Cut the object into tetrahedra and keep them in this file. Esc cancels"""

    bl_idname = "ringdown.cage"
    bl_label = "Build"
    bl_options = {"REGISTER", "UNDO"}
    what = "Tetrahedra"

    @classmethod
    def poll(cls, context):
        return ready.refuse(cls, ready.at_rest(context) or ready.idle())

    def start(self, context, obj, folder: Path) -> job.Job:
        depsgraph = context.evaluated_depsgraph_get()
        surface = read.surface(obj, depsgraph)
        np.savez(
            folder / "surface.npz",
            vertices=surface.vertices,
            faces=surface.faces,
            pinned=read.pinned(obj, depsgraph),
            elements=obj.ringdown.elements,
            poisson_ratio=decimal(obj.ringdown.material.poisson_ratio),
            element=running.element(),
        )
        return job.Job([str(CHILD), str(folder)], folder, running.threads())

    def finish(self, context, obj, folder: Path) -> None:
        with np.load(folder / "surface.npz") as file:
            surface = Surface(file["vertices"], file["faces"])
        with np.load(folder / "cage.npz") as file:
            found = {name: file[name] for name in file.files}
        write_cage(obj, surface, found)
        measure(context, obj)


def write_cage(obj: bpy.types.Object, surface: Surface, found: dict) -> None:
    """Keep tetrahedra with the object, and say in one line what they are like."""
    facts = obj.ringdown.facts
    facts.cage = keep.pack(nodes=found["nodes"], tets=found["tets"], of=surface.vertices)
    facts.cage_look = ready.look(obj)
    line = f"{len(found['tets']):,} tetrahedra, worst quality {float(found['quality']):.2f}"
    excess = float(found["too_high"])
    if np.isfinite(excess):
        line += (
            f"\nThis mesh rings {words.share(max(excess, 0))} too high; calibration takes it out"
        )
    facts.cage_says = line


def measured(operator, context) -> set[str]:
    try:
        measure(context, ready.target(context))
    except CoreError as error:
        operator.report({"ERROR"}, str(error))
        return {"CANCELLED"}
    return {"FINISHED"}


def measure(context, obj: bpy.types.Object) -> None:
    """Volume and pins' area of the evaluated rest shape, kept for the panel to draw."""
    depsgraph = context.evaluated_depsgraph_get()
    surface = read.surface(obj, depsgraph)
    facts = obj.ringdown.facts
    facts.volume, facts.closed = enclosed_volume(surface), is_closed(surface)
    facts.size = np.ptp(surface.vertices, axis=0).tolist()
    facts.look = ready.look(obj)
    facts.pins, facts.pins_small = "", False
    if obj.ringdown.pins in obj.vertex_groups:
        held = read.pinned(obj, depsgraph)
        areas = face_areas(surface)
        area = areas[held[surface.faces].all(axis=1)].sum()
        share = area / areas.sum()
        size = bpy.utils.units.to_string("METRIC", "AREA", area, precision=3)
        facts.pins = f"{held.sum()} vertices, {size}, {words.share(share)} of the surface"
        facts.pins_small = bool(share < SMALL)


CLASSES = (
    RINGDOWN_OT_use,
    RINGDOWN_OT_measure,
    RINGDOWN_OT_pins,
    RINGDOWN_OT_cage,
    running.RINGDOWN_OT_cancel,
)
