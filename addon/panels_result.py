"""The tab, second half: calibrate, result and bake."""

import bpy

from . import marks, ready, words
from .job import NOW
from .layout import SubStep, fact, needs, say


class RINGDOWN_PT_calibrate(SubStep, bpy.types.Panel):
    bl_label = "Calibrate"
    runs = late = True

    def fill(self, context, layout, obj):
        if NOW.child:
            told = NOW.child.progress
            layout.progress(factor=told.fraction, text=f"{100 * told.fraction:.0f} %")
            say(layout, told.text)
            layout.operator("ringdown.cancel", icon="X")
            return
        column = layout.column()
        column.scale_y = 1.4
        column.operator("ringdown.calibrate", icon="PLAY")
        needs(layout, ready.for_calibration(context))


class RINGDOWN_PT_result(SubStep, bpy.types.Panel):
    bl_label = "Result"
    late = True

    def fill(self, context, layout, obj):
        facts = obj.ringdown.facts
        if not facts.report:
            needs(layout, ready.for_result(context))
            return
        report = words.report(facts.report)
        icon, line = words.VERDICTS[report["diagnosis"]["verdict"]]
        say(layout, line, icon)
        self.found(layout, report["diagnosis"])
        self.modes(layout, report["modes"])
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
            column = layout.column(align=True)
            say(column, words.effect(effect), "DOT")
            for label, value in words.numbers(effect):
                fact(column, label, value)
            if effect["twins"]:
                twins = " or ".join(words.name(twin) for twin in effect["twins"])
                say(layout, f"This film cannot tell it from {twins}", "BLANK1")

    def modes(self, layout, modes):
        box = layout.box().column(align=True)
        if not modes:
            box.label(text="No mode was found")
            return
        row = box.row()
        for text in ("Measured", "Computed", "Damping"):
            row.label(text=text)
        for mode in sorted(modes, key=lambda mode: mode["natural_frequency_hz"]["value"]):
            row = box.row()
            row.label(text=f"{mode['natural_frequency_hz']['value']:.2f} Hz")
            computed = mode["model_frequency_hz"]
            row.label(text=f"{computed:.2f} Hz" if computed else "none")
            row.label(text=words.share(mode["damping_ratio"]["value"]))

    def numbers(self, layout, report):
        column = layout.column(align=True)
        stiffness, error = report["youngs_modulus"], report["error"]
        for name, key in (("Modulus", "material"), ("On This Mesh", "apparent")):
            if stiffness.get(key):
                fact(column, name, words.modulus(stiffness[key]))
        if error["after"] is not None and error["before"] is not None:
            was, now = words.share(error["before"]), words.share(error["after"])
            fact(column, "Held-Out Error", now if was == now else f"{was}, now {now}")
        if error["floor"] is not None:
            fact(column, "Noise", words.share(error["floor"]))

    def next(self, layout, report):
        for warning in report["warnings"]:
            say(layout, words.sentence(warning), "ERROR")
        if report["diagnosis"]["advice"]:
            layout.label(text="To know more:")
        for advice in report["diagnosis"]["advice"]:
            say(layout, words.sentence(advice), "LIGHT")


class RINGDOWN_PT_bake(SubStep, bpy.types.Panel):
    bl_label = "Bake"
    late = True

    def fill(self, context, layout, obj):
        bake = obj.ringdown.bake
        layout.prop(bake, "motion", expand=True)
        if bake.motion == "PLUCKED":
            row = layout.row(align=True)
            if bake.vertex < 0:
                row.operator("ringdown.pluck", icon="EYEDROPPER")
            else:
                row.prop(bake, "vertex")
                row.operator("ringdown.pluck", text="", icon="EYEDROPPER")
            layout.prop(bake, "pull")
            if (
                obj.ringdown.facts.report
                and words.report(obj.ringdown.facts.report)["diagnosis"]["effects"]
            ):
                say(layout, "Plays the modes alone; Recorded has what else was found", "INFO")
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


CLASSES = (RINGDOWN_PT_calibrate, RINGDOWN_PT_result, RINGDOWN_PT_bake)
