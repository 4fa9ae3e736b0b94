"""The command line refuses in one line, before it works, and leaves nothing behind."""

import importlib
import os
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from core.command import main
from core.errors import CaseError
from core.files import written_whole
from tests.truth import make

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    folder = tmp_path_factory.mktemp("case")
    make("null", 4, folder)
    return folder / "case.toml"


@pytest.fixture
def refused(case, capsys, monkeypatch):
    """Runs `calibrate CASE WORDS` and gives the one line; no file may change, none may be new."""
    work = "core.pipeline.calibrate_case"
    monkeypatch.setattr(work, lambda *_, **__: pytest.fail("it went to work"))

    def run(*words, given=None):
        before = {path: path.read_bytes() for path in case.parent.iterdir() if path.is_file()}
        assert main([*(given or ["calibrate", str(case)]), *map(str, words)]) == 2
        told = capsys.readouterr().err
        assert told.count("\n") == 1 and told.startswith("ringdown: ") and "usage" not in told
        after = {path: path.read_bytes() for path in case.parent.iterdir() if path.is_file()}
        assert after == before
        return told

    return run


def inputs(case):
    return [path.name for path in case.parent.iterdir() if path.suffix in (".csv", ".obj", ".toml")]


def test_no_output_may_be_an_input_of_the_case(refused, case, tmp_path):
    names = inputs(case)
    assert len(names) >= 3
    for name in names:
        told = refused("--out", case.parent / name)
        assert "--out" in told and name in told and "input" in told
        told = refused("--out", tmp_path / "r.json", "--motion", case.parent / name)
        assert "--motion" in told and "input" in told


def test_an_input_is_known_by_a_link_to_it_as_well(refused, case, tmp_path):
    (tmp_path / "link.json").symlink_to(case)
    assert "input" in refused("--out", tmp_path / "link.json")


def test_no_two_outputs_may_be_one_file(refused, tmp_path):
    report, kept = tmp_path / "r.json", tmp_path / "r.npz"
    assert "--motion" in refused("--out", report, "--motion", report)
    (tmp_path / "x").mkdir()
    assert "--plot" in refused("--out", report, "--plot", tmp_path / "x" / ".." / "r.json")
    assert "tetrahedra" in refused("--out", report, "--motion", kept)
    assert "tetrahedra" in refused("--out", kept)


def test_an_output_that_is_a_folder_or_has_none_is_refused(refused, tmp_path):
    (tmp_path / "file").write_text("")
    assert "is a folder" in refused("--out", tmp_path)
    assert "does not exist" in refused("--out", tmp_path / "no" / "r.json")
    assert "not a folder" in refused("--out", tmp_path / "file" / "r.json")
    assert "is a folder" in refused("--out", tmp_path / "r.json", "--plot", tmp_path)


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write all")
def test_an_output_in_a_folder_that_may_not_be_written_to_is_refused(refused, tmp_path):
    tmp_path.chmod(0o500)
    assert "may not be written" in refused("--out", tmp_path / "r.json")


@pytest.mark.parametrize("name", ["r.xyz", "r", "r.png.gz"])
def test_a_picture_of_no_known_kind_is_refused_with_the_known_ones(refused, tmp_path, name):
    told = refused("--out", tmp_path / "r.json", "--plot", tmp_path / name)
    assert name in told and ".png" in told and ".svg" in told


def test_the_video_of_a_ringdown_is_never_written_over(refused, tmp_path):
    clip = tmp_path / "clip.mp4"
    clip.write_bytes(b"film")
    given = ["ringdown", str(clip), "--capture-fps", "100"]
    for option in ("--out", "--magnify"):
        assert "input clip.mp4" in refused(option, clip, given=given)
    assert clip.read_bytes() == b"film"


@pytest.mark.parametrize("text", ["0", "-1", "3", "1000001", "9" * 5000, "many", "²", "1.5", ""])
def test_a_number_of_tetrahedra_that_cannot_be_is_refused_in_one_short_line(
    refused, tmp_path, text
):
    told = refused("--out", tmp_path / "r.json", "--elements", text)
    assert "--elements" in told and "4 to 1000000" in told and len(told) < 200


def test_a_missing_or_unknown_option_is_refused_without_a_block_of_usage(refused):
    assert "--out" in refused()
    assert "--ot" in refused("--out", "r.json", "--ot")
    assert "calibrate" in refused(given=["calbrate"])


def test_a_case_refused_after_its_body_was_cut_leaves_no_file(tmp_path, capsys):
    make("null", 4, tmp_path)
    tracks = tmp_path / "tracks.csv"
    tracks.write_text("".join(tracks.read_text().splitlines(keepends=True)[:5]))
    names = set(os.listdir(tmp_path))
    words = ["calibrate", str(tmp_path / "case.toml"), "--out", str(tmp_path / "r.json")]
    assert main([*words, "--elements", "60"]) == 2
    assert capsys.readouterr().err.count("ringdown: ") == 1
    assert set(os.listdir(tmp_path)) == names


def test_a_file_that_cannot_be_put_in_place_is_one_readable_line(tmp_path):
    target = tmp_path / "report.json"

    def write():
        with written_whole(target) as draft:
            draft.write_text("{}")
            target.mkdir()

    with pytest.raises(CaseError, match="cannot be replaced"):
        write()
    assert [path.name for path in tmp_path.iterdir()] == ["report.json"]


def test_a_stop_while_modules_are_loaded_is_one_line_and_130():
    code = (
        "import runpy, sys\n"
        "class Stop:\n"
        "    def find_spec(self, name, *_):\n"
        "        if name == 'core.bake': raise KeyboardInterrupt\n"
        "sys.meta_path.insert(0, Stop())\n"
        "runpy.run_module('core', run_name='__main__')\n"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 130
    assert done.stderr.strip() == "ringdown: stopped; nothing was written."


def test_the_installed_command_runs_what_the_module_runs(monkeypatch, capsys):
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    module, _, name = project["scripts"]["ringdown"].partition(":")
    start = getattr(importlib.import_module(module.replace("ringdown", "core", 1)), name)
    monkeypatch.setattr(sys, "argv", ["ringdown", "calibrate"])
    assert start() == 2
    assert capsys.readouterr().err.startswith("ringdown: ")
