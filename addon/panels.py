"""The tab: one sub-panel per step. Nothing is worked out here, only shown."""

import bpy
from bpy.utils import units

from . import marks, operators_recording, ready, words
from .job import NOW


def say(layout, text: str, icon: str = "NONE", width: int = 0) -> None:
    """Text in as many lines as the sidebar needs, the icon before the first."""
    column = layout.column(align=True)
    width = width or max(
        20, int(bpy.context.region.width / (6.5 * scale())) - (6 if icon != "NONE" else 4)
    )
    for k, line in enumerate(words.wrapped(text, width)):
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

    @classmethod
    def poll(cls, context):
        return ready.target(context) is not None

    def draw(self, context):
        self.layout.use_property_split = True
        self.layout.use_property_decorate = False
        self.fill(context, self.layout, ready.target(context))


class RINGDOWN_PT_main(Step, bpy.types.Panel):
    bl_label = "Ringdown"

    def draw(self, context):
        layout = self.layout
        row = layout.row(align=True)
        row.prop(context.scene, "ringdown_object", text="", icon="OBJECT_DATA")
        row.operator("ringdown.use", text="", icon="EYEDROPPER")
        if ready.target(context) is None:
            needs(layout, ready.for_object(context))
        elif context.scene.ringdown_object is None:
            layout.label(text=f"Active: {context.object.name}", icon="OBJECT_DATA")
        layout.operator("ringdown.case_open", icon="FILE_FOLDER")


class RINGDOWN_PT_object(SubStep, bpy.types.Panel):
    bl_label = "Object"

    def fill(self, context, layout, obj):
        material, facts = obj.ringdown.material, obj.ringdown.facts
        row = layout.row(align=True)
        row.operator_menu_enum("ringdown.material", "preset", text=material.name or "Material")
        row.menu("RINGDOWN_MT_material", text="", icon="PRESET")
        row.operator("ringdown.material_save", text="", icon="ADD")
        column = layout.column()
        column.prop(material, "density", text="Density kg/m³")
        column.prop(material, "poisson_ratio")
        column.prop(material, "modulus", text="Expected kPa")
        if material.source:
            say(layout, material.source, "BOOKMARKS")
        self.sizes(context, layout, obj, facts)

    def sizes(self, context, layout, obj, facts):
        system = context.scene.unit_settings.system
        metre = context.scene.unit_settings.scale_length if system != "NONE" else 1.0
        system = "METRIC" if system == "NONE" else system
        column = layout.column(align=True)
        fact(column, "Size", words.size([d * metre for d in obj.dimensions], system))
        if not facts.look or ready.stale(obj, facts.look):
            layout.operator("ringdown.measure", text="Measure Volume and Mass")
            return
        mass = facts.volume * obj.ringdown.material.density
        fact(column, "Volume", units.to_string(system, "VOLUME", facts.volume, precision=3))
        fact(column, "Mass", units.to_string(system, "MASS", mass, precision=3))
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
        needs(layout, ready.for_recording(context))
        self.clock(context, layout, recording)
        layout.operator("ringdown.read", icon="FILE_REFRESH")
        if recording.found:
            say(layout, f"{recording.found}, {recording.seconds:.3g} s")
        if obj.ringdown.points:
            self.points(context, layout, obj)
        self.free_part(layout, recording)
        self.camera(layout, recording)

    def clock(self, context, layout, recording):
        if recording.source == "CSV":
            if recording.found and not recording.timed:
                layout.prop(recording, "capture_fps", text="Captured At")
            return
        plays = operators_recording.playback(context, recording)
        layout.prop(recording, "capture_fps", text="Captured At")
        fact(layout, "Plays At", f"{plays:g}, {recording.capture_fps / plays:.3g} × slower")
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
        row = layout.row(heading="Free Part")
        row.prop(recording, "own_range", text="Set")
        row.operator("ringdown.free_part", text="Find", icon="VIEWZOOM")
        if recording.own_range:
            column = layout.column(align=True)
            column.prop(recording, "start")
            column.prop(recording, "stop")
        else:
            fact(layout, "", "Found while calibrating")

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
                layout.prop(recording, "length_px")
        column = layout.column(heading="Weight")
        column.prop(recording, "gravity")
        if recording.gravity:
            column.prop(recording, "unloaded")


class RINGDOWN_PT_calibrate(SubStep, bpy.types.Panel):
    bl_label = "Calibrate"

    def fill(self, context, layout, obj):
        if NOW.child:
            told = NOW.child.progress
            layout.progress(factor=told.fraction, text=f"{told.fraction:.0%}")
            say(layout, told.text)
            layout.operator("ringdown.cancel", icon="X")
            return
        column = layout.column()
        column.scale_y = 1.4
        column.operator("ringdown.calibrate", icon="PLAY")
        needs(layout, ready.for_calibration(context))


class RINGDOWN_PT_result(SubStep, bpy.types.Panel):
    bl_label = "Result"

    def fill(self, context, layout, obj):
        facts = obj.ringdown.facts
        if not facts.report:
            needs(layout, ready.for_result(context))
            return
        report = words.report(facts.report)
        icon, line = words.VERDICTS[report["diagnosis"]["verdict"]]
        say(layout, line, icon)
        self.found(layout, report["diagnosis"])
        self.modes(layout, report)
        self.numbers(layout, report)
        row = layout.row(align=True)
        row.operator("ringdown.picture", text="Picture", icon="IMAGE_DATA")
        row.use_property_split = False
        row.prop(obj.ringdown, "show_ghost", text="Markers", toggle=True, icon="GHOST_ENABLED")
        row = layout.row(align=True)
        row.operator("ringdown.export_report", text="Report", icon="EXPORT")
        row.operator("ringdown.export", text="Case", icon="EXPORT")
        self.next(layout, report)

    def found(self, layout, diagnosis):
        for effect in diagnosis["effects"]:
            say(layout, words.effect(effect), "DOT")
            if effect["twins"]:
                twins = " or ".join(words.name(twin) for twin in effect["twins"])
                say(layout, f"This film cannot tell it from {twins}", "BLANK1")

    def modes(self, layout, report):
        box = layout.box().column(align=True)
        row = box.row()
        for text in ("Measured", "Computed", "Damping"):
            row.label(text=text)
        for mode in report["modes"]:
            row = box.row()
            row.label(text=f"{mode['natural_frequency_hz']['value']:.2f} Hz")
            computed = mode["model_frequency_hz"]
            row.label(text=f"{computed:.2f} Hz" if computed else "none")
            row.label(text=words.share(mode["damping_ratio"]["value"]))

    def numbers(self, layout, report):
        column = layout.column(align=True)
        stiffness, error = report["youngs_modulus"], report["error"]
        for name, key in (("Mesh Needs", "apparent"), ("Material", "material")):
            if stiffness.get(key):
                fact(column, name, words.modulus(stiffness[key]))
        if error["after"] is not None and error["before"] is not None:
            fact(
                column,
                "Held-Out Error",
                f"{words.share(error['before'])}, now {words.share(error['after'])}",
            )

    def next(self, layout, report):
        for advice in report["diagnosis"]["advice"]:
            say(layout, words.sentence(advice), "LIGHT")
        for warning in report["warnings"]:
            say(layout, words.sentence(warning), "ERROR")


class RINGDOWN_PT_bake(SubStep, bpy.types.Panel):
    bl_label = "Bake"

    def fill(self, context, layout, obj):
        bake = obj.ringdown.bake
        layout.prop(bake, "motion", expand=True)
        if bake.motion == "PLUCKED":
            row = layout.row(align=True)
            row.prop(bake, "vertex")
            row.operator("ringdown.pluck", text="", icon="EYEDROPPER")
            layout.prop(bake, "pull")
            if (
                obj.ringdown.facts.report
                and words.report(obj.ringdown.facts.report)["diagnosis"]["effects"]
            ):
                say(layout, "The modes alone; what else was found is in Recorded", "INFO")
        layout.prop(bake, "target", expand=True)
        column = layout.column(align=True)
        column.prop(bake, "first")
        column.prop(bake, "to_end")
        if not bake.to_end:
            column.prop(bake, "last")
        layout.prop(bake, "amplitude")
        layout.prop(bake, "count")
        row = layout.row(align=True)
        row.operator(
            "ringdown.bake", text="Bake Again" if marks.RECORD in obj else "Bake", icon="ACTION"
        )
        row.operator("ringdown.remove", icon="X")
        done = ready.baked(obj, context.scene)
        if done:
            say(layout, done, "CHECKMARK")
        needs(layout, ready.for_bake(context))


CLASSES = (
    RINGDOWN_UL_points,
    RINGDOWN_PT_main,
    RINGDOWN_PT_object,
    RINGDOWN_PT_resolution,
    RINGDOWN_PT_pins,
    RINGDOWN_PT_recording,
    RINGDOWN_PT_calibrate,
    RINGDOWN_PT_result,
    RINGDOWN_PT_bake,
)
