"""Least squares of many channels on one basis: sums over what each channel has."""

import numpy as np

MANY = 0.5  # of the instants, beyond which what a channel lacks is no longer taken off the whole
LITTLE = 1e-6  # of a column's whole, below which what a channel has of it is summed by itself


def normal(basis: np.ndarray, values: np.ndarray, use: np.ndarray):
    """Normal equations (B, P, n, n), (B, C, n), and which of the P each channel's are (C,): those
    that lack the same share them.

    basis (B, 1 or C, T, n), values and use (T, C).
    """
    C = values.shape[1]
    some = use.any(axis=1)
    rows = slice(None) if some.all() else some  # no copy of what is large
    basis, values, use = basis[:, :, rows], np.where(use, values, 0.0)[rows], use[rows]
    if basis.shape[1] > 1:  # channels with their own delay
        b = basis if use.all() else basis * use.T[None, :, :, None]
        return np.swapaxes(b, 2, 3) @ b, np.einsum("bcti,tc->bci", b, values), np.arange(C)
    b = basis[:, 0]
    gram = (np.swapaxes(b, 1, 2) @ b)[:, None]
    right = np.swapaxes(np.swapaxes(b, 1, 2) @ values, 1, 2)
    if use.all():
        return gram, right, np.zeros(C, int)
    patterns = {}
    of = np.array([patterns.setdefault(one.tobytes(), len(patterns)) for one in use.T])
    use = use[:, np.unique(of, return_index=True)[1]]
    most = int((~use).sum(axis=0).max())
    if most > MANY * len(use):
        b = basis * use.T[None, :, :, None]
        return np.swapaxes(b, 2, 3) @ b, right, of
    missing = np.argsort(use, axis=0, kind="stable")[:most].T  # (P, most), of some too many
    lost = b[:, missing] * ~np.take_along_axis(use.T, missing, axis=1)[None, :, :, None]
    own = gram - np.swapaxes(lost, 2, 3) @ lost
    whole, kept = (np.einsum("bpii->bpi", one) for one in (gram, own))
    for p in np.flatnonzero((kept < LITTLE * whole).any(axis=(0, 2))):
        here = b[:, use[:, p]]  # the difference would have no digits left
        own[:, p] = np.swapaxes(here, 1, 2) @ here
    return own, right, of


def coefficients_of(
    gram: np.ndarray, right: np.ndarray, of: np.ndarray, barred: np.ndarray
) -> np.ndarray:
    """(B, C, n) from the normal equations, nought where `barred` (C, n)."""
    scale = np.sqrt(np.einsum("bpii->bpi", gram))
    scale = np.where(scale > 0, scale, 1.0)
    gram = gram / (scale[:, :, :, None] * scale[:, :, None])
    scale = scale if scale.shape[1] == 1 else scale[:, of]
    right = right / scale
    alike = {}
    for n, pair in enumerate(zip(of, barred, strict=True)):
        alike.setdefault((pair[0], pair[1].tobytes()), []).append(n)
    out = np.empty_like(right)
    if len(alike) == len(of):
        own = gram[:, of] + np.where(barred, 1e12, 1e-11)[:, :, None] * np.eye(barred.shape[1])
        out[:] = np.linalg.solve(own, right[..., None])[..., 0]
        return out / scale
    for (p, _), some in alike.items():
        those = slice(None) if len(alike) == 1 else some
        own = gram[:, p] + np.diag(np.where(barred[some[0]], 1e12, 1e-11))
        y = np.swapaxes(right[:, those], 1, 2)
        out[:, those] = np.swapaxes(np.linalg.solve(own, y), 1, 2)
    return out / scale
