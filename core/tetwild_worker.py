"""The one file that imports pytetwild; run by path in a child process, never imported.

Its folder holds input.npz (vertices, faces) and settings.json (paths, edge_length, epsilon); it
leaves output.npz (nodes, tets) or error.txt there. Exit status 3: pytetwild cannot be imported.
"""

import json
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


def main(folder: Path) -> int:
    settings = json.loads((folder / "settings.json").read_text())
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
