"""The skin of a solid mesh."""

from dataclasses import dataclass

import numpy as np

from .data import ElasticModel, TetMesh
from .elements import ELEMENTS

OPPOSITE = np.array([(1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1)])  # faces of a tet, turned outward


@dataclass(frozen=True, eq=False)
class Faces:
    """Boundary triangles of a tetrahedral mesh, turned outward."""

    corners: np.ndarray  # (F, 3) rows of the mesh's nodes
    tet: np.ndarray  # (F,) the tetrahedron behind each
    local: np.ndarray  # (F, 3) which corners of that tetrahedron
    centres: np.ndarray  # (F, 3) m
    normals: np.ndarray  # (F, 3) outward, unit
    areas: np.ndarray  # (F,) m2
    longest_edge: np.ndarray  # (F,) m

    @property
    def edge_length(self) -> float:
        """Typical edge of the skin, m."""
        return float(np.median(self.longest_edge))

    def barycentric(self, face: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """(n, 4) coordinates in the tetrahedra behind of points with `weights` (n, 3) on faces."""
        out = np.zeros((len(face), 4))
        np.put_along_axis(out, self.local[face], weights, axis=1)
        return out


def boundary(mesh: TetMesh) -> Faces:
    """The triangles that belong to one tetrahedron only."""
    faces = mesh.tets[:, OPPOSITE].reshape(-1, 3)
    key = np.sort(faces, axis=1)
    order = np.lexsort(key.T)
    fresh = np.append(True, (np.diff(key[order], axis=0) != 0).any(axis=1))
    group = np.cumsum(fresh) - 1
    single = np.bincount(group)[group] == 1
    rows = np.sort(order[single])
    corners = faces[rows]
    a, b, c = mesh.nodes[corners].transpose(1, 0, 2)
    cross = np.cross(b - a, c - a)
    twice = np.linalg.norm(cross, axis=1)
    edges = np.stack([np.linalg.norm(p - q, axis=1) for p, q in ((a, b), (b, c), (c, a))])
    normals = cross / twice[:, None]
    return Faces(
        corners, rows // 4, OPPOSITE[rows % 4], (a + b + c) / 3, normals, twice / 2, edges.max(0)
    )


def face_points(model: ElasticModel, *, each: bool = False) -> np.ndarray:
    """Points of the model that lie on its skin: ascending (n,), or (F, k) of `each`."""
    element, skin = ELEMENTS[model.element], boundary(model.mesh)
    somewhere = np.array([0.2, 0.35, 0.45])  # no shape function of the face vanishes here
    faces = np.arange(len(skin.tet))
    values, _ = element.basis(skin.barycentric(faces, np.tile(somewhere, (len(faces), 1))))
    on = np.abs(values) > 1e-12
    points = element.cells(model.mesh)[skin.tet][on].reshape(len(faces), -1)
    return points if each else np.unique(points)
