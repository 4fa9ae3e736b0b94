"""Every operator as the panel calls it, from an empty scene to a baked object."""

import base64
import io
import json
import tomllib
import zlib
from pathlib import Path

import bpy
import numpy as np
import pytest

from tests.addon.driven import hold, message, png, prepared, record, select, state


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


def test_the_modal_masses_of_a_calibration_are_kept_for_plucking(bar, fake, tmp_path):
    prepared(bar, tmp_path)
    bpy.ops.ringdown.calibrate()
    data = zlib.decompress(base64.b64decode(bar.ringdown.facts.motion))
    assert np.load(io.BytesIO(data))["modal_mass"] == [0.7]


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


def test_while_a_calibration_runs_the_tab_shows_it_alone(bar, rd):
    import importlib

    now = importlib.import_module("bl_ext.user_default.ringdown.addon.job").NOW
    steps = [c for c in bpy.types.Panel.__subclasses__() if c.bl_rna.identifier.startswith("RING")]
    bpy.ops.ringdown.use()
    assert len([c for c in steps if getattr(c, "bl_parent_id", "")]) >= 7

    def shown():
        return {c.bl_label for c in steps if hasattr(c, "poll") and c.poll(bpy.context)}

    before = shown()
    try:
        now.child, now.alone = object(), True
        assert shown() & before == {"Calibrate"}
        now.alone = False  # a short job
        assert shown() == before
        bpy.context.window_manager.ringdown_short = True
        assert shown() == before  # nothing is hidden while there is no result
        bar.ringdown.facts.report = "{}"
        assert shown() & before == {"Calibrate", "Result", "Bake"}
    finally:
        now.child, now.alone = None, False
        bpy.context.window_manager.ringdown_short = False
