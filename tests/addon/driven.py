"""Driving the panel: a quick stand-in for the calibration, and the file's data to compare."""

import base64
import zlib

import bpy
import pytest

FAKE = """
import json, sys
from pathlib import Path
import numpy as np
import time
folder, verb = Path(sys.argv[1]), sys.argv[2]
if verb == "refuse":
    print("recording: it lasts 0.1 s, 1 period; 2 are needed. Record longer.", file=sys.stderr)
    sys.exit(2)
surface = np.load(folder / "surface.npz")
vertices = surface["vertices"]
time_ = np.linspace(0, 1, 400)
shape = np.zeros((len(vertices), 3, 1))
shape[:, 1, 0] = (vertices[:, 0] - vertices[:, 0].min()) ** 2 * 50
wave = 0.1 * np.exp(-2 * time_) * np.cos(2 * np.pi * 5 * time_)
np.savez(folder / "motion.npz", names=np.array(["mode 1: 5 Hz"]), shapes=shape, time=time_,
    weights=wave[:, None], modal_mass=np.array([0.7]),
    clock=time_, measured=np.ones((400, 1, 3)), predicted=np.zeros((400, 1, 3)))
est = lambda x: {"value": x, "ci95": [0.9 * x, 1.1 * x]}
(folder / "report.json").write_text(json.dumps({
    "case": "bar", "version": "0", "seconds": 1.0,
    "mesh": {"nodes": 1, "tets": 1, "element": "p1", "stiffening": 0.1},
    "youngs_modulus": {"apparent": {**est(9e4), "unit": "Pa"},
                       "material": {**est(1e5), "unit": "Pa"}},
    "modes": [{"natural_frequency_hz": est(5.0), "damping_ratio": est(0.06), "amplitude_m": 0.01,
               "model_frequency_hz": 5.0, "mac": 0.99}],
    "error": {"floor": 0.01, "before": 0.2, "after": 0.02, "chain": []},
    "diagnosis": {"verdict": "explained", "effects": [], "ranking": [], "budget": {}, "advice": [],
                  "minor": []},
    "warnings": []}))
"""


def select(obj, chosen):
    for vertex in obj.data.vertices:
        vertex.select = chosen(vertex.co)


def hold(obj):
    select(obj, lambda co: co.x < 0.001)
    assert bpy.ops.ringdown.pins() == {"FINISHED"}


def record(obj, tmp_path):
    obj.ringdown.recording.source = "CSV"
    obj.ringdown.recording.path = str(tmp_path / "tracks.csv")
    assert bpy.ops.ringdown.read() == {"FINISHED"}


def prepared(obj, tmp_path):
    bpy.ops.ringdown.use()
    hold(obj)
    record(obj, tmp_path)


def message(operator):
    with pytest.raises(RuntimeError) as refusal:
        operator()
    return str(refusal.value)


def values(group):
    """All properties of a group, nested ones too."""
    found = {}
    for name, rna in group.bl_rna.properties.items():
        if name == "rna_type" or (rna.type == "POINTER" and name not in group_names(group)):
            continue
        value = getattr(group, name)
        if rna.type == "COLLECTION":
            found[name] = [values(item) for item in value]
        elif rna.type == "POINTER":
            found[name] = (
                values(value) if hasattr(value, "bl_rna") and "PG" in str(value) else str(value)
            )
        else:
            found[name] = tuple(value) if getattr(rna, "is_array", False) else value
    return found


def group_names(group):
    return {"material", "recording", "facts", "bake"}


def state():
    """The file's data: every object's settings, shape keys, groups, modifiers; every data-block."""
    found = {"blocks": {kind: sorted(b.name for b in getattr(bpy.data, kind)) for kind in KINDS}}
    for obj in bpy.data.objects:
        keys = obj.data.shape_keys
        found[obj.name] = {
            "settings": values(obj.ringdown),
            "baked": dict(obj["ringdown_bake"]) if "ringdown_bake" in obj else None,
            "keys": [(b.name, b.value, [tuple(p.co) for p in b.points]) for b in keys.key_blocks]
            if keys
            else None,
            "groups": [g.name for g in obj.vertex_groups],
            "weights": [[(g.group, g.weight) for g in v.groups] for v in obj.data.vertices],
            "modifiers": [(m.name, m.type) for m in obj.modifiers],
            "places": [tuple(v.co) for v in obj.data.vertices],
        }
    picked = bpy.context.scene.ringdown_object
    found["scene"] = picked.name if picked else None
    return found


KINDS = ("objects", "meshes", "actions", "images", "shape_keys", "movieclips")


def png(tmp_path):
    """A small picture as the object keeps it."""
    image = bpy.data.images.new("small", 4, 4)
    image.filepath_raw, image.file_format = str(tmp_path / "small.png"), "PNG"
    image.save()
    bpy.data.images.remove(image)
    data = (tmp_path / "small.png").read_bytes()
    return base64.b64encode(zlib.compress(data)).decode()
