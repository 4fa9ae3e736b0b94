"""The extension's zips: nothing that is imported is left out, nothing else is put in."""

import tomllib
import zipfile

import pytest

import build_extension as made

LINUX = made.PLATFORMS["linux-x64"][1] | {"python_version": "3.11"}


@pytest.fixture
def wheel(tmp_path):
    def wheel(name, modules, *lines):
        path = tmp_path / f"{name}-1.0-py3-none-any.whl"
        meta = [f"Name: {name}", "Version: 1.0", "License: MIT", *lines]
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr(f"{name}-1.0.dist-info/METADATA", "\n".join(meta) + "\n\n")
            for module in modules:
                archive.writestr(module, "")
        return path

    return wheel


@pytest.fixture
def ours(tmp_path, monkeypatch):
    """Sources that import two libraries, Blender, numpy and the standard library."""
    for folder in ("core", "addon"):
        (tmp_path / "root" / folder).mkdir(parents=True)
    (tmp_path / "root" / "core" / "a.py").write_text(
        "import json, numpy\nfrom wool.yarn import knit\n"
    )
    (tmp_path / "root" / "addon" / "b.py").write_text("import bpy\n\ndef f():\n    import silk\n")
    monkeypatch.setattr(made, "ROOT", tmp_path / "root")


def test_wheels_that_hold_every_import_and_need_are_complete(wheel, ours):
    wool = wheel("Wool", ["wool/yarn.py"], "Requires-Dist: numpy>=1", "Requires-Dist: silk_thread")
    silk = wheel("silk-thread", ["silk.cpython-311-x86_64-linux-gnu.so"])
    made.check_complete([wool, silk], "here", LINUX)


def test_an_import_that_no_wheel_has_is_refused_by_name(wheel, ours):
    with pytest.raises(SystemExit, match=r"linux.*no wheel has silk\."):
        made.check_complete([wheel("wool", ["wool/yarn.py"])], "linux", LINUX)


def test_a_need_of_a_wheel_counts_only_where_its_marker_holds(wheel, ours):
    silk = wheel("silk", ["silk.py"])
    absent = [
        "Requires-Dist: moth; sys_platform == 'win32'",
        "Requires-Dist: moth; python_version < '3.11'",
        "Requires-Dist: moth; extra == 'dev'",
    ]
    made.check_complete([silk, wheel("wool", ["wool/yarn.py"], *absent)], "here", LINUX)
    here = wheel("wool", ["wool/yarn.py"], "Requires-Dist: moth; sys_platform == 'linux'")
    with pytest.raises(SystemExit, match=r"no wheel has moth\."):
        made.check_complete([silk, here], "here", LINUX)


def test_the_manifest_gains_the_wheels_and_keeps_its_tables():
    manifest = 'id = "x"\n\n[permissions]\nfiles = "why"\n'
    facts = tomllib.loads(made.bundled(manifest, "linux-x64", ["a.whl", "b.whl"]))
    assert facts == {
        "id": "x",
        "platforms": ["linux-x64"],
        "wheels": ["./wheels/a.whl", "./wheels/b.whl"],
        "permissions": {"files": "why"},
    }


def test_every_wheel_is_in_the_list_of_licences_once(wheel):
    text = made.licences([wheel("wool", ["w.py"]), wheel("silk", ["s.py"])])
    assert text.count("| wool | 1.0 | MIT |") == 1
    assert text.index("| silk") < text.index("| wool")


def test_blenders_own_tool_makes_a_zip_of_the_sources_and_nothing_else(wheel, tmp_path):
    pytest.importorskip("bpy")
    path = made.build("linux-x64", [wheel("wool", ["wool.py"])], tmp_path)
    with zipfile.ZipFile(path) as archive:
        names = archive.namelist()
    assert {"__init__.py", "blender_manifest.toml", "LICENSE", "core/case.py"} <= set(names)
    tops = {name.split("/")[0] for name in names}
    assert tops <= {*made.CONTENTS, "blender_manifest.toml", "LICENSES.md", "wheels"}
    assert not [name for name in names if "__pycache__" in name or name.endswith(".pyc")]
