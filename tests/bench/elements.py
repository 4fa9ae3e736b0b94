"""Every element on coarse meshes as pytetwild makes them: error of the first five frequencies.

    python tests/bench/elements.py [--shapes bar,pudding,ear] [--sizes 400,1200,3000]
        [--nu 0.3,0.49]

Prints a table for the docs: per cent off the mesh-converged value (its own standard deviation in
the heading), worst of modes 2 to 5 after the first is calibrated, unknowns, CPU seconds from mesh
to modes. The reference is extrapolated from quadratic and cubic elements on the finest mesh.
"""

import argparse
import os
import sys
import time
from pathlib import Path

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(threads, "1")
sys.path.insert(0, str(Path(__file__).parents[2]))

import numpy as np

from core.data import Material
from core.elasticity import assemble, hold
from core.modes import solve_modes
from core.stiffening import converged_eigenvalues
from core.tetrahedralize import tetrahedralize
from tests.bench import shapes

ELEMENTS = ("p1", "p1_smoothed", "p2", "p2_mixed", "dg")


def builder(surface, along: int, nu: float):
    pinned = surface.vertices[:, along] < 1e-9
    return lambda mesh, element: hold(
        assemble(mesh, Material(1000.0, nu), element), surface, pinned
    )


def rows(meshes, build):
    """Lines of the table, and the reference's standard deviation in per cent."""
    limit = converged_eigenvalues(build, meshes[-1], 5)
    exact = np.sqrt(limit.values[:5]) / (2 * np.pi)
    out = []
    for mesh in meshes:
        for element in ELEMENTS:
            start = time.process_time()
            model = build(mesh, element)
            modes = solve_modes(model, 5)
            seconds = time.process_time() - start
            error = 100 * (modes.frequency / exact - 1)
            left = modes.frequency / modes.frequency[0] * exact[0] / exact - 1
            after = 100 * np.abs(left[1:]).max()
            first = " | ".join(f"{e:+.1f}" for e in error)
            size = f"{len(mesh.tets)} | {element} | {model.free.size}"
            out.append(f"| {size} | {first} | {after:.1f} | {seconds:.2f} |")
    return out, 50 * (limit.sigma[:5] / limit.values[:5])


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--shapes", default="bar,pudding,ear")
    parser.add_argument("--sizes", default="400,1200,3000")
    parser.add_argument("--nu", default="0.3,0.49")
    args = parser.parse_args()
    for name in args.shapes.split(","):
        surface = getattr(shapes, name)()
        meshes = [tetrahedralize(surface, int(n))[0] for n in args.sizes.split(",")]
        for nu in map(float, args.nu.split(",")):
            lines, sigma = rows(meshes, builder(surface, 0 if name == "bar" else 2, nu))
            print(f"\n{name}, nu = {nu} (reference ±{sigma[0]:.2f} % .. ±{sigma.max():.2f} %)\n")
            print("| tets | element | unknowns | 1 | 2 | 3 | 4 | 5 | after DAC | s |")
            print("|---|---|---|---|---|---|---|---|---|---|")
            print("\n".join(lines), flush=True)
