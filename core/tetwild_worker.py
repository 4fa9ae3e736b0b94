"""The one file that imports pytetwild; run by path in a child process, never imported.

Its folder holds input.npz (vertices, faces) and settings.json (paths, edge_length, epsilon,
threads, seconds it may take); it leaves output.npz (nodes, tets) or error.txt there. Exit
status 3: pytetwild cannot be imported; 4: it found nothing.
"""

import ctypes
import faulthandler
import json
import signal
import sys
import types
from pathlib import Path


def import_pytetwild():
    """pytetwild imports pyvista without using it here; an empty stand-in spares shipping vtk."""
    absent = "pyvista" not in sys.modules
    if absent:
        sys.modules["pyvista"] = types.ModuleType("pyvista")
    try:
        import pytetwild
    finally:
        if absent:
            del sys.modules["pyvista"]
    return pytetwild


def die_with_parent(seconds: float) -> None:
    """End when the parent is killed (Linux, at once), and after `seconds` at the latest.

    Neither needs the GIL, which pytetwild holds for minutes: a thread in Python would not do.
    """
    if seconds > 0:
        faulthandler.dump_traceback_later(seconds, exit=True)
    if sys.platform.startswith("linux"):
        set_death_signal = 1  # PR_SET_PDEATHSIG
        ctypes.CDLL(None).prctl(set_death_signal, int(signal.SIGKILL), 0, 0, 0)


def main(folder: Path) -> int:
    settings = json.loads((folder / "settings.json").read_text())
    die_with_parent(settings["seconds"])
    sys.path.extend(p for p in settings["paths"] if p not in sys.path)
    try:
        import numpy as np

        pytetwild = import_pytetwild()
    except ImportError as error:
        (folder / "error.txt").write_text(str(error))
        return 3
    given = np.load(folder / "input.npz")
    try:
        nodes, tets = pytetwild.tetrahedralize(
            given["vertices"],
            given["faces"],
            edge_length_fac=settings["edge_length"],
            epsilon=settings["epsilon"],
            vtk_ordering=True,
            num_threads=settings["threads"],
            num_opt_iter=30,  # of 80: a coarse edge with a fine epsilon would try for half a minute
        )
    except (ValueError, RuntimeError, IndexError) as error:
        (folder / "error.txt").write_text(str(error))
        return 4
    np.savez(folder / "output.npz", nodes=nodes, tets=tets)
    return 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
