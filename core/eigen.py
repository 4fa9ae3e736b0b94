"""Factorizations of symmetric positive definite matrices, and lowest eigenpairs by them.

CHOLMOD comes with cvxopt or kvxopt, which have wheels wherever Blender runs; scipy's SuperLU in
symmetric mode is the fallback.

Source      Chen, Davis, Hager, Rajamanickam, CHOLMOD, ACM TOMS 35 (2008);
            George, Nested dissection, SIAM J. Numer. Anal. 10 (1973);
            Grimes, Lewis, Simon, A shifted block Lanczos algorithm, SIMAX 15 (1994)
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.linalg import eigh
from scipy.sparse.linalg import splu

from .errors import DataError
from .ordering import nested_dissection

try:
    import cvxopt as cholmod_home
    from cvxopt import cholmod
except ImportError:
    try:
        import kvxopt as cholmod_home
        from kvxopt import cholmod
    except ImportError:
        cholmod = None

DISSECT_FROM = 30_000  # unknowns; below, minimum degree is as good and costs nothing
SHIFT = 1e-8  # below zero, in the mean of all eigenvalues: a free body has six zeros
TOLERANCE = 1e-8  # residual of a pair over its eigenvalue, whose own error is the square of it


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


def _order(A, points):
    return (
        nested_dissection(A, points) if points is not None and len(points) > DISSECT_FROM else None
    )


def factorize_cholmod(A: sparse.spmatrix, points: np.ndarray | None = None) -> Factorization:
    """By CHOLMOD's supernodal Cholesky, ordered by minimum degree or nested dissection."""
    lower = sparse.tril(A, format="coo")
    matrix, n = cholmod_home.matrix, A.shape[0]
    L = cholmod_home.spmatrix(
        matrix(np.ascontiguousarray(lower.data, float)),
        matrix(lower.row.astype(np.int64)),
        matrix(lower.col.astype(np.int64)),
        (n, n),
    )
    order = _order(A, points)
    cholmod.options["supernodal"] = 2
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


def factorize_superlu(A: sparse.spmatrix, points: np.ndarray | None = None) -> Factorization:
    """By scipy alone: SuperLU told that the matrix is symmetric, with diagonal pivots."""
    options = {"SymmetricMode": True, "Equil": False}
    order = _order(A, points)
    try:
        if order is None:
            lu = splu(A.tocsc(), "MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
            return Factorization(lu.solve, "superlu")
        permuted = A.tocsr()[order][:, order].tocsc()
        lu = splu(permuted, "NATURAL", diag_pivot_thresh=0.0, options=options)
    except RuntimeError as error:
        raise DataError(_INDEFINITE) from error

    def solve(b: np.ndarray) -> np.ndarray:
        x = np.empty(np.shape(b))
        x[order] = lu.solve(np.ascontiguousarray(b[order], float))
        return x

    return Factorization(solve, "superlu")


_INDEFINITE = (
    "Stiffness matrix: it is not positive definite, so the body would buckle or come apart. Check "
    "that it is one connected piece that is held, and that loads and gravity are not too large."
)


def lowest_eigenpairs(
    K: sparse.csr_matrix,
    M: sparse.csr_matrix,
    count: int,
    points: np.ndarray | None = None,
    *,
    multiplicity: int = 4,
) -> tuple[np.ndarray, np.ndarray]:
    """Lowest `count` eigenvalues (m,) ascending and vectors (n, m) of K x = λ M x, xᵀ M x = 1.

    K may be singular (a free body): the shift is a little below zero. An eigenvalue is found as
    often as it is there, up to `multiplicity` times: give 8 for a free body, which has six zeros.
    The same input gives the same bytes.
    """
    n = K.shape[0]
    if not 0 < count < n:
        raise DataError(f"lowest_eigenpairs: {count} asked of {n} unknowns; 1 to {n - 1} can be.")
    if n <= max(60, 3 * count):
        values, vectors = eigh(K.toarray(), M.toarray())
        return values[:count], _signed(vectors[:, :count])
    scale = K.diagonal().sum() / M.diagonal().sum()
    shift = -SHIFT * scale
    factor = factorize(K - shift * M, points)
    theta, x = block_lanczos(factor.solve, M, count, width=multiplicity)
    values = 1 / theta + shift
    # Rounding harms this value as ε λ / shift, Rayleigh's quotient as ε scale / λ: take the better
    large = values > np.sqrt(SHIFT) * scale
    values[large] = np.einsum("nk,nk->k", x, K @ x)[large]
    return values, _signed(x)


def _signed(vectors: np.ndarray) -> np.ndarray:
    """Each vector's largest entry made positive, so that results do not flip between machines."""
    largest = np.abs(vectors).argmax(axis=0)
    return vectors * np.where(np.take_along_axis(vectors, largest[None], axis=0) < 0, -1, 1)


def block_lanczos(
    solve: Callable[[np.ndarray], np.ndarray], M: sparse.csr_matrix, count: int, *, width: int = 4
) -> tuple[np.ndarray, np.ndarray]:
    """Largest `count` eigenvalues θ (m,) descending and M-orthonormal vectors of x -> solve(M x).

    Every block is orthogonalized twice against all before it: a hundred vectors cost less than
    the ghosts that a short recurrence brings. Raises DataError when it does not converge.
    """
    n = M.shape[0]
    width = min(width, max(1, n // 4))
    Q, MQ, H = np.empty((n, 0)), np.empty((n, 0)), np.empty((0, 0))
    block = solve(M @ np.random.default_rng(0).standard_normal((n, width)))
    most = min(n, 40 * count + 400)
    while True:
        block = _orthonormal(block, M, Q, MQ)
        Q = np.column_stack([Q, block])
        MQ = np.column_stack([MQ, M @ block])
        block = solve(MQ[:, -block.shape[1] :])
        projected = MQ.T @ block
        H = _bordered(H, projected)
        if Q.shape[1] < count + width:
            continue
        theta, y = np.linalg.eigh(H)
        rest = block - Q @ projected
        coupling = np.sqrt(np.abs(np.einsum("nk,nk->k", rest, M @ rest)))
        top = np.argsort(-theta)[:count]
        tail = y[-block.shape[1] :, top]
        residual = np.linalg.norm(coupling[:, None] * tail, axis=0)
        if (residual <= TOLERANCE * theta[top]).all() or Q.shape[1] == n:
            return theta[top], Q @ y[:, top]
        if Q.shape[1] + block.shape[1] > most:
            raise DataError(
                f"block_lanczos: {count} eigenvalues did not converge in {Q.shape[1]} vectors. "
                "Ask for fewer modes, or look for loose pieces in the mesh."
            )


def _bordered(H: np.ndarray, projected: np.ndarray) -> np.ndarray:
    """H grown by the columns `projected`, symmetric."""
    old, new = H.shape[0], projected.shape[1]
    out = np.zeros((old + new, old + new))
    out[:old, :old] = H
    out[:, old:] = projected
    out[old:, :old] = projected[:old].T
    out[old:, old:] = (projected[old:] + projected[old:].T) / 2
    return out


def _orthonormal(block, M, Q, MQ) -> np.ndarray:
    """`block` made M-orthonormal and M-orthogonal to Q; directions that vanish are dropped."""
    for _ in range(3):
        block = block - Q @ (MQ.T @ block)
        block = block / np.sqrt(np.einsum("nk,nk->k", block, M @ block))
        values, vectors = np.linalg.eigh(block.T @ (M @ block))
        keep = values > 1e-14 * values[-1]
        block = block @ (vectors[:, keep] / np.sqrt(values[keep]))
    return block


def improved_eigenpairs(
    K: sparse.csr_matrix,
    M: sparse.csr_matrix,
    x: np.ndarray,
    precondition: Callable[[np.ndarray], np.ndarray],
    *,
    steps: int,
) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues (m,) and vectors (n, m) from good guesses x (n, m), lower with every step.

    Source: Knyazev, Toward the optimal preconditioned eigensolver (LOBPCG), SISC 23 (2001).
    """
    count = x.shape[1]
    spaces = (x, K @ x, M @ x)  # what spans the search, and K and M times it
    values, y = _rayleigh_ritz(*spaces, count)
    x, Kx, Mx = (S @ y for S in spaces)
    steps_back = tuple(np.empty((len(x), 0)) for _ in range(3))
    for _ in range(steps):
        w = precondition(Kx - Mx * values)
        spaces = tuple(
            np.column_stack(parts)
            for parts in zip((x, Kx, Mx), (w, K @ w, M @ w), steps_back, strict=True)
        )
        values, y = _rayleigh_ritz(*spaces, count)
        steps_back = tuple(S[:, count:] @ y[count:] for S in spaces)
        x, Kx, Mx = (S @ y for S in spaces)
    return values, x


def _rayleigh_ritz(S, KS, MS, count):
    """Lowest `count` Ritz values and their coefficients in the columns of S (n, k)."""
    size = 1 / np.sqrt(np.maximum(np.einsum("nk,nk->k", S, MS), 1e-300))
    gram = (S.T @ MS) * np.outer(size, size)
    values, vectors = np.linalg.eigh((gram + gram.T) / 2)
    keep = values > 1e-12 * values[-1]
    basis = size[:, None] * vectors[:, keep] / np.sqrt(values[keep])
    reduced = basis.T @ (S.T @ KS) @ basis
    ritz, y = np.linalg.eigh((reduced + reduced.T) / 2)
    return ritz[:count], basis @ y[:, :count]
