"""What the README shows works, and what it points to is there."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")
SNIPPETS = re.findall(r"^```(python|sh|console)\n(.*?)^```", TEXT, re.M | re.S)
LINKS = re.findall(r"\]\(([^)#:]+)\)", TEXT)


@pytest.mark.parametrize("link", LINKS)
def test_every_link_leads_to_a_file(link):
    assert (ROOT / link).is_file()


@pytest.mark.parametrize("path", re.findall(r"`((?:core|assets|tests|addon)/[\w/.]+)`", TEXT))
def test_every_path_named_exists(path):
    assert (ROOT / path).exists()


@pytest.mark.slow
def test_every_snippet_runs_on_the_example_in_order(tmp_path):
    for name in ("core", "assets"):
        (tmp_path / name).symlink_to(ROOT / name)
    python = tmp_path / "bin" / "python"
    python.parent.mkdir()
    python.write_text(f'#!/bin/sh\nexec "{sys.executable}" "$@"\n')
    python.chmod(0o755)
    path = f"{python.parent}{os.pathsep}{os.environ['PATH']}"
    environment = {**os.environ, "PATH": path, "PYTHONPATH": str(tmp_path)}
    assert SNIPPETS
    for kind, text in SNIPPETS:
        command = [sys.executable, "-c", text] if kind == "python" else ["sh", "-ec", text]
        ran = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
        assert ran.returncode == 0, f"{text}\n{ran.stderr}"
