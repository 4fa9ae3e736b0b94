"""Lowest eigenpairs of K x = λ M x.

Source      Grimes, Lewis, Simon, A shifted block Lanczos algorithm, SIMAX 15 (1994)
"""

from collections.abc import Callable

import numpy as np
from scipy import sparse
from scipy.linalg import eigh

from .errors import DataError
from .factorization import factorize

SHIFT = 1e-8  # below zero, in the mean of all eigenvalues: a free body has six zeros
TOLERANCE = 1e-8  # residual of a pair over its eigenvalue, whose own error is the square of it


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
    rest = solve(M @ np.random.default_rng(0).standard_normal((n, width)))
    Mrest = M @ rest
    most = min(n, 40 * count + 400)
    while True:
        block, Mblock = _orthonormal(rest, Mrest, M, (Q, MQ))
        Q, MQ = np.column_stack([Q, block]), np.column_stack([MQ, Mblock])
        rest = solve(Mblock)
        projected = MQ.T @ rest
        H = _bordered(H, projected)
        rest -= Q @ projected
        Mrest = M @ rest
        if Q.shape[1] < count + width:
            continue
        theta, y = np.linalg.eigh(H)
        coupling = np.sqrt(np.abs(np.einsum("nk,nk->k", rest, Mrest)))
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


def _orthonormal(block, Mblock, M, basis) -> tuple[np.ndarray, np.ndarray]:
    """`block` made M-orthonormal and M-orthogonal to basis = Q, M Q; and M times it.

    Directions that vanish are dropped; those that nearly do are what M is applied to again.
    """
    Q, MQ = basis
    for _ in range(3):
        size = 1 / np.sqrt(np.einsum("nk,nk->k", block, Mblock))
        values, vectors = np.linalg.eigh(size[:, None] * (block.T @ Mblock) * size)
        keep = values > 1e-14 * values[-1]
        turn = size[:, None] * vectors[:, keep] / np.sqrt(values[keep])
        block = block @ turn
        Mblock = Mblock @ turn if keep.all() and values[0] > 1e-4 else M @ block
        share = MQ.T @ block
        block -= Q @ share
        Mblock -= MQ @ share
        if np.abs(share).max(initial=0) < 1e-14 and np.abs(values - 1).max() < 1e-14:
            break
    return block, Mblock


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
