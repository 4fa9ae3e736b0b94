"""Nested refinement: every tetrahedron into eight.

Source      Bey, Tetrahedral grid refinement, Computing 55 (1995)
"""

import numpy as np

from .data import TetMesh, tet_volumes
from .elements.simplex import EDGES, tet_edges

CORNERS = {pair: i for i, pair in enumerate(map(tuple, EDGES))}


def refine(mesh: TetMesh) -> TetMesh:
    """The same body in eight times as many tetrahedra; nodes of the coarse mesh come first.

    The inner octahedron is cut along its shortest diagonal.
    """
    edges, edge = tet_edges(mesh.tets)
    middle = edge + len(mesh.nodes)
    nodes = np.concatenate([mesh.nodes, mesh.nodes[edges].mean(axis=1)])
    tips = [
        np.column_stack([mesh.tets[:, a], *(middle[:, _between(a, b)] for b in range(4) if b != a)])
        for a in range(4)
    ]
    diagonals = [(0, 5, (1, 2, 4, 3)), (1, 4, (0, 2, 5, 3)), (2, 3, (0, 1, 5, 4))]
    vectors = [nodes[middle[:, p]] - nodes[middle[:, q]] for p, q, _ in diagonals]
    shortest = np.argmin(np.linalg.norm(vectors, axis=2), axis=0)
    cores = []
    for which, (p, q, belt) in enumerate(diagonals):
        m = middle[shortest == which]
        for i in range(4):
            r, s = belt[i], belt[(i + 1) % 4]
            cores.append(m[:, [p, q, r, s]])
    tets = np.concatenate([*tips, *cores])
    flipped = tet_volumes(nodes, tets) < 0
    tets[flipped] = tets[flipped][:, [1, 0, 2, 3]]
    return TetMesh(nodes, tets)


def _between(a: int, b: int) -> int:
    return CORNERS[min(a, b), max(a, b)]
