"""How long Blender's event loop stands still while a calibration runs, in its real window.

real_blender.sh DIR shot tests/gui/pauses.py picture.png CHECKOUT

Prints the longest pause with Blender's own tab drawn and with ours, idle and beside the running
child, as often each; what software OpenGL needs to draw the window is in all of them. Prints too
how long the extension's own Python took at most. Takes a minute and a half.
"""

import itertools
import runpy
import statistics
import sys
import time

import bpy

PRESS = runpy.run_path("/mnt/checkout/tests/gui/press.py", run_name="press")
HEART, region, job, listen = (PRESS[name] for name in ("HEART", "region", "job", "listen"))
OURS = {"longest": 0.0, "where": "", "frame": None, "since": 0.0}
ROUNDS = 20


def story():
    PRESS["prepare"]()
    yield 1.0
    yield from PRESS["open_tab"]()
    PRESS["mouse"](*PRESS["MIDDLE"])
    for tab in ("Item", "Ringdown"):
        yield from drawn(tab, "idle")
    sys.setprofile(clock_ours)
    bpy.ops.ringdown.calibrate("INVOKE_DEFAULT")
    yield 3.0
    tabs = itertools.cycle(("Item", "Ringdown"))
    while job().child and job().child.progress.fraction < 0.9:
        yield from drawn(next(tabs), f"{100 * job().child.progress.fraction:3.0f} % calibrated")
    sys.setprofile(None)
    print(
        f"The extension's own Python took {1000 * OURS['longest']:.1f} ms at most: {OURS['where']}"
    )
    PRESS["shot"]("7_pauses")
    if job().child:
        bpy.ops.ringdown.cancel()
    yield 1.0


def drawn(tab, when):
    """The tab in front, drawn ten times a second, and the pauses that this brings."""
    region("UI").active_panel_category = tab
    yield 1.0
    found = []
    for _ in range(ROUNDS):
        listen()
        region("UI").tag_redraw()
        yield 0.1
        found.append(1000 * HEART["pause"])
    HEART["on"] = False
    middle = statistics.median(found)
    print(f"Event loop: {middle:.0f} ms, at most {max(found):.0f} ms, tab {tab:8}, {when}")


def clock_ours(frame, event, _argument):
    """The longest that one call into the extension's Python lasted."""
    if event == "call" and OURS["frame"] is None and "/addon/" in frame.f_code.co_filename:
        OURS.update(frame=frame, since=time.perf_counter())
    elif event == "return" and frame is OURS["frame"]:
        spent = time.perf_counter() - OURS["since"]
        OURS["frame"] = None
        if spent > OURS["longest"]:
            OURS.update(longest=spent, where=frame.f_code.co_qualname)


if __name__ == "__main__":
    PRESS["enable"]()
    PRESS["run"](story())
