"""The tab, first half: object, resolution, pins and recording."""

import bpy
from bpy.utils import units

from . import operators_recording, ready, words
from .job import NOW
from .layout import Step, SubStep, fact, needs, say

LARGE = 1.0  # m: few soft things that are filmed wobbling are so large; Blender's own cube is


class RINGDOWN_PT_main(Step, bpy.types.Panel):
    bl_label = "Ringdown"

    def draw(self, context):
        layout = self.layout
        layout.enabled = NOW.child is None
        row = layout.row(align=True)
        row.prop(context.scene, "ringdown_object", text="", icon="OBJECT_DATA")
        picked, active = context.scene.ringdown_object, context.object
        if ready.target(context) is None:
            needs(layout, ready.for_object(context))
        elif picked is None:
            layout.operator("ringdown.use", text=f"Use {active.name}", icon="OBJECT_DATA")
        elif active is not None and active.type == "MESH" and active != picked:
            row.operator("ringdown.use", text="", icon="FILE_REFRESH")
        row = layout.row(align=True)
        row.operator("ringdown.case_open", icon="FILE_FOLDER")
        target = ready.target(context)
        if target and target.ringdown.facts.report:
            row.prop(context.window_manager, "ringdown_short", toggle=True, icon="COLLAPSEMENU")


class RINGDOWN_PT_object(SubStep, bpy.types.Panel):
    bl_label = "Object"

    def fill(self, context, layout, obj):
        material, facts = obj.ringdown.material, obj.ringdown.facts
        row = layout.row(align=True)
        row.operator_menu_enum("ringdown.material", "preset", text=material.name or "Material")
        row.menu("RINGDOWN_MT_material", text="", icon="PRESET")
        row.operator("ringdown.material_save", text="", icon="ADD")
        column = layout.column()
        column.prop(material, "density", text="Density (kg/m³)")
        column.prop(material, "poisson_ratio")
        column.prop(material, "modulus", text="Modulus (kPa)")
        if material.source:
            say(layout, material.source, "BOOKMARKS")
        self.sizes(context, layout, obj, facts)

    def sizes(self, context, layout, obj, facts):
        system = context.scene.unit_settings.system
        system = "METRIC" if system == "NONE" else system
        if not facts.look or ready.stale(obj, facts.look):
            layout.operator("ringdown.measure", text="Measure", icon="DRIVER_DISTANCE")
            return
        column = layout.column(align=True)
        fact(column, "Size", words.size(list(facts.size), system))
        mass = facts.volume * obj.ringdown.material.density
        fact(column, "Volume", units.to_string(system, "VOLUME", facts.volume, precision=3))
        fact(column, "Mass", units.to_string(system, "MASS", mass, precision=3))
        if max(facts.size) >= LARGE:
            needs(layout, "So large? Scale it to its true size")
        if not facts.closed:
            say(layout, "The mesh is not closed: the volume is that of its tetrahedra", "INFO")


class RINGDOWN_PT_resolution(SubStep, bpy.types.Panel):
    bl_label = "Resolution"

    def fill(self, context, layout, obj):
        facts = obj.ringdown.facts
        layout.prop(obj.ringdown, "elements")
        row = layout.row(align=True)
        row.operator(
            "ringdown.cage", text="Build Again" if facts.cage else "Build", icon="MESH_ICOSPHERE"
        )
        row.prop(
            obj.ringdown,
            "show_cage",
            text="",
            icon="HIDE_OFF" if obj.ringdown.show_cage else "HIDE_ON",
        )
        if not facts.cage:
            needs(layout, "Not built yet; Calibrate does it too")
            return
        for line in facts.cage_says.split("\n"):
            say(layout, line)
        if ready.stale(obj, facts.cage_look):
            say(layout, "The mesh has changed since: build again", "ERROR")


class RINGDOWN_PT_pins(SubStep, bpy.types.Panel):
    bl_label = "Pins"

    def fill(self, context, layout, obj):
        facts = obj.ringdown.facts
        row = layout.row(align=True)
        row.prop_search(obj.ringdown, "pins", obj, "vertex_groups", text="Held")
        row.prop(
            obj.ringdown,
            "show_pins",
            text="",
            icon="HIDE_OFF" if obj.ringdown.show_pins else "HIDE_ON",
        )
        layout.operator("ringdown.pins", icon="PINNED")
        needs(layout, ready.for_pins(context))
        if facts.pins:
            say(layout, facts.pins)
        if facts.pins_small:
            say(
                layout,
                "So small a hold makes the answer depend on the mesh. Hold a larger area",
                "ERROR",
            )


class RINGDOWN_UL_points(bpy.types.UIList):
    def draw_item(self, _context, layout, _data, item, _icon, _active, _property, _index):
        layout.label(text=item.name, icon="CHECKMARK" if item.placed else "RADIOBUT_OFF")
        layout.prop(
            item, "support", text="", icon="PINNED" if item.support else "UNPINNED", emboss=False
        )


class RINGDOWN_PT_recording(SubStep, bpy.types.Panel):
    bl_label = "Recording"

    def fill(self, context, layout, obj):
        recording = obj.ringdown.recording
        layout.prop(recording, "source", expand=True)
        if recording.source == "CSV":
            layout.prop(recording, "path")
        else:
            layout.use_property_split = False
            layout.template_ID(recording, "clip", open="clip.open")
            layout.use_property_split = True
            if recording.clip:
                layout.operator("ringdown.clip_editor", icon="TRACKER")
        needs(layout, ready.for_recording(context))
        self.clock(context, layout, recording)
        layout.operator("ringdown.read", icon="FILE_REFRESH")
        if recording.found:
            say(layout, f"{recording.found}, {recording.frames / recording.capture_fps:.3g} s")
        elif not ready.for_recording(context):
            needs(layout, "Not read yet")
        if obj.ringdown.points:
            self.points(context, layout, obj)
        self.free_part(layout, recording)
        self.camera(layout, recording)

    def clock(self, context, layout, recording):
        if recording.source == "CSV":
            if recording.found and not recording.timed:
                layout.prop(recording, "capture_fps", text="Captured (fps)")
            return
        plays = operators_recording.playback(context, recording)
        layout.prop(recording, "capture_fps", text="Captured (fps)")
        fact(layout, "Plays (fps)", f"{plays:g}, {recording.capture_fps / plays:.3g} × slower")
        row = layout.row(align=True)
        for factor in (1, 2, 4, 8, 16, 32):
            row.operator("ringdown.slow_motion", text=f"{factor}×").factor = factor

    def points(self, context, layout, obj):
        row = layout.row()
        row.template_list(
            "RINGDOWN_UL_points",
            "",
            obj.ringdown,
            "points",
            obj.ringdown,
            "point",
            rows=3,
            maxrows=4,
        )
        layout.operator("ringdown.place", icon="RESTRICT_SELECT_OFF")
        needs(layout, ready.for_points(context))

    def free_part(self, layout, recording):
        column = layout.column(align=True)
        for end, heading in (("start", "Release"), ("stop", "Stop")):
            row = column.row(align=True, heading=heading)
            row.prop(recording, f"own_{end}", text="")
            if getattr(recording, f"own_{end}"):
                row.prop(recording, end, text="")
            else:
                row.label(text="Automatic")
        if recording.source != "VIDEO":
            layout.operator("ringdown.free_part", icon="VIEWZOOM")

    def camera(self, layout, recording):
        if recording.case_file:
            row = layout.row(align=True)
            row.prop(recording, "case_file", text="From Case")
            return
        if not recording.solid:
            layout.prop(recording, "scale")
            if recording.scale != "CAMERA":
                layout.prop(recording, "view")
            if recording.scale == "LENGTH":
                layout.prop(recording, "length")
                layout.prop(recording, "length_px", text="Seen As (px)")
        column = layout.column(heading="Own Weight")
        column.prop(recording, "gravity")
        if recording.gravity:
            column.prop(recording, "unloaded")


CLASSES = (
    RINGDOWN_UL_points,
    RINGDOWN_PT_main,
    RINGDOWN_PT_object,
    RINGDOWN_PT_resolution,
    RINGDOWN_PT_pins,
    RINGDOWN_PT_recording,
)
