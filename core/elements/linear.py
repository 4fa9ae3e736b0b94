"""Linear simplices in one, two and three dimensions: the family that `p1` is the solid one of.

Two-dimensional elasticity is plane strain: thick along the third axis, and it cannot move there.

Source      Zienkiewicz & Taylor, The Finite Element Method, vol. 1, ch. 6
"""

import numpy as np
from scipy import sparse

from .simplex import gradient_products, gradients, pairs_of, scalar_matrix


def laplacian(nodes: np.ndarray, cells: np.ndarray) -> sparse.csr_matrix:
    """(N, N) ∫ ∇N_a · ∇N_b over simplices `cells` (T, d+1) of `nodes` (N, d)."""
    volume, g = gradients(nodes, cells)
    return scalar_matrix(pairs_of(cells, len(nodes)), np.einsum("t,tai,tbi->tab", volume, g, g))


def scalar_mass(nodes: np.ndarray, cells: np.ndarray) -> sparse.csr_matrix:
    """(N, N) ∫ N_a N_b = V (1 + δ_ab) / ((d + 1)(d + 2)), consistent."""
    volume, _ = gradients(nodes, cells)
    k = cells.shape[1]
    entries = volume[:, None, None] * (1 + np.eye(k)) / (k * (k + 1))
    return scalar_matrix(pairs_of(cells, len(nodes)), entries)


def shear_and_bulk(
    nodes: np.ndarray, cells: np.ndarray
) -> tuple[sparse.csr_matrix, sparse.csr_matrix]:
    """G and B, (dN, dN), of isotropic elasticity K = μ G + κ B in `d` dimensions, strain plane.

    B_ab = D_ab = ∫ ∇N_a ⊗ ∇N_b and G_ab = tr(D_ab) I + D_abᵀ - ⅔ D_ab.
    """
    volume, g = gradients(nodes, cells)
    d = nodes.shape[1]

    def product(i: int, j: int) -> np.ndarray:
        return volume[:, None, None] * g[:, :, None, i] * g[:, None, :, j]

    D = gradient_products(pairs_of(cells, len(nodes)), product, d)
    blocks = D.data.transpose(0, 2, 1) - 2 / 3 * D.data
    blocks[:, range(d), range(d)] += np.trace(D.data, axis1=1, axis2=2)[:, None]
    return sparse.bsr_matrix((blocks, D.indices, D.indptr), D.shape).tocsr(), D.tocsr()


def stiffness(nodes: np.ndarray, cells: np.ndarray, poisson_ratio: float) -> sparse.csr_matrix:
    """(dN, dN) K at Young's modulus 1 Pa."""
    shear, bulk = shear_and_bulk(nodes, cells)
    return shear / (2 * (1 + poisson_ratio)) + bulk / (3 * (1 - 2 * poisson_ratio))
