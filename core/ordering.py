"""Orderings that keep a sparse factor small.

Source      George, Nested dissection of a regular finite element mesh, SINUM 10 (1973)
"""

import numpy as np
from scipy import sparse

LEAF = 24  # places per undivided part


def nested_dissection(A: sparse.spmatrix, points: np.ndarray) -> np.ndarray:
    """Permutation (n,) of the unknowns of A (n, n) that lie at `points` (n, 3).

    Parts are halved at the median of their longest axis; the places of the lower half that touch
    the upper half are the separator and come after both. All parts of a level at once.
    """
    place, index = np.unique(points, axis=0, return_inverse=True)
    index = index.reshape(-1)
    graph = _place_graph(A, index, len(place))
    rows = np.repeat(np.arange(len(place)), np.diff(graph.indptr))
    columns = graph.indices
    n = len(place)
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
        separator = np.zeros(n, bool)
        separator[rows[cut]] = True
        width /= 4
        rank[live] += width * np.where(separator[live], 2, upper[live])
        part[live] = 2 * part[live] + upper[live]
        part[separator] = -1
        live = part >= 0
        part[live] = np.unique(part[live], return_inverse=True)[1].reshape(-1)
    order = np.lexsort((index, rank[index]))
    return order.astype(np.int64)


def _place_graph(A: sparse.spmatrix, index: np.ndarray, n: int) -> sparse.csr_matrix:
    """Which places (n, n) share an entry of A."""
    coo = A.tocoo()
    key = np.unique(index[coo.row] * n + index[coo.col])
    rows, columns = np.divmod(key, n)
    return sparse.csr_matrix((np.ones(len(key), np.int8), (rows, columns)), shape=(n, n))


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
