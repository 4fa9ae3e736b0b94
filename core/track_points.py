"""Which points of a picture can be followed, and which of them are worth it."""

from pathlib import Path

import cv2
import numpy as np

from .errors import RecordingError
from .track_clarity import clarity, commotion
from .track_template import RADIUS, SIDE, make_templates
from .video import FEWEST_FRAMES, Video, open_video, read_frames

WORST = 0.1  # px: a point whose place such noise blurs more is featureless
LOOKED_AT = 240  # frames after which, and after twice as many, motion is looked for
CORNERS = 120  # followed to find those that move
LEAST_SHARE = 0.1  # of the clearest and of the largest motion: what is less tells little
EDGE = 3.0  # how much worse a corner may be told along one direction than along the other
SPACING = 12  # px between picked points
NOISE = 2.0  # grey levels, what a phone or a codec leaves


def check_points(grey: np.ndarray, points: np.ndarray) -> tuple[str, ...]:
    """Warnings about `points` (n, 2) px in the picture `grey`.

    Raises RecordingError for a point outside the picture or one without features.
    """
    points = np.asarray(points, float)
    if points.ndim != 2 or points.shape[1] != 2 or not len(points):
        raise RecordingError(f"points: shape {points.shape}; (n, 2) pixels are needed, n >= 1.")
    height, width = grey.shape
    for k, (u, v) in enumerate(points):
        if not (0 <= u <= width - 1 and 0 <= v <= height - 1):
            raise RecordingError(
                f"point {k + 1} at ({u:g}, {v:g}) px is outside the picture of {width} x {height} "
                "px. Read it off the first frame used, from the top left corner."
            )
    best, worst = blur_of_place(grey, points)
    for k in np.flatnonzero(best > WORST):
        u, v = points[k]
        tells = f"to {best[k]:.2g} px at best" if best[k] < SIDE else "to no pixel"
        raise RecordingError(
            f"point {k + 1} at ({u:g}, {v:g}) px is featureless: the picture around it tells its "
            f"place {tells}, {WORST} px are needed (contrast {_contrast(grey, points[k]):.2g} grey "
            "levels). Pick a corner, a dot or a speckle."
        )
    return tuple(
        f"point {k + 1} lies on a straight edge: along it one frame tells its place to "
        f"{worst[k]:.2g} px only. Pick a corner, a dot or a speckle where you can."
        for k in np.flatnonzero(worst > WORST)
    )


def blur_of_place(grey: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(n,), (n,) px: how far noise of `NOISE` blurs a place in the best and the worst direction."""
    level = np.linalg.eigvalsh(make_templates(grey, points).normal)
    best, worst = NOISE / np.sqrt(np.maximum(level[:, ::-1].T, 1e-12))
    return best, worst


def picture_noise(grey: np.ndarray) -> float:
    """Grey levels rms of what neighbouring pixels do not share (Immerkaer, CVIU 1996; median)."""
    mask = np.array([[1, -2, 1], [-2, 4, -2], [1, -2, 1]], np.float32)
    rough = cv2.filter2D(grey.astype(np.float32), -1, mask)[1:-1, 1:-1]
    return float(np.median(np.abs(rough)) / 0.6745 / 6)


def pick_points(
    video: Video | str | Path, count: int = 12, *, start: int = 0, static: np.ndarray | None = None
) -> np.ndarray:
    """Up to `count` points (n, 2) px of frame `start` where texture moves clearest, spread out.

    Corners are followed through the clip until the spectrum of some stands out of its noise.
    Motion is that beside the mean one of `static` (s, 2) px, where given. Raises RecordingError
    where there is nothing to follow, or nothing moves.
    """
    video = video if isinstance(video, Video) else open_video(video)
    fixed = np.zeros((0, 2)) if static is None else np.asarray(static, float)
    corners, moved = _moved(video, start, fixed)
    clear = _of_points(clarity, moved)
    if not (clear > 0).any():
        clear = _of_points(commotion, moved)
    if not (clear > 0).any():
        raise RecordingError(
            f"{video.path.name}: no motion in it; none of its {len(corners)} corners moves beyond "
            "the noise. Film the motion, or give the points."
        )
    far = np.where(clear > 0, moved.std(axis=0).max(axis=1), 0)
    return _spread(corners, np.where(far > LEAST_SHARE * far.max(), clear, 0), count)


def _moved(video, start, fixed) -> tuple[np.ndarray, np.ndarray]:
    """Corners (m, 2) px and where they went (T, m, 2), until it is clear that some vibrate.

    The mean motion of the points `fixed` (s, 2) px is taken off.
    """
    moved, opening, corners, look = [], None, None, LOOKED_AT
    frames = read_frames(video, start)
    for frame in frames:
        if opening is None:
            opening = frame.grey
            corners = np.vstack([fixed, _corners(frame.grey, video.path.name)])
            moved.append(np.zeros_like(corners))
            continue
        moved.append(_displacement(opening, frame.grey, corners, moved[-1]))
        if len(moved) == look:
            if (_of_points(clarity, _beside(moved, len(fixed))) > 0).any():
                break
            look *= 2
    frames.close()
    if len(moved) < FEWEST_FRAMES:
        raise RecordingError(
            f"{video.path.name}: {len(moved)} frames; {FEWEST_FRAMES} are needed at least, "
            "and several periods to learn something. Film longer."
        )
    return corners[len(fixed) :], _beside(moved, len(fixed))


def _beside(moved: list, fixed: int) -> np.ndarray:
    """(T, m, 2) the motions but for the first `fixed` points, whose mean is taken off."""
    whole = np.array(moved)
    still = np.nanmean(whole[:, :fixed], axis=1, keepdims=True) if fixed else 0.0
    return whole[:, fixed:] - still


def _of_points(measure, moved: np.ndarray) -> np.ndarray:
    """(m,) `measure` of the displacements (T, m, 2), the larger of the axes; NaN where lost."""
    known = np.isfinite(moved).all((0, 2))
    flat = np.where(known[None, :, None], moved, 0).reshape(len(moved), -1)
    return np.where(known, measure(flat).reshape(-1, 2).max(1), np.nan)


def _corners(grey, name) -> np.ndarray:
    """(m, 2) px, places whose shift can be told in both directions, the clearest first."""
    found = cv2.goodFeaturesToTrack(grey, CORNERS, 0.01, SPACING, blockSize=RADIUS)
    corners = np.zeros((0, 2)) if found is None else found[:, 0].astype(float)
    if len(corners):
        best, worst = blur_of_place(grey, corners)
        corners = corners[(worst < WORST) & (worst < EDGE * best)]
    if not len(corners):
        raise RecordingError(f"{name}: there is no corner to follow. Put dots on the object.")
    return corners


def _displacement(opening, grey, corners, last) -> np.ndarray:
    """(m, 2) px from the opening, sought from where they were `last`; NaN: never seen again."""
    begin = corners.astype(np.float32).reshape(-1, 1, 2)
    guess = begin + np.nan_to_num(last).astype(np.float32).reshape(-1, 1, 2)
    found, seen, _ = cv2.calcOpticalFlowPyrLK(
        opening, grey, begin, guess, winSize=(SIDE, SIDE), flags=cv2.OPTFLOW_USE_INITIAL_FLOW
    )
    return np.where((seen == 1) & np.isfinite(last), (found - begin)[:, 0], np.nan)


def _spread(corners, score, count) -> np.ndarray:
    """The best `count` corners, at first a window apart, closer where that leaves too few."""
    score = np.nan_to_num(score)
    order = [k for k in np.argsort(-score, kind="stable") if score[k] > 0]
    chosen: list[int] = []
    for apart in (SIDE, SPACING):
        for k in order:
            far = all(np.hypot(*(corners[k] - corners[j])) >= apart for j in chosen)
            if far and len(chosen) < count and score[k] > LEAST_SHARE * score[order[0]]:
                chosen.append(k)
    return corners[chosen]


def _contrast(grey, point) -> float:
    """Grey levels, standard deviation in the window around `point` (2,) px."""
    low = np.maximum(np.round(point).astype(int) - RADIUS, 0)
    return float(grey[low[1] : low[1] + SIDE, low[0] : low[0] + SIDE].std())
