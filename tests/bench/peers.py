"""What our benchmarks are held against, put together as each tool's own examples do."""

import numpy as np

from core.boundary import boundary
from core.data import Material, TetMesh

RUBBER = Material(1000.0, 0.3)
HAIR = 1e-6  # m


def scikit_fem_parts(mesh: TetMesh, element: str):
    """scikit-fem's module, its basis maker, and its forms of stiffness (Y = 1 Pa) and mass."""
    import skfem
    from skfem.helpers import ddot, dot, eye, sym_grad, trace
    from skfem.models.elasticity import lame_parameters

    lam, mu = lame_parameters(1.0, RUBBER.poisson_ratio)
    cells = skfem.MeshTet(mesh.nodes.T.copy(), mesh.tets.T.copy())
    scalar = skfem.ElementTetP1() if element == "p1" else skfem.ElementTetP2()

    @skfem.BilinearForm
    def stiffness(u, v, _):
        strain = sym_grad(u)
        return ddot(2 * mu * strain + eye(lam * trace(strain), 3), sym_grad(v))

    @skfem.BilinearForm
    def mass(u, v, _):
        return RUBBER.density * dot(u, v)

    return skfem, lambda: skfem.Basis(cells, skfem.ElementVector(scalar)), stiffness, mass


def netgen_mesh(mesh: TetMesh):
    """The mesh as netgen has it; its skin at x = 0 is called "held"."""
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


def ngsolve_matrices(mesh: TetMesh, element: str):
    """ngsolve's module, its space, and its stiffness (Y = 1 Pa) and mass."""
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
    return ng, space, K, M
