"""Linear tetrahedra, shear smoothed over edges and volume over nodes: no locking up to nu = 0.499.

A strain is averaged over the tetrahedra around each edge (each lends a sixth of its volume), its
deviatoric energy counted there; the dilatation is averaged around each node (a quarter each).
The unknowns are those of `p1`, the matrix has about three times the entries. It is no
conforming element: frequencies approach from either side.

Source      Liu & Nguyen-Thoi, Smoothed Finite Element Methods, 2010, ch. 7-9;
            Onishi & Amaya, Int. J. Numer. Meth. Eng. 99 (2014)
"""

import numpy as np
from scipy import sparse

from ..data import TetMesh
from .element import Element, Matrices
from .p1 import basis, cells, mass
from .simplex import averages, gradients, pairs_of, shear_of, tet_edges


def domains(mesh: TetMesh) -> tuple[np.ndarray, np.ndarray]:
    """Edges (T, 6), over which shear is averaged, and nodes (T, 4), over which volume is."""
    return tet_edges(mesh.tets)[1], mesh.tets


def divergences(mesh: TetMesh, g: np.ndarray) -> sparse.csr_matrix:
    """(T, 3N) 1/m: row t gives div u of tetrahedron t, and its entries are the gradients `g`."""
    columns = (3 * mesh.tets[:, :, None] + np.arange(3)).reshape(-1)
    starts = np.arange(0, columns.size + 1, 12)
    return sparse.csr_matrix(
        (g.reshape(-1), columns, starts), shape=(len(mesh.tets), 3 * len(mesh.nodes))
    )


def smoothed_products(
    domains: np.ndarray, volume: np.ndarray, gradient: sparse.csr_matrix, scale: np.ndarray
) -> sparse.csr_matrix:
    """D (3N, 3N) = Σ_d V_d ∇̃N_a ⊗ ∇̃N_b with gradients averaged over each domain d."""
    mean, size = averages(domains, volume)
    root = sparse.diags(np.sqrt(size * (mean @ scale))) @ (mean @ gradient)
    return (root.T @ root).tocsr()


def build(mesh: TetMesh, scale: np.ndarray) -> Matrices:
    """Matrices of the mesh; `scale` (T,) multiplies the stiffness of each tetrahedron."""
    volume, g = gradients(mesh.nodes, mesh.tets)
    gradient = divergences(mesh, g)
    shear, bulk = (smoothed_products(d, volume, gradient, scale) for d in domains(mesh))
    bulk.sort_indices()
    return Matrices(
        mesh.nodes,
        shear_of(shear.tobsr((3, 3))),
        bulk,
        mass(pairs_of(mesh.tets, len(mesh.nodes)), volume),
    )


P1_SMOOTHED = Element("p1_smoothed", 1, build, cells, basis, domains)
