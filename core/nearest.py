"""Where a place is: in which tetrahedron, or nearest to which triangle. Exact, by trees."""

import numpy as np
from scipy.spatial import cKDTree

CHUNK = 4096  # queries at a time, so that candidate lists stay small


def _candidates(places: np.ndarray, centres: np.ndarray, radii: np.ndarray, reach: np.ndarray):
    """Pairs (query, piece) whose distance of centres is at most reach (n,) + the piece's radius.

    Pieces of like size share a tree: one long sliver must not make every query look far.
    """
    size = np.floor(np.log2(np.maximum(radii, radii.max() * 1e-6))).astype(int)
    queries, pieces = [], []
    for level in np.unique(size):
        members = np.flatnonzero(size == level)
        tree = cKDTree(centres[members])
        found = tree.query_ball_point(places, reach + radii[members].max())
        queries.append(np.repeat(np.arange(len(places)), [len(f) for f in found]))
        pieces.append(members[np.concatenate([np.asarray(f, int) for f in found])])
    return np.concatenate(queries), np.concatenate(pieces)


def _best(query: np.ndarray, cost: np.ndarray, count: int) -> np.ndarray:
    """For each of `count` queries the row with the least cost, -1 where it has none."""
    order = np.lexsort((cost, query))
    first = np.searchsorted(query[order], np.arange(count))
    here = first < len(order)
    here[here] = query[order[first[here]]] == np.flatnonzero(here)
    out = np.full(count, -1)
    out[here] = order[first[here]]
    return out


def locate(places: np.ndarray, nodes: np.ndarray, tets: np.ndarray):
    """Tetrahedron (n,), -1 = outside all, and barycentric coordinates (n, 4) of places (n, 3) m."""
    corners = nodes[tets]
    centres = corners.mean(axis=1)
    radii = np.linalg.norm(corners - centres[:, None], axis=2).max(axis=1)
    tet, bary = np.full(len(places), -1), np.zeros((len(places), 4))
    for start in range(0, len(places), CHUNK):
        here = slice(start, start + CHUNK)
        x = places[here]
        query, piece = _candidates(x, centres, radii, np.zeros(len(x)))
        if not len(query):
            continue
        edges = (corners[piece, 1:] - corners[piece, :1]).transpose(0, 2, 1)
        inner = np.linalg.solve(edges, (x[query] - corners[piece, 0])[:, :, None])[:, :, 0]
        weights = np.column_stack([1 - inner.sum(axis=1), inner])
        best = _best(query, -weights.min(axis=1), len(x))
        inside = best >= 0
        inside[inside] = weights[best[inside]].min(axis=1) > -1e-9
        tet[here][inside] = piece[best[inside]]
        bary[here][inside] = weights[best[inside]]
    return tet, bary


def closest_on_triangles(x: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Barycentric coordinates (n, 3) of the point of each triangle (n, 3, 3) closest to x (n, 3).

    The projection onto the plane, or where that falls outside, the best of the three edges; a
    triangle without area is its edges.
    """
    a, b, c = triangles.transpose(1, 0, 2)
    u, v, w = b - a, c - a, x - a
    uu, uv, vv = (np.einsum("ni,ni->n", p, q) for p, q in ((u, u), (u, v), (v, v)))
    uw, vw = np.einsum("ni,ni->n", u, w), np.einsum("ni,ni->n", v, w)
    det = uu * vv - uv**2
    flat = det <= 1e-14 * uu * vv
    det = np.where(flat, 1, det)
    s, t = (vv * uw - uv * vw) / det, (uu * vw - uv * uw) / det
    inside = ~flat & (s >= 0) & (t >= 0) & (s + t <= 1)
    best = np.column_stack([1 - s - t, s, t])
    nearest = np.where(inside, 0, np.inf)
    for i in range(3):
        start, edge = triangles[:, i], triangles[:, (i + 1) % 3] - triangles[:, i]
        length = np.einsum("ni,ni->n", edge, edge)
        along = np.einsum("ni,ni->n", x - start, edge) / np.where(length > 0, length, 1)
        along = np.clip(along, 0, 1)
        distance = np.linalg.norm(x - start - along[:, None] * edge, axis=1)
        better = ~inside & (distance < nearest)
        nearest = np.where(better, distance, nearest)
        weights = np.zeros((len(x), 3))
        weights[:, i], weights[:, (i + 1) % 3] = 1 - along, along
        best[better] = weights[better]
    return best


def nearest_face(places: np.ndarray, vertices: np.ndarray, faces: np.ndarray):
    """Face (n,), barycentric coordinates (n, 3), distance (n,) m of the closest surface point."""
    corners = vertices[faces]
    centres = corners.mean(axis=1)
    radii = np.linalg.norm(corners - centres[:, None], axis=2).max(axis=1)
    tree = cKDTree(vertices[np.unique(faces)])
    face, bary = np.zeros(len(places), int), np.zeros((len(places), 3))
    distance = np.zeros(len(places))
    for start in range(0, len(places), CHUNK):
        here = slice(start, start + CHUNK)
        x = places[here]
        reach = tree.query(x)[0] * (1 + 1e-9) + 1e-12 * radii.max()
        query, piece = _candidates(x, centres, radii, reach)
        weights = closest_on_triangles(x[query], corners[piece])
        gap = np.linalg.norm(x[query] - np.einsum("nk,nki->ni", weights, corners[piece]), axis=1)
        best = _best(query, gap, len(x))
        face[here], bary[here], distance[here] = piece[best], weights[best], gap[best]
    return face, bary, distance
