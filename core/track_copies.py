"""Doubled frames: pictures that repeat the one before while the motion goes on.

A copy stands for a frame that was lost (time went on), or was put in to fill up a playback rate
(time stood still). Of the three readings, the third being that it is no copy but a turning point,
the one is kept whose motion is smooth: each sample near a cubic through its four neighbours.
"""

import numpy as np

STILL = 0.1  # of the neighbours' change: below it a picture may be a copy of the one before
SMOOTHER = 0.25  # of the roughness: what a reading must leave at most to be believed
CLEARLY = 0.3  # of the other reading's roughness, for time to have stood still: a codec that leaves
# a frame as it was is common, and stops no clock
TORN, HOLE = 2.5, 12  # times, and frames: a change above all those near it
AROUND = 4  # frames on either side that are looked at


def doubled_frames(
    time: np.ndarray, values: np.ndarray, change: np.ndarray
) -> tuple[np.ndarray, bool]:
    """(T,) bool, which frames are copies; True where time stood still in them.

    time (T,) s; values (T, n, 2) px, NaN = lost; change (T,) grey levels between pictures.
    """
    flat = values.reshape(len(values), -1)
    copies = np.zeros(len(time), bool)
    went_on, stood_still = [], []
    for k in _alike(change):
        near = np.arange(max(0, k - AROUND), min(len(time), k + AROUND + 1))
        rough = _readings(time[near], flat[near], int(k - near[0]))
        if min(rough[1:]) < SMOOTHER * rough[0]:
            copies[k] = True
            went_on.append(rough[1])
            stood_still.append(rough[2])
    return copies, bool(np.sum(stood_still) < CLEARLY * np.sum(went_on))


def without_copies(time: np.ndarray, copies: np.ndarray, stood_still: bool) -> np.ndarray:
    """The instants (T - copies,) s of the frames that are no copies."""
    if stood_still:
        time = time - np.median(np.diff(time)) * np.cumsum(copies)
    return time[~copies]


def first_hole(change: np.ndarray, values: np.ndarray) -> int:
    """The first frame that differs from the one before far more than any near it do: a hole.

    change (T,) grey levels, values (T, n, 2) px; len(change) where there is none.
    """
    steps = np.hypot(*np.diff(values, axis=0).transpose(2, 0, 1))
    known = np.isfinite(steps).any(axis=1)
    speed = np.zeros(len(change))
    speed[1:][known] = np.nanmedian(steps[known], axis=1)
    for k in range(1, len(change)):
        for series in (change, speed):
            near = np.r_[series[max(1, k - HOLE) : k], series[k + 1 : k + HOLE + 1]]
            if near.size and series[k] > TORN * max(near.max(), 1e-9):
                return k
    return len(change)


def copies_warning(copies: np.ndarray, stood_still: bool) -> str:
    """What was found, in one sentence."""
    how = "time stood still in them" if stood_still else "they stand where frames were lost"
    return (
        f"{copies.sum()} doubled frames, the first is frame {np.flatnonzero(copies)[0]}: by the "
        f"motion around them {how}. They were left out; switch frame-rate conversion off."
    )


def _alike(change: np.ndarray) -> np.ndarray:
    """Frames whose picture changed far less than its neighbours' did."""
    found = []
    for k in range(1, len(change)):
        around = [i for i in range(max(1, k - AROUND), min(len(change), k + 5)) if i != k]
        if around and change[k] < STILL * np.median(change[around]):
            found.append(k)
    return np.array(found, int)


def _readings(time, flat, k) -> tuple[float, float, float]:
    """Roughness as it is, without sample `k`, and without it and the step to it."""
    rest = np.arange(len(time)) != k
    step = time[k] - time[k - 1]
    earlier = np.where(np.arange(len(time)) > k, time - step, time)
    return (
        _roughness(time, flat),
        _roughness(time[rest], flat[rest]),
        _roughness(earlier[rest], flat[rest]),
    )


def _roughness(time, flat) -> float:
    """px2, mean square of samples off the cubic through their two neighbours on each side."""
    off = []
    for k in range(2, len(time) - 2):
        near = [k - 2, k - 1, k + 1, k + 2]
        weight = np.linalg.inv(np.vander((time[near] - time[k]) / (time[k + 1] - time[k]), 4))[3]
        off.append((flat[k] - weight @ flat[near]) ** 2)
    known = np.isfinite(off)
    return float(np.mean(np.array(off)[known])) if known.any() else np.inf
