"""What packaging promises: one version, every folder in the wheel, imports that work in Blender."""

import ast
import re
import tomllib
from pathlib import Path

import pytest

import core
from core import effects
from core.case_schema import EFFECT_NAMES

ROOT = Path(__file__).parents[2]
SOURCES = sorted([*(ROOT / "core").rglob("*.py"), *(ROOT / "addon").rglob("*.py")])


def toml(name):
    return tomllib.loads((ROOT / name).read_text(encoding="utf-8"))


def absolute_imports(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name.split(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            yield node.module.split(".")[0]


def test_the_extension_and_the_package_have_one_version():
    assert toml("blender_manifest.toml")["version"] == core.__version__


def test_every_folder_of_core_is_in_the_package():
    folders = {path.parent.relative_to(ROOT / "core") for path in (ROOT / "core").rglob("*.py")}
    listed = set(toml("pyproject.toml")["tool"]["setuptools"]["packages"])
    assert {".".join(("ringdown", *folder.parts)) for folder in folders} == listed


def test_what_the_package_needs_is_pinned_for_the_extension():
    def names(lines):
        return {re.split(r"[=<>]", line)[0].lower() for line in lines if line[:1].isalpha()}

    needed = names(toml("pyproject.toml")["project"]["dependencies"]) - {"numpy"}
    assert needed <= names((ROOT / "requirements.txt").read_text().splitlines())


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(ROOT)))
def test_no_file_imports_what_blender_would_not_find(path):
    imported = set(absolute_imports(path))
    assert not imported & {"ringdown", "addon"}
    if path.is_relative_to(ROOT / "core"):
        by_path = {"core"} if path.name == "__main__.py" else set()  # it may be run as a file
        assert not (imported - by_path) & {"core", "bpy", "mathutils"}


def test_every_effect_may_be_declared_in_a_case():
    lists = [getattr(effects, name) for name in dir(effects) if name.endswith("EFFECTS")]
    names = {effect.name for one in lists for effect in one}
    assert names
    assert names <= set(EFFECT_NAMES)
