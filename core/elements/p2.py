"""Quadratic tetrahedra with straight edges: the best accuracy per second where few tets will do.

Source      Zienkiewicz & Taylor, The Finite Element Method, vol. 1, ch. 6
"""

import numpy as np

from ..data import TetMesh
from .element import Element, Matrices
from .simplex import (
    EDGES,
    each_axis,
    gradient_products,
    gradients,
    quadrature,
    scalar_matrix,
    shear_of,
    tet_edges,
)


def cells(mesh: TetMesh) -> np.ndarray:
    """(T, 10) four corners, then the midpoints of `EDGES`; midpoints follow the mesh's nodes."""
    return np.column_stack([mesh.tets, len(mesh.nodes) + tet_edges(mesh.tets)[1]])


def basis(bary: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """N_a = L_a (2 L_a - 1), N_ab = 4 L_a L_b: values (n, 10), derivatives (n, 10, 4)."""
    a, b = EDGES.T
    values = np.column_stack([bary * (2 * bary - 1), 4 * bary[:, a] * bary[:, b]])
    derivatives = np.zeros((len(bary), 10, 4))
    derivatives[:, range(4), range(4)] = 4 * bary - 1
    derivatives[:, range(4, 10), a] = 4 * bary[:, b]
    derivatives[:, range(4, 10), b] = 4 * bary[:, a]
    return values, derivatives


def reference() -> tuple[np.ndarray, np.ndarray]:
    """∫ N_a N_b / V (10, 10) and ∫ ∂N_a/∂L_k ∂N_b/∂L_l / V (4, 4, 10, 10)."""
    bary, weight = quadrature(3, 4)
    N, dN = basis(bary)
    return np.einsum("q,qa,qb->ab", weight, N, N), np.einsum("q,qak,qbl->klab", weight, dN, dN)


def build(mesh: TetMesh, scale: np.ndarray) -> Matrices:
    """Matrices of the mesh; `scale` (T,) multiplies the stiffness of each tetrahedron."""
    edges, _ = tet_edges(mesh.tets)
    points = np.concatenate([mesh.nodes, mesh.nodes[edges].mean(axis=1)])
    where = cells(mesh)
    volume, g = gradients(mesh.nodes, mesh.tets)
    masses, stiffnesses = reference()
    table = stiffnesses.reshape(16, 100)

    def product(i: int, j: int) -> np.ndarray:
        metric = (scale * volume)[:, None, None] * g[:, :, None, i] * g[:, None, :, j]
        return metric.reshape(-1, 16) @ table

    D = gradient_products(where, len(points), product)
    mass = scalar_matrix(where, len(points), volume[:, None, None] * masses)
    return Matrices(points, shear_of(D), D.tocsr(), each_axis(mass))


P2 = Element("p2", 2, build, cells, basis)
