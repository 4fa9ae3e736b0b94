"""The example through the panel and through the command line: the same numbers."""

import importlib
import json
from pathlib import Path

import bpy
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = sorted(ROOT.glob("assets/*/case.toml"))
NAME = "bl_ext.user_default.ringdown"
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not EXAMPLES, reason="assets holds no example"),
]


def opened(factor):
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    bpy.context.scene.unit_settings.scale_length = factor
    assert bpy.ops.ringdown.case_open(filepath=str(EXAMPLES[0])) == {"FINISHED"}
    obj = bpy.context.object
    obj.ringdown.elements = 600
    return obj


def numbers(report):
    """The report without what depends on time or on the object's name."""
    return {key: value for key, value in report.items() if key not in ("seconds", "case")}


def alike(value, rel=1e-6, floor=1e-9):
    """Equal but for the last digits of sums, which depend on where an array lies in memory.

    What was tried and rejected fits badly, and its fit ends somewhere on a flat slope, where the
    last digits of the tracks decide.
    """
    if isinstance(value, dict):
        loose = {"ranking": (1e-2, 1e-3)}  # the accepted one is found among `effects` as well
        return {key: alike(one, *loose.get(key, (rel, floor))) for key, one in value.items()}
    if isinstance(value, list):
        return [alike(one, rel, floor) for one in value]
    return pytest.approx(value, rel=rel, abs=floor) if isinstance(value, float) else value


@pytest.fixture(scope="module")
def calibrated(extension, tmp_path_factory):
    """The example as the panel calibrates it: its .blend, and the case that it exports."""
    folder = tmp_path_factory.mktemp("example")
    obj = opened(1.0)
    assert bpy.ops.ringdown.cage() == {"FINISHED"}
    assert bpy.ops.ringdown.calibrate() == {"FINISHED"}
    assert bpy.ops.ringdown.export(directory=str(folder / "case")) == {"FINISHED"}
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "file.blend"))
    return folder, json.loads(obj.ringdown.facts.report), obj.ringdown.facts.cage


def test_an_exported_case_gives_the_same_report_from_the_command_line(calibrated, tmp_path):
    folder, report, _ = calibrated
    main = importlib.import_module("core.command").main
    arguments = ["calibrate", folder / "case", "--out", folder / "case" / "report.json"]
    arguments += ["--elements", 600]
    assert main([str(one) for one in arguments]) == 0
    again = json.loads((folder / "case" / "report.json").read_text())
    assert numbers(again) == alike(numbers(report))


@pytest.mark.parametrize("factor", [0.1, 10.0])
def test_units_ten_times_larger_or_smaller_change_no_physical_number(calibrated, factor):
    _, report, cage = calibrated
    obj = opened(factor)
    facts, keep = obj.ringdown.facts, importlib.import_module(f"{NAME}.addon.keep")
    read = importlib.import_module(f"{NAME}.addon.read")
    surface = read.surface(obj, bpy.context.evaluated_depsgraph_get())
    facts.cage = keep.pack(**(keep.unpack(cage) | {"of": surface.vertices}))
    assert bpy.ops.ringdown.calibrate() == {"FINISHED"}
    found = json.loads(facts.report)
    assert found["diagnosis"]["verdict"] == report["diagnosis"]["verdict"]
    names = [effect["name"] for effect in report["diagnosis"]["effects"]]
    assert [effect["name"] for effect in found["diagnosis"]["effects"]] == names
    for pick in (
        lambda r: r["youngs_modulus"]["material"]["value"],
        lambda r: r["modes"][0]["natural_frequency_hz"]["value"],
        lambda r: r["modes"][0]["damping_ratio"]["value"],
    ):
        assert np.isclose(pick(found), pick(report), rtol=1e-4)


@pytest.mark.parametrize("target", ["KEYS", "CACHE"])
def test_the_calibrated_example_bakes_after_reload(calibrated, target):
    folder = calibrated[0]
    bpy.ops.wm.open_mainfile(filepath=str(folder / "file.blend"))
    obj = bpy.context.scene.ringdown_object
    obj.ringdown.bake.target = target
    assert bpy.ops.ringdown.bake() == {"FINISHED"}
    tops = []
    for frame in (1, 4, 8):
        bpy.context.scene.frame_set(frame)
        mesh = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        tops.append(np.array([v.co for v in mesh.vertices]))
    assert np.abs(tops[0] - tops[1]).max() > 1e-4
    assert np.abs(tops[1] - tops[2]).max() > 1e-4
