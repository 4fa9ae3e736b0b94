"""Without a window: the baked file, opened again, plays what was calibrated."""

import importlib
import json
import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
NAME = "bl_ext.user_default.ringdown"
MEASURED = ROOT.parent / "shared" / "measured" / "silicone_beam_gravity_a" / "case.toml"
CASES = [MEASURED, *sorted(ROOT.glob("assets/*/case.toml"))]


@pytest.fixture(scope="module", params=CASES, ids=lambda path: path.parent.name)
def baked(extension, tmp_path_factory, request):
    """(motion, surface, the .blend, the report) of one calibration through the batch entry."""
    if not request.param.is_file():
        pytest.skip(f"{request.param} is not here")
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    batch = importlib.import_module(f"{NAME}.addon.batch")
    folder = tmp_path_factory.mktemp("batch")
    kept = []
    load = batch.bake.load_motion
    batch.bake.load_motion = lambda path: kept.append(load(path)) or kept[-1]
    try:
        arguments = [request.param, "--out", folder / "report.json", "--elements", 600]
        arguments += ["--bake", folder / "baked.blend"]
        assert batch.main([str(one) for one in arguments]) == 0
    finally:
        batch.bake.load_motion = load
    surface = batch._surface(request.param)[0]
    return kept[0][0], surface, folder / "baked.blend", folder / "report.json"


@pytest.mark.slow
@pytest.mark.parametrize("fps", [24, 30, 60])
def test_the_opened_file_follows_the_predicted_motion(baked, fps, tmp_path):
    motion, surface, path, _ = baked
    bpy.ops.wm.open_mainfile(filepath=str(path))
    obj = next(obj for obj in bpy.data.objects if obj.type == "MESH")
    scene = bpy.context.scene
    stretch = 24 / fps  # the file was baked at 24; its curves hold the motion between frames too
    moves = np.einsum("vdk,tk->tvd", motion.shapes, motion.weights)
    reach = np.sqrt((moves**2).sum(axis=2)).max()
    bake = importlib.import_module(f"{NAME}.core.bake")
    for step in range(0, int(motion.time[-1] * fps), 7):
        frame = 1 + step * stretch
        scene.frame_set(int(frame), subframe=frame - int(frame))
        mesh = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        co = np.empty(3 * len(mesh.vertices), np.float32)
        mesh.vertices.foreach_get("co", co)
        weights = bake.sample(motion, np.array([step / fps]))[0]
        truth = surface.vertices + motion.shapes @ weights
        assert np.abs(co.reshape(-1, 3) - truth).max() < 1e-4 * reach


@pytest.mark.slow
def test_the_baked_file_has_one_key_per_shape_and_covers_the_motion(baked):
    motion, _, path, report = baked
    bpy.ops.wm.open_mainfile(filepath=str(path))
    obj = next(obj for obj in bpy.data.objects if obj.type == "MESH")
    moving = np.abs(motion.weights).max(axis=0) * np.abs(motion.shapes).max(axis=(0, 1))
    count = (moving > 1e-6 * moving.max()).sum()
    assert abs(len(obj.data.shape_keys.key_blocks) - 1 - count) <= 1
    assert bpy.context.scene.frame_end >= motion.time[-1] * 24
    assert json.loads(report.read_text())["diagnosis"]["verdict"]


def run(*arguments):
    line = [sys.executable, str(ROOT / "addon" / "batch.py"), "--", *map(str, arguments)]
    return subprocess.run(line, capture_output=True, text=True, timeout=120, check=False)


def test_a_refused_case_gives_status_two_one_line_and_no_file(tmp_path):
    (tmp_path / "case.toml").write_text('name = "x"\n')
    done = run(tmp_path / "case.toml", "--out", tmp_path / "r.json", "--bake", tmp_path / "b.blend")
    assert done.returncode == 2
    assert len([line for line in done.stderr.splitlines() if "ringdown:" in line]) == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["case.toml"]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--elements", "0"], "4 to 1000000"),
        (["--bake", "case.toml"], "the input case.toml"),
        (["--bake", "r.json"], "the file of --out"),
        (["--bake", "."], "is a folder"),
        (["--bake", "case.toml/b.blend"], "not a folder"),
        (["--ot"], "--ot"),
    ],
)
def test_a_wrong_option_is_refused_before_any_work(
    extension, tmp_path, monkeypatch, capsys, words, told
):
    batch = importlib.import_module(f"{NAME}.addon.batch")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(batch, "core_main", lambda _: pytest.fail("it went to work"))
    Path("case.toml").write_text('name = "x"\n')
    assert batch.main(["case.toml", "--out", "r.json", *words]) == 2
    error = capsys.readouterr().err
    assert told in error and error.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["case.toml"]
