"""Ten lowest modes of a clamped body: ours, scikit-fem with scipy's eigsh, ngsolve; one thread.

    pip install scikit-fem ngsolve
    python tests/bench/eigen.py [--sizes 10000,30000,100000] [--kinds bar,pudding,thin]

Prints CPU seconds from matrices to modes, ratios, agreement, peak memory and how cost grows.
"""

import argparse
import os
import sys
import time
from multiprocessing import get_context
from pathlib import Path

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(threads, "1")
sys.path.insert(0, str(Path(__file__).parents[2]))

import numpy as np

from core import factorization
from core.boundary import boundary, face_points
from core.data import TetMesh
from core.eigen import lowest_eigenpairs
from core.elasticity import assemble, hold_points
from core.refine import refine
from core.tetrahedralize import tetrahedralize
from tests.bench import shapes
from tests.bench.peers import HAIR, RUBBER, ngsolve_matrices, scikit_fem_parts
from tests.core.solids import block

COUNT = 10
KRYLOV = 22  # vectors that ngsolve's Arnoldi needs for ten values to 1e-8
SLOW = 40_000  # unknowns beyond which scipy's default takes minutes


def structured(unknowns: int) -> tuple[TetMesh, str]:
    """A 5:1 bar in linear elements."""
    n = round((unknowns / 15) ** (1 / 3)) - 1
    return block((5 * n, n, n), (1.0, 0.2, 0.2)), "p1"


def thin(unknowns: int) -> tuple[TetMesh, str]:
    """A 10:1 bar as pytetwild cuts it, quadratic; once refined beyond 20,000 unknowns."""
    tets = unknowns / 5.0
    if unknowns < 20_000:
        return tetrahedralize(shapes.bar(), int(tets))[0], "p2"
    return refine(tetrahedralize(shapes.bar(), int(tets / 8))[0]), "p2"


def pudding(unknowns: int) -> tuple[TetMesh, str]:
    """A pudding as pytetwild cuts it, quadratic, its foot laid on x = 0."""
    mesh = tetrahedralize(shapes.pudding(), int(unknowns / 4.5))[0]
    nodes = mesh.nodes[:, [2, 0, 1]]
    foot = np.abs(nodes[:, 0]) < 1e-3 * np.ptp(nodes[:, 0])
    return TetMesh(np.where(foot[:, None], nodes * (0, 1, 1), nodes), mesh.tets), "p2"


BODIES = {"bar": structured, "pudding": pudding, "thin": thin}


def problem(mesh: TetMesh, element: str):
    """K, M and places of the free dofs, the end at x = 0 held."""
    model = assemble(mesh, RUBBER, element)
    end = (np.abs(mesh.nodes[boundary(mesh).corners, 0]) < HAIR).all(axis=1)
    model = hold_points(model, np.unique(face_points(model, each=True)[end]))
    free = model.free
    places = np.repeat(model.points, 3, axis=0)[free]
    return model.stiffness[free][:, free], model.mass[free][:, free], places


def ours(K, M, places, backend: str = "cholmod"):
    kept = factorization.cholmod
    factorization.cholmod = kept if backend == "cholmod" else None
    start = time.process_time()
    values, _ = lowest_eigenpairs(K, M, COUNT, places)
    factorization.cholmod = kept
    return time.process_time() - start, values


def scikit_fem(mesh: TetMesh, element: str):
    """Its own basis, assembly and eigensolver, as its examples put them together."""
    skfem, basis, stiffness, mass = scikit_fem_parts(mesh, element)
    space = basis()
    K, M = stiffness.assemble(space), mass.assemble(space)
    held = space.get_dofs(lambda x: np.abs(x[0]) < HAIR)
    start = time.process_time()
    solver = skfem.solver_eigen_scipy_sym(k=COUNT, sigma=0.0)
    values, _ = skfem.solve(*skfem.condense(K, M, D=held), solver=solver)
    return time.process_time() - start, np.sort(values)


def ngsolve_modes(mesh: TetMesh, element: str):
    ng, space, K, M = ngsolve_matrices(mesh, element)
    found = [ng.CreateVVector(space.ndof, True, 1) for _ in range(KRYLOV)]
    start = time.process_time()
    values = ng.ArnoldiSolver(K.mat, M.mat, space.FreeDofs(), found, 0, inverse="sparsecholesky")
    return time.process_time() - start, np.sort(np.array([complex(x).real for x in values]))[:COUNT]


def peak(kind: str, size: int) -> float:
    """GB that building and solving takes at most, in a process of its own."""
    with get_context("spawn").Pool(1) as pool:
        return pool.apply(_peak, (kind, size))


def _peak(kind: str, size: int) -> float:
    mesh, element = BODIES[kind](size)
    ours(*problem(mesh, element))
    # not ru_maxrss, which a child takes over from its parent
    status = Path("/proc/self/status").read_text()
    return int(status.split("VmHWM:")[1].split()[0]) / 1e6


def report(kind: str, sizes: list[int]) -> None:
    print(f"\n{kind}: {'unknowns':>9} {'entries':>9} | seconds (times ours) disagreement")
    growth = []
    for size in sizes:
        mesh, element = BODIES[kind](size)
        K, M, places = problem(mesh, element)
        n = K.shape[0]
        seconds, values = ours(K, M, places)
        growth.append((n, seconds))
        line = f"{element:>4} {n:9d} {K.nnz:9d} | ours {seconds:.2f}"
        peers = {"fallback": lambda K=K, M=M, p=places: ours(K, M, p, "superlu")}
        if n < SLOW:
            peers["scikit-fem"] = lambda m=mesh, e=element: scikit_fem(m, e)
        peers["ngsolve"] = lambda m=mesh, e=element: ngsolve_modes(m, e)
        for name, solve in peers.items():
            other, theirs = solve()
            line += f", {name} {other:.2f} ({other / seconds:.1f}x)"
            line += f" {np.abs(theirs / values - 1).max():.0e}"
        print(line, flush=True)
    if len(growth) > 1:
        slope = np.polyfit(*np.log(np.array(growth)).T, 1)[0]
        print(f"  our seconds grow as unknowns^{slope:.2f}")
    print(f"  peak memory at {sizes[-1]} unknowns: {peak(kind, sizes[-1]):.2f} GB", flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sizes", default="10000,30000,100000")
    parser.add_argument("--kinds", default="bar,pudding,thin")
    args = parser.parse_args()
    for which in args.kinds.split(","):
        report(which, [int(size) for size in args.sizes.split(",")])
