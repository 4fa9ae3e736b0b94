"""Every field that case.toml may hold, with its check. README.md says what each one means."""

from .camera_fields import CAMERA_FIELDS
from .case_fields import Field, choice, flag, integers, number, table, tables, text, texts, vector

EFFECT_NAMES = (
    "viscous_damping",
    "structural_damping",
    "relaxation",
    "dry_friction",
    "air_drag",
    "large_amplitude",
    "asymmetric_stiffness",
    "contact",
    "stiffness_drift",
    "compliant_pin",
    "added_mass",
    "graded_stiffness",
    "gravity_preload",
    "poisson_ratio",
    "mesh_stiffening",
    "split_modes",
    "base_motion",
    "steady_drive",
    "rolling_shutter",
    "lost_frames",
    "perspective",
    "tracker_drift",
    "aliasing",
    "clock",
)

GRAVITY = vector(3, high=100, unit="m/s2")
PLACE = vector(3, unit="m")
LOAD_FIELDS = {
    "mass": Field(number(above=0, unit="kg", hint="Weigh it."), required=True),
    "position": Field(PLACE, required=True),
}
OBJECT_FIELDS = {
    "mesh": Field(text(), required=True),
    "length_unit": Field(choice("m", "cm", "mm"), default="m"),
    "density": Field(
        number(low=1, high=30_000, unit="kg/m3", hint="Weigh the object, divide by its volume."),
        required=True,
    ),
    "poisson_ratio": Field(
        number(low=0, below=0.5, hint="For an incompressible body give 0.499."), default=0.48
    ),
    "youngs_modulus": Field(number(above=0, unit="Pa")),
    "gravity": Field(GRAVITY),
    "shape": Field(choice("equilibrium", "unloaded"), default="equilibrium"),
}
BOX_FIELDS = {"min": Field(PLACE, required=True), "max": Field(PLACE, required=True)}
SPHERE_FIELDS = {
    "centre": Field(PLACE, required=True),
    "radius": Field(number(above=0, unit="m"), required=True),
}
PIN_FIELDS = {
    "box": Field(table(BOX_FIELDS)),
    "vertices": Field(integers()),
    "sphere": Field(table(SPHERE_FIELDS)),
}
RECORDING_FIELDS = {
    "tracks": Field(text()),
    "video": Field(text()),
    "capture_fps": Field(
        number(low=1, high=1e6, unit="frames per second", hint="Give the camera's real rate.")
    ),
    "start": Field(number(unit="s")),
    "stop": Field(number(unit="s")),
}
TAKE_FIELDS = RECORDING_FIELDS | {
    "held_out": Field(flag(), default=False),
    "load": Field(tables(LOAD_FIELDS)),
    "gravity": Field(GRAVITY),
}
MARKER_FIELDS = {
    "name": Field(text(), required=True),
    "position": Field(PLACE, required=True),
    "on": Field(choice("object", "support"), default="object"),
    "pixel": Field(vector(2, unit="px")),
}
CASE_FIELDS = {
    "name": Field(text(), required=True),
    "object": Field(table(OBJECT_FIELDS), required=True),
    "pin": Field(tables(PIN_FIELDS, fewest=1), required=True),
    "load": Field(tables(LOAD_FIELDS), default=()),
    "model": Field(table({"declared": Field(texts(EFFECT_NAMES), default=())})),
    "recording": Field(table(RECORDING_FIELDS), required=True),
    "take": Field(tables(TAKE_FIELDS), default=()),
    "camera": Field(table(CAMERA_FIELDS)),
    "marker": Field(tables(MARKER_FIELDS, fewest=1), required=True),
}
