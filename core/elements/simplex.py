"""What all elements share: gradients, edges, quadrature, and sums over elements, in any dimension.

D_ab = ∫ ∇N_a ⊗ ∇N_b is all that isotropic elasticity needs: B_ab = D_ab, and
G_ab = tr(D_ab) I + D_abᵀ - ⅔ D_ab.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from math import factorial

import numpy as np
from scipy import sparse
from scipy.special import roots_jacobi

from ..data import TetMesh
from .element import Element, Matrices

EDGES = np.array([(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)])  # corners, in this order always


def gradients(nodes: np.ndarray, cells: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Volumes (T,) m^d and gradients (T, d+1, d) 1/m of simplices' barycentric coordinates."""
    d = cells.shape[1] - 1
    edges = nodes[cells[:, 1:]] - nodes[cells[:, :1]]
    others = np.linalg.inv(edges).transpose(0, 2, 1)
    gradient = np.concatenate([-others.sum(axis=1, keepdims=True), others], axis=1)
    return np.abs(np.linalg.det(edges)) / factorial(d), gradient


def tet_edges(tets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The edges (E, 2), each once with its lower node first, and those of each tet (T, 6)."""
    pairs = np.sort(tets[:, EDGES].reshape(-1, 2), axis=1)
    count = int(tets.max()) + 1
    key, where = np.unique(pairs[:, 0] * count + pairs[:, 1], return_inverse=True)
    return np.column_stack(np.divmod(key, count)), where.reshape(-1, 6)


def tet_faces(tets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The triangles (F, 3), each once, ascending, and those opposite each corner of tets (T, 4)."""
    corners = np.sort(tets[:, [(1, 2, 3), (0, 2, 3), (0, 1, 3), (0, 1, 2)]].reshape(-1, 3), axis=1)
    count = int(tets.max()) + 1
    key = (corners[:, 0] * count + corners[:, 1]) * count + corners[:, 2]
    _, first, where = np.unique(key, return_index=True, return_inverse=True)
    return corners[first], where.reshape(-1, 4)


def quadrature(dimension: int, degree: int) -> tuple[np.ndarray, np.ndarray]:
    """Barycentric points (q, d+1) and weights (q,), sum 1, exact up to `degree`.

    The conical product of Gauss-Jacobi rules (Stroud, Approximate Calculation of Multiple
    Integrals, 1971, 2.4).
    """
    order = degree // 2 + 1
    left, bary, weight = np.ones(1), np.zeros((1, 0)), np.ones(1)
    for axis in range(dimension):
        x, w = roots_jacobi(order, dimension - 1 - axis, 0)
        x, w = (1 + x) / 2, w / w.sum()
        bary = np.column_stack([np.repeat(bary, order, axis=0), np.outer(left, x).ravel()])
        left, weight = np.outer(left, 1 - x).ravel(), np.outer(weight, w).ravel()
    return np.column_stack([bary, left]), weight


@dataclass(frozen=True, eq=False)
class Pairs:
    """The pattern of an assembled matrix: which pairs of points share a cell."""

    count: int  # points
    columns: np.ndarray  # (nnz,) of each row in turn, ascending
    starts: np.ndarray  # (count + 1,)
    where: np.ndarray  # (T k k,) the entry that each element entry is added to
    mirror: np.ndarray  # (nnz,) the transposed entry of each

    def add(self, entries: np.ndarray) -> np.ndarray:
        """(nnz,) sums of element entries (T, k, k)."""
        return np.bincount(self.where, weights=entries.ravel(), minlength=len(self.columns))


def pairs_of(cells: np.ndarray, count: int) -> Pairs:
    """The pattern for `count` points in cells (T, k)."""
    k = cells.shape[1]
    key = (cells[:, :, None] * count + cells[:, None, :]).ravel()
    unique, where = np.unique(key, return_inverse=True)
    where = where.reshape(-1)
    rows, columns = np.divmod(unique, count)
    mirror = np.empty(len(unique), int)
    mirror[where] = where.reshape(-1, k, k).transpose(0, 2, 1).ravel()
    return Pairs(count, columns, np.searchsorted(rows, np.arange(count + 1)), where, mirror)


@lru_cache(maxsize=1)
def _pattern(mesh: TetMesh, element: Element, count: int) -> Pairs:
    """The pattern of an element's matrices; a mesh is mostly assembled several times in a row."""
    return pairs_of(element.cells(mesh), count)


def gradient_products(
    pairs: Pairs, product: Callable[[int, int], np.ndarray], d: int = 3
) -> sparse.bsr_matrix:
    """D (d count, d count) in blocks d x d from element entries product(i, j) (T, k, k)."""
    blocks = np.empty((len(pairs.columns), d, d))
    for i in range(d):
        for j in range(i, d):
            blocks[:, i, j] = pairs.add(product(i, j))
            blocks[:, j, i] = blocks[pairs.mirror, i, j]
    shape = (d * pairs.count, d * pairs.count)
    return sparse.bsr_matrix((blocks, pairs.columns, pairs.starts), shape=shape)


def shear_of(products: sparse.bsr_matrix) -> sparse.csr_matrix:
    """G, the stiffness of the deviatoric part at mu = 1, from D in blocks 3 x 3."""
    D = products.data
    blocks = D.transpose(0, 2, 1) - 2 / 3 * D
    blocks[:, range(3), range(3)] += np.trace(D, axis1=1, axis2=2)[:, None]
    return sparse.bsr_matrix((blocks, products.indices, products.indptr), products.shape).tocsr()


def scalar_matrix(pairs: Pairs, entries: np.ndarray) -> sparse.csr_matrix:
    """(count, count) csr from element entries (T, k, k)."""
    return sparse.csr_matrix(
        (pairs.add(entries), pairs.columns, pairs.starts), shape=(pairs.count, pairs.count)
    )


def each_axis(scalar: sparse.csr_matrix, d: int = 3) -> sparse.csr_matrix:
    """The same scalar matrix for every axis: (n, m) to (d n, d m)."""
    scalar = scalar.tocsr()
    blocks = scalar.data[:, None, None] * np.eye(d)
    shape = (d * scalar.shape[0], d * scalar.shape[1])
    out = sparse.bsr_matrix((blocks, scalar.indices, scalar.indptr), shape).tocsr()
    out.eliminate_zeros()
    return out


def averages(domains: np.ndarray, volume: np.ndarray) -> tuple[sparse.csr_matrix, np.ndarray]:
    """Volume-weighted means (D, T) over the tets that share a domain (T, k), volumes (D,) m3."""
    k = domains.shape[1]
    tets = np.repeat(np.arange(len(domains)), k)
    sums = sparse.csr_matrix((np.repeat(volume / k, k), (domains.ravel(), tets)))
    size = np.asarray(sums.sum(axis=1)).ravel()
    return sparse.diags(1 / np.where(size > 0, size, 1)) @ sums, size


def assemble_lagrange(
    mesh: TetMesh, element: Element, points: np.ndarray, scale: np.ndarray
) -> Matrices:
    """Matrices of an element with straight edges, from integrals over one reference tetrahedron.

    D_ab = Σ_kl V ∇L_k ⊗ ∇L_l R_abkl with R_abkl = ∫ ∂N_a/∂L_k ∂N_b/∂L_l / V.
    """
    bary, weight = quadrature(3, 2 * element.degree)
    N, dN = element.basis(bary)
    k = N.shape[1]
    table = np.einsum("q,qak,qbl->klab", weight, dN, dN).reshape(16, k * k)
    volume, g = gradients(mesh.nodes, mesh.tets)

    def product(i: int, j: int) -> np.ndarray:
        metric = (scale * volume)[:, None, None] * g[:, :, None, i] * g[:, None, :, j]
        return metric.reshape(-1, 16) @ table

    pairs = _pattern(mesh, element, len(points))
    D = gradient_products(pairs, product)
    masses = np.einsum("q,qa,qb->ab", weight, N, N)
    mass = scalar_matrix(pairs, volume[:, None, None] * masses)
    return Matrices(points, shear_of(D), D.tocsr(), each_axis(mass))
