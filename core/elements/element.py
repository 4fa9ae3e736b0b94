"""What an element is: how it cuts a body into points, and the matrices that follow."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from ..data import TetMesh


@dataclass(frozen=True, eq=False)
class Matrices:
    """Matrices of one body at unit moduli and unit density, dofs x0 y0 z0 x1 ..."""

    points: np.ndarray  # (P, 3) m
    shear: sparse.csr_matrix  # (3P, 3P) m, deviatoric part at mu = 1 Pa
    bulk: sparse.csr_matrix  # (3P, 3P) m, volumetric part at kappa = 1 Pa
    mass: sparse.csr_matrix  # (3P, 3P) m3, consistent, at density 1 kg/m3


@dataclass(frozen=True)
class Element:
    """One way to interpolate displacements on tetrahedra.

    build(mesh, scale)  Matrices; `scale` (T,) multiplies the stiffness of each tetrahedron
    cells(mesh)         (T, k) the points that belong to each tetrahedron
    basis(bary)         values (n, k) and derivatives by the barycentric coordinates (n, k, 4) of
                        the k shape functions at barycentric coordinates (n, 4)
    domains(mesh)       (T, k) and (T, l): the domains that share each tetrahedron, over which the
                        deviatoric and the volumetric strain are averaged; None = not averaged
    mixed               the dilatation is projected on functions linear between the nodes
    """

    name: str
    degree: int
    build: Callable[[TetMesh, np.ndarray], Matrices]
    cells: Callable[[TetMesh], np.ndarray]
    basis: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
    domains: Callable[[TetMesh], tuple[np.ndarray, np.ndarray]] | None = None
    mixed: bool = False
