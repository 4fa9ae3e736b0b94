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
from .simplex import gradients, shear_of, tet_edges


def averages(domains: np.ndarray, volume: np.ndarray) -> tuple[sparse.csr_matrix, np.ndarray]:
    """Volume-weighted means (D, T) over the tets that share a domain (T, k), volumes (D,) m3."""
    k = domains.shape[1]
    tets = np.repeat(np.arange(len(domains)), k)
    share = np.repeat(volume / k, k)
    sums = sparse.csr_matrix((share, (domains.ravel(), tets)))
    size = np.asarray(sums.sum(axis=1)).ravel()
    return sparse.diags(1 / np.where(size > 0, size, 1)) @ sums, size


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
    shear = smoothed_products(tet_edges(mesh.tets)[1], volume, gradient, scale)
    bulk = smoothed_products(mesh.tets, volume, gradient, scale)
    bulk.sort_indices()
    return Matrices(mesh.nodes, shear_of(shear.tobsr((3, 3))), bulk, mass(mesh, volume))


def divergence(mesh: TetMesh) -> sparse.csr_matrix:
    """(T, 3N) 1/m: the dilatation of each tetrahedron as its four corners, smoothed, see it."""
    volume, g = gradients(mesh.nodes, mesh.tets)
    mean, _ = averages(mesh.tets, volume)
    corners = sparse.csr_matrix(
        (np.full(mesh.tets.size, 0.25), mesh.tets.ravel(), np.arange(0, mesh.tets.size + 1, 4)),
        shape=(len(mesh.tets), mean.shape[0]),
    )
    return (corners @ (mean @ divergences(mesh, g))).tocsr()


P1_SMOOTHED = Element("p1_smoothed", 1, build, cells, basis, divergence)
