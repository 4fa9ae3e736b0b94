"""The camera's own motion, read off points that stand still, taken out of the others' tracks."""

from dataclasses import replace

import numpy as np

from .errors import RecordingError
from .track import Tracks

TURNS = 3  # reference points from which a turn and a zoom of the camera are read


def relative_to(tracks: Tracks, reference: np.ndarray) -> Tracks:
    """The tracks without the camera's shake, as the static points `reference` (n,) bool show it.

    The mean motion of the reference points is taken out, and with three or more their turn and
    scale about the mean; the reference points themselves are left out, their noise goes along.
    Raises RecordingError where no reference is seen.
    """
    reference = np.asarray(reference, bool)
    if not reference.any() or reference.all():
        raise RecordingError(
            f"camera shake: {reference.sum()} of {len(reference)} points are static references; "
            "at least one, and one other, are needed."
        )
    flat = tracks.values[..., 0] + 1j * tracks.values[..., 1]
    rest = tracks.points[:, 0] + 1j * tracks.points[:, 1]
    steady, added = np.full_like(flat, np.nan), np.full(flat.shape, np.nan)
    for k, row in enumerate(flat):
        known = reference & np.isfinite(row)
        if known.any():
            turn, shift, lever = _similarity(rest[known], row[known], rest)
            steady[k] = (row - shift) / turn
            added[k] = np.sqrt(np.mean(tracks.sigma[k, known] ** 2)) * lever
    values = np.stack([steady.real, steady.imag], -1)[:, ~reference]
    sigma = np.hypot(tracks.sigma, added)[:, ~reference]
    return replace(tracks, values=values, sigma=sigma, points=tracks.points[~reference])


def _similarity(rest, seen, at) -> tuple[complex, complex, np.ndarray]:
    """Turn-and-scale a and shift b of seen = a rest + b, and what noise 1 of `seen` is worth `at`.

    Least squares; a = 1 for fewer than three points, whose noise would turn the picture.
    """
    middle, there = rest.mean(), seen.mean()
    spread = np.sum(np.abs(rest - middle) ** 2)
    turns = len(rest) >= TURNS and spread > 1
    turn = np.vdot(rest - middle, seen - there) / spread if turns else 1.0
    lever = np.sqrt(1 / len(rest) + (np.abs(at - middle) ** 2 / spread if turns else 0))
    return turn, there - turn * middle, lever * np.ones(len(at))
