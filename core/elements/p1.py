"""Linear tetrahedra: cheapest, from above, and they lock when nearly incompressible.

Source      Zienkiewicz & Taylor, The Finite Element Method, vol. 1, ch. 6
"""

import numpy as np
from scipy import sparse

from ..data import TetMesh
from .element import Element, Matrices
from .simplex import (
    Pairs,
    each_axis,
    gradient_products,
    gradients,
    pairs_of,
    scalar_matrix,
    shear_of,
)


def cells(mesh: TetMesh) -> np.ndarray:
    """(T, 4) the corners."""
    return mesh.tets


def basis(bary: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """N_a = L_a: values (n, 4), derivatives (n, 4, 4)."""
    return bary, np.broadcast_to(np.eye(4), (len(bary), 4, 4))


def mass(pairs: Pairs, volume: np.ndarray) -> sparse.csr_matrix:
    """Consistent mass (3N, 3N) m3 of linear shape functions: ∫ L_a L_b = V (1 + δ_ab) / 20."""
    return each_axis(scalar_matrix(pairs, volume[:, None, None] * (1 + np.eye(4)) / 20))


def build(mesh: TetMesh, scale: np.ndarray) -> Matrices:
    """Matrices of the mesh; `scale` (T,) multiplies the stiffness of each tetrahedron."""
    volume, g = gradients(mesh.nodes, mesh.tets)
    weighted = (scale * volume)[:, None, None]

    def product(i: int, j: int) -> np.ndarray:
        return weighted * g[:, :, None, i] * g[:, None, :, j]

    pairs = pairs_of(mesh.tets, len(mesh.nodes))
    D = gradient_products(pairs, product)
    return Matrices(mesh.nodes, shear_of(D), D.tocsr(), mass(pairs, volume))


P1 = Element("p1", 1, build, cells, basis)
