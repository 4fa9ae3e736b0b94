"""One run of fTetWild in a child process: it may crash, hang or be cancelled, and we stay whole.

Source      Y. Hu, T. Schneider, B. Wang, D. Zorin, D. Panozzo, Fast Tetrahedral Meshing in the
            Wild, ACM Trans. Graph. 39(4), 2020
"""

import json
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from .data import Surface
from .errors import Cancelled, MeshError

WORKER = Path(__file__).with_name("tetwild_worker.py")
POLL = 0.05  # s, how often cancel and time limit are looked at


class Crashed(MeshError):
    """fTetWild found nothing, or died; a smaller epsilon may help."""


class TookTooLong(MeshError):
    """fTetWild was stopped at the time limit."""


def python() -> str:
    """The Python that runs us; inside Blender `sys.executable` may be Blender itself."""
    if Path(sys.executable or "").stem.lower().startswith("python"):
        return sys.executable
    major, minor = sys.version_info[:2]
    for home in (sys.exec_prefix, sys.base_exec_prefix):
        for name in (f"python{major}.{minor}", "python3", "python", "python.exe"):
            for folder in (Path(home) / "bin", Path(home)):
                if (folder / name).is_file():
                    return str(folder / name)
    found = shutil.which(f"python{major}.{minor}")
    if found is None:
        raise MeshError("Tetrahedralization: no Python found to run it. Install Python beside it.")
    return found


def run_tetwild(
    surface: Surface,
    edge_length: float,
    epsilon: float,
    *,
    cancelled: Callable[[], bool] | None = None,
    deadline: float | None = None,
    worker: Path = WORKER,
) -> tuple[np.ndarray, np.ndarray]:
    """Nodes (N, 3) m and tets (T, 4) of the solid within `surface`; T may be 0.

    `edge_length` and `epsilon` (how far the new surface may lie off the old) are relative to the
    box's diagonal; `deadline` is a reading of time.monotonic(). Raises Cancelled within 0.1 s of
    cancelled() turning true, and MeshError, one line, at the deadline and when the child crashes.
    """
    with tempfile.TemporaryDirectory(prefix="ringdown_") as name:
        folder = Path(name)
        vertices, faces = np.array(surface.vertices), np.array(surface.faces, np.int32)
        np.savez(folder / "input.npz", vertices=vertices, faces=faces)
        seconds = 0.0 if deadline is None else max(deadline - time.monotonic(), 0.0) + 5
        settings = {"edge_length": edge_length, "epsilon": epsilon, "threads": 1}
        settings["seconds"] = seconds  # should nobody be there to stop it
        (folder / "settings.json").write_text(json.dumps({**settings, "paths": sys.path}))
        with (folder / "chatter.txt").open("wb") as chatter:
            child = subprocess.Popen(
                [python(), "-P", str(worker), str(folder)],
                cwd=folder,
                stdin=subprocess.DEVNULL,
                stdout=chatter,
                stderr=subprocess.STDOUT,
                creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),  # Windows would show one
            )
            try:
                wait(child, cancelled, deadline)
            finally:
                child.kill()
                child.wait()
        check(child.returncode, folder)
        with np.load(folder / "output.npz") as output:
            return output["nodes"].astype(float), output["tets"].astype(int).reshape(-1, 4)


def wait(child, cancelled: Callable[[], bool] | None, deadline: float | None) -> None:
    """Return when the child has ended; raises Cancelled or, past the deadline, TookTooLong."""
    while True:
        try:
            child.wait(POLL)
            return
        except subprocess.TimeoutExpired:
            stop_if(cancelled)
            if deadline is not None and time.monotonic() > deadline:
                raise TookTooLong(
                    "Tetrahedralization: it took longer than its time limit. "
                    "Ask for fewer elements, or decimate the mesh."
                ) from None


def stop_if(cancelled: Callable[[], bool] | None) -> None:
    """Raises Cancelled when it says so."""
    if cancelled is not None and cancelled():
        raise Cancelled("Tetrahedralization: cancelled. Nothing was written.") from None


def check(status: int, folder: Path) -> None:
    """Raises MeshError or Crashed, one line, for a child that did not leave its tetrahedra."""
    note = folder / "error.txt"
    said = " ".join(note.read_text().split()) if note.exists() else ""
    if status == 3:
        raise MeshError(
            f"Tetrahedralization: pytetwild cannot be used here ({said}). It exists for Linux "
            "x86-64, Windows x64 and macOS arm64; on those run: pip install pytetwild."
        )
    if status == 4:
        raise Crashed(
            f"Tetrahedralization: nothing solid was found in the surface ({said}). "
            "Give it thickness, or close its holes."
        )
    if status != 0 or not (folder / "output.npz").exists():
        how = f"crashed with signal {-status}" if status < 0 else f"ended with status {status}"
        raise Crashed(
            f"Tetrahedralization: the tetrahedralizer {how}. The object may be too thin for this "
            "many elements: ask for more, or give it thickness."
        )
