"""Where the poles of a ring-down may lie: the matrix pencil on all channels at once.

Rows of a Hankel matrix of samples span the same space as the damped exponentials in them; shifting
that space by one sample multiplies by exp(p dt) (Hua & Sarkar, IEEE Trans. ASSP 38 (1990) 814;
Roy & Kailath, IEEE Trans. ASSP 37 (1989) 984). Cheap and close, but not the most likely values:
these are starting points, and the material of a stabilization diagram.
"""

import numpy as np

LONGEST = 220  # columns of the Hankel matrix: cost grows as its square
WIDEST = 8  # principal components of the channels: enough for as many independent shapes


def evenly(time: np.ndarray, signals: np.ndarray) -> tuple[float, np.ndarray]:
    """dt and (T', C): every channel interpolated onto an even grid, gaps bridged in a line."""
    count = round((time[-1] - time[0]) / np.median(np.diff(time))) + 1
    grid = np.linspace(time[0], time[-1], count)  # written instants are rounded, their step too
    dt = float(grid[1] - grid[0])
    even = len(grid) == len(time) and np.abs(grid - time).max() < 1e-3 * dt
    if even and np.isfinite(signals).all():
        return dt, signals
    filled = np.empty((len(grid), signals.shape[1]))
    for c, y in enumerate(signals.T):
        seen = np.isfinite(y)
        filled[:, c] = np.interp(grid, time[seen], y[seen])
    return dt, filled


def signal_space(signals: np.ndarray) -> np.ndarray:
    """(L, min(L, ...)) right singular vectors of the stacked Hankel matrices, strongest first.

    signals (T, C) without gaps, in units of each channel's noise.
    """
    signals = signals - signals.mean(axis=0)
    if signals.shape[1] > 1:
        u, s, _ = np.linalg.svd(signals, full_matrices=False)
        keep = max(1, min(WIDEST, int(np.sum(s > 1e-12 * s[0]))))
        signals = u[:, :keep] * s[:keep]
    count = len(signals)
    columns = min(max(int(0.4 * count), 2), LONGEST)
    windows = np.lib.stride_tricks.sliding_window_view(signals, columns, axis=0)
    rows = windows.reshape(-1, columns)
    if len(rows) > 3 * columns:
        rows = np.linalg.qr(rows, mode="r")
    return np.linalg.svd(rows, full_matrices=False)[2].T


def shift_poles(space: np.ndarray, order: int, dt: float) -> np.ndarray:
    """(order,) complex poles 1/s of the signal space's first `order` directions."""
    v = space[:, :order]
    roots = np.linalg.eigvals(np.linalg.lstsq(v[:-1], v[1:], rcond=None)[0])
    roots = roots[np.abs(roots) > 1e-6]
    return np.log(roots.astype(complex)) / dt


def thinned(signals: np.ndarray, factor: int) -> np.ndarray:
    """(T // factor, C) means of `factor` samples: damped exponentials stay what they are."""
    whole = len(signals) // factor * factor
    return signals[:whole].reshape(-1, factor, signals.shape[1]).mean(axis=1)
