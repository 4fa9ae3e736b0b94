"""Quadratic tetrahedra with a pressure of its own: for rubber that keeps its volume, nu to 0.4999.

The dilatation is projected on functions that are linear and continuous, with a lumped matrix, so
that the pressure drops out tetrahedron patch by tetrahedron patch: the unknowns are those of `p2`
and the matrix stays positive definite, but fuller. Not conforming in the energy: frequencies
approach from either side.

Source      Taylor & Hood, Computers & Fluids 1 (1973);
            Zienkiewicz & Taylor, The Finite Element Method, vol. 1, ch. 11
"""

from dataclasses import replace

import numpy as np
from scipy import sparse

from ..data import TetMesh
from . import p2
from .element import Element, Matrices
from .simplex import gradients, quadrature


def nodal_dilatation(mesh: TetMesh) -> tuple[sparse.csr_matrix, np.ndarray]:
    """θ_i = ∫ L_i div u / ∫ L_i as an operator (N, 3P), and ∫ L_i (N,) m3."""
    cells = p2.cells(mesh)
    volume, g = gradients(mesh.nodes, mesh.tets)
    bary, weight = quadrature(3, 2)
    table = np.einsum("q,ql,qak->lak", weight, bary, p2.basis(bary)[1])
    entries = np.einsum("t,lak,tki->tlai", volume, table, g)
    rows = np.broadcast_to(mesh.tets[:, :, None, None], entries.shape)
    columns = np.broadcast_to((3 * cells[:, :, None] + np.arange(3))[:, None], entries.shape)
    size = np.bincount(mesh.tets.ravel(), np.repeat(volume / 4, 4), len(mesh.nodes))
    sums = sparse.csr_matrix(
        (entries.ravel(), (rows.ravel(), columns.ravel())), (len(size), 3 * (cells.max() + 1))
    )
    return sparse.diags(1 / np.where(size > 0, size, 1)) @ sums, size


def build(mesh: TetMesh, scale: np.ndarray) -> Matrices:
    """Matrices of the mesh; `scale` (T,) multiplies the stiffness of each tetrahedron."""
    volume, _ = gradients(mesh.nodes, mesh.tets)
    dilatation, size = nodal_dilatation(mesh)
    scaled = np.bincount(mesh.tets.ravel(), np.repeat(scale * volume / 4, 4), len(size))
    root = sparse.diags(np.sqrt(scaled)) @ dilatation
    bulk = (root.T @ root).tocsr()
    bulk.sort_indices()
    return replace(p2.build(mesh, scale), bulk=bulk)


P2_MIXED = Element("p2_mixed", 2, build, p2.cells, p2.basis, mixed=True)
