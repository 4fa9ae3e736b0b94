"""Materials that artists cast and film, each with its source; and one's own, as Blender presets."""

from dataclasses import dataclass

import bpy
from bl_operators.presets import AddPresetBase

from . import ready, words


@dataclass(frozen=True)
class Preset:
    """A stuff out of a table."""

    name: str
    density: float  # kg/m3
    poisson_ratio: float
    modulus: float  # Pa
    source: str


def _rubber(shore_a: int) -> float:
    """Young's modulus (Pa) of a rubber of Shore hardness A, after Gent."""
    return 0.0981e6 * (56 + 7.62336 * shore_a) / (0.137505 * (254 - 2.54 * shore_a))


def _gelatine(percent: float) -> float:
    """Young's modulus (Pa) of gelatine at a mass fraction, after Hall: 3.4 C^2.09 mPa, C in g/l."""
    return 3.4 * (10 * percent) ** 2.09


SMOOTH_ON = "Smooth-On technical bulletin, modulus at 100 %"
GENT = "Gent, Rubber Chem. Technol. 31 (1958) 896, from the hardness"
HALL = "Hall et al., IEEE Trans. UFFC 44 (1997) 1355"
FOAM = "Gibson and Ashby, Cellular Solids (1997), open cells, polyurethane"
PRESETS = {
    "ECOFLEX_10": Preset("Silicone 00-10 (Ecoflex)", 1040, 0.49, 55e3, SMOOTH_ON),
    "ECOFLEX_30": Preset("Silicone 00-30 (Ecoflex)", 1070, 0.49, 69e3, SMOOTH_ON),
    "ECOFLEX_50": Preset("Silicone 00-50 (Ecoflex)", 1070, 0.49, 83e3, SMOOTH_ON),
    "DRAGON_10": Preset("Silicone 10A (Dragon Skin)", 1070, 0.49, 151e3, SMOOTH_ON),
    "DRAGON_20": Preset("Silicone 20A (Dragon Skin)", 1080, 0.49, 338e3, SMOOTH_ON),
    "DRAGON_30": Preset("Silicone 30A (Dragon Skin)", 1080, 0.49, 593e3, SMOOTH_ON),
    "RUBBER_40": Preset("Natural Rubber 40A", 930, 0.495, _rubber(40), GENT),
    "RUBBER_60": Preset("Natural Rubber 60A", 1100, 0.495, _rubber(60), GENT),
    "GELATINE_5": Preset("Gelatine 5 % (jelly)", 1010, 0.495, _gelatine(5), HALL),
    "GELATINE_10": Preset("Gelatine 10 %", 1030, 0.495, _gelatine(10), HALL),
    "FOAM_30": Preset("Soft Foam 30 kg/m³", 30, 0.33, 45e6 * (30 / 1200) ** 2, FOAM),
    "FOAM_60": Preset("Firm Foam 60 kg/m³", 60, 0.33, 45e6 * (60 / 1200) ** 2, FOAM),
}
ITEMS = tuple((key, p.name, f"{p.density} kg/m³, {p.source}") for key, p in PRESETS.items())


class RINGDOWN_OT_material(bpy.types.Operator):
    """Take density, Poisson ratio and expected modulus out of a table"""

    bl_idname = "ringdown.material"
    bl_label = "Material"
    bl_options = {"REGISTER", "UNDO"}
    bl_property = "preset"
    preset: bpy.props.EnumProperty(name="Material", items=ITEMS)

    @classmethod
    def poll(cls, context):
        return ready.refuse(cls, "" if ready.target(context) else "Pick a mesh object first")

    def execute(self, context):
        preset, material = PRESETS[self.preset], ready.target(context).ringdown.material
        material.name, material.source = preset.name, preset.source
        material.density, material.poisson_ratio = preset.density, preset.poisson_ratio
        material.modulus = preset.modulus / 1000
        return {"FINISHED"}


class RINGDOWN_MT_material(bpy.types.Menu):
    bl_label = "Own Materials"
    preset_subdir = "ringdown/material"
    preset_operator = "script.execute_preset"
    draw = bpy.types.Menu.draw_preset


class RINGDOWN_OT_material_save(AddPresetBase, bpy.types.Operator):
    """Keep this material as a preset of your own, with the modulus that was calibrated"""

    bl_idname = "ringdown.material_save"
    bl_label = "Save Material"
    preset_menu = "RINGDOWN_MT_material"
    preset_subdir = "ringdown/material"
    preset_defines = [
        "obj = bpy.context.scene.ringdown_object or bpy.context.object",
        "material = obj.ringdown.material",
    ]
    preset_values = [
        "material.name",
        "material.source",
        "material.density",
        "material.poisson_ratio",
        "material.modulus",
    ]

    @classmethod
    def poll(cls, context):
        return ready.refuse(cls, "" if ready.target(context) else "Pick a mesh object first")

    def pre_cb(self, context):
        settings = ready.target(context).ringdown
        if self.remove_active or not settings.facts.report:
            return
        found = words.report(settings.facts.report)
        settings.material.name = self.name or settings.material.name
        settings.material.modulus = found["youngs_modulus"]["material"]["value"] / 1000
        settings.material.source = f"Calibrated, {found['case']}"


CLASSES = (RINGDOWN_OT_material, RINGDOWN_MT_material, RINGDOWN_OT_material_save)
