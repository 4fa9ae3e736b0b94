"""What Blender is told of us, and takes back."""

import bpy
from bpy.props import EnumProperty, IntProperty, StringProperty

from . import (
    materials,
    open_case,
    operators_bake,
    operators_object,
    operators_place,
    operators_recording,
    operators_run,
    overlay,
    panels,
    panels_result,
    properties,
    running,
)


class RINGDOWN_AP_preferences(bpy.types.AddonPreferences):
    bl_idname = __package__.rpartition(".")[0]

    cache: StringProperty(
        name="Cache Folder",
        description="For point caches and running calibrations. Empty: beside the file, and the "
        "system's temporary folder",
        subtype="DIR_PATH",
    )
    threads: IntProperty(
        name="Threads", description="Of a calibration; 0: as many as there are", default=0, min=0
    )
    element: EnumProperty(
        name="Element",
        items=(
            ("AUTO", "Default", "What the calibration takes by itself"),
            ("p1", "Linear", "Stiff, quick"),
            ("p2", "Quadratic", "True, slower"),
        ),
    )

    def draw(self, _context):
        self.layout.use_property_split = True
        for name in ("cache", "threads", "element"):
            self.layout.prop(self, name)


CLASSES = (
    RINGDOWN_AP_preferences,
    *materials.CLASSES,
    *operators_object.CLASSES,
    *operators_recording.CLASSES,
    *operators_place.CLASSES,
    *open_case.CLASSES,
    *operators_run.CLASSES,
    *operators_bake.CLASSES,
    *panels.CLASSES,
    *panels_result.CLASSES,
)
_command = None


def command(argv: list[str]) -> int:
    """`blender -c ringdown CASE.toml ...`"""
    from . import batch

    return batch.main(argv)


def register():
    global _command
    properties.register()
    for one in CLASSES:
        bpy.utils.register_class(one)
    overlay.register()
    _command = bpy.utils.register_cli_command("ringdown", command)


def unregister():
    running.end_all()
    bpy.utils.unregister_cli_command(_command)
    overlay.unregister()
    for one in reversed(CLASSES):
        bpy.utils.unregister_class(one)
    properties.unregister()
