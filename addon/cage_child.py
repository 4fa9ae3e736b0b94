"""The child that cuts an object into tetrahedra: `python cage_child.py FOLDER`.

Reads FOLDER/surface.npz, leaves FOLDER/cage.npz, and tells its progress line by line.
"""

import json
import sys
from pathlib import Path

import numpy as np

from core.data import Material, Surface, TetMesh
from core.elasticity import assemble, held_part, hold
from core.errors import CoreError
from core.modes import solve_modes
from core.rim import along_rim
from core.tetrahedralize import tetrahedralize


def tell(fraction: float, text: str) -> None:
    sys.stdout.write(json.dumps({"progress": fraction, "text": text}) + "\n")
    sys.stdout.flush()


ELEMENT = "p2"  # what the calibration takes by itself
HIGHER = {"p1": "p2", "p1_smoothed": "p2", "p2": "p3"}  # one order up: next to the true pitch


def too_high(mesh: TetMesh, surface: Surface, pinned: np.ndarray, stuff: tuple) -> float:
    """How much higher this mesh rings than with elements one order up, relative frequency.

    `stuff`: Poisson ratio and element; the density scales both alike.
    """
    material, element = Material(1000.0, stuff[0]), stuff[1]
    mesh = along_rim(mesh, held_part(surface, pinned))
    pitch = [
        solve_modes(hold(assemble(mesh, material, one), surface, pinned), 1).frequency[0]
        for one in (element, HIGHER[element])
    ]
    return float(pitch[0] / pitch[1] - 1)


def main(folder: Path) -> int:
    with np.load(folder / "surface.npz") as given:
        surface = Surface(given["vertices"], given["faces"])
        pinned, elements = given["pinned"], int(given["elements"])
        stuff = float(given["poisson_ratio"]), str(given["element"]) or ELEMENT
    try:
        mesh, told = tetrahedralize(
            surface, elements, progress=lambda fraction, text: tell(0.8 * fraction, text)
        )
        tell(0.8, "ringing it once")
        excess = too_high(mesh, surface, pinned, stuff) if pinned.any() else np.nan
    except CoreError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    np.savez(
        folder / "cage.npz",
        nodes=mesh.nodes,
        tets=mesh.tets,
        quality=told.worst_quality,
        too_high=excess,
    )
    tell(1.0, f"{told.tets} tetrahedra")
    return 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
