"""The cage is kept with the object until the mesh changes; the free part is found."""

import importlib

import bpy
import numpy as np
import pytest

NAME = "bl_ext.user_default.ringdown"


@pytest.fixture
def post(rd):
    bpy.ops.mesh.primitive_cube_add(size=0.04)
    obj = bpy.context.object
    for vertex in obj.data.vertices:
        vertex.select = vertex.co.z < 0
    bpy.ops.ringdown.use()
    bpy.ops.ringdown.pins()
    return obj


@pytest.fixture
def parts(rd):
    names = ("ready", "keep", "operators_run")
    return {name: importlib.import_module(f"{NAME}.addon.{name}") for name in names}


def test_a_cage_fills_the_object_is_kept_and_goes_stale_with_the_mesh(post, parts, rd, tmp_path):
    post.ringdown.elements = 300
    assert bpy.ops.ringdown.cage() == {"FINISHED"}
    facts = post.ringdown.facts
    cage = parts["keep"].unpack(facts.cage)
    mesh = rd.data.TetMesh(cage["nodes"], cage["tets"])
    assert np.isclose(mesh.volume, 0.04**3, rtol=5e-3)
    assert 150 < len(mesh.tets) < 600
    assert "too high" in facts.cage_says
    assert not parts["ready"].stale(post, facts.cage_look)
    shape = rd.read.surface(post, bpy.context.evaluated_depsgraph_get())
    parts["operators_run"].use_cage(post, shape, tmp_path)
    assert (tmp_path / parts["operators_run"].TETS).is_file()
    post.data.vertices[0].co *= 1.5
    post.data.update()
    bpy.context.view_layer.update()
    assert parts["ready"].stale(post, facts.cage_look)
    (tmp_path / parts["operators_run"].TETS).unlink()
    shape = rd.read.surface(post, bpy.context.evaluated_depsgraph_get())
    parts["operators_run"].use_cage(post, shape, tmp_path)
    assert not (tmp_path / parts["operators_run"].TETS).exists()


def test_undo_takes_a_cage_back(post):
    post.ringdown.elements = 300
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.ringdown.cage()
    bpy.ops.ed.undo_push(message="cage")
    bpy.ops.ed.undo()
    assert bpy.context.object.ringdown.facts.cage == ""


@pytest.mark.parametrize("release", [0.25, 0.6])
def test_the_free_part_begins_at_the_planted_release(post, tmp_path, release):
    time = np.arange(0, 4, 1 / 120)
    after = np.maximum(time - release, 0)
    wave = 0.01 * np.exp(-0.8 * after) * np.cos(2 * np.pi * 4 * after)
    noise = np.random.default_rng(0).normal(0, 2e-5, len(time))
    rows = [f"{t},0,{w + n},0.02" for t, w, n in zip(time, wave, noise, strict=True)]
    (tmp_path / "a.csv").write_text("\n".join(["time,top.x,top.y,top.z", *rows]))
    recording = post.ringdown.recording
    recording.source, recording.path = "CSV", str(tmp_path / "a.csv")
    bpy.ops.ringdown.read()
    assert np.isclose(recording.capture_fps, 120, rtol=1e-6)
    assert bpy.ops.ringdown.free_part() == {"FINISHED"}
    assert abs(recording.start - release) < 0.03
    assert recording.own_start and recording.own_stop
    assert recording.stop > 2
