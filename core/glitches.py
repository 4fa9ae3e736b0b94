"""Samples that a tracker has thrown out of place for one frame: no motion of the body.

What moves goes on: a sample is where the three before it lead to, and where the three after it lead
back to, or it is where one of them says, as at a stop's kink or where frames are missing. One that
both call wrong, by as much, while they agree, jumped out and back (Hampel's filter,
J. Am. Stat. Assoc. 69 (1974) 383, with what leads there for the median).
"""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

LOOKS = 3  # at most: one jump hides another that is near
BEFORE, AFTER, BETWEEN = (-3, -2, -1), (1, 2, 3), (-2, -1, 1, 2)  # samples that lead to a place
AROUND = 8  # samples on each side, by which it is told how far these usually are off
FAR = 8.0  # times as far
SCALE = 1.4826  # of a standard deviation over the median of what is off
APART = 0.5  # of how far it jumped, that the two sides may disagree by
LONG = 0.8  # of the steps nearby that are shorter: another jump may be among them
FASTER = 2.5  # times as long a step: a frame that is shown twice is off by one step


def without_glitches(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The values (T, n, d) with NaN where a marker jumped out and back; (n,) how often each did.

    time (T,) s, even or not; NaN where nothing was seen.
    """
    out, count = values.copy(), 0
    marked = np.zeros(values.shape[:2], bool)
    for _ in range(LOOKS):
        for marker, axis in np.ndindex(values.shape[1:]):
            known = np.flatnonzero(np.isfinite(out[:, marker, axis]))
            if len(known) > 2 * AROUND:
                some = _jumped(time[known], out[known, marker, axis])
                marked[known[some], marker] = True
        if marked.sum() == count:
            break
        count = marked.sum()
        out[marked] = np.nan
    return out, marked.sum(axis=0)


def _jumped(t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """(T,) bool of samples x (T,) at instants t (T,)."""
    before, after, between = (_where(t, x, near) for near in (BEFORE, AFTER, BETWEEN))
    jump, step = np.abs(x - between), np.abs(np.diff(x, prepend=x[0]))
    rounded = step[step > 0].min(initial=np.inf)
    noise = max(rounded, np.nanmedian(jump))
    usual = SCALE * np.maximum(_nearby(jump, np.nanmedian), noise)
    longest = _nearby(step, _long)
    # where one of them is not known, none of these is true
    both = ((x - before) * (x - after) > 0) & (np.abs(before - after) < APART * jump)
    near, far = np.sort(np.abs([x - before, x - after]), axis=0)
    each = (near > (1 - APART) * jump) & (far < (1 + APART) * jump)  # all three say the same
    return both & each & (jump > FAR * usual) & (jump > FASTER * longest)


def _where(t: np.ndarray, x: np.ndarray, near: tuple[int, ...]) -> np.ndarray:
    """(T,) where each sample should be by those that are so many `near` it (Lagrange's formula);
    NaN where it has not all of them.
    """
    first, last = max(0, -min(near)), len(x) - max(0, *near)
    out, now = np.full(len(x), np.nan), t[first:last]
    at = [slice(first + n, last + n) for n in near]
    out[first:last] = sum(
        x[one] * np.prod([(now - t[o]) / (t[one] - t[o]) for o in at if o != one], axis=0)
        for one in at
    )
    return out


def _long(steps: np.ndarray, axis: int) -> np.ndarray:
    """The step than which so many of those that are known are shorter, along an axis."""
    known = np.isfinite(steps).sum(axis=axis, keepdims=True)
    at = (LONG * known).astype(int)
    return np.take_along_axis(np.sort(steps, axis=axis), at, axis).squeeze(axis)


def _nearby(one: np.ndarray, how) -> np.ndarray:
    """(T,) of the numbers (T,) AROUND each on both sides, without those that it leads to."""
    padded = np.pad(one, AROUND, constant_values=np.nan)
    windows = sliding_window_view(padded, 2 * AROUND + 1)
    beside = np.abs(np.arange(-AROUND, AROUND + 1)) > max(AFTER)
    return how(windows[:, beside], axis=1)
