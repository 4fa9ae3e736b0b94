"""A mesh whose skin has an edge where its pins end.

A triangle that is held at one corner and free at another holds too much or too little, whichever
polynomial spans it, and a finer element on the same triangles does not mend it.
"""

from collections.abc import Callable

import numpy as np

from .boundary import boundary
from .data import TetMesh
from .elasticity import HAIR
from .elements.simplex import EDGES, tet_edges

NEAR = 0.2  # of an edge, from its held end: the rim is where the mesh has a node
LEAST = 0.25  # of an edge, that is cut off one
HALVINGS = 8  # of an edge, to find the rim on it


def along_rim(mesh: TetMesh, held: Callable[..., np.ndarray]) -> TetMesh:
    """The mesh with nodes where its skin's edges leave what is held; its own nodes come first.

    `held`: see `held_part`.
    """
    ends, share = _crossings(mesh, held)
    while len(ends):
        mesh, left = _cut(mesh, ends, share)
        ends, share = ends[left], share[left]
    return mesh


def _crossings(mesh: TetMesh, held: Callable[..., np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """(n, 2) held and free end of the skin's edges that the rim crosses, and where each is cut
    (n,), as a share of it.
    """
    skin = boundary(mesh)
    corners, nodes = skin.corners, np.unique(skin.corners)
    on = np.zeros(len(mesh.nodes), bool)
    on[nodes] = held(mesh.nodes[nodes], HAIR * skin.edge_length)
    pairs = np.unique(np.sort(corners[:, [(0, 1), (1, 2), (2, 0)]].reshape(-1, 2), axis=1), axis=0)
    pairs = pairs[on[pairs[:, 0]] != on[pairs[:, 1]]]
    ends = np.where(on[pairs[:, :1]], pairs, pairs[:, ::-1])
    start = mesh.nodes[ends[:, 0]]
    way = mesh.nodes[ends[:, 1]] - start
    low, high = np.zeros(len(ends)), np.ones(len(ends))
    for _ in range(HALVINGS if len(ends) else 0):
        middle = (low + high) / 2
        inside = held(start + middle[:, None] * way)
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    cut = low > NEAR
    return ends[cut], np.clip(low[cut], LEAST, 1 - LEAST)


def _cut(mesh: TetMesh, ends: np.ndarray, share: np.ndarray) -> tuple[TetMesh, np.ndarray]:
    """Some of these edges cut in two, with all tetrahedra about them, and those (n,) bool that are
    left: of two in one tetrahedron the shorter one.
    """
    edges, edge = tet_edges(mesh.tets)
    count = len(mesh.nodes)
    own = np.searchsorted(edges @ [count, 1], np.sort(ends, axis=1) @ [count, 1])
    length = np.linalg.norm(mesh.nodes[ends[:, 0]] - mesh.nodes[ends[:, 1]], axis=1)
    rank = np.full(len(edges), -1)
    rank[own[np.argsort(length, kind="stable")]] = np.arange(len(ends))
    beaten = np.zeros(len(edges), bool)
    for mine in edge.T:
        beaten[mine[rank[mine] < rank[edge].max(axis=1)]] = True
    left = beaten[own]
    start = mesh.nodes[ends[~left, 0]]
    places = start + share[~left, None] * (mesh.nodes[ends[~left, 1]] - start)
    new = np.full(len(edges), -1)
    new[own[~left]] = count + np.arange(len(places))
    at = np.flatnonzero((new[edge] >= 0).any(axis=1))
    local = np.argmax(new[edge[at]] >= 0, axis=1)
    halves = []
    for end in EDGES[local].T:
        half = mesh.tets[at].copy()
        half[np.arange(len(at)), end] = new[edge[at, local]]
        halves.append(half)
    tets = np.vstack([np.delete(mesh.tets, at, axis=0), *halves])
    return TetMesh(np.vstack([mesh.nodes, places]), tets), left
