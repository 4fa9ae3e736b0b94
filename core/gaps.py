"""Takes whose markers are hidden by turns, so that hardly a frame shows them all."""

import numpy as np

WHOLE = 0.5  # share of the frames, from which those that show all markers are enough


def bridged(values: np.ndarray, told: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Samples (T, C), NaN where missing, and which frames (T,) have all of them; where these are
    too few, what is missing as `told` (T, C) but for a constant, and all frames.
    """
    seen = np.isfinite(values)
    whole = seen.all(axis=1)
    if whole.mean() >= WHOLE:
        return values, whole
    told = told + np.nanmean(values - told, axis=0)  # what is still is told at nought
    return np.where(seen, values, told), np.ones(len(values), bool)
