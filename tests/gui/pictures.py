"""The pictures of the panel for docs: the tab with a result, the cage, and the baked object.

real_blender.sh DIR shot tests/gui/pictures.py out.png CHECKOUT

Wants a screen of 1900 x 2500 (a copy of the script with that size) and some minutes. Leaves
panel.png, cage.png and result.png in DIR/mnt/stage; look at them before they are taken over.
"""

import os
import pathlib
import sys

import bpy

sys.path.insert(0, "/mnt/checkout/tests/gui")
import press

press.SCALE, press.ELEMENTS, press.TAKES = 1.0, 1500, 2
STAGE = pathlib.Path("/mnt/stage")
HEAD, TABS, BUTTON = 20, 24, 36  # px: the window's title, the strip of tabs, a button and its gap
LOWER = 60  # px that a body on its support sits below the middle of the view


def story():
    press.prepare()
    yield 1.0
    yield from press.open_tab()
    press.mouse(*press.MIDDLE)
    space = press.view().spaces.active
    for what in ("cursor", "object_origins", "axis_x", "axis_y"):
        setattr(space.overlay, f"show_{what}", False)
    space.region_3d.view_distance *= 1.6
    obj = bpy.context.scene.ringdown_object
    for name, step in (("cage", bpy.ops.ringdown.cage), ("result", bpy.ops.ringdown.calibrate)):
        with bpy.context.temp_override(
            window=press.window(), area=press.view(), region=press.region("WINDOW")
        ):
            step("INVOKE_DEFAULT")
        yield from press.wait(lambda: press.job().child is None)
        yield 1.0
        if name == "cage":
            press.shot("raw_cage")
    obj.ringdown.show_cage = obj.ringdown.show_pins = False
    obj.ringdown.show_ghost = True
    bpy.context.window_manager.ringdown_short = False
    bpy.ops.ringdown.bake()
    bpy.context.scene.frame_set(4)
    yield 1.0
    press.shot("raw_result")
    yield from columns()
    view = press.view()
    middle = view.x + view.width // 2, press.window().height - view.y - view.height // 2
    wide, high = 960, 860
    for name in ("cage", "result"):
        corner = middle[0] - wide // 2, middle[1] - high // 2 + LOWER
        crop(f"raw_{name}", name, (wide, high, *corner))
    for name, size in (("panel", "100%"), ("cage", "66%"), ("result", "66%")):
        path = STAGE / f"{name}.png"
        os.system(
            f"convert {path} +repage -resize {size} +dither -colors 255 {path}"
        )  # a page loads it


def columns():
    """The tab as two columns: up to Calibrate, and from there to the last line under Bake."""
    bar, height = press.region("UI"), press.window().height
    left, top = bar.x, height - bar.y - bar.height + HEAD
    for name in ("ringdown.calibrate(", "ringdown.bake("):
        yield from press.find(name)
    split, end = (height - press.FOUND[n][1] for n in ("ringdown.calibrate(", "ringdown.bake("))
    split, end = split + HEAD + BUTTON, end + HEAD + 2 * BUTTON - 20
    crop("raw_result", "left", (bar.width - TABS, split - top, left, top))
    crop("raw_result", "right", (bar.width - TABS, end - split, left, split))
    both = f"{STAGE}/left.png {STAGE}/right.png"
    os.system(f"convert {both} -background '#303030' +append {STAGE}/panel.png")


def crop(raw, name, box):
    os.system(
        f"convert {STAGE / raw}.png -crop {box[0]}x{box[1]}+{box[2]}+{box[3]} {STAGE / name}.png"
    )


if __name__ == "__main__":
    press.enable()
    os.system(f"touch {STAGE}/6_baked.png")
    press.run(story())
