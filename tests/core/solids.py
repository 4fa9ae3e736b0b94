"""Bodies with known answers."""

from itertools import permutations

import numpy as np

from core.data import Surface, TetMesh, tet_volumes


def block(counts: tuple, size: tuple, *, jitter: float = 0.0) -> TetMesh:
    """A box from the origin, six tetrahedra a cell; inner nodes moved by `jitter` cell widths."""
    axes = [np.linspace(0, s, n + 1) for s, n in zip(size, counts, strict=True)]
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)
    if jitter:
        inner = ((nodes > 0) & (nodes < np.array(size))).all(axis=1)
        moves = np.random.default_rng(1).uniform(-jitter, jitter, nodes.shape)
        nodes = nodes + inner[:, None] * moves * np.array(size) / counts
    cell = np.stack(np.meshgrid(*map(range, counts), indexing="ij"), -1).reshape(-1, 3)
    strides = np.array([(counts[1] + 1) * (counts[2] + 1), counts[2] + 1, 1])
    tets = []
    for order in permutations(range(3)):
        path = np.concatenate([[np.zeros(3, int)], np.cumsum(np.eye(3, dtype=int)[list(order)], 0)])
        tets.append((cell[:, None] + path) @ strides)
    tets = np.concatenate(tets)
    flipped = tet_volumes(nodes, tets) < 0
    tets[flipped] = tets[flipped][:, [1, 0, 2, 3]]
    return TetMesh(nodes, tets)


def box_surface(size: tuple) -> Surface:
    """The same box as an artist would have it: twelve triangles."""
    corners = np.stack(np.meshgrid(*[(0, s) for s in size], indexing="ij"), -1).reshape(-1, 3)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    return Surface(corners, np.array(faces))
