"""An operator whose work is done by a child: Blender stays awake, Esc ends it."""

import shutil
import tempfile
from pathlib import Path

import bpy

from ..core.errors import Cancelled, CoreError
from . import job, ready
from .job import NOW

TICK = 0.25  # s between two looks at the child, and so between two drawings of what it says


class Running:
    """Mix-in: `start` gives the child, `finish` takes in what it left; the rest is here.

    `execute` waits; `invoke` watches from a timer and leaves the object alone until the end.
    """

    what = "Working"
    alone = False  # it takes long: the tab shows it alone

    def start(self, context, obj, folder: Path) -> job.Job:
        raise NotImplementedError

    def finish(self, context, obj, folder: Path) -> None:
        raise NotImplementedError

    def execute(self, context):
        obj = ready.target(context)
        with tempfile.TemporaryDirectory(prefix="ringdown_", dir=cache_root()) as folder:
            try:
                child = self.start(context, obj, Path(folder))
                child.wait()
                self.finish(context, obj, Path(folder))
            except CoreError as error:
                self.report({"ERROR"}, str(error))
                return {"CANCELLED"}
        return {"FINISHED"}

    def invoke(self, context, _event):
        if bpy.app.background:
            return self.execute(context)
        obj = ready.target(context)
        self._folder = Path(tempfile.mkdtemp(prefix="ringdown_", dir=cache_root()))
        self._name = obj.name
        try:
            NOW.child = self.start(context, obj, self._folder)
        except CoreError as error:
            self._end(context)
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        NOW.what, NOW.alone, NOW.stop = self.what, self.alone, False
        self._timer = context.window_manager.event_timer_add(TICK, window=context.window)
        context.window_manager.modal_handler_add(self)
        self._show(context)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC" and event.value == "PRESS":
            NOW.stop = True
        if NOW.stop and NOW.child:
            NOW.child.stop()
        if event.type != "TIMER":
            return {"RUNNING_MODAL"} if event.type == "ESC" else {"PASS_THROUGH"}
        self._show(context)
        if NOW.child.progress.running:
            return {"PASS_THROUGH"}
        return self._ended(context)

    def cancel(self, context):  # Blender closes, or the file is left
        if NOW.child:
            NOW.child.cancel()
        self._end(context)

    def _ended(self, context):
        try:
            NOW.child.wait()
            if NOW.stop:
                raise Cancelled(f"{self.what}: stopped. Nothing was changed.")
            obj = bpy.data.objects.get(self._name)
            if obj is None:
                raise Cancelled(f'{self.what}: "{self._name}" is gone. Nothing was changed.')
            self.finish(context, obj, self._folder)
        except Cancelled as stopped:
            self.report({"WARNING"}, str(stopped))
            return {"CANCELLED"}
        except CoreError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        finally:
            self._end(context)
        return {"FINISHED"}

    def _show(self, context) -> None:
        now = NOW.child.progress
        if now == NOW.shown:
            return
        if context.workspace and now.text != NOW.said:
            NOW.said = now.text  # the panel follows at the next look: one drawing at a time
            context.workspace.status_text_set(f"Ringdown: {now.text}   |   Esc: Cancel")
            return
        NOW.shown = now
        redraw(context, everything=False)

    def _end(self, context) -> None:
        timer = getattr(self, "_timer", None)
        if timer is not None:
            context.window_manager.event_timer_remove(timer)
            self._timer = None
        if context.workspace:
            context.workspace.status_text_set(None)
        NOW.child, NOW.what, NOW.stop, NOW.shown, NOW.said = None, "", False, None, ""
        NOW.alone = False
        shutil.rmtree(self._folder, ignore_errors=True)
        redraw(context)


class RINGDOWN_OT_cancel(bpy.types.Operator):
    """Stop what runs, and leave everything as it was"""

    bl_idname = "ringdown.cancel"
    bl_label = "Cancel"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, context):
        return ready.refuse(cls, "" if NOW.child else "Nothing runs")

    def execute(self, context):
        NOW.stop = True
        NOW.child.stop()
        return {"FINISHED"}


def redraw(context, everything: bool = True) -> None:
    """The panels anew, or every 3D view with its overlay."""
    for window in context.window_manager.windows:
        for area in (area for area in window.screen.areas if area.type == "VIEW_3D"):
            for region in area.regions:
                if everything or region.type == "UI":
                    region.tag_redraw()


def settings() -> bpy.types.AddonPreferences | None:
    addon = bpy.context.preferences.addons.get(__package__.rpartition(".")[0])
    return addon.preferences if addon else None


def cache_root() -> str | None:
    """Where folders of a run are made: as preferred, or the system's own place for such."""
    mine = settings()
    chosen = bpy.path.abspath(mine.cache) if mine and mine.cache else ""
    if chosen:
        Path(chosen).mkdir(parents=True, exist_ok=True)
    return chosen or None


def threads() -> int:
    mine = settings()
    return mine.threads if mine else 0


def element() -> str:
    """The preferred element; empty: what the calibration takes by itself."""
    mine = settings()
    return mine.element if mine and mine.element != "AUTO" else ""


def end_all() -> None:
    """For the extension's end: no child outlives it."""
    if NOW.child:
        NOW.child.cancel()
        NOW.child = None
