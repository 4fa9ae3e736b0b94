"""The extension as Blender loads it, from this checkout, in a fresh user folder."""

import importlib
import os
import tempfile
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
HOME = tempfile.mkdtemp(prefix="ringdown_test_")
os.environ["BLENDER_USER_RESOURCES"] = HOME  # read once, when bpy is imported

bpy = pytest.importorskip("bpy")
from tests import seeded_tetwild  # noqa: E402
from tests.addon.driven import FAKE  # noqa: E402  (it imports bpy)

NAME = "bl_ext.user_default.ringdown"


@pytest.fixture(scope="session", autouse=True)
def extension():
    folder = Path(bpy.utils.user_resource("EXTENSIONS")) / "user_default"
    folder.mkdir(parents=True, exist_ok=True)
    if not (folder / "ringdown").exists():
        (folder / "ringdown").symlink_to(ROOT, target_is_directory=True)
    bpy.ops.preferences.addon_enable(module=NAME)
    assert NAME in bpy.context.preferences.addons
    # the extension has a `core` of its own
    seeded_tetwild.use(importlib.import_module(f"{NAME}.core.tetwild").run_tetwild)
    yield
    bpy.ops.preferences.addon_disable(module=NAME)  # a class left behind hangs 4.5 at exit


@pytest.fixture
def rd(extension):
    """The extension's modules in an empty scene: rd.write, rd.read, rd.bake, rd.data, ..."""
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    parts = {name: f"core.{name}" for name in ("bake", "data", "errors")}
    parts |= {name: f"addon.{name}" for name in ("write", "read", "marks")}
    parts |= {"job": "addon.job"}
    return SimpleNamespace(
        **{name: importlib.import_module(f"{NAME}.{path}") for name, path in parts.items()}
    )


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
