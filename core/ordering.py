"""Orderings that keep a sparse factor small.

Source      George, Nested dissection of a regular finite element mesh, SINUM 10 (1973)
"""

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import maximum_bipartite_matching

LEAF = 12  # places per undivided part


def nested_dissection(A: sparse.spmatrix, points: np.ndarray) -> np.ndarray:
    """Permutation (n,) of the unknowns of A (n, n) that lie at `points` (n, 3).

    Parts are halved at the median of their longest axis; the fewest places that
    part the halves are the separator and come after both. All parts of a level at once.
    """
    first, graph = places(A, points)
    place, n = points[first], len(first)
    rows, columns = np.repeat(np.arange(n), np.diff(graph.indptr)), graph.indices
    part = np.zeros(n, int)  # path of a part as a number; -1 once it is in a separator
    rank = np.zeros(n)  # position in the ordering, refined as the parts are halved
    width = 1.0
    while True:
        live = np.flatnonzero(part >= 0)
        sizes = np.bincount(part[live]) if live.size else np.zeros(1, int)
        if sizes.max() <= LEAF:
            break
        upper = _upper_half(place, part, live, sizes)
        same = (part[rows] >= 0) & (part[rows] == part[columns])
        cut = same & ~upper[rows] & upper[columns]
        separator = _cover(rows[cut], columns[cut], n)
        width /= 4
        rank[live] += width * np.where(separator[live], 2, upper[live])
        part[live] = 2 * part[live] + upper[live]
        part[separator] = -1
        live = part >= 0
        part[live] = np.unique(part[live], return_inverse=True)[1].reshape(-1)
    return spread(np.argsort(rank, kind="stable"), first, len(points))


def places(A: sparse.spmatrix, points: np.ndarray) -> tuple[np.ndarray, sparse.csr_matrix]:
    """First unknown (p,) of each place, and which places (p, p) share an entry of A.

    An ordering of places takes a ninth of the work that one of unknowns takes.
    """
    first = np.flatnonzero(np.append(True, (points[1:] != points[:-1]).any(axis=1)))
    return first, A.tocsr()[first][:, first]


def spread(order: np.ndarray, first: np.ndarray, n: int) -> np.ndarray:
    """Permutation (n,) of the unknowns from the order (p,) of the places that they lie at."""
    size = np.diff(np.append(first, n))[order]
    start = np.repeat(first[order] - np.cumsum(size) + size, size)
    return start + np.arange(n)


def _cover(lower: np.ndarray, upper: np.ndarray, n: int) -> np.ndarray:
    """(n,) bool: fewest places that all edges from `lower` to `upper` (e,) end at.

    Source: Kőnig's theorem, from a maximum matching: what unmatched lower places cannot reach by
    alternating paths, and the upper places that they can.
    """
    edges = sparse.csr_matrix((np.ones(len(lower), np.int32), (lower, upper)), shape=(n, n))
    partner = maximum_bipartite_matching(edges, perm_type="row")  # of upper places, or -1
    low, high = np.zeros(n, bool), np.zeros(n, bool)
    low[lower] = True
    low[partner[partner >= 0]] = False
    back = edges.T.tocsr()
    while True:
        reached = (back @ low > 0) & ~high
        if not reached.any():
            break
        high |= reached
        low[partner[reached]] = True  # a maximum matching leaves none of them alone
    high[lower] |= ~low[lower]
    return high


def _upper_half(place, part, live, sizes) -> np.ndarray:
    """(n,) bool: beyond the median of its part along that part's longest axis."""
    count = len(sizes)
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, part[live], place[live])
    np.maximum.at(high, part[live], place[live])
    axis = (high - low).argmax(axis=1)
    along = place[live, axis[part[live]]]
    order = np.lexsort((along, part[live]))
    starts = np.concatenate([[0], np.cumsum(sizes)[:-1]])
    position = np.empty(len(live), int)
    position[order] = np.arange(len(live)) - starts[part[live][order]]
    upper = np.zeros(len(place), bool)
    upper[live] = (2 * position >= sizes[part[live]]) & (sizes[part[live]] > LEAF)
    return upper
