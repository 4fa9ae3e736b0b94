"""The clip with one mode's motion exaggerated, so that a person sees what was measured.

What the points do in the mode is spread smoothly over the picture, and every frame is warped by
it: motion magnification from tracks (Liu et al., Motion magnification, SIGGRAPH 2005), with the
motion of one pole in place of all of it.
"""

from pathlib import Path

import cv2
import numpy as np

from .data import RingDown, poles
from .errors import RecordingError
from .files import written_whole
from .track import Tracks
from .video import Video, read_frames

VISIBLE = 0.02  # of the picture's width: the swing that is aimed at
MOST = 300.0  # times
PLAYED = 30.0  # frames/s of the preview
COARSE = 8  # px between the places where the field is computed
FADE = 2.0  # of the points' spacing: farther away nothing moves


def magnify_mode(
    clip: Video, tracks: Tracks, ringdown: RingDown, path: str | Path, *, mode: int = 0
) -> float:
    """Write `path` (mp4, avi): the clip with the motion of one mode magnified. Gives the factor.

    ringdown: its channels are u and v of the points of `tracks`. Frame k is warped so that what
    the mode moves by d(t) is moved by factor * d(t); all other motion stays. Raises RecordingError
    where no such video can be written.
    """
    motion = mode_motion(tracks, ringdown, mode)
    largest = float(np.abs(motion).max())
    factor = float(np.clip(VISIBLE * clip.size[0] / max(largest, 1e-9), 1.0, MOST))
    weights = spread_weights(tracks.points, clip.size)
    wanted = dict(zip(tracks.frames.tolist(), motion, strict=True))
    with written_whole(path) as draft:
        writer = _writer(draft, clip.size)
        for frame in read_frames(clip):
            if frame.index in wanted:
                shift = (factor - 1) * np.tensordot(weights, wanted[frame.index], axes=(2, 0))
                writer.write(warped(frame.grey, shift))
        writer.release()
    return factor


def mode_motion(tracks: Tracks, ringdown: RingDown, mode: int) -> np.ndarray:
    """(T, n, 2) px: Re(a exp(p (t - t0))) of every point; zero before t0."""
    pole = poles(ringdown.frequency, ringdown.damping_ratio)[mode]
    since = tracks.time - ringdown.t0
    swing = np.where(since >= 0, np.exp(pole * np.maximum(since, 0)), 0)
    motion = (swing[:, None] * ringdown.amplitude[mode]).real
    return motion.reshape(len(since), len(tracks.points), 2)


def spread_weights(points: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """(rows, columns, n) share of each point's motion at places `COARSE` px apart.

    Gaussian about each point, the shares summing to 1 among the points and to 0 far from them.
    """
    u, v = (np.arange(0, length + COARSE, COARSE) for length in size)
    away = np.hypot(u[None, :, None] - points[:, 0], v[:, None, None] - points[:, 1])
    between = np.hypot(*(points[:, None] - points).transpose(2, 0, 1))
    np.fill_diagonal(between, np.inf)
    reach = np.median(between.min(axis=1)) if len(points) > 1 else min(size) / 4
    bell = np.exp(-((away / reach) ** 2) / 2)
    return bell / (bell.sum(axis=2, keepdims=True) + np.exp(-(FADE**2) / 2))


def warped(grey: np.ndarray, shift: np.ndarray) -> np.ndarray:
    """`grey` (height, width) moved by `shift` (rows, columns, 2) px given `COARSE` px apart."""
    height, width = grey.shape
    v, u = np.mgrid[:height, :width].astype(np.float32)
    coarse = shift.astype(np.float32)
    there = [cv2.remap(coarse[..., axis], u / COARSE, v / COARSE, 1) for axis in (0, 1)]
    return cv2.remap(grey, u - there[0], v - there[1], 1, borderMode=cv2.BORDER_REPLICATE)


def _writer(path: Path, size: tuple[int, int]) -> cv2.VideoWriter:
    code = "MJPG" if path.suffix.lower() == ".avi" else "mp4v"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*code), PLAYED, size, False)
    if not writer.isOpened():
        raise RecordingError(
            f"{path.name}: no such video can be written. Give a file that ends in .mp4 or .avi."
        )
    return writer
