"""Takes whose markers are hidden by turns, so that hardly a frame shows them all."""

import numpy as np

WHOLE = 0.5  # share of the frames, from which those that show all markers are enough


def bridged(values: np.ndarray, told: np.ndarray, use=slice(None), slow: np.ndarray | None = None):
    """Samples (T, C), NaN where missing, and which frames (T,) have all of them; where these are
    too few of those to `use`, what is missing as `told` (T, C), but for what wanders as the columns
    of `slow` (T, q) do, a constant by itself, and all frames. What is fitted to them must have
    these columns, too: outside what is used they may run far off.
    """
    seen = np.isfinite(values)
    whole = seen.all(axis=1)
    if whole[use].mean() >= WHOLE:
        return values, whole
    slow = np.ones((len(values), 1)) if slow is None else slow
    filled = values.copy()
    for c, known in enumerate(seen.T):
        rows = np.zeros(len(values), bool)
        rows[use] = known[use]
        off, *_ = np.linalg.lstsq(slow[rows], values[rows, c] - told[rows, c], rcond=None)
        filled[~known, c] = (told[:, c] + slow @ off)[~known]
    return filled, np.ones(len(values), bool)
