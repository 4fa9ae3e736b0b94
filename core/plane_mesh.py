"""Triangles of even size in a polygon.

A truss that pushes: start from a hexagonal grid, join neighbours (Delaunay), let every edge
shorter than its wanted length push, bring back what leaves, until nothing moves.

Source      Persson & Strang, A Simple Mesh Generator in MATLAB, SIAM Review 46(2), 2004
"""

import numpy as np
from scipy.spatial import Delaunay

PUSH = 1.2  # wanted length over the mean: edges stay a little compressed
STEP = 0.2
STILL = 1e-3  # of the edge length: a step that ends the search
AGAIN = 0.1  # of the edge length: movement after which neighbours are found anew
LONGEST = 1000  # steps


def signed_distance(points: np.ndarray, polygon: np.ndarray) -> np.ndarray:
    """(n,) to the edge of `polygon` (m, 2), negative inside."""
    start, edge = polygon, np.roll(polygon, -1, axis=0) - polygon
    away = points[:, None] - start
    along = np.clip((away * edge).sum(-1) / (edge**2).sum(-1), 0, 1)
    distance = np.linalg.norm(away - along[..., None] * edge, axis=-1).min(axis=1)
    x, y = points.T
    (ax, ay), (bx, by) = start.T[:, :, None], (start + edge).T[:, :, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        left = x < (bx - ax) * (y - ay) / (by - ay) + ax
    inside = np.logical_xor.reduce(((ay > y) != (by > y)) & left, axis=0)
    return np.where(inside, -distance, distance)


def polygon_mesh(polygon: np.ndarray, h: float) -> tuple[np.ndarray, np.ndarray]:
    """Nodes (N, 2) and triangles (T, 3), positive area, of edges about `h`; corners are kept."""
    corners = len(polygon)
    points = _start(polygon, h)
    before = np.full_like(points, np.inf)
    for step in range(LONGEST):
        if np.abs(points - before).max() > AGAIN * h:
            before, triangles = points.copy(), _triangles(points, polygon, h)
            bars = np.unique(np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)), axis=0)
        vector = points[bars[:, 0]] - points[bars[:, 1]]
        length = np.linalg.norm(vector, axis=1)
        wanted = PUSH * np.sqrt((length**2).mean())
        if step % 30 == 29 and (wanted > 2 * length).any():
            crowded = np.unique(bars[wanted > 2 * length])
            points = np.delete(points, crowded[crowded >= corners], axis=0)
            before = np.full_like(points, np.inf)
            continue
        push = (np.maximum(wanted - length, 0) / length)[:, None] * vector
        force = np.zeros_like(points)
        np.add.at(force, bars[:, 0], push)
        np.add.at(force, bars[:, 1], -push)
        force[:corners] = 0
        points = points + STEP * force
        points = _brought_back(points, polygon, h)
        inner = signed_distance(points, polygon) < -1e-3 * h
        if (STEP * np.linalg.norm(force[inner], axis=1)).max(initial=0) < STILL * h:
            break
    return _tidy(points, _triangles(points, polygon, h))


def _start(polygon: np.ndarray, h: float) -> np.ndarray:
    """The corners, then a hexagonal grid inside."""
    low, high = polygon.min(axis=0) - h, polygon.max(axis=0) + h
    low = np.floor(low)  # so that the grid does not hang on the polygon's own box
    x, y = np.meshgrid(
        np.arange(low[0], high[0], h), np.arange(low[1], high[1], h * np.sqrt(3) / 2)
    )
    x[1::2] += h / 2
    grid = np.column_stack([x.T.ravel(), y.T.ravel()])
    grid = grid[signed_distance(grid, polygon) < 1e-3 * h]
    near = np.linalg.norm(grid[:, None] - polygon, axis=-1).min(axis=1)
    return np.concatenate([polygon, grid[near > 1e-9]])


def _triangles(points: np.ndarray, polygon: np.ndarray, h: float) -> np.ndarray:
    triangles = Delaunay(points).simplices
    middle = points[triangles].mean(axis=1)
    return triangles[signed_distance(middle, polygon) < -1e-3 * h]


def _brought_back(points: np.ndarray, polygon: np.ndarray, h: float) -> np.ndarray:
    """What left the polygon, put onto its edge along the distance's slope."""
    distance = signed_distance(points, polygon)
    out, small = distance > 0, np.sqrt(np.finfo(float).eps) * h
    x, d = points[out], distance[out]
    slope = [(signed_distance(x + small * e, polygon) - d) / small for e in np.eye(2)]
    points = points.copy()
    points[out] = x - d[:, None] * np.column_stack(slope)
    return points


def _tidy(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Positive areas, no flat triangle, no unused node."""
    a, b, c = points[triangles].transpose(1, 0, 2)
    area = ((b - a) * (c - a)[:, ::-1] * [1, -1]).sum(axis=1) / 2
    triangles = np.where(area[:, None] < 0, triangles[:, [0, 2, 1]], triangles)
    triangles = triangles[np.abs(area) > 1e-6 * np.abs(area).max()]
    used, triangles = np.unique(triangles, return_inverse=True)
    return points[used], triangles.reshape(-1, 3)


def refined(nodes: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Every triangle cut into four at the middles of its edges: a nested mesh."""
    edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    unique, which = np.unique(edges, axis=0, return_inverse=True)
    middle = len(nodes) + which.reshape(-1, 3)
    (a, b, c), (ab, bc, ca) = triangles.T, middle.T
    parts = ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))
    cells = np.concatenate([np.column_stack(p) for p in parts])
    return np.concatenate([nodes, nodes[unique].mean(axis=1)]), cells
