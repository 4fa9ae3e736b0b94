"""Displacements, gradients and turning of a model's field at places, as sparse operators."""

import numpy as np
from scipy import sparse
from scipy.spatial import cKDTree

from .boundary import Faces
from .data import ElasticModel
from .elements import ELEMENTS
from .elements.simplex import each_axis, gradients

PATCH = 1.2  # longest edges of the nearest triangle: how far the surface's turning is averaged


def interpolation(model: ElasticModel, tet: np.ndarray, bary: np.ndarray) -> sparse.csr_matrix:
    """(3n, 3P): displacement at barycentric coordinates `bary` (n, 4) of tetrahedra `tet` (n,)."""
    element = ELEMENTS[model.element]
    values, _ = element.basis(bary)
    return each_axis(_rows(element.cells(model.mesh)[tet], values, len(model.points)))


def gradient_at(model: ElasticModel, tet: np.ndarray, bary: np.ndarray):
    """Points (n, k) of the tetrahedra and ∂N/∂x (n, k, 3) 1/m at these barycentric coordinates."""
    element = ELEMENTS[model.element]
    _, g = gradients(model.mesh.nodes, model.mesh.tets[tet])
    return element.cells(model.mesh)[tet], element.basis(bary)[1] @ g


def _rows(columns: np.ndarray, values: np.ndarray, count: int) -> sparse.csr_matrix:
    """(n, count) csr with `values` (n, k) at `columns` (n, k)."""
    n, k = columns.shape
    starts = np.arange(0, n * k + 1, k)
    return sparse.csr_matrix((values.ravel(), columns.ravel(), starts), shape=(n, count))


def rotation_operator(model: ElasticModel, skin: Faces) -> sparse.csr_matrix:
    """(3F, 3P): ½ curl u (rad) at the middle of each boundary triangle."""
    middle = skin.barycentric(np.arange(len(skin.tet)), np.full((len(skin.tet), 3), 1 / 3))
    cells, g = gradient_at(model, skin.tet, middle)
    n, k = cells.shape
    blocks = np.zeros((n, k, 3, 3))
    for i, j, m in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        blocks[:, :, i, m], blocks[:, :, i, j] = g[:, :, j] / 2, -g[:, :, m] / 2
    starts = np.arange(0, n * k + 1, k)
    shape = (3 * n, 3 * len(model.points))
    return sparse.bsr_matrix((blocks.reshape(-1, 3, 3), cells.ravel(), starts), shape).tocsr()


def patch_means(skin: Faces, face: np.ndarray, foot: np.ndarray) -> sparse.csr_matrix:
    """(3n, 3F): means over the boundary triangles round each foot (n, 3), fading with distance."""
    reach = PATCH * skin.longest_edge[face]
    near = cKDTree(skin.centres).query_ball_point(foot, reach)
    row = np.repeat(np.arange(len(foot)), [len(f) for f in near])
    column = np.concatenate([np.asarray(f, int) for f in near])
    gap = np.linalg.norm(foot[row] - skin.centres[column], axis=1) / reach[row]
    weight = skin.areas[column] * (1 - gap**2)
    weight /= np.bincount(row, weight, len(foot))[row]
    return each_axis(sparse.csr_matrix((weight, (row, column)), shape=(len(foot), len(skin.areas))))


def cross_blocks(r: np.ndarray) -> sparse.bsr_matrix:
    """(3n, 3n) block diagonal r × for r (n, 3)."""
    blocks = np.cross(r[:, None, :], np.eye(3)).transpose(0, 2, 1)
    return sparse.bsr_matrix((blocks, np.arange(len(r)), np.arange(len(r) + 1)))
