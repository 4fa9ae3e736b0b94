"""Least squares of many channels on one basis: sums over what each channel has."""

import numpy as np

MANY = 0.5  # of the instants, beyond which what a channel lacks is no longer taken off the whole
LITTLE = 1e-6  # of a column's whole, below which what a channel has of it is summed by itself


def normal(basis: np.ndarray, values: np.ndarray, use: np.ndarray):
    """Normal equations (B, 1 or C, n, n), (B, C, n); one for all channels where none lacks any.

    basis (B, 1 or C, T, n), values and use (T, C).
    """
    some = use.any(axis=1)
    rows = slice(None) if some.all() else some  # no copy of what is large
    basis, values, use = basis[:, :, rows], np.where(use, values, 0.0)[rows], use[rows]
    if basis.shape[1] > 1:  # channels with their own delay
        b = basis if use.all() else basis * use.T[None, :, :, None]
        return np.swapaxes(b, 2, 3) @ b, np.einsum("bcti,tc->bci", b, values)
    b = basis[:, 0]
    gram = (np.swapaxes(b, 1, 2) @ b)[:, None]
    right = np.swapaxes(np.swapaxes(b, 1, 2) @ values, 1, 2)
    if use.all():
        return gram, right
    most = int((~use).sum(axis=0).max())
    if most > MANY * len(use):
        b = basis * use.T[None, :, :, None]
        return np.swapaxes(b, 2, 3) @ b, right
    missing = np.argsort(use, axis=0, kind="stable")[:most].T  # (C, most), of some too many
    lost = b[:, missing] * ~np.take_along_axis(use.T, missing, axis=1)[None, :, :, None]
    own = gram - np.swapaxes(lost, 2, 3) @ lost
    whole, kept = (np.einsum("bcii->bci", one) for one in (gram, own))
    for c in np.flatnonzero((kept < LITTLE * whole).any(axis=(0, 2))):
        here = b[:, use[:, c]]  # the difference would have no digits left
        own[:, c] = np.swapaxes(here, 1, 2) @ here
    return own, right


def coefficients_of(gram: np.ndarray, right: np.ndarray, barred: np.ndarray) -> np.ndarray:
    """(B, C, n) from the normal equations, nought where `barred` (C, n)."""
    scale = np.sqrt(np.einsum("bcii->bci", gram))
    scale = np.where(scale > 0, scale, 1.0)
    gram = gram / (scale[:, :, :, None] * scale[:, :, None])
    right = right / scale
    out = np.empty_like(right)
    kinds = {}
    for n, kind in enumerate(barred):
        kinds.setdefault(kind.tobytes(), []).append(n)
    for some in kinds.values():
        alike, kind = slice(None) if len(kinds) == 1 else some, barred[some[0]]
        own = gram if gram.shape[1] == 1 else gram[:, alike]
        own = own + np.diag(np.where(kind, 1e12, 1e-11))
        y = right[:, alike]
        if own.shape[1] == 1:
            out[:, alike] = np.swapaxes(np.linalg.solve(own[:, 0], np.swapaxes(y, 1, 2)), 1, 2)
        else:
            out[:, alike] = np.linalg.solve(own, y[..., None])[..., 0]
    return out / scale
