"""Cubic tetrahedra with straight edges: the yardstick that tells how far quadratic ones are off.

Source      Zienkiewicz & Taylor, The Finite Element Method, vol. 1, ch. 6
"""

import numpy as np

from ..data import TetMesh
from .element import Element, Matrices
from .simplex import EDGES, assemble_lagrange, tet_edges, tet_faces

FACES = np.array([(1, 2, 3), (0, 2, 3), (0, 1, 3), (0, 1, 2)])


def cells(mesh: TetMesh) -> np.ndarray:
    """(T, 20) corners; two thirds of each of `EDGES`, nearer to its first corner first; faces."""
    edges, edge = tet_edges(mesh.tets)
    first = mesh.tets[:, EDGES[:, 0]] == edges[edge, 0]
    start = len(mesh.nodes) + 2 * edge
    thirds = np.stack([start + ~first, start + first], axis=2).reshape(-1, 12)
    face = len(mesh.nodes) + 2 * len(edges) + tet_faces(mesh.tets)[1]
    return np.column_stack([mesh.tets, thirds, face])


def points(mesh: TetMesh) -> np.ndarray:
    """(P, 3) m: nodes, thirds of edges from the lower node on, middles of faces."""
    low, high = mesh.nodes[tet_edges(mesh.tets)[0]].transpose(1, 0, 2)
    thirds = np.stack([(2 * low + high) / 3, (low + 2 * high) / 3], axis=1).reshape(-1, 3)
    middles = mesh.nodes[tet_faces(mesh.tets)[0]].mean(axis=1)
    return np.concatenate([mesh.nodes, thirds, middles])


def basis(bary: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Corners ½ L (3L-1)(3L-2), thirds 4½ L_a L_b (3L_a-1), faces 27 L_a L_b L_c.

    Values (n, 20) and derivatives (n, 20, 4).
    """
    n, L = len(bary), bary
    values, slopes = np.zeros((n, 20)), np.zeros((n, 20, 4))
    values[:, :4] = L * (3 * L - 1) * (3 * L - 2) / 2
    slopes[:, range(4), range(4)] = (27 * L**2 - 18 * L + 2) / 2
    for start, (a, b) in ((4, EDGES.T), (5, EDGES[:, ::-1].T)):
        rows = range(start, 16, 2)
        values[:, rows] = 4.5 * L[:, a] * L[:, b] * (3 * L[:, a] - 1)
        slopes[:, rows, a] = 4.5 * L[:, b] * (6 * L[:, a] - 1)
        slopes[:, rows, b] = 4.5 * L[:, a] * (3 * L[:, a] - 1)
    values[:, 16:] = 27 * L[:, FACES].prod(axis=2)
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        slopes[:, range(16, 20), FACES[:, i]] = 27 * L[:, FACES[:, j]] * L[:, FACES[:, k]]
    return values, slopes


def build(mesh: TetMesh, scale: np.ndarray) -> Matrices:
    """Matrices of the mesh; `scale` (T,) multiplies the stiffness of each tetrahedron."""
    return assemble_lagrange(mesh, P3, points(mesh), scale)


P3 = Element("p3", 3, build, cells, basis)
