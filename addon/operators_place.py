"""Where the points of the recording sit on the mesh."""

import bpy
import numpy as np
from bpy_extras import view3d_utils

from . import read, ready


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


CLASSES = (RINGDOWN_OT_place,)
