"""What all panels of the tab have in common. Nothing is worked out in them, only shown."""

import blf
import bpy

from . import ready, words
from .job import NOW

MARGIN, ICON = 60, 22  # px at scale 1: what a panel leaves free beside a label; an icon


def say(layout, text: str, icon: str = "NONE") -> None:
    """Text in as many lines as the sidebar needs, the icon before the first."""
    column = layout.column(align=True)
    room = bpy.context.region.width - scale() * (MARGIN + (ICON if icon != "NONE" else 0))
    blf.size(0, bpy.context.preferences.ui_styles[0].widget.points * scale())
    lines = words.wrapped(text, room, lambda line: blf.dimensions(0, line)[0])
    for k, line in enumerate(lines):
        column.label(text=line, icon=icon if k == 0 else ("BLANK1" if icon != "NONE" else "NONE"))


def scale() -> float:
    return bpy.context.preferences.system.ui_scale


def needs(layout, why: str) -> None:
    """The one line that says what a step still needs."""
    if why:
        say(layout, why, "INFO")


def fact(layout, name: str, value: str) -> None:
    """A name on the left, its value on the right, as properties are laid out."""
    split = layout.split(factor=0.4)
    left = split.column()
    left.alignment = "RIGHT"
    left.label(text=name)
    split.label(text=value)


class Step:
    """What all panels of the tab have in common."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Ringdown"


class SubStep(Step):
    bl_parent_id = "RINGDOWN_PT_main"
    runs = False  # shown while a calibration runs, when nothing else can be changed
    late = False  # belongs to the result, and stays when only that is to be seen

    @classmethod
    def poll(cls, context):
        obj = ready.target(context)
        if obj is None:
            return False
        if NOW.child is not None and NOW.alone:
            return cls.runs
        return cls.late or not (context.window_manager.ringdown_short and obj.ringdown.facts.report)

    def draw(self, context):
        self.layout.use_property_split = True
        self.layout.use_property_decorate = False
        self.fill(context, self.layout, ready.target(context))
