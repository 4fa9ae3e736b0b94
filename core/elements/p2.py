"""Quadratic tetrahedra with straight edges: the best accuracy per second where few tets will do.

Source      Zienkiewicz & Taylor, The Finite Element Method, vol. 1, ch. 6
"""

import numpy as np

from ..data import TetMesh
from .element import Element, Matrices
from .simplex import EDGES, assemble_lagrange, tet_edges


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


def build(mesh: TetMesh, scale: np.ndarray) -> Matrices:
    """Matrices of the mesh; `scale` (T,) multiplies the stiffness of each tetrahedron."""
    middles = mesh.nodes[tet_edges(mesh.tets)[0]].mean(axis=1)
    return assemble_lagrange(mesh, P2, np.concatenate([mesh.nodes, middles]), scale)


P2 = Element("p2", 2, build, cells, basis)
