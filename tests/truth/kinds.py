"""What can be made: single effects, nothing, pairs, strangers, honest twins, traps."""

import zlib

EFFECTS = (
    "viscous_damping", "structural_damping", "relaxation", "dry_friction", "air_drag",
    "large_amplitude", "asymmetric_stiffness", "contact", "stiffness_drift", "compliant_pin",
    "added_mass", "graded_stiffness", "gravity_preload", "poisson_ratio", "mesh_stiffening",
    "split_modes", "base_motion", "steady_drive", "rolling_shutter", "lost_frames", "perspective",
    "tracker_drift", "aliasing", "clock",
)  # fmt: skip
PAIRS = (
    "added_mass+relaxation", "relaxation+large_amplitude", "dry_friction+stiffness_drift",
    "steady_drive+air_drag", "contact+tracker_drift", "compliant_pin+dry_friction",
    "base_motion+large_amplitude", "lost_frames+relaxation", "asymmetric_stiffness+air_drag",
    "steady_drive+stiffness_drift", "relaxation+dry_friction", "large_amplitude+tracker_drift",
)  # fmt: skip
ABSENT = (
    "tuned_absorber", "sudden_crack", "stick_slip", "intermittent_touch", "pumped_stiffness",
    "eddy_brake",
)  # fmt: skip
TWINS = {
    "large_amplitude|stiffness_drift": {
        "snr": (20, 26),
        "damping": (0.04, 0.06),
        "markers": (3, 5),
    },
    "added_mass|graded_stiffness": {"snr": (28, 34), "markers": (3, 4), "takes": 1},
    "contact|asymmetric_stiffness": {"snr": (20, 28), "gapless": True, "release": "pull"},
    "relaxation|base_motion": {"markers": (2, 4), "support": 0.0, "snr": (20, 30), "cluster": True},
    "compliant_pin|graded_stiffness": {"snr": (28, 34), "markers": (3, 4), "takes": 1},
}
TRAPS = ("clock", "density", "loss", "exposure")
IN_PLANE = {  # not along a line: what rubs whichever way its place goes, a support that goes two
    "plane:dry_friction": {},
    "plane:base_motion": {"support": 1.0},
}
KINDS = (
    "null", *EFFECTS, *IN_PLANE, *(f"two:{p}" for p in PAIRS), *(f"absent:{a}" for a in ABSENT),
    *(f"twin:{t}" for t in TWINS), *(f"trap:{t}" for t in TRAPS),
)  # fmt: skip


def planted_in(kind: str, seed: int) -> list:
    """Names of the effects that a case of `kind` and `seed` plants."""
    if kind == "null":
        return []
    what = kind.split(":")[-1]
    return [what.split("|")[seed % 2]] if "|" in what else what.split("+")


def number(kind: str) -> int:
    return zlib.crc32(kind.encode())


def cases(subset: str = "quick", seed: int = 1, kinds=KINDS) -> list:
    """(kind, seed): "quick" one of each, "whole" 4 of each effect, 20 nulls and 10 of the rest.

    Consecutive seeds of one kind take consecutive objects.
    """
    few = {"two": 1, "absent": 3, "twin": 2, "trap": 3}
    out = []
    for kind in kinds:
        count = 20 if kind == "null" else few.get(kind.split(":")[0], 4)
        out += [(kind, seed + n) for n in range(1 if subset == "quick" else count)]
    return out
