"""Factorizations of symmetric positive definite matrices.

CHOLMOD comes with cvxopt or kvxopt, which have wheels wherever Blender runs; scipy's SuperLU in
symmetric mode is the fallback.

Source      Chen, Davis, Hager, Rajamanickam, CHOLMOD, ACM TOMS 35 (2008);
            George, Nested dissection, SIAM J. Numer. Anal. 10 (1973)
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from .errors import DataError
from .ordering import nested_dissection, places, spread

try:
    import cvxopt as cholmod_home
    from cvxopt import amd, cholmod
except ImportError:
    try:
        import kvxopt as cholmod_home
        from kvxopt import amd, cholmod
    except ImportError:
        cholmod = None

DISSECT_FROM = 25_000  # unknowns; below, minimum degree is as good and costs less


@dataclass(frozen=True, eq=False)
class Factorization:
    """A x = b for one matrix, again and again: solve((n,) or (n, k)) -> the same shape."""

    solve: Callable[[np.ndarray], np.ndarray]
    backend: str  # "cholmod" | "superlu"


def factorize(A: sparse.spmatrix, points: np.ndarray | None = None) -> Factorization:
    """Factorization of a symmetric positive definite matrix (n, n).

    `points` (n, 3), the place of each unknown, allows a nested dissection where that pays.
    Raises DataError when A is not positive definite.
    """
    return factorize_cholmod(A, points) if cholmod else factorize_superlu(A, points)


def factorize_cholmod(A: sparse.spmatrix, points: np.ndarray | None = None) -> Factorization:
    """By CHOLMOD's supernodal Cholesky, ordered by minimum degree or nested dissection."""
    matrix, n = cholmod_home.matrix, A.shape[0]
    L, order, options = _lower(A), None, {"supernodal": 2}
    if points is not None:
        order = _order(A, points, _amd)
        options["nmethods"] = 1  # only this one; else all are tried
    cholmod.options.clear()
    cholmod.options.update(options)
    factor = cholmod.symbolic(L) if order is None else cholmod.symbolic(L, matrix(order))
    try:
        cholmod.numeric(L, factor)
    except ArithmeticError as error:
        raise DataError(_INDEFINITE) from error

    def solve(b: np.ndarray) -> np.ndarray:
        x = matrix(np.array(b, float, order="F").reshape(n, -1, order="F"))
        if x.size[1] == 1:
            cholmod.solve(factor, x)
        else:  # `solve` goes column by column; `spsolve` takes four at a time, twice as fast
            x = matrix(cholmod.spsolve(factor, cholmod_home.sparse(x)))
        return np.array(x).reshape(np.shape(b))

    return Factorization(solve, "cholmod")


def _lower(A: sparse.spmatrix):
    """A symmetric matrix as CHOLMOD wants it: its lower half, column by column."""
    upper = sparse.triu(A.tocsr(), format="coo")  # its rows are the columns of the lower half
    values = cholmod_home.matrix(np.ascontiguousarray(upper.data, float))
    place = (cholmod_home.matrix(i.astype(np.int64)) for i in (upper.col, upper.row))
    return cholmod_home.spmatrix(values, *place, A.shape)


def _order(A: sparse.spmatrix, points: np.ndarray, minimum_degree) -> np.ndarray:
    """Permutation (n,) of the unknowns by the places that they lie at."""
    if A.shape[0] > DISSECT_FROM:
        return nested_dissection(A, points)
    first, graph = places(A, points)
    graph.data = np.ones(graph.nnz)
    return spread(minimum_degree(graph), first, A.shape[0])


def _amd(graph: sparse.csr_matrix) -> np.ndarray:
    return np.array(amd.order(_lower(graph))).ravel()


def _mmd(graph: sparse.csr_matrix) -> np.ndarray:
    """SuperLU tells its minimum degree only with a factor: that of a graph's Laplacian is cheap."""
    laplacian = sparse.diags(np.asarray(graph.sum(axis=1)).ravel() + 1.0) - graph
    return np.argsort(_splu(laplacian, "MMD_AT_PLUS_A").perm_c)


def _splu(A: sparse.spmatrix, ordering: str):
    options = {"SymmetricMode": True, "Equil": False}
    return splu(A.tocsc(), ordering, diag_pivot_thresh=0.0, options=options)


def factorize_superlu(A: sparse.spmatrix, points: np.ndarray | None = None) -> Factorization:
    """By scipy alone: SuperLU told that the matrix is symmetric, with diagonal pivots."""
    try:
        if points is None:
            lu = _splu(A, "MMD_AT_PLUS_A")
        else:
            order = _order(A, points, _mmd)
            lu = _splu(A.tocsr()[order][:, order], "NATURAL")
    except RuntimeError as error:
        raise DataError(_INDEFINITE) from error
    if (lu.U.diagonal() <= 0).any():
        raise DataError(_INDEFINITE)
    if points is None:
        return Factorization(lu.solve, "superlu")

    def solve(b: np.ndarray) -> np.ndarray:
        x = np.empty(np.shape(b))
        x[order] = lu.solve(np.ascontiguousarray(b[order], float))
        return x

    return Factorization(solve, "superlu")


_INDEFINITE = (
    "Stiffness matrix: it is not positive definite, so the body would buckle or come apart. Check "
    "that it is one connected piece that is held, and that loads and gravity are not too large."
)
