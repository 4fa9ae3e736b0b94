"""A real Blender, its window, and nothing but simulated mouse and keys once the example is open.

real_blender.sh DIR shot tests/gui/press.py picture.png CHECKOUT

Opens the tab, starts a calibration and stops it half-way with Esc, calibrates, opens the picture,
bakes and plays. Prints each step and the longest time for which the event loop stood still while
the calibration ran; leaves a picture of every step beside the last one (DIR/mnt/stage). Ends with
an error when a press has not done what it should, so that a moved button is noticed.
"""

import os
import pathlib
import time

import bpy
from mathutils import Euler

STAGE = pathlib.Path("/mnt/stage")
EXAMPLE = "/mnt/checkout/assets/jelly/case.toml"
ELEMENTS = 600
# where things are in a window of 1600 x 900 at this interface scale, from the bottom left corner
SCALE = 0.75
PLACES = {
    "middle": (500, 500),
    "object": (1121, 742),
    "resolution": (1121, 589),
    "build": (1193, 547),
    "show cage": (1275, 547),
    "pins": (1121, 503),
    "recording": (1121, 401),
    "calibrate": (1201, 636),
    "picture": (1157, 323),
    "markers": (1246, 323),
    "result": (1121, 608),
    "bake": (1157, 454),
}


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


def press(name):
    """The mouse goes there, waits as a hand does until the button lights up, and clicks."""
    mouse(*PLACES[name])
    yield 0.3
    click(*PLACES[name])
    yield 0.3


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
    view().spaces.active.region_3d.view_rotation = Euler((1.25, 0, -0.35)).to_quaternion()


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


def build():
    """Cut the example; panels are folded from the bottom up, so that the others stay in place."""
    for header in ("recording", "pins"):
        yield from press(header)
    yield from press("build")
    yield from wait(lambda: facts().cage and job().child is None, 120)
    mouse(*PLACES["middle"])
    yield 0.5
    shot("2_cage")
    yield from press("show cage")
    yield 0.5
    for header in ("resolution", "object"):
        yield from press(header)


def wait(until, seconds=300):
    end = time.monotonic() + seconds
    while not until():
        assert time.monotonic() < end, "it took too long"
        yield 0.1


def facts():
    return bpy.context.scene.ringdown_object.ringdown.facts


def story():
    prepare()
    yield 1.0
    yield from open_tab()
    mouse(*PLACES["middle"])
    yield 0.5
    shot("1_tab")
    yield from build()
    yield from still()
    yield from cancel()
    yield from calibrate()
    yield from picture()
    yield from bake()


def still():
    """The same window with its sidebar drawn as often, and nothing to do: what the machine can."""
    HEART["on"], HEART["last"] = True, time.monotonic()
    for _ in range(20):
        sidebar().tag_redraw()
        yield 0.1
    HEART["on"] = False
    print(f"Event loop: longest pause {1000 * HEART['pause']:.0f} ms idle, the sidebar redrawn")
    HEART["pause"] = 0.0


def cancel():
    yield from press("calibrate")
    yield from wait(lambda: job().child and job().child.progress.fraction > 0.1, 20)
    shot("3_running")
    yield 0.3
    mouse(*PLACES["middle"])
    key("ESC")
    pressed = time.monotonic()
    yield from wait(lambda: job().child is None, 5)
    print(f"Esc: stopped after {time.monotonic() - pressed:.2f} s")
    assert time.monotonic() - pressed < 1
    assert not facts().report, "a stopped calibration left a result"


def calibrate():
    yield from press("calibrate")
    yield from wait(lambda: job().child is not None, 5)
    mouse(*PLACES["middle"])
    yield 0.5
    HEART["on"], HEART["last"] = True, time.monotonic()
    yield from wait(lambda: job().child.progress.fraction > 0.94)
    yield 0.2
    HEART["on"] = False
    yield from wait(lambda: job().child is None)
    print(f"Event loop: longest pause {1000 * HEART['pause']:.0f} ms while calibrating")
    assert facts().report, "no result"
    yield 0.5
    shot("4_result")


def picture():
    yield from press("markers")
    yield 0.5
    assert bpy.context.scene.ringdown_object.ringdown.show_ghost, "no markers"
    yield from press("picture")
    yield from wait(lambda: len(bpy.context.window_manager.windows) == 2, 10)
    yield 1.5
    shot("5_picture")
    other = bpy.context.window_manager.windows[-1]
    space = other.screen.areas[0].spaces.active
    assert space.type == "IMAGE_EDITOR", space.type
    assert space.image.packed_file, "no picture"
    with bpy.context.temp_override(window=other):
        bpy.ops.wm.window_close()
    yield 0.5
    mouse(*PLACES["result"])
    yield 0.5


def bake():
    obj = bpy.context.scene.ringdown_object
    yield from press("result")
    yield 0.5
    yield from press("bake")
    yield from wait(lambda: obj.data.shape_keys is not None, 10)
    mouse(*PLACES["middle"])
    yield 0.5
    begun = bpy.context.scene.frame_current
    key("SPACE")
    yield 2.0
    assert window().screen.is_animation_playing, "it does not play"
    key("SPACE")
    yield 0.5
    assert bpy.context.scene.frame_current != begun
    bpy.context.scene.frame_set(3)
    yield 0.5
    shot("6_baked")


HEART = {"on": False, "last": 0.0, "pause": 0.0}


def heart():
    """Beats as often as the event loop turns: the longest time between two beats is the pause."""
    now = time.monotonic()
    if HEART["on"]:
        HEART["pause"] = max(HEART["pause"], now - HEART["last"])
    HEART["last"] = now
    return 0.001


def run():
    told = story()

    def tick():
        try:
            return next(told)
        except StopIteration:
            os.system(f"cp {STAGE}/6_baked.png {STAGE}/out.png")
            bpy.ops.wm.quit_blender()
        except Exception:  # noqa: BLE001  (whatever it is, the window must not stay open)
            import traceback

            traceback.print_exc()
            shot("failed")
            os._exit(1)
        return None

    bpy.app.timers.register(tick, first_interval=1.0)
    bpy.app.timers.register(heart)


enable()
run()
