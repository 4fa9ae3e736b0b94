"""Every operator as the panel calls it, from an empty scene to a baked object."""

import json
import tomllib
from pathlib import Path

import bpy
import numpy as np
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
    weights=wave[:, None],
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


@pytest.fixture
def bar(rd, tmp_path):
    """A bar held at one end, and a table of its tip's ring-down; everything but the calibration."""
    bpy.ops.mesh.primitive_cube_add(size=1)
    obj = bpy.context.object
    for vertex in obj.data.vertices:
        vertex.co = vertex.co[0] * 0.1 + 0.05, vertex.co[1] * 0.02, vertex.co[2] * 0.02
    time = np.linspace(0, 2, 481)
    wave = 0.005 * np.exp(-2 * time) * np.cos(2 * np.pi * 5 * time)
    rows = [
        "time,tip.x,tip.y,tip.z",
        *(f"{t},0.1,{w},0.01" for t, w in zip(time, wave, strict=True)),
    ]
    (tmp_path / "tracks.csv").write_text("\n".join(rows))
    (tmp_path / "fake.py").write_text(FAKE)
    bpy.ops.ed.undo_push(message="start")
    return obj


@pytest.fixture
def fake(rd, tmp_path, monkeypatch):
    """A calibration that answers at once; the real one has tests of its own."""

    def use(verb):
        line = lambda case, folder, elements: [str(tmp_path / "fake.py"), str(folder), verb]  # noqa: E731
        monkeypatch.setattr(rd.job, "calibration", line)

    use("finish")
    return use


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


def test_from_an_empty_scene_to_a_baked_object(bar, fake, tmp_path):
    assert bpy.ops.ringdown.use() == {"FINISHED"}
    assert np.isclose(bar.ringdown.facts.volume, 0.1 * 0.02**2)
    assert bpy.ops.ringdown.material(preset="ECOFLEX_30") == {"FINISHED"}
    assert bar.ringdown.material.density == 1070
    hold(bar)
    assert "4 vertices" in bar.ringdown.facts.pins
    record(bar, tmp_path)
    assert [p.name for p in bar.ringdown.points] == ["tip"]
    assert np.allclose(bar.ringdown.points[0].position, (0.1, 0, 0.01), atol=2e-4)
    assert bpy.ops.ringdown.calibrate() == {"FINISHED"}
    assert json.loads(bar.ringdown.facts.report)["diagnosis"]["verdict"] == "explained"
    bar.ringdown.bake.first = 3
    assert bpy.ops.ringdown.bake() == {"FINISHED"}
    bpy.context.scene.frame_set(3)
    moved = bar.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.vertices
    tip = max(range(8), key=lambda i: bar.data.vertices[i].co.x)
    assert np.isclose(moved[tip].co.y - bar.data.vertices[tip].co.y, 0.1 * 0.1**2 * 50, rtol=1e-4)
    assert bpy.ops.ringdown.remove() == {"FINISHED"}
    assert bar.data.shape_keys is None


def message(operator):
    with pytest.raises(RuntimeError) as refusal:
        operator()
    return str(refusal.value)


def test_each_missing_step_is_named(bar, fake, tmp_path):
    bpy.context.view_layer.objects.active = None
    assert "Pick a mesh" in message(bpy.ops.ringdown.calibrate)
    assert "active" in message(bpy.ops.ringdown.use)
    bpy.context.view_layer.objects.active = bar
    assert "what is held" in message(bpy.ops.ringdown.calibrate)
    hold(bar)
    assert "movie clip" in message(bpy.ops.ringdown.calibrate)
    bar.ringdown.recording.source = "CSV"
    assert "table" in message(bpy.ops.ringdown.read)
    bar.ringdown.recording.path = str(tmp_path / "tracks.csv")
    assert "Read the recording" in message(bpy.ops.ringdown.calibrate)
    bpy.ops.ringdown.read()
    bar.ringdown.points[0].placed = False
    assert 'Place "tip"' in message(bpy.ops.ringdown.calibrate)
    assert bpy.ops.ringdown.place(index=0, position=(0.1, 0, 0.01)) == {"FINISHED"}
    for late in (bpy.ops.ringdown.bake, bpy.ops.ringdown.picture, bpy.ops.ringdown.export_report):
        assert "Calibrate first" in message(late)
    bpy.ops.ringdown.calibrate()
    bar.ringdown.bake.motion = "PLUCKED"
    assert "vertex to pull" in message(bpy.ops.ringdown.bake)
    assert "Nothing" in message(bpy.ops.ringdown.remove)
    assert "Nothing runs" in message(bpy.ops.ringdown.cancel)
    bpy.ops.object.mode_set(mode="EDIT")
    assert "Edit Mode" in message(bpy.ops.ringdown.bake)
    bpy.ops.object.mode_set(mode="OBJECT")
    bar.vertex_groups.clear()
    assert "gone" in message(bpy.ops.ringdown.calibrate)


def test_a_refused_calibration_says_why_and_changes_nothing(bar, fake, tmp_path):
    prepared(bar, tmp_path)
    before = state()
    fake("refuse")
    assert "Record longer" in message(bpy.ops.ringdown.calibrate)
    assert state() == before


def test_a_plucked_vertex_starts_where_it_was_pulled_to(bar, fake, tmp_path):
    prepared(bar, tmp_path)
    bpy.ops.ringdown.calibrate()
    tip = max(range(8), key=lambda i: bar.data.vertices[i].co.x)
    select(bar, lambda co: co == bar.data.vertices[tip].co)
    bpy.ops.ringdown.pluck()
    assert bar.ringdown.bake.vertex == tip
    bar.ringdown.bake.motion, bar.ringdown.bake.pull = "PLUCKED", (0, 0.02, 0)
    bpy.ops.ringdown.bake()
    bpy.context.scene.frame_set(1)
    moved = bar.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.vertices
    assert np.isclose(moved[tip].co.y - bar.data.vertices[tip].co.y, 0.02, rtol=1e-4)


def test_the_exported_case_holds_the_shape_bit_for_bit_and_its_numbers(bar, fake, tmp_path):
    prepared(bar, tmp_path)
    bpy.ops.ringdown.material(preset="DRAGON_30")
    assert bpy.ops.ringdown.export(directory=str(tmp_path / "case")) == {"FINISHED"}
    case = tomllib.loads((tmp_path / "case" / "case.toml").read_text())
    assert case["object"]["density"] == 1080
    assert case["marker"] == [
        {"name": "tip", "position": [0.1, case["marker"][0]["position"][1], 0.01]}
    ]
    assert (tmp_path / "case" / "tracks.csv").read_text() == (tmp_path / "tracks.csv").read_text()
    from core.surface import read_surface

    surface = read_surface(tmp_path / "case" / case["object"]["mesh"])
    places = np.array([v.co for v in bar.data.vertices])
    assert (surface.vertices == places.astype(np.float32).astype(float)).all()
    assert case["pin"] == [{"vertices": np.flatnonzero(places[:, 0] < 0.001).tolist()}]


@pytest.mark.parametrize("factor", [0.1, 10])
def test_units_and_scale_change_no_number_of_the_case(bar, fake, tmp_path, factor):
    prepared(bar, tmp_path)
    bpy.ops.ringdown.export(directory=str(tmp_path / "plain"))
    bpy.context.scene.unit_settings.scale_length = factor
    bar.scale = (1 / factor,) * 3
    bar.rotation_euler = (0.1, 0.2, 0.3)
    bpy.context.view_layer.update()
    bpy.ops.ringdown.export(directory=str(tmp_path / "other"))
    assert (tmp_path / "plain/case.toml").read_text() == (tmp_path / "other/case.toml").read_text()
    from core.surface import read_surface

    plain, other = (read_surface(tmp_path / f / "mesh.ply").vertices for f in ("plain", "other"))
    assert np.allclose(plain, other, rtol=0, atol=1e-7 * 0.1)


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


def do_place(obj, tmp_path):
    return bpy.ops.ringdown.place(index=0, position=(0.05, 0, 0.01))


STEPS = {
    "use": lambda o, t: bpy.ops.ringdown.use(),
    "material": lambda o, t: bpy.ops.ringdown.material(preset="DRAGON_30"),
    "pins": lambda o, t: bpy.ops.ringdown.pins(),
    "read": lambda o, t: bpy.ops.ringdown.read(),
    "slow_motion": lambda o, t: bpy.ops.ringdown.slow_motion(factor=4),
    "place": do_place,
    "calibrate": lambda o, t: bpy.ops.ringdown.calibrate(),
    "picture": lambda o, t: bpy.ops.ringdown.picture(),
    "pluck": lambda o, t: bpy.ops.ringdown.pluck(vertex=3),
    "bake": lambda o, t: bpy.ops.ringdown.bake(),
    "remove": lambda o, t: bpy.ops.ringdown.remove(),
}


@pytest.mark.parametrize("upto", list(STEPS))
def test_undo_after_each_step_restores_the_file(bar, fake, tmp_path, upto):
    select(bar, lambda co: co.x < 0.001)
    bar.ringdown.recording.source = "CSV"
    bar.ringdown.recording.path = str(tmp_path / "tracks.csv")
    names = list(STEPS)
    for name in names[: names.index(upto)]:
        if name != "picture":
            assert STEPS[name](bar, tmp_path) == {"FINISHED"}
    if upto == "picture":
        bar.ringdown.facts.picture = png(tmp_path)
    bpy.ops.ed.undo_push(message="before")
    before = state()
    assert STEPS[upto](bpy.data.objects[0], tmp_path) == {"FINISHED"}
    bpy.ops.ed.undo_push(message=upto)
    assert state() != before
    bpy.ops.ed.undo()
    assert state() == before


def png(tmp_path):
    """A small picture as the object keeps it."""
    import base64
    import zlib

    image = bpy.data.images.new("small", 4, 4)
    image.filepath_raw, image.file_format = str(tmp_path / "small.png"), "PNG"
    image.save()
    bpy.data.images.remove(image)
    data = (tmp_path / "small.png").read_bytes()
    return base64.b64encode(zlib.compress(data)).decode()


@pytest.mark.parametrize("upto", ["use", "pins", "read", "calibrate", "bake"])
def test_a_file_saved_after_any_step_goes_on_from_there(bar, fake, tmp_path, upto):
    select(bar, lambda co: co.x < 0.001)
    bar.ringdown.recording.source = "CSV"
    bar.ringdown.recording.path = str(tmp_path / "tracks.csv")
    names = ["use", "pins", "read", "calibrate", "bake"]
    for name in names[: names.index(upto) + 1]:
        STEPS[name](bar, tmp_path)
    before = state()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "file.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "file.blend"))
    assert state() == before
    for name in names[names.index(upto) + 1 :]:
        assert STEPS[name](bpy.data.objects[0], tmp_path) == {"FINISHED"}
    assert len(bpy.data.shape_keys) == 1


def test_the_picture_becomes_a_packed_image(bar, fake, tmp_path):
    prepared(bar, tmp_path)
    bpy.ops.ringdown.calibrate()
    assert "no picture" in message(bpy.ops.ringdown.picture)
    bar.ringdown.facts.picture = png(tmp_path)
    for _ in range(2):
        assert bpy.ops.ringdown.picture() == {"FINISHED"}
    image = bpy.data.images[f"Ringdown {bar.name}"]
    assert image.packed_file
    assert tuple(image.size) == (4, 4)
    assert len(bpy.data.images) == 1


def test_a_copied_object_takes_its_calibration_along(bar, fake, tmp_path):
    prepared(bar, tmp_path)
    bpy.ops.ringdown.calibrate()
    bpy.ops.object.duplicate()
    copy = bpy.context.object
    assert copy is not bar
    bpy.context.scene.ringdown_object = copy
    assert bpy.ops.ringdown.bake() == {"FINISHED"}
    assert copy.data.shape_keys
    assert bar.data.shape_keys is None


def test_an_own_material_travels_with_its_calibrated_modulus(bar, fake, tmp_path):
    prepared(bar, tmp_path)
    bpy.ops.ringdown.calibrate()
    bar.ringdown.material.density = 1234
    assert bpy.ops.ringdown.material_save(name="My Jelly") == {"FINISHED"}
    (kept,) = bpy.utils.preset_paths("ringdown/material")
    (preset,) = (path for path in Path(kept).iterdir() if path.stem.lower() == "my_jelly")
    bpy.ops.mesh.primitive_cube_add()
    bpy.ops.ringdown.use()
    bpy.ops.script.execute_preset(filepath=str(preset), menu_idname="RINGDOWN_MT_material")
    material = bpy.context.object.ringdown.material
    assert material.density == 1234
    assert np.isclose(material.modulus, 100.0)
    assert "Calibrated" in material.source


def test_an_appended_object_brings_its_calibration_and_bakes(bar, fake, tmp_path):
    prepared(bar, tmp_path)
    bpy.ops.ringdown.calibrate()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "from.blend"))
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    with bpy.data.libraries.load(str(tmp_path / "from.blend")) as (there, here):
        here.objects = list(there.objects)
    obj = here.objects[0]
    bpy.context.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = obj
    assert bpy.ops.ringdown.bake() == {"FINISHED"}
    assert len(obj.data.shape_keys.key_blocks) == 2


def test_a_linked_object_is_refused_with_the_way_out(bar, fake, tmp_path):
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "from.blend"))
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    with bpy.data.libraries.load(str(tmp_path / "from.blend"), link=True) as (there, here):
        here.objects = list(there.objects)
    bpy.context.collection.objects.link(here.objects[0])
    bpy.context.view_layer.objects.active = here.objects[0]
    assert "make it local" in message(bpy.ops.ringdown.calibrate)


def test_settings_on_a_library_override_can_be_edited_and_survive_reload(bar, fake, tmp_path):
    prepared(bar, tmp_path)
    bpy.ops.ringdown.material(preset="DRAGON_30")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "from.blend"))
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    with bpy.data.libraries.load(str(tmp_path / "from.blend"), link=True) as (there, here):
        here.objects = list(there.objects)
    mine = here.objects[0].override_create()
    bpy.context.collection.objects.link(mine)
    mine.ringdown.elements = 777
    mine.ringdown.material.density = 1111
    name = mine.name
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "over.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "over.blend"))
    mine = next(o for o in bpy.data.objects if o.name == name and o.override_library)
    assert mine.ringdown.elements == 777
    assert mine.ringdown.material.density == 1111
