"""Surfaces that tests are made on."""

import numpy as np

from core.data import Surface

CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
TRIANGLES = np.array([(a, b, c) for p in SIDES for a, b, c in ((p[0], p[1], p[2]), p[0:1] + p[2:])])


def box(size) -> Surface:
    """A closed box with a corner at the origin; `size` (3,) m."""
    return Surface(CUBE * size, TRIANGLES)


def sphere(level: int, radius: float = 1.0) -> Surface:
    """An octahedron, each face cut into 4 `level` times: 8 * 4^level triangles on a sphere."""
    points = np.array([(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)], float)
    faces = np.array(
        [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    )
    for _ in range(level):
        edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        unique, which = np.unique(edges, axis=0, return_inverse=True)
        middle = len(points) + which.reshape(-1, 3)
        points = np.concatenate([points, points[unique].mean(axis=1)])
        (a, b, c), (ab, bc, ca) = faces.T, middle.T
        parts = ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))
        faces = np.concatenate([np.column_stack(p) for p in parts])
    return Surface(radius * points / np.linalg.norm(points, axis=1, keepdims=True), faces)


def scan(level: int, seed: int = 0) -> Surface:
    """A lumpy, noisy body of 10 cm as a scanner gives it: vertices and faces in random order."""
    smooth, random = sphere(level), np.random.default_rng(seed)
    waves, phases = 3 * random.standard_normal((40, 3)), random.uniform(0, 2 * np.pi, 40)
    lumps = 1 + 0.03 * np.cos(smooth.vertices @ waves.T + phases).sum(axis=1)
    points = smooth.vertices * lumps[:, None] * (1, 0.8, 1.2)
    points += 1e-3 * random.standard_normal(points.shape)
    order = random.permutation(len(points))
    faces = np.argsort(order)[smooth.faces]
    return Surface(0.05 * points[order], faces[random.permutation(len(faces))])
