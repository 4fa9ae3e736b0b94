"""The extension as Blender loads it, from this checkout, in a fresh user folder."""

import importlib
import os
import tempfile
from pathlib import Path
from types import SimpleNamespace

import pytest

ROOT = Path(__file__).resolve().parents[2]
HOME = tempfile.mkdtemp(prefix="ringdown_test_")
os.environ["BLENDER_USER_RESOURCES"] = HOME  # read once, when bpy is imported

bpy = pytest.importorskip("bpy")
NAME = "bl_ext.user_default.ringdown"


@pytest.fixture(scope="session", autouse=True)
def extension():
    folder = Path(bpy.utils.user_resource("EXTENSIONS")) / "user_default"
    folder.mkdir(parents=True, exist_ok=True)
    if not (folder / "ringdown").exists():
        (folder / "ringdown").symlink_to(ROOT, target_is_directory=True)
    bpy.ops.preferences.addon_enable(module=NAME)
    assert NAME in bpy.context.preferences.addons
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
