"""From an empty scene to a baked object in a real window, by mouse and keys alone.

real_blender.sh DIR shot tests/gui/walk.py picture.png CHECKOUT

Only the mesh is imported for it. Then: Use, a material from the menu, held vertices by a box drawn
in Edit Mode, the table of tracks and its rate pasted into their fields, Read, a click on the mesh
for each of the twelve points, Calibrate, Bake, play. Leaves a picture of every step in
DIR/mnt/stage, and ends with an error when a press has not done what it should.
"""

import runpy
import tomllib

import bpy
from bpy_extras.view3d_utils import location_3d_to_region_2d
from mathutils import Vector

PRESS = runpy.run_path("/mnt/checkout/tests/gui/press.py", run_name="press")
VERBS = ("click", "key", "mouse", "press", "region", "settings", "shot", "view", "wait", "window")
click, key, mouse, press, region, settings, shot, view, wait, window = map(PRESS.get, VERBS)
EXAMPLE = PRESS["EXAMPLE"]
ROW = 19  # px from one row of the tab to the next
LINE = 17  # px from one line of a menu to the next
BOTTOM = 0.0005  # m: what lies below is held


def empty():
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    bpy.ops.wm.obj_import(filepath=str(EXAMPLE / "jelly.obj"), forward_axis="Y", up_axis="Z")
    with bpy.context.temp_override(window=window(), area=view(), region=region("WINDOW")):
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_selected()


def story():
    empty()
    yield 1.0
    yield from PRESS["open_tab"]()
    yield from press("ringdown.use(")
    yield from wait(lambda: bpy.context.scene.ringdown_object is not None, 5)
    yield from material()
    yield from pins()
    yield from recording()
    yield from points()
    shot("8_ready")
    yield from PRESS["calibrate"]()
    yield from PRESS["bake"]()
    shot("9_walked")


def material():
    """The menu opens below the mouse; its ninth line is a gelatine."""
    yield from press_not("ringdown.material_save(")  # at the end of the menu's row
    bar = region("UI")
    x, y = int(bar.x + 0.3 * bar.width), PRESS["FOUND"]["ringdown.material_save("][1]
    yield from go(x, y)
    for line in (7, 8, 9):
        mouse(x, y - LINE * line)
        yield 0.3
    click(x, y - LINE * 9)
    yield from wait(lambda: settings().material.name, 5)
    print(f"Material: {settings().material.name}, {settings().material.density:g} kg/m3")
    yield from paste("material.density", "1040")
    yield from wait(lambda: settings().material.density == 1040, 5)


def go(x, y):
    """As a hand does: there, a moment until the button lights up, a click."""
    mouse(x, y)
    yield 0.4
    click(x, y)
    yield 0.7


def paste(name, text):
    """Into the field of that name."""
    yield from press_not(name)
    yield from drop(*PRESS["FOUND"][name], text)


def drop(x, y, text):
    """Into the field under the mouse, as Ctrl V does."""
    mouse(x, y)
    yield 0.4
    bpy.context.window_manager.clipboard = text
    for value in ("PRESS", "RELEASE"):
        window().event_simulate(type="V", value=value, x=int(x), y=int(y), ctrl=True)
    yield 0.7


def press_not(name):
    """The mouse goes to the button and stays there."""
    yield from PRESS["find"](name)
    mouse(*PRESS["FOUND"][name])
    yield 0.3


def on_screen(place):
    obj, screen = bpy.context.scene.ringdown_object, region("WINDOW")
    at = location_3d_to_region_2d(screen, view().spaces.active.region_3d, obj.matrix_world @ place)
    return screen.x + at.x, screen.y + at.y


def pins():
    """Edit Mode, see-through, a box over the bottom, Assign."""
    low, high = on_screen(Vector((-0.06, 0, -0.01))), on_screen(Vector((0.06, 0, BOTTOM)))
    mouse(*PRESS["MIDDLE"])
    key("TAB")
    yield 0.5
    key("A", alt=True)
    key("Z", alt=True)
    yield 0.5
    key("B")
    yield 0.3
    mouse(*low)
    window().event_simulate(type="LEFTMOUSE", value="PRESS", x=int(low[0]), y=int(low[1]))
    yield 0.2
    mouse(*high)
    yield 0.2
    window().event_simulate(type="LEFTMOUSE", value="RELEASE", x=int(high[0]), y=int(high[1]))
    yield 0.5
    yield from press("ringdown.pins(")
    yield from wait(lambda: settings().facts.pins, 5)
    print(f"Pins: {settings().facts.pins}")
    mouse(*PRESS["MIDDLE"])
    key("TAB")
    yield 0.5
    key("Z", alt=True)
    yield 0.5


def recording():
    yield from press_not("recording.source")
    bar = region("UI")
    yield from go(bar.x + 0.47 * bar.width, PRESS["FOUND"]["recording.source"][1])  # Table
    yield from wait(lambda: settings().recording.source == "CSV", 5)
    y = PRESS["FOUND"]["recording.source"][1] - ROW
    yield from drop(bar.x + 0.55 * bar.width, y, str(EXAMPLE / "tracks.csv"))
    yield from wait(lambda: settings().recording.path, 5)
    yield from press("ringdown.read(")
    yield from wait(lambda: len(settings().points) == 12, 5)
    yield from paste("recording.capture_fps", "120")
    yield from wait(lambda: settings().recording.capture_fps == 120, 5)


def points():
    """Each point where the case says that it sits, by a click; they follow one another."""
    case = tomllib.loads((EXAMPLE / "case.toml").read_text())
    places = {one["name"]: Vector(one["position"]) for one in case["marker"]}
    yield from press("ringdown.place(")
    for _ in range(12):
        name = settings().points[settings().point].name
        inward = Vector((0, 0, 0.025)) - places[name]
        for share in (0.0, 0.04, 0.08):  # one on the outline may be missed
            click(*on_screen(places[name] + share * inward))
            yield 0.4
            if settings().points[name].placed:
                break
    yield from wait(lambda: all(point.placed for point in settings().points), 5)


if __name__ == "__main__":
    PRESS["enable"]()
    PRESS["run"](story())
