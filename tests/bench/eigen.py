"""Ten lowest modes of a clamped body: ours, scikit-fem with scipy's eigsh, ngsolve; one thread.

    pip install scikit-fem ngsolve
    python tests/bench/eigen.py [--sizes 10000,30000,100000] [--kinds bar,scan]

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

from core import eigen
from core.boundary import boundary, face_points
from core.data import Material, TetMesh
from core.elasticity import assemble, hold_points
from core.refine import refine
from core.tetrahedralize import tetrahedralize
from tests.bench.shapes import bar
from tests.core.solids import block

RUBBER = Material(1000.0, 0.3)
COUNT = 10
HAIR = 1e-6  # m
KRYLOV = 22  # vectors that ngsolve's Arnoldi needs for ten values to 1e-8
SLOW = 40_000  # unknowns beyond which scipy's default takes minutes


def structured(unknowns: int) -> tuple[TetMesh, str]:
    """A 5:1 bar in linear elements."""
    n = round((unknowns / 15) ** (1 / 3)) - 1
    return block((5 * n, n, n), (1.0, 0.2, 0.2)), "p1"


def scanned(unknowns: int) -> tuple[TetMesh, str]:
    """A bar as pytetwild cuts it, in quadratic elements; once refined beyond 20,000 unknowns."""
    tets = unknowns / 5.0
    if unknowns < 20_000:
        return tetrahedralize(bar(), int(tets))[0], "p2"
    return refine(tetrahedralize(bar(), int(tets / 8))[0]), "p2"


def problem(mesh: TetMesh, element: str):
    """K, M and places of the free dofs, the end at x = 0 held."""
    model = assemble(mesh, RUBBER, element)
    end = (np.abs(mesh.nodes[boundary(mesh).corners, 0]) < HAIR).all(axis=1)
    model = hold_points(model, np.unique(face_points(model, each=True)[end]))
    free = model.free
    places = np.repeat(model.points, 3, axis=0)[free]
    return model.stiffness[free][:, free], model.mass[free][:, free], places


def ours(K, M, places, backend: str = "cholmod"):
    kept, eigen.cholmod = eigen.cholmod, eigen.cholmod if backend == "cholmod" else None
    start = time.process_time()
    values, _ = eigen.lowest_eigenpairs(K, M, COUNT, places)
    eigen.cholmod = kept
    return time.process_time() - start, values


def scikit_fem(mesh: TetMesh, element: str):
    """Its own basis, assembly and eigensolver, as its examples put them together."""
    import skfem
    from skfem.helpers import ddot, dot, eye, sym_grad, trace
    from skfem.models.elasticity import lame_parameters

    lam, mu = lame_parameters(1.0, RUBBER.poisson_ratio)
    cells = skfem.MeshTet(mesh.nodes.T.copy(), mesh.tets.T.copy())
    scalar = skfem.ElementTetP1() if element == "p1" else skfem.ElementTetP2()
    basis = skfem.Basis(cells, skfem.ElementVector(scalar))

    @skfem.BilinearForm
    def stiffness(u, v, _):
        strain = sym_grad(u)
        return ddot(2 * mu * strain + eye(lam * trace(strain), 3), sym_grad(v))

    @skfem.BilinearForm
    def mass(u, v, _):
        return RUBBER.density * dot(u, v)

    K, M = stiffness.assemble(basis), mass.assemble(basis)
    held = basis.get_dofs(lambda x: np.abs(x[0]) < HAIR)
    start = time.process_time()
    solver = skfem.solver_eigen_scipy_sym(k=COUNT, sigma=0.0)
    values, _ = skfem.solve(*skfem.condense(K, M, D=held), solver=solver)
    return time.process_time() - start, np.sort(values)


def netgen_mesh(mesh: TetMesh):
    from netgen import meshing

    out = meshing.Mesh(dim=3)
    ids = [out.Add(meshing.MeshPoint(meshing.Pnt(*map(float, p)))) for p in mesh.nodes]
    skin = boundary(mesh)
    for number, held in ((1, True), (2, False)):
        out.Add(meshing.FaceDescriptor(surfnr=number, domin=1, domout=0, bc=number))
        out.SetBCName(number - 1, "held" if held else "free")
    for corners in skin.corners:
        number = 1 if (np.abs(mesh.nodes[corners, 0]) < HAIR).all() else 2
        out.Add(meshing.Element2D(number, [ids[i] for i in corners]))
    for a, b, c, d in mesh.tets:  # netgen turns its tetrahedra the other way
        out.Add(meshing.Element3D(1, [ids[i] for i in (a, c, b, d)]))
    return out


def ngsolve_modes(mesh: TetMesh, element: str):
    import ngsolve as ng

    ng.SetNumThreads(1)
    ng.ngsglobals.msg_level = 0
    nu = RUBBER.poisson_ratio
    mu, lam = 1 / (2 * (1 + nu)), nu / ((1 + nu) * (1 - 2 * nu))
    space = ng.VectorH1(
        ng.Mesh(netgen_mesh(mesh)), order=1 if element == "p1" else 2, dirichlet="held"
    )
    u, v = space.TnT()
    eps = [ng.Sym(ng.Grad(w)) for w in (u, v)]
    form = 2 * mu * ng.InnerProduct(*eps) + lam * ng.div(u) * ng.div(v)
    K = ng.BilinearForm(form * ng.dx, symmetric=True).Assemble()
    M = ng.BilinearForm(RUBBER.density * u * v * ng.dx, symmetric=True).Assemble()
    found = [ng.CreateVVector(space.ndof, True, 1) for _ in range(KRYLOV)]
    start = time.process_time()
    values = ng.ArnoldiSolver(K.mat, M.mat, space.FreeDofs(), found, 0, inverse="sparsecholesky")
    return time.process_time() - start, np.sort(np.array([complex(x).real for x in values]))[:COUNT]


def peak(kind: str, size: int) -> float:
    """GB that building and solving takes at most, in a process of its own."""
    with get_context("spawn").Pool(1) as pool:
        return pool.apply(_peak, (kind, size))


def _peak(kind: str, size: int) -> float:
    mesh, element = structured(size) if kind == "bar" else scanned(size)
    ours(*problem(mesh, element))
    # not ru_maxrss, which a child takes over from its parent
    status = Path("/proc/self/status").read_text()
    return int(status.split("VmHWM:")[1].split()[0]) / 1e6


def report(kind: str, sizes: list[int]) -> None:
    print(f"\n{kind}: {'unknowns':>9} {'entries':>9} | seconds (times ours) disagreement")
    growth = []
    for size in sizes:
        mesh, element = structured(size) if kind == "bar" else scanned(size)
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
    parser.add_argument("--kinds", default="bar,scan")
    args = parser.parse_args()
    for which in args.kinds.split(","):
        report(which, [int(size) for size in args.sizes.split(",")])
