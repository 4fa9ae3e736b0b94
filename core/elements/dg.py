"""Linear discontinuous Galerkin with a symmetric interior penalty: every tetrahedron on its own.

A face between two tetrahedra, n from the first to the second, adds with the jump [u] and mean {·}
- ∫ {σ(u) n}·[v] - ∫ {σ(v) n}·[u] + (η/h) ∫ 2μ [u]·[v] + κ [u]·n [v]·n, h the lower height on it.
η > 6 suffices for a positive matrix (four faces, half of each stress, h ≤ 3 V/A). Penalty is
stiffness: a larger η rings higher, and as η grows the element becomes `p1`, locking and all.
Its points are the corners of each tetrahedron, not the mesh's nodes.

Source      Kaufmann, Martin, Botsch, Gross, Flexible simulation of deformable models using
            discontinuous Galerkin FEM, SCA 2008 / Graphical Models 71 (2009);
            Arnold, Brezzi, Cockburn, Marini, SIAM J. Numer. Anal. 39 (2002)
"""

import numpy as np

from ..data import TetMesh
from . import p1
from .element import Element, Matrices
from .simplex import gradient_products, gradients, pairs_of, tet_faces

PENALTY = 7.0  # η


def cells(mesh: TetMesh) -> np.ndarray:
    """(T, 4) four points of its own for each tetrahedron."""
    return np.arange(mesh.tets.size).reshape(-1, 4)


def inner_faces(mesh: TetMesh) -> tuple[np.ndarray, np.ndarray]:
    """Tetrahedra (F, 2) on both sides of each inner face and the opposite corner (F, 2) in each."""
    face = tet_faces(mesh.tets)[1].ravel()
    order = np.argsort(face, kind="stable")
    pair = np.flatnonzero(np.diff(face[order]) == 0)
    return np.divmod(np.column_stack([order[pair], order[pair + 1]]), 4)


def build(mesh: TetMesh, scale: np.ndarray, penalty: float = PENALTY) -> Matrices:
    """Matrices of the mesh; `scale` (T,) multiplies the stiffness of each tetrahedron."""
    alone = TetMesh(mesh.nodes[mesh.tets].reshape(-1, 3), cells(mesh))
    inside = p1.build(alone, scale)
    shear, bulk = face_blocks(mesh, scale, penalty)
    sides, _ = inner_faces(mesh)
    where = cells(mesh)[sides].reshape(-1, 8)
    pairs = pairs_of(where, len(alone.nodes))
    shear, bulk = (
        gradient_products(pairs, lambda i, j, b=b: b[:, :, :, i, j]).tocsr() for b in (shear, bulk)
    )
    return Matrices(alone.nodes, inside.shear + shear, inside.bulk + bulk, inside.mass)


def face_blocks(mesh: TetMesh, scale: np.ndarray, penalty: float) -> tuple[np.ndarray, np.ndarray]:
    """Shear and bulk blocks (F, 8, 8, 3, 3) of inner faces, on the points of both sides."""
    sides, opposite = inner_faces(mesh)
    volume, g = gradients(mesh.nodes, mesh.tets)
    outward = -np.take_along_axis(g[sides], opposite[:, :, None, None], axis=2)[:, :, 0]
    steep = np.linalg.norm(outward, axis=2)  # (F, 2) 1/height
    n = outward[:, 0] / steep[:, :1]
    area = 3 * volume[sides[:, 0]] * steep[:, 0]
    on = np.arange(4) != opposite[:, :, None]
    sign = (on * np.array([1.0, -1.0])[None, :, None]).reshape(-1, 8)
    stress = (g[sides] * scale[sides][:, :, None, None] / 2).reshape(-1, 8, 3)
    normal = np.einsum("fbk,fk->fb", stress, n)
    volumetric = np.einsum("fi,fbj->fbij", n, stress)
    deviatoric = (
        normal[:, :, None, None] * np.eye(3)
        + np.einsum("fbi,fj->fbij", stress, n)
        - 2 / 3 * volumetric
    )
    corner = mesh.tets[sides].reshape(-1, 8)
    same = 1 + (corner[:, :, None] == corner[:, None, :])
    glue = same * sign[:, :, None] * sign[:, None, :] / 12
    glue *= (penalty * area * steep.max(axis=1) * scale[sides].max(axis=1))[:, None, None]
    jump = sign * area[:, None] / 3
    return (
        _both(jump, deviatoric) + 2 * glue[..., None, None] * np.eye(3),
        _both(jump, volumetric) + np.einsum("fab,fi,fj->fabij", glue, n, n),
    )


def _both(jump: np.ndarray, traction: np.ndarray) -> np.ndarray:
    """- J_a S_b and its transpose, (F, 8, 8, 3, 3)."""
    one = np.einsum("fa,fbij->fabij", jump, traction)
    return -one - one.transpose(0, 2, 1, 4, 3)


DG = Element("dg", 1, build, cells, p1.basis)
