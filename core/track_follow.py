"""From one frame to the next: where each window went, whether it is still itself, and if not,
where it turned up again.
"""

from dataclasses import dataclass, replace

import cv2
import numpy as np

from .track_points import picture_noise
from .track_template import GRID, RADIUS, SIDE, Fit, Templates, inside_picture, refine

LEVELS = 3  # of the pyramid
HALVE = cv2.INTER_AREA  # keeps places true: a pixel becomes the mean of those it covers
LEAST_MATCH = 0.15  # share of a window's contrast that must be explained, however noisy the clip
MOST_NOISE = 0.8  # share of it that may be noise to begin with
WORSE = 6.0  # times the usual unexplained share: something is in front of the point
SLACK = 0.03  # of the contrast, on top of that
MEMORY = 0.1  # share of the new frame in the running mean of the unexplained share
SEARCH_EVERY = 4  # frames between two searches for a lost point
SEARCH = 48  # px around the last place
LARGEST_STRETCH = 2.0  # of a window, either way
UNSETTLED = 0.3  # px, a last step that shows the search did not converge


@dataclass(frozen=True, eq=False)
class State:
    """All n points in one frame."""

    fit: Fit  # as found; for a lost point where it was last
    found: np.ndarray  # (n,) bool
    usual: np.ndarray  # (n,) running mean of the unexplained share of contrast
    lost_for: np.ndarray  # (n,) frames
    step: tuple[np.ndarray, np.ndarray]  # of affine (n, 2, 2) and place (n, 2) in the last frame


def begin(first: Templates, opening: np.ndarray) -> State:
    """The points where they were picked, in the picture `opening`.

    How much noise will leave unexplained is guessed from that picture alone, and soon learned.
    """
    n = len(first.points)
    identity = np.tile(np.eye(2), (n, 1, 1))
    zeros = np.zeros(n)
    fit = Fit(identity, first.centre.copy(), zeros, zeros + 1, np.zeros((n, len(GRID))), zeros)
    middle = np.average(first.values, axis=1, weights=first.weight)[:, None]
    contrast = np.average((first.values - middle) ** 2, axis=1, weights=first.weight)
    usual = np.clip(2 * picture_noise(opening) ** 2 / np.maximum(contrast, 1e-6), 0, MOST_NOISE)
    return State(fit, np.ones(n, bool), usual, np.zeros(n, int), (0 * identity, 0 * first.centre))


def follow(first: Templates, opening: np.ndarray, grey: np.ndarray, state: State) -> State:
    """The points in `grey`; `opening` is the picture that the windows of `first` come from."""
    guess = _lucas_kanade(first, opening, grey, state.fit.place)
    fit = refine(first, grey, state.fit.affine, guess)
    good = _itself(first, fit, state, grey.shape)
    astray = np.flatnonzero(~good)
    if len(astray):
        onward = state.fit.affine + state.step[0], state.fit.place + state.step[1]
        fit, good = _retry(first, grey, state, (fit, good), (astray, *onward))
    due = np.flatnonzero(~good & (state.lost_for % SEARCH_EVERY == 0))
    if len(due):
        places = state.fit.place.copy()
        places[due] = [_search(first, grey, k, places[k]) for k in due]
        fit, good = _retry(first, grey, state, (fit, good), (due, state.fit.affine, places))
    return _next(state, fit, good)


def _lucas_kanade(first: Templates, opening, grey, last) -> np.ndarray:
    """(n, 2) px where pyramids see the windows' centres; the last place where they see nothing.

    Half the size is enough for what is only a first guess, and costs a quarter.
    """
    half = [cv2.resize(one, None, fx=0.5, fy=0.5, interpolation=HALVE) for one in (opening, grey)]
    ratio = np.array(grey.shape[::-1]) / half[1].shape[::-1]  # two, but for odd sizes
    places = [np.float32((p + 0.5) / ratio - 0.5).reshape(-1, 1, 2) for p in (first.centre, last)]
    found, seen, _ = cv2.calcOpticalFlowPyrLK(
        *half,
        *places,
        winSize=(RADIUS, RADIUS),
        maxLevel=LEVELS - 1,
        flags=cv2.OPTFLOW_USE_INITIAL_FLOW,
    )
    found = (found[:, 0].astype(float) + 0.5) * ratio - 0.5
    inside = ((found > 0) & (found < grey.shape[::-1])).all(1)
    return np.where((seen[:, 0] == 1)[:, None] & inside[:, None], found, last)


def _retry(first, grey, state, so_far, start) -> tuple[Fit, np.ndarray]:
    """so_far = (fit, good) with the points of start = (which, affine, place) sought from there."""
    (fit, good), (which, affine, place) = so_far, start
    part = first.subset(which)
    second = refine(part, grey, affine[which], place[which])
    again = _itself(part, second, _part(state, which), grey.shape)
    mended = {name: getattr(fit, name).copy() for name in fit.__dataclass_fields__}
    for name, values in mended.items():
        values[which[again]] = getattr(second, name)[again]
    good = good.copy()
    good[which] = again
    return Fit(**mended), good


def _part(state: State, which) -> State:
    return replace(state, usual=state.usual[which], lost_for=state.lost_for[which])


def _itself(first: Templates, fit: Fit, state: State, shape) -> np.ndarray:
    """(n,) bool: the window still shows what it showed, undistorted, inside the picture."""
    least = np.maximum(LEAST_MATCH, (1 - state.usual) / 2)
    same = (fit.match > least) & (1 - fit.match < WORSE * state.usual + SLACK)
    stretch = np.linalg.svd(fit.affine, compute_uv=False)
    whole = (stretch[:, 0] < LARGEST_STRETCH) & (stretch[:, 1] > 1 / LARGEST_STRETCH)
    settled = fit.step < UNSETTLED
    return same & whole & settled & inside_picture(fit, first, shape)


def _search(first: Templates, grey, k, last) -> np.ndarray:
    """(2,) px where window `k` looks most like itself around its last place."""
    height, width = grey.shape
    reach = RADIUS + SEARCH
    low = np.maximum(np.round(last).astype(int) - reach, 0)
    high = np.minimum(np.round(last).astype(int) + reach + 1, (width, height))
    area = grey[low[1] : high[1], low[0] : high[0]]
    if min(area.shape) < SIDE:
        return last
    window = np.clip(first.values[k].reshape(SIDE, SIDE), 0, 255).astype(np.uint8)
    likeness = cv2.matchTemplate(area, window, cv2.TM_CCOEFF_NORMED)
    row, column = np.unravel_index(np.argmax(likeness), likeness.shape)
    return low + np.array([column, row]) + float(RADIUS)


def _next(state: State, fit: Fit, good) -> State:
    unexplained = 1 - fit.match
    mean = state.usual + MEMORY * (unexplained - state.usual)
    keep = {"affine": state.fit.affine, "place": state.fit.place}
    last = {
        name: np.where(good.reshape(-1, *[1] * (old.ndim - 1)), getattr(fit, name), old)
        for name, old in keep.items()
    }
    steady = good & state.found
    return State(
        replace(fit, **last),
        good,
        np.where(good, mean, state.usual),
        np.where(good, 0, state.lost_for + 1),
        (
            np.where(steady[:, None, None], fit.affine - state.fit.affine, 0),
            np.where(steady[:, None], fit.place - state.fit.place, 0),
        ),
    )
