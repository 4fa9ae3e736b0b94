"""A real Blender, its window, and nothing but simulated mouse and keys once the example is open.

real_blender.sh DIR shot tests/gui/press.py picture.png CHECKOUT

Opens the tab, starts a calibration and stops it half-way with Esc, calibrates, opens the picture,
bakes and plays. Prints each step and the longest time for which the event loop stood still while
the calibration ran; leaves a picture of every step beside the last one (DIR/mnt/stage). Ends with
an error when a press has not done what it should, so that a moved button is noticed.
"""

import os
import pathlib

import bpy

STAGE = pathlib.Path("/mnt/stage")
EXAMPLE = "/mnt/checkout/assets/jelly/case.toml"
ELEMENTS = 600
# where things are in a window of 1600 x 900 at this interface scale, from the bottom left corner
SCALE = 0.75
PLACES = {"middle": (500, 500)}


def enable():
    folder = pathlib.Path(bpy.utils.user_resource("EXTENSIONS")) / "user_default"
    folder.mkdir(parents=True, exist_ok=True)
    if not (folder / "ringdown").exists():
        (folder / "ringdown").symlink_to("/mnt/checkout", target_is_directory=True)
    bpy.ops.preferences.addon_enable(module="bl_ext.user_default.ringdown")
    bpy.context.preferences.view.show_splash = False
    bpy.context.preferences.view.ui_scale = SCALE


def window():
    return bpy.context.window_manager.windows[0]


def view():
    return next(area for area in window().screen.areas if area.type == "VIEW_3D")


def sidebar():
    return next(region for region in view().regions if region.type == "UI")


def job():
    from bl_ext.user_default.ringdown.addon.job import NOW

    return NOW


def mouse(x, y):
    window().event_simulate(type="MOUSEMOVE", value="NOTHING", x=int(x), y=int(y))


def click(x, y):
    mouse(x, y)
    window().event_simulate(type="LEFTMOUSE", value="PRESS", x=int(x), y=int(y))
    window().event_simulate(type="LEFTMOUSE", value="RELEASE", x=int(x), y=int(y))


def key(kind, x=None, y=None):
    x, y = (x, y) if x is not None else PLACES["middle"]
    window().event_simulate(type=kind, value="PRESS", x=x, y=y)
    window().event_simulate(type=kind, value="RELEASE", x=x, y=y)


def shot(name):
    with bpy.context.temp_override(window=window()):
        bpy.ops.wm.redraw_timer(type="DRAW_WIN_SWAP", iterations=1)
    os.system(f"import -window root {STAGE / name}.png")


def prepare():
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    bpy.ops.ringdown.case_open(filepath=EXAMPLE)
    bpy.context.object.ringdown.elements = ELEMENTS
    with bpy.context.temp_override(window=window(), area=view(), region=view().regions[-1]):
        bpy.ops.view3d.view_selected()


def open_tab():
    """N, then one click down the strip of tabs after another until ours is the active one."""
    mouse(*PLACES["middle"])
    key("N")
    yield 0.5
    region = sidebar()
    print("sidebar", region.x, region.y, region.width, region.height, region.active_panel_category)
    shot("0_open")
    yield 0.5
    for y in range(region.y + region.height - 20, region.y, -20):
        if sidebar().active_panel_category == "Ringdown":
            return
        click(region.x + region.width - 8, y)
        yield 0.1
    raise AssertionError("no tab")


def story():
    prepare()
    yield 1.0
    yield from open_tab()
    mouse(*PLACES["middle"])
    yield 0.5
    shot("1_tab")
    click(1121, 401)
    yield 1
    mouse(*PLACES["middle"])
    yield 0.5
    shot("2_folded")


def run():
    told = story()

    def tick():
        try:
            return next(told)
        except StopIteration:
            os.system(f"cp {STAGE}/1_tab.png {STAGE}/out.png")
            bpy.ops.wm.quit_blender()
        except Exception:  # noqa: BLE001  (whatever it is, the window must not stay open)
            import traceback

            traceback.print_exc()
            shot("failed")
            os._exit(1)
        return None

    bpy.app.timers.register(tick, first_interval=1.0)


enable()
run()
