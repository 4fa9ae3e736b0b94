"""An editor of another kind beside the 3D view: one that is open already, else in a window."""

import bpy


def editor(context, kind: str, show) -> None:
    """`show(space)` in an editor of that kind, all of it in view. Nothing without a window."""
    area = next((a for a in context.screen.areas if a.type == kind), None)
    if area is None and not bpy.app.background:
        bpy.ops.wm.window_new()
        area = context.window_manager.windows[-1].screen.areas[0]
        area.type = kind
    if area is None:
        return
    show(area.spaces.active)
    region = next(r for r in area.regions if r.type == "WINDOW")
    window = next(w for w in context.window_manager.windows if area in w.screen.areas[:])
    with context.temp_override(window=window, area=area, region=region):
        family = {"IMAGE_EDITOR": bpy.ops.image, "CLIP_EDITOR": bpy.ops.clip}[kind]
        if family.view_all.poll():
            family.view_all(fit_view=True)
