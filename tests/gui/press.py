"""A real Blender, its window, and nothing but simulated mouse and keys once the example is open.

real_blender.sh DIR shot tests/gui/press.py picture.png CHECKOUT

Opens the tab, cuts the body, places a point by a click and takes that back, starts a calibration
and stops it half-way with Esc, calibrates, opens the picture, bakes and plays. Buttons are found
by moving the mouse until Blender names the one under it. Prints the longest time for which the
event loop stood still meanwhile; leaves a picture of every step in DIR/mnt/stage. Ends with an
error when a press has not done what it should. Takes two to three minutes.
"""

import os
import pathlib
import re
import shutil
import time

import bpy
from bpy_extras.view3d_utils import location_3d_to_region_2d
from mathutils import Euler, Vector

STAGE = pathlib.Path("/mnt/stage")
EXAMPLE = pathlib.Path("/mnt/checkout/assets/jelly")
ELEMENTS = 600
TAKES = 1  # of the example's two
SCALE = 0.75  # of the interface
MIDDLE = (500, 450)  # in the viewport, clear of the panel
STEP = 12  # px between two looks for a button, less than one is high
FOUND = {}  # where a button was when it was last seen
LAST = {}  # "y" of the one before


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


def region(kind):
    return next(region for region in view().regions if region.type == kind)


def settings():
    return bpy.context.scene.ringdown_object.ringdown


def job():
    from bl_ext.user_default.ringdown.addon.job import NOW

    return NOW


def mouse(x, y):
    window().event_simulate(type="MOUSEMOVE", value="NOTHING", x=int(x), y=int(y))


def click(x, y):
    mouse(x, y)
    window().event_simulate(type="LEFTMOUSE", value="PRESS", x=int(x), y=int(y))
    window().event_simulate(type="LEFTMOUSE", value="RELEASE", x=int(x), y=int(y))


def key(kind, **held):
    x, y = MIDDLE
    window().event_simulate(type=kind, value="PRESS", x=x, y=y, **held)
    window().event_simulate(type=kind, value="RELEASE", x=x, y=y, **held)


def told():
    """What Blender says of the button under the mouse: its operator or its property."""
    manager = bpy.context.window_manager
    manager.clipboard = ""
    with bpy.context.temp_override(window=window(), area=view(), region=region("UI")):
        for ask in (bpy.ops.ui.copy_python_command_button, bpy.ops.ui.copy_data_path_button):
            if ask.poll() and ask() == {"FINISHED"}:
                break
    return manager.clipboard


def find(name):
    """Down the tab until the button that Blender calls `name` lies under the mouse.

    From the last one on, as the work goes, and from the top where it is not farther down.
    """
    bar = region("UI")
    across = [bar.x + int(part * bar.width) for part in (0.3, 0.8)]
    top = bar.y + bar.height - 20
    begin = min(top, LAST.get("y", top) + 2 * STEP)
    for page in range(9):
        for y in range(begin, bar.y + 10, -STEP):
            for x in across:
                mouse(x, y)
                yield 0.01
                if name in told():
                    yield from settle(name, across, y)
                    LAST["y"] = FOUND[name][1]
                    return
        yield from scroll("WHEELDOWNMOUSE", 6) if page != 1 else scroll("WHEELUPMOUSE", 40)
        begin = top
    raise AssertionError(f"no button {name} in the tab")


def settle(name, across, y):
    """Well inside the button that was touched a moment ago: a slow window tells of it late."""
    for place in [(x, y + up) for up in (0, STEP, 2 * STEP) for x in across]:
        mouse(*place)
        yield 0.25
        if name in told():
            break
    x, hits = place[0], []
    for up in (-8, -4, 0, 4, 8):
        mouse(x, place[1] + up)
        yield 0.2
        hits += [place[1] + up] if name in told() else []
    assert hits, f"the button {name} is gone again"
    FOUND[name] = (x, sum(hits) // len(hits))
    mouse(*FOUND[name])


def scroll(wheel, turns):
    bar = region("UI")
    x, y = bar.x + 4, bar.y + bar.height // 2  # at its edge: a list would take the wheel
    mouse(x, y)
    for _ in range(turns):
        window().event_simulate(type=wheel, value="PRESS", x=x, y=y)
        yield 0.01
    yield 0.3


def press(name):
    """The mouse goes there, waits as a hand does until the button lights up, and clicks."""
    if name in FOUND:
        mouse(*FOUND[name])
        yield 0.3
    if name not in told():
        yield from find(name)
        yield 0.3
    click(*FOUND[name])
    yield 0.3


def shot(name):
    with bpy.context.temp_override(window=window()):
        bpy.ops.wm.redraw_timer(type="DRAW_WIN_SWAP", iterations=1)
    os.system(f"import -window root {STAGE / name}.png")


def prepare():
    """The example in a saved file beside its case, seen from the front."""
    folder = STAGE / "example"
    shutil.copytree(EXAMPLE, folder, dirs_exist_ok=True)
    if TAKES == 1:  # half the time
        text = (folder / "case.toml").read_text()
        (folder / "case.toml").write_text(re.sub(r"\[\[take\]\][^\[]*", "", text))
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "jelly.blend"))
    bpy.ops.ringdown.case_open(filepath=str(folder / "case.toml"))
    settings().elements = ELEMENTS
    with bpy.context.temp_override(window=window(), area=view(), region=region("WINDOW")):
        bpy.ops.view3d.view_selected()
    view().spaces.active.region_3d.view_rotation = Euler((1.25, 0, -0.35)).to_quaternion()
    bpy.ops.ed.undo_push(message="Example")


def open_tab():
    """N, then one click down the strip of tabs after another until ours is the active one."""
    mouse(*MIDDLE)
    key("N")
    yield 0.5
    bar = region("UI")
    for y in range(bar.y + bar.height - 20, bar.y, -20):
        if region("UI").active_panel_category == "Ringdown":
            return
        click(bar.x + bar.width - 8, y)
        yield 0.1
    raise AssertionError("no tab")


def wait(until, seconds=400):
    end = time.monotonic() + seconds
    while not until():
        assert time.monotonic() < end, f"nothing came of it in {seconds} s"
        yield 0.1


def story():
    prepare()
    yield 1.0
    yield from open_tab()
    mouse(*MIDDLE)
    yield 0.5
    shot("1_tab")
    yield from build()
    yield from place()
    yield from cancel()
    yield from calibrate()
    yield from picture()
    yield from bake()


def build():
    yield from press("ringdown.cage(")
    yield from wait(lambda: settings().facts.cage and job().child is None, 120)
    mouse(*MIDDLE)
    yield 0.5
    shot("2_cage")
    yield from press("show_cage")
    yield from wait(lambda: not settings().show_cage, 5)


def place():
    """A click on the mesh moves the first point there; Ctrl Z brings it back."""
    before = Vector(settings().points[0].position)
    screen, obj = region("WINDOW"), bpy.context.scene.ringdown_object
    target = before + Vector((0.004, 0, -0.012))
    at = location_3d_to_region_2d(screen, view().spaces.active.region_3d, obj.matrix_world @ target)
    yield from press("ringdown.place(")
    yield 0.5
    click(screen.x + at.x, screen.y + at.y)
    yield from wait(lambda: Vector(settings().points[0].position) != before, 5)
    moved = Vector(settings().points[0].position)
    print(f"A click on the mesh: {1000 * (moved - before).length:.1f} mm from where it was")
    assert 0.002 < (moved - before).length < 0.03, (before, moved)
    mouse(*MIDDLE)
    key("Z", ctrl=True)
    yield from wait(lambda: (Vector(settings().points[0].position) - before).length < 1e-6, 5)


def cancel():
    yield from press("ringdown.calibrate(")
    yield from wait(lambda: job().child and job().child.progress.fraction > 0.1, 60)
    mouse(*MIDDLE)
    yield 0.3
    shot("3_running")
    key("ESC")
    pressed = time.monotonic()
    yield from wait(lambda: job().child is None, 5)
    print(f"Esc: stopped after {time.monotonic() - pressed:.2f} s")
    assert time.monotonic() - pressed < 1
    assert not settings().facts.report, "a stopped calibration left a result"


def calibrate():
    listen()
    yield from press("ringdown.calibrate(")
    yield from wait(lambda: job().child is not None, 5)
    paused("while it begins")
    mouse(*MIDDLE)
    yield 0.5
    listen()
    begun = time.monotonic()
    yield from wait(
        lambda: not job().child.progress.running or job().child.progress.fraction > 0.98
    )
    paused(f"in {time.monotonic() - begun:.0f} s of calibrating")
    listen()
    yield from wait(lambda: job().child is None)
    yield 0.3
    paused("while the result is taken in")
    assert settings().facts.report, "no result"
    yield 0.5
    shot("4_result")


def picture():
    yield from press("show_ghost")
    yield from wait(lambda: settings().show_ghost, 5)
    yield from press("ringdown.picture(")
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


def bake():
    obj = bpy.context.scene.ringdown_object
    yield from press("ringdown.bake(")
    yield from wait(lambda: obj.data.shape_keys is not None, 10)
    mouse(*MIDDLE)
    yield 0.5
    begun = bpy.context.scene.frame_current
    key("SPACE")
    yield from wait(lambda: window().screen.is_animation_playing, 5)
    yield 1.0
    key("SPACE")
    yield from wait(lambda: not window().screen.is_animation_playing, 5)
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


def listen():
    HEART.update(on=True, last=time.monotonic(), pause=0.0)


def paused(when):
    HEART["on"] = False
    print(f"Event loop: longest pause {1000 * HEART['pause']:.0f} ms {when}")


def run(steps):

    def tick():
        try:
            return next(steps)
        except StopIteration:
            os.system(f"cp $(ls -t {STAGE}/[0-9]_*.png | head -1) {STAGE}/out.png")
            bpy.ops.wm.quit_blender()
        except Exception:  # noqa: BLE001  (whatever it is, the window must not stay open)
            import traceback

            traceback.print_exc()
            shot("failed")
            os._exit(1)
        return None

    bpy.app.timers.register(tick, first_interval=1.0, persistent=True)
    bpy.app.timers.register(heart, persistent=True)


if __name__ == "__main__":
    enable()
    run(story())
